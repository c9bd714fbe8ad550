#include "skinfield/domain/tri_domain.h"

#include "domain/plane_insertion.h"
#include "domain/triangle_sheet.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

constexpr const char* kWhere = "triangle domain";
constexpr double kOnHandle = 1e-6;           // of the box's diagonal: design.md 4
constexpr double kSamplesPerEdge = 2;        // of a bone
constexpr double kFlat = kOnHandle;          // as Diagnosis has it
constexpr double kServes = 0.5 * kOnHandle;  // moved by rounding, it still is on the handle

/// Handles dropped onto the plane; as they are in space.
std::vector<Handle> dropped(const std::vector<Handle>& handles, const std::optional<Plane>& plane) {
  std::vector<Handle> result = handles;
  if (!plane) return result;
  for (Handle& handle : result) {
    handle.point = plane->drop(handle.point);
    for (auto& [a, b] : handle.segments) a = plane->drop(a), b = plane->drop(b);
  }
  return result;
}

double mean_edge(const Points& V, const Triangles& F) {
  double sum = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) sum += (V.row(F(f, c)) - V.row(F(f, (c + 1) % 3))).norm();
  }
  return sum / static_cast<double>(3 * F.rows());
}

/// Which handles own each node of a triangle: those within `tolerance`; regions their vertices.
std::map<int, std::vector<int>> owners_of(const Points& V, const std::vector<int>& part,
                                          const std::vector<Handle>& handles, double tolerance) {
  std::vector<std::vector<int>> near(static_cast<std::size_t>(V.rows()));
  parallel_for(near.size(), 256, [&](std::size_t i) {
    if (part[i] < 0) return;
    for (std::size_t j = 0; j < handles.size(); ++j) {
      if (handles[j].kind == Handle::Kind::region) continue;
      const Vec3 x = V.row(static_cast<Eigen::Index>(i));
      if (handle_distance(handles[j], x) <= tolerance) near[i].push_back(static_cast<int>(j));
    }
  });
  for (std::size_t j = 0; j < handles.size(); ++j) {
    if (handles[j].kind != Handle::Kind::region) continue;
    for (const int v : handles[j].vertices) {
      if (part[static_cast<std::size_t>(v)] >= 0) {
        near[static_cast<std::size_t>(v)].push_back(static_cast<int>(j));
      }
    }
  }
  std::map<int, std::vector<int>> owners;
  for (std::size_t i = 0; i < near.size(); ++i) {
    std::sort(near[i].begin(), near[i].end());
    near[i].erase(std::unique(near[i].begin(), near[i].end()), near[i].end());
    if (!near[i].empty()) owners.emplace(static_cast<int>(i), std::move(near[i]));
  }
  return owners;
}

/// 1 for handles that own no node. A region has its vertices or nothing.
std::vector<char> bare_handles(const std::map<int, std::vector<int>>& owners,
                               const std::vector<Handle>& handles) {
  std::vector<char> bare(handles.size(), 1);
  for (const auto& [node, of] : owners) {
    for (const int j : of) bare[static_cast<std::size_t>(j)] = 0;
  }
  for (std::size_t j = 0; j < handles.size(); ++j) {
    if (handles[j].kind == Handle::Kind::region) bare[j] = 0;
  }
  return bare;
}

/// nearest_visible_rows among the nodes of triangles alone.
FixedRows visible_rows(const Points& V, const Triangles& F, const std::vector<int>& part,
                       const std::vector<Handle>& handles, const std::vector<char>& wanted,
                       const Points& mesh_V, double h) {
  std::vector<int> used, number(part.size(), -1);
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] < 0) continue;
    number[i] = static_cast<int>(used.size());
    used.push_back(static_cast<int>(i));
  }
  const Points own = V(used, Eigen::all);
  const Triangles faces =
      F.unaryExpr([&](std::int32_t v) { return number[static_cast<std::size_t>(v)]; });
  FixedRows rows =
      nearest_visible_rows(own, faces, KdTree(own), handles, wanted, number, mesh_V, h);
  for (int& node : rows.node) node = used[static_cast<std::size_t>(node)];
  return rows;
}

/// The rows of both; `first` wins.
FixedRows joined(const FixedRows& first, const FixedRows& second) {
  std::map<int, Eigen::RowVectorXd> rows;
  for (const FixedRows* one : {&first, &second}) {
    for (std::size_t k = 0; k < one->node.size(); ++k) {
      rows.emplace(one->node[k], one->weights.row(static_cast<Eigen::Index>(k)));
    }
  }
  FixedRows result;
  result.weights.resize(static_cast<Eigen::Index>(rows.size()), first.weights.cols());
  for (const auto& [node, row] : rows) {
    result.weights.row(static_cast<Eigen::Index>(result.node.size())) = row;
    result.node.push_back(node);
  }
  return result;
}

using Position = std::array<double, 3>;
Position position_of(const Points& X, Eigen::Index i) {
  return {X(i, 0) + 0.0, X(i, 1) + 0.0, X(i, 2) + 0.0};  // -0 and 0 are one place
}

}  // namespace

struct TriDomain::Impl {
  Mesh mesh;  ///< as given
  Points V;
  Triangles F;
  SparseRows K;
  Vector M;
  FixedRows fixed;
  TriDomainFacts facts;
  std::optional<Plane> plane;
  double tolerance = 0;
  std::unique_ptr<ClosestPointQuery> closest;
  std::map<Position, int> vertex_at;

  void split_at_handles(const std::vector<Handle>& handles, const std::vector<char>& bare,
                        const Progress& progress);
  void count_parts(const std::vector<int>& part);
};

/// Makes vertices of the samples of bare handles that lie in the flat shape.
void TriDomain::Impl::split_at_handles(const std::vector<Handle>& handles,
                                       const std::vector<char>& bare, const Progress& progress) {
  const double spacing = mean_edge(V, F) / kSamplesPerEdge;
  PlaneInsertion insertion(V, F, *plane, kServes / kOnHandle * tolerance);
  for (std::size_t j = 0; j < handles.size(); ++j) {
    if (!bare[j]) continue;
    const Points samples = sample_handle(handles[j], spacing);
    for (Eigen::Index s = 0; s < samples.rows(); ++s) {
      progress.check();
      insertion.insert(samples.row(s).transpose());
    }
  }
  V = insertion.vertices();
  F = insertion.faces();
}

void TriDomain::Impl::count_parts(const std::vector<int>& part) {
  const Vector area = element_volumes(V, F);
  std::vector<double> area_of;
  std::vector<char> held;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const auto p = static_cast<std::size_t>(part[static_cast<std::size_t>(F(f, 0))]);
    if (p >= area_of.size()) area_of.resize(p + 1, 0.0);
    area_of[p] += area[f];
  }
  held.resize(area_of.size(), 0);
  for (const int node : fixed.node) {
    held[static_cast<std::size_t>(part[static_cast<std::size_t>(node)])] = 1;
  }
  facts.components = static_cast<int>(area_of.size());
  for (std::size_t p = 0; p < held.size(); ++p) {
    facts.area += area_of[p];
    if (held[p]) continue;
    ++facts.components_without_handle;
    facts.area_without_handle += area_of[p];
  }
}

TriDomain::TriDomain(const Mesh& mesh, const std::vector<Handle>& handles,
                     const TriDomainOptions& options, const Progress& progress)
    : impl_(std::make_unique<Impl>()) {
  Impl& d = *impl_;
  if (handles.empty()) throw DomainError("there is no handle", kWhere);
  const Vector areas = element_volumes(mesh.V, mesh.F);
  if (mesh.F.rows() == 0 || !(areas.sum() > 0)) {
    throw DomainError("no triangle has an area", kWhere);
  }
  if (options.mass.size() > 0 && options.mass.size() != mesh.V.rows()) {
    throw InputError("there are " + std::to_string(options.mass.size()) + " masses for " +
                         std::to_string(mesh.V.rows()) + " vertices",
                     kWhere, "give one for each vertex, in the mesh's order");
  }
  if (options.mass.size() > 0 && !(options.mass.minCoeff() > 0 && options.mass.allFinite())) {
    throw InputError("a mass is not a positive number", kWhere);
  }
  d.mesh = mesh;
  d.V = mesh.V;
  // Triangles without an area connect nothing.
  std::vector<int> proper;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    if (areas[f] > 0) proper.push_back(static_cast<int>(f));
  }
  d.mesh.F = d.F = mesh.F(proper, Eigen::all);
  const double size = diagonal(bounding_box(mesh.V));
  d.tolerance = kOnHandle * size;
  d.plane = plane_of(mesh.V, kFlat * size);
  d.facts.planar = d.plane.has_value();
  const std::vector<Handle> flat = dropped(handles, d.plane);

  std::vector<int> part = parts_of(d.F, d.V.rows());
  std::map<int, std::vector<int>> owners = owners_of(d.V, part, flat, d.tolerance);
  const std::vector<char> bare = bare_handles(owners, flat);
  const bool changes = std::find(bare.begin(), bare.end(), 1) != bare.end();
  FixedRows seen;
  if (changes) {
    if (d.V.rows() < options.nodes) refine_to(d.V, d.F, options.nodes, areas.sum(), progress);
    if (d.plane) d.split_at_handles(flat, bare, progress);
    part = parts_of(d.F, d.V.rows());
    owners = owners_of(d.V, part, flat, d.tolerance);
    if (!d.plane) {
      seen = visible_rows(d.V, d.F, part, flat, bare, mesh.V, mean_edge(d.V, d.F));
    }
  }
  d.facts.added_nodes = static_cast<int>(d.V.rows() - mesh.V.rows());
  if (options.mass.size() > 0 && d.facts.added_nodes > 0) {
    const auto j = static_cast<std::size_t>(std::find(bare.begin(), bare.end(), 1) - bare.begin());
    throw InputError("masses are given for a mesh that must be split: handle " + handles[j].name +
                         " has no vertex",
                     kWhere, "put a vertex on every handle, or leave the masses out");
  }
  d.fixed = joined(shared_rows(owners, static_cast<Eigen::Index>(handles.size())), seen);
  if (d.fixed.node.empty()) throw DomainError("no handle lies in the shape", kWhere);
  d.facts.handle_nodes = static_cast<int>(d.fixed.node.size());
  d.count_parts(part);
  progress.check();

  d.K = skinfield::stiffness(d.V, d.F);
  d.M = options.mass.size() > 0 ? options.mass : lumped_mass(d.V, d.F, options.mass_kind);
  d.closest = std::make_unique<ClosestPointQuery>(d.V, d.F);
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    // A loose vertex asks the surface.
    if (part[static_cast<std::size_t>(i)] >= 0) {
      d.vertex_at.emplace(position_of(mesh.V, i), static_cast<int>(i));
    }
  }
}

TriDomain::~TriDomain() = default;

const Points& TriDomain::nodes() const { return impl_->V; }
const SparseRows& TriDomain::stiffness() const { return impl_->K; }
const Vector& TriDomain::mass() const { return impl_->M; }
const FixedRows& TriDomain::fixed() const { return impl_->fixed; }
const Triangles& TriDomain::triangles() const { return impl_->F; }
const TriDomainFacts& TriDomain::facts() const { return impl_->facts; }

bool TriDomain::covers(const Vec3& x) const {
  if (!impl_->plane) return false;
  return impl_->closest->at(impl_->plane->drop(x), 2 * impl_->tolerance).face >= 0;
}

Interpolation TriDomain::at(const Points& X, const Points&) const {
  std::vector<int> exact(static_cast<std::size_t>(X.rows()), -1);
  std::vector<int> others;
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const auto found = impl_->vertex_at.find(position_of(X, i));
    if (found == impl_->vertex_at.end()) {
      others.push_back(static_cast<int>(i));
    } else {
      exact[static_cast<std::size_t>(i)] = found->second;
    }
  }
  const SparseRows rest =
      barycentric_rows(*impl_->closest, impl_->F, X(others, Eigen::all), impl_->V.rows());
  Interpolation result;
  result.fill.assign(static_cast<std::size_t>(X.rows()), Fill::none);
  result.P.resize(X.rows(), impl_->V.rows());
  result.P.reserve(rest.nonZeros() + X.rows());
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    result.P.startVec(i);
    const int node = exact[static_cast<std::size_t>(i)];
    if (node >= 0) {
      result.P.insertBack(i, node) = 1;
      continue;
    }
    for (SparseRows::InnerIterator it(rest, next); it; ++it) {
      result.P.insertBack(i, it.col()) = it.value();
    }
    ++next;
  }
  result.P.finalize();
  return result;
}

SparseRows TriDomain::from_mesh() const {
  const Eigen::Index n = impl_->mesh.V.rows(), N = impl_->V.rows();
  const Points added = impl_->V.bottomRows(N - n);
  const SparseRows tail =
      barycentric_rows(ClosestPointQuery(impl_->mesh.V, impl_->mesh.F), impl_->mesh.F, added, n);
  SparseRows P(N, n);
  P.reserve(n + tail.nonZeros());
  for (Eigen::Index i = 0; i < N; ++i) {
    P.startVec(i);
    if (i < n) {
      P.insertBack(i, i) = 1;
      continue;
    }
    for (SparseRows::InnerIterator it(tail, i - n); it; ++it) {
      P.insertBack(i, it.col()) = it.value();
    }
  }
  P.finalize();
  return P;
}

}  // namespace skinfield
