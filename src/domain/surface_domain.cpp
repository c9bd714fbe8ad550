#include "skinfield/domain/surface_domain.h"

#include "domain/kd_tree.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace skinfield {
namespace {

constexpr double kWeld = 1e-7;
constexpr double kLeastWeight = 0.05;  // of an edge; a cotangent weight of a good mesh is 0.6
constexpr double kLinkWeight = 0.3;
constexpr int kNearest = 24;
constexpr int kMostSplits = 12;

struct Sheet {
  Points V;
  Triangles F;
  std::vector<int> node_of_vertex;  ///< of the mesh, -1: in no triangle
};

/// The mesh's proper triangles over welded vertices, unused ones left out.
Sheet proper_triangles(const Mesh& mesh) {
  Sheet sheet;
  const Welded welded = weld(mesh.V, kWeld);
  std::vector<int> number(static_cast<std::size_t>(welded.V.rows()), -1);
  std::vector<int> used;
  std::vector<Eigen::RowVector3i> faces;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    Triangles one(1, 3);
    for (int c = 0; c < 3; ++c) one(0, c) = welded.vertex[static_cast<std::size_t>(mesh.F(f, c))];
    if (!(element_volumes(welded.V, one)[0] > 0)) continue;
    for (int c = 0; c < 3; ++c) {
      int& id = number[static_cast<std::size_t>(one(0, c))];
      if (id < 0) {
        id = static_cast<int>(used.size());
        used.push_back(one(0, c));
      }
      one(0, c) = id;
    }
    faces.emplace_back(one.row(0));
  }
  sheet.V.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t i = 0; i < used.size(); ++i) {
    sheet.V.row(static_cast<Eigen::Index>(i)) = welded.V.row(used[i]);
  }
  sheet.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    sheet.F.row(static_cast<Eigen::Index>(f)) = faces[f];
  }
  for (const int v : welded.vertex) {
    sheet.node_of_vertex.push_back(number[static_cast<std::size_t>(v)]);
  }
  return sheet;
}

/// Splits every edge longer than h at its middle, once; triangles are cut to fit (no hanging
/// vertices). Returns whether there were any.
bool split_long_edges(Sheet& sheet, double h) {
  std::map<std::pair<int, int>, int> middle;
  std::vector<Eigen::RowVector3i> faces;
  std::vector<Vec3> added;
  const auto first_new = static_cast<int>(sheet.V.rows());
  const auto split = [&](int a, int b) {
    if ((sheet.V.row(a) - sheet.V.row(b)).norm() <= h) return -1;
    const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), 0);
    if (fresh) {
      at->second = first_new + static_cast<int>(added.size());
      added.emplace_back((sheet.V.row(a) + sheet.V.row(b)).transpose() / 2);
    }
    return at->second;
  };
  for (Eigen::Index f = 0; f < sheet.F.rows(); ++f) {
    int corner[3], mid[3];  // mid[c] lies opposite to corner[c]
    for (int c = 0; c < 3; ++c) corner[c] = sheet.F(f, c);
    for (int c = 0; c < 3; ++c) mid[c] = split(corner[(c + 1) % 3], corner[(c + 2) % 3]);
    const int cuts = (mid[0] >= 0) + (mid[1] >= 0) + (mid[2] >= 0);
    if (cuts == 0) {
      faces.emplace_back(corner[0], corner[1], corner[2]);
    } else if (cuts == 3) {
      for (int c = 0; c < 3; ++c) {
        faces.emplace_back(corner[c], mid[(c + 2) % 3], mid[(c + 1) % 3]);
      }
      faces.emplace_back(mid[0], mid[1], mid[2]);
    } else {
      // Turn the triangle so that edge 0 (opposite to corner 0) is the one cut, or the one whole.
      int turn = 0;
      while ((mid[turn] >= 0) != (cuts == 1)) ++turn;
      const int a = corner[turn], b = corner[(turn + 1) % 3], c = corner[(turn + 2) % 3];
      if (cuts == 1) {
        faces.emplace_back(a, b, mid[turn]);
        faces.emplace_back(a, mid[turn], c);
      } else {
        const int ca = mid[(turn + 1) % 3], ab = mid[(turn + 2) % 3];
        faces.emplace_back(a, ab, ca);
        faces.emplace_back(ab, b, ca);
        faces.emplace_back(b, c, ca);
      }
    }
  }
  if (added.empty()) return false;
  sheet.V.conservativeResize(first_new + static_cast<Eigen::Index>(added.size()), 3);
  for (std::size_t i = 0; i < added.size(); ++i) {
    sheet.V.row(first_new + static_cast<Eigen::Index>(i)) = added[i].transpose();
  }
  sheet.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    sheet.F.row(static_cast<Eigen::Index>(f)) = faces[f];
  }
  return true;
}

/// K from links (a, b, weight > 0): K 1 = 0, non-positive off the diagonal.
SparseRows from_links(const std::vector<Eigen::Triplet<double, std::int32_t>>& links,
                      Eigen::Index n) {
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(4 * links.size() + static_cast<std::size_t>(n));
  for (std::int32_t i = 0; i < n; ++i) entries.emplace_back(i, i, 0.0);
  for (const auto& link : links) {
    entries.emplace_back(link.row(), link.row(), link.value());
    entries.emplace_back(link.col(), link.col(), link.value());
    entries.emplace_back(link.row(), link.col(), -link.value());
    entries.emplace_back(link.col(), link.row(), -link.value());
  }
  SparseRows K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

/// Component of every vertex.
std::vector<int> parts_of(const Sheet& sheet) {
  const Components components = connected_components(sheet.F, sheet.V.rows());
  std::vector<int> part(static_cast<std::size_t>(sheet.V.rows()), 0);
  for (Eigen::Index f = 0; f < sheet.F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      part[static_cast<std::size_t>(sheet.F(f, c))] =
          components.of_face[static_cast<std::size_t>(f)];
    }
  }
  return part;
}

SparseRows safe_stiffness(const Sheet& sheet, const KdTree& tree, double touching) {
  std::vector<Eigen::Triplet<double, std::int32_t>> links;
  const SparseRows cotangent = stiffness(sheet.V, sheet.F);
  for (Eigen::Index i = 0; i < cotangent.rows(); ++i) {
    for (SparseRows::InnerIterator it(cotangent, i); it; ++it) {
      if (it.col() <= i) continue;
      links.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(it.col()),
                         std::max(kLeastWeight, -it.value()));
    }
  }
  const std::vector<int> part = parts_of(sheet);
  std::set<std::pair<int, int>> joined;
  std::vector<Neighbour> found;
  for (int i = 0; i < sheet.V.rows(); ++i) {
    tree.nearest(sheet.V.row(i), kNearest, found);
    for (const Neighbour& other : found) {
      if (other.distance > touching) break;
      if (part[static_cast<std::size_t>(i)] == part[static_cast<std::size_t>(other.index)])
        continue;
      joined.insert(std::minmax(i, other.index));
      break;  // the nearest vertex of another part
    }
  }
  for (const auto& [a, b] : joined) links.emplace_back(a, b, kLinkWeight);
  return from_links(links, sheet.V.rows());
}

/// Nodes that a handle holds: the nearest to its samples that they see.
std::set<int> held_nodes(const Sheet& sheet, const KdTree& tree, const RayScene& scene,
                         const Handle& handle, const Points& samples, double h) {
  std::set<int> held;
  if (handle.kind == Handle::Kind::region) {
    for (const int v : handle.vertices) {
      const int node = sheet.node_of_vertex[static_cast<std::size_t>(v)];
      if (node >= 0) held.insert(node);
    }
    return held;
  }
  std::vector<Neighbour> found;
  for (Eigen::Index s = 0; s < samples.rows(); ++s) {
    const Vec3 x = samples.row(s);
    tree.nearest(x, kNearest, found);
    const double skip = 1e-3 * h + 1e-5;
    const auto seen = [&](const Neighbour& node) {
      return node.distance < h || !scene.occluded(x, sheet.V.row(node.index), skip, skip);
    };
    const auto nearest = std::find_if(found.begin(), found.end(), seen);
    if (nearest == found.end()) {
      held.insert(found.front().index);
      continue;
    }
    // A bone inside a tube holds the ring around it, not one strip.
    for (auto it = nearest; it != found.end() && it->distance <= 1.1 * nearest->distance + 0.25 * h;
         ++it) {
      if (seen(*it)) held.insert(it->index);
    }
  }
  return held;
}

FixedRows fix_handles(const Sheet& sheet, const KdTree& tree, const Mesh& mesh,
                      const std::vector<Handle>& handles, double h) {
  const RayScene scene(sheet.V, sheet.F);
  const auto columns = static_cast<Eigen::Index>(handles.size());
  std::vector<std::set<int>> held(handles.size());
  parallel_for(handles.size(), 1, [&](std::size_t j) {
    held[j] =
        held_nodes(sheet, tree, scene, handles[j], sample_handle(handles[j], 0.5 * h, mesh.V), h);
  });
  std::map<int, std::vector<int>> claims;
  for (std::size_t j = 0; j < held.size(); ++j) {
    for (const int v : held[j]) claims[v].push_back(static_cast<int>(j));
  }
  // Of several handles the nearest get the node; one that loses all its nodes shares them.
  std::vector<int> left(handles.size(), 0);
  std::map<int, std::vector<int>> owners;
  for (const auto& [v, claimants] : claims) {
    std::vector<double> distance;
    for (const int j : claimants) {
      distance.push_back(
          handle_distance(handles[static_cast<std::size_t>(j)], sheet.V.row(v), mesh.V));
    }
    const double least = *std::min_element(distance.begin(), distance.end());
    for (std::size_t t = 0; t < claimants.size(); ++t) {
      if (distance[t] > 1.02 * least + 0.02 * h) continue;
      owners[v].push_back(claimants[t]);
      ++left[static_cast<std::size_t>(claimants[t])];
    }
  }
  for (std::size_t j = 0; j < held.size(); ++j) {
    if (left[j] > 0) continue;
    for (const int v : held[j]) owners[v].push_back(static_cast<int>(j));
  }
  FixedRows fixed;
  fixed.weights = RowMatrix::Zero(static_cast<Eigen::Index>(owners.size()), columns);
  for (const auto& [v, columns_of] : owners) {
    const auto row = static_cast<Eigen::Index>(fixed.node.size());
    fixed.node.push_back(v);
    for (const int j : columns_of) {
      fixed.weights(row, j) = 1.0 / static_cast<double>(columns_of.size());
    }
  }
  return fixed;
}

}  // namespace

struct SurfaceDomain::Impl {
  Sheet sheet;
  SparseRows K;
  Vector M;
  FixedRows fixed;
  std::unique_ptr<ClosestPointQuery> closest;
};

SurfaceDomain::SurfaceDomain(const Mesh& mesh, const std::vector<Handle>& handles,
                             const SurfaceDomainOptions& options, const Progress& progress)
    : impl_(std::make_unique<Impl>()) {
  if (handles.empty()) throw DomainError("there is no handle", "surface domain");
  Sheet& sheet = impl_->sheet;
  sheet = proper_triangles(mesh);
  const double area = element_volumes(sheet.V, sheet.F).sum();
  if (sheet.F.rows() == 0 || !(area > 0)) {
    throw DomainError("no triangle has an area", "surface domain");
  }
  // A node of an equilateral mesh of edge h stands for sqrt(3)/2 h^2.
  const double h = std::sqrt(area / (0.866 * std::max(1, options.nodes)));
  for (int pass = 0; pass < kMostSplits && sheet.V.rows() < options.nodes; ++pass) {
    progress.check();
    if (!split_long_edges(sheet, 1.5 * h)) break;
  }
  const KdTree tree(sheet.V);
  impl_->K = safe_stiffness(sheet, tree, options.touching * h);
  impl_->M = lumped_mass(sheet.V, sheet.F, options.mass);
  progress.check();
  impl_->fixed = fix_handles(sheet, tree, mesh, handles, h);
  if (impl_->fixed.node.empty()) {
    throw DomainError("no handle reaches the surface", "surface domain");
  }
  impl_->closest = std::make_unique<ClosestPointQuery>(sheet.V, sheet.F);
}

SurfaceDomain::~SurfaceDomain() = default;

const Points& SurfaceDomain::nodes() const { return impl_->sheet.V; }
const SparseRows& SurfaceDomain::stiffness() const { return impl_->K; }
const Vector& SurfaceDomain::mass() const { return impl_->M; }
const FixedRows& SurfaceDomain::fixed() const { return impl_->fixed; }

Interpolation SurfaceDomain::at(const Points& X, const Points&) const {
  const auto n = static_cast<std::size_t>(X.rows());
  std::vector<ClosestPoint> closest(n);
  parallel_for(n, 64, [&](std::size_t i) {
    closest[i] = impl_->closest->at(X.row(static_cast<Eigen::Index>(i)));
  });
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 b = closest[i].barycentric.cwiseMax(0.0);
    for (int c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<std::int32_t>(i), impl_->sheet.F(closest[i].face, c),
                           b[c] / b.sum());
    }
  }
  Interpolation result;
  result.P.resize(X.rows(), impl_->sheet.V.rows());
  result.P.setFromTriplets(entries.begin(), entries.end());
  result.fill.assign(n, Fill::none);
  return result;
}

}  // namespace skinfield
