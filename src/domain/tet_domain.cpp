#include "skinfield/domain/tet_domain.h"

#include "domain/tet_handles.h"
#include "domain/tet_locator.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace skinfield {
namespace {

constexpr const char* kWhere = "tet domain";

/// Tets with four different corners and a volume that stiffness counts; equal positions made one.
Tetrahedra proper_tets(const Points& V, const Tetrahedra& T, TetDomainFacts& facts) {
  const Welded welded = weld(V);
  std::vector<int> first(static_cast<std::size_t>(welded.V.rows()), -1);
  for (int v = 0; v < V.rows(); ++v) {
    int& f = first[static_cast<std::size_t>(welded.vertex[static_cast<std::size_t>(v)])];
    if (f < 0) f = v;
  }
  Tetrahedra merged(T.rows(), 4);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) {
      merged(t, c) =
          first[static_cast<std::size_t>(welded.vertex[static_cast<std::size_t>(T(t, c))])];
    }
  }
  const Vector volume = element_volumes(V, merged);
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < merged.rows(); ++t) {
    if (!(volume[t] > 0)) {
      ++facts.degenerate_tets;
      continue;
    }
    const auto corner = [&](int c) { return Vec3(V.row(merged(t, c)).transpose()); };
    const Vec3 a = corner(0);
    facts.inverted_tets += (corner(1) - a).cross(corner(2) - a).dot(corner(3) - a) < 0;
    facts.volume += volume[t];
    merged.row(kept++) = merged.row(t);
  }
  merged.conservativeResize(kept, 4);
  return merged;
}

/// Counts the components of nodes that tets couple.
void count_components(const SparseRows& K, const FixedRows& fixed, TetDomainFacts& facts) {
  const auto n = static_cast<std::size_t>(K.rows());
  std::vector<char> is_fixed(n, 0), seen(n, 0);
  for (const int i : fixed.node) is_fixed[static_cast<std::size_t>(i)] = 1;
  for (std::size_t s = 0; s < n; ++s) {
    if (seen[s]) continue;
    std::vector<int> component{static_cast<int>(s)};
    seen[s] = 1;
    bool handle = false;
    for (std::size_t k = 0; k < component.size(); ++k) {
      handle |= is_fixed[static_cast<std::size_t>(component[k])] != 0;
      for (SparseRows::InnerIterator it(K, component[k]); it; ++it) {
        char& known = seen[static_cast<std::size_t>(it.col())];
        if (known || it.value() == 0) continue;
        known = 1;
        component.push_back(static_cast<int>(it.col()));
      }
    }
    if (component.size() == 1) {
      ++facts.uncoupled_nodes;
      continue;
    }
    ++facts.components;
    if (handle) continue;
    ++facts.components_without_handle;
    facts.nodes_without_handle += static_cast<int>(component.size());
  }
}

/// The given masses on the mesh as it was; after splits their density.
Vector masses(const Points& V, const Tetrahedra& T, const TetSplit& split,
              const TetDomainOptions& options) {
  const Vector& given = options.mass;
  if (given.size() == 0) return lumped_mass(split.V, split.T, options.mass_kind);
  if (given.size() != V.rows() || !(given.array() > 0).all() || !given.allFinite()) {
    throw InputError("the masses are not " + std::to_string(V.rows()) + " positive numbers", kWhere,
                     "give one a vertex");
  }
  if (split.made.empty()) return given;
  const Vector before = barycentric_mass(V, T);
  Vector density(split.V.rows());
  density.head(V.rows()) = given.cwiseQuotient(before);
  for (std::size_t k = 0; k < split.made.size(); ++k) {
    const TetSplitter::Place& from = split.made[k];
    double& d = density[V.rows() + static_cast<Eigen::Index>(k)];
    d = 0;
    for (std::size_t c = 0; c < from.corner.size(); ++c)
      d += from.share[c] * density[from.corner[c]];
  }
  return barycentric_mass(split.V, split.T).cwiseProduct(density);
}

}  // namespace

struct TetDomain::Impl {
  Points V;
  Tetrahedra T;
  SparseRows K;
  Vector M;
  FixedRows fixed;
  TetDomainFacts facts;
  Triangles boundary;
  std::optional<TetLocator> locator;
  std::optional<ClosestPointQuery> closest;
};

TetDomain::TetDomain(const Points& V, const Tetrahedra& T, const std::vector<Handle>& handles,
                     const TetDomainOptions& options)
    : impl_(std::make_unique<Impl>()) {
  Impl& d = *impl_;
  const Tetrahedra proper = proper_tets(V, T, d.facts);
  if (proper.rows() == 0) throw DomainError("no tetrahedron has a volume", kWhere);
  TetSplit split = split_at_handles(V, proper, handles);
  d.M = masses(V, proper, split, options);
  d.V = std::move(split.V);
  d.T = std::move(split.T);
  d.fixed = std::move(split.fixed);
  d.K = skinfield::stiffness(d.V, d.T);
  d.facts.split_handles = split.split_handles;
  d.facts.new_nodes = static_cast<int>(split.made.size());
  d.facts.outside = std::move(split.outside);
  d.facts.handle_nodes = static_cast<int>(d.fixed.node.size());
  if (!handles.empty() && d.fixed.node.empty()) {
    throw DomainError("no handle has a part inside the tet mesh", kWhere,
                      "check the skeleton's position and scale, or use --domain points");
  }
  count_components(d.K, d.fixed, d.facts);
  d.boundary = boundary_faces(d.V, d.T);
  d.locator.emplace(d.V, d.T);
  d.closest.emplace(d.V, d.boundary);
}

TetDomain::~TetDomain() = default;

const Points& TetDomain::nodes() const { return impl_->V; }
const SparseRows& TetDomain::stiffness() const { return impl_->K; }
const Vector& TetDomain::mass() const { return impl_->M; }
const FixedRows& TetDomain::fixed() const { return impl_->fixed; }
const Tetrahedra& TetDomain::elements() const { return impl_->T; }
const TetDomainFacts& TetDomain::facts() const { return impl_->facts; }
bool TetDomain::contains(const Vec3& x) const { return impl_->locator->find(x).tet >= 0; }

Interpolation TetDomain::at(const Points& X, const Points&) const {
  const Impl& d = *impl_;
  const auto n = static_cast<std::size_t>(X.rows());
  struct Row {
    std::array<int, 4> node{};
    Barycentric share = Barycentric::Zero();
  };
  std::vector<Row> rows(n);
  parallel_for(n, 64, [&](std::size_t i) {
    const Vec3 x = X.row(static_cast<Eigen::Index>(i)).transpose();
    const TetLocator::Place place = d.locator->find(x);
    Row& row = rows[i];
    if (place.tet >= 0) {
      for (int c = 0; c < 4; ++c) row.node[static_cast<std::size_t>(c)] = d.T(place.tet, c);
      row.share = place.b;
      return;
    }
    const ClosestPoint closest = d.closest->at(x);
    if (closest.face < 0) return;  // not a finite point
    const Vec3 b = closest.barycentric.cwiseMax(0.0);
    for (int c = 0; c < 3; ++c) row.node[static_cast<std::size_t>(c)] = d.boundary(closest.face, c);
    row.share.head<3>() = b / b.sum();
  });
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (int c = 0; c < 4; ++c) {
      if (!(rows[i].share[c] > 0)) continue;
      entries.emplace_back(static_cast<std::int32_t>(i), rows[i].node[static_cast<std::size_t>(c)],
                           rows[i].share[c]);
    }
  }
  Interpolation result;
  result.P.resize(X.rows(), d.V.rows());
  result.P.setFromTriplets(entries.begin(), entries.end());
  result.fill.assign(n, Fill::none);
  return result;
}

}  // namespace skinfield
