#include "domain/triangle_sheet.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace skinfield {
namespace {

constexpr int kNearest = 24;
constexpr int kMostSplits = 12;

/// Nodes that a handle holds: the nearest to its samples that they see.
std::set<int> held_nodes(const Points& V, const KdTree& tree, const RayScene& scene,
                         const Handle& handle, const Points& samples,
                         const std::vector<int>& node_of_vertex, double h) {
  std::set<int> held;
  if (handle.kind == Handle::Kind::region) {
    for (const int v : handle.vertices) {
      const int node = node_of_vertex[static_cast<std::size_t>(v)];
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
      return node.distance < h || !scene.occluded(x, V.row(node.index), skip, skip);
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

}  // namespace

bool split_long_edges(Points& V, Triangles& F, double h) {
  std::map<std::pair<int, int>, int> middle;
  std::vector<Eigen::RowVector3i> faces;
  std::vector<Vec3> added;
  const auto first_new = static_cast<int>(V.rows());
  const auto split = [&](int a, int b) {
    if ((V.row(a) - V.row(b)).norm() <= h) return -1;
    const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), 0);
    if (fresh) {
      at->second = first_new + static_cast<int>(added.size());
      added.emplace_back((V.row(a) + V.row(b)).transpose() / 2);
    }
    return at->second;
  };
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    int corner[3], mid[3];  // mid[c] lies opposite to corner[c]
    for (int c = 0; c < 3; ++c) corner[c] = F(f, c);
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
  V.conservativeResize(first_new + static_cast<Eigen::Index>(added.size()), 3);
  for (std::size_t i = 0; i < added.size(); ++i) {
    V.row(first_new + static_cast<Eigen::Index>(i)) = added[i].transpose();
  }
  F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    F.row(static_cast<Eigen::Index>(f)) = faces[f];
  }
  return true;
}

double node_distance(double area, int nodes) {
  // A node of an equilateral mesh of edge h stands for sqrt(3)/2 h^2.
  return std::sqrt(area / (0.866 * std::max(1, nodes)));
}

void refine_to(Points& V, Triangles& F, int nodes, double area, const Progress& progress) {
  const double h = node_distance(area, nodes);
  for (int pass = 0; pass < kMostSplits && V.rows() < nodes; ++pass) {
    progress.check();
    if (!split_long_edges(V, F, 1.5 * h)) break;
  }
}

std::vector<int> parts_of(const Triangles& F, Eigen::Index vertices) {
  const Components components = connected_components(F, vertices);
  std::vector<int> part(static_cast<std::size_t>(vertices), -1);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      part[static_cast<std::size_t>(F(f, c))] = components.of_face[static_cast<std::size_t>(f)];
    }
  }
  return part;
}

FixedRows shared_rows(const std::map<int, std::vector<int>>& owners, Eigen::Index columns) {
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

FixedRows nearest_visible_rows(const Points& V, const Triangles& F, const KdTree& tree,
                               const std::vector<Handle>& handles, const std::vector<char>& wanted,
                               const std::vector<int>& node_of_vertex, const Points& mesh_V,
                               double h) {
  const RayScene scene(V, F);
  std::vector<std::set<int>> held(handles.size());
  parallel_for(handles.size(), 1, [&](std::size_t j) {
    if (!wanted[j]) return;
    held[j] = held_nodes(V, tree, scene, handles[j], sample_handle(handles[j], 0.5 * h, mesh_V),
                         node_of_vertex, h);
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
      distance.push_back(handle_distance(handles[static_cast<std::size_t>(j)], V.row(v), mesh_V));
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
  return shared_rows(owners, static_cast<Eigen::Index>(handles.size()));
}

SparseRows barycentric_rows(const ClosestPointQuery& query, const Triangles& F, const Points& X,
                            Eigen::Index nodes) {
  const auto n = static_cast<std::size_t>(X.rows());
  std::vector<ClosestPoint> closest(n);
  parallel_for(n, 64,
               [&](std::size_t i) { closest[i] = query.at(X.row(static_cast<Eigen::Index>(i))); });
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 b = closest[i].barycentric.cwiseMax(0.0);
    for (int c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<std::int32_t>(i), F(closest[i].face, c), b[c] / b.sum());
    }
  }
  SparseRows P(X.rows(), nodes);
  P.setFromTriplets(entries.begin(), entries.end());
  return P;
}

}  // namespace skinfield
