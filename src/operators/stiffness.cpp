#include "skinfield/operators/stiffness.h"

#include "operators/elements.h"

#include <vector>

namespace skinfield {
namespace {

template <class Elements>
SparseRows assemble_stiffness(const Points& V, const Elements& E) {
  constexpr int corners = Elements::ColsAtCompileTime;
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(static_cast<std::size_t>(E.rows() * corners * corners + V.rows()));
  for (std::int32_t i = 0; i < V.rows(); ++i) entries.emplace_back(i, i, 0.0);
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Element<corners> one = element(V, E, e);
    if (one.volume == 0) continue;
    for (int i = 0; i < corners; ++i) {
      for (int j = i + 1; j < corners; ++j) {
        // Each edge is added as a link, so that K 1 = 0 up to the rounding of row sums.
        const double k = one.volume * one.G.row(i).dot(one.G.row(j));
        entries.emplace_back(E(e, i), E(e, j), k);
        entries.emplace_back(E(e, j), E(e, i), k);
        entries.emplace_back(E(e, i), E(e, i), -k);
        entries.emplace_back(E(e, j), E(e, j), -k);
      }
    }
  }
  SparseRows K(V.rows(), V.rows());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

template <class Elements>
SparseRows assemble_gradient(const Points& V, const Elements& E) {
  constexpr int corners = Elements::ColsAtCompileTime;
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(static_cast<std::size_t>(E.rows() * corners * 3));
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Element<corners> one = element(V, E, e);
    if (one.volume == 0) continue;
    for (int i = 0; i < corners; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        entries.emplace_back(static_cast<std::int32_t>(3 * e + axis), E(e, i), one.G(i, axis));
      }
    }
  }
  SparseRows G(3 * E.rows(), V.rows());
  G.setFromTriplets(entries.begin(), entries.end());
  return G;
}

template <class Elements>
Vector volumes(const Points& V, const Elements& E) {
  Vector result(E.rows());
  for (Eigen::Index e = 0; e < E.rows(); ++e) result[e] = element(V, E, e).volume;
  return result;
}

}  // namespace

SparseRows stiffness(const Points& V, const Tetrahedra& T) { return assemble_stiffness(V, T); }
SparseRows stiffness(const Points& V, const Triangles& F) { return assemble_stiffness(V, F); }
SparseRows gradient(const Points& V, const Tetrahedra& T) { return assemble_gradient(V, T); }
SparseRows gradient(const Points& V, const Triangles& F) { return assemble_gradient(V, F); }
Vector element_volumes(const Points& V, const Tetrahedra& T) { return volumes(V, T); }
Vector element_volumes(const Points& V, const Triangles& F) { return volumes(V, F); }

}  // namespace skinfield
