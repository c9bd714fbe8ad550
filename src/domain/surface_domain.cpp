#include "skinfield/domain/surface_domain.h"

#include "domain/triangle_sheet.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"

#include <algorithm>
#include <set>

namespace skinfield {
namespace {

constexpr double kWeld = 1e-7;
constexpr double kLeastWeight = 0.05;  // of an edge; a cotangent weight of a good mesh is 0.6
constexpr double kLinkWeight = 0.3;
constexpr int kNearest = 24;

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
  const std::vector<int> part = parts_of(sheet.F, sheet.V.rows());
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
  const double h = node_distance(area, options.nodes);
  refine_to(sheet.V, sheet.F, options.nodes, area, progress);
  const KdTree tree(sheet.V);
  impl_->K = safe_stiffness(sheet, tree, options.touching * h);
  impl_->M = lumped_mass(sheet.V, sheet.F, options.mass);
  progress.check();
  impl_->fixed =
      nearest_visible_rows(sheet.V, sheet.F, tree, handles, std::vector<char>(handles.size(), 1),
                           sheet.node_of_vertex, mesh.V, h);
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
  Interpolation result;
  result.P = barycentric_rows(*impl_->closest, impl_->sheet.F, X, impl_->sheet.V.rows());
  result.fill.assign(static_cast<std::size_t>(X.rows()), Fill::none);
  return result;
}

}  // namespace skinfield
