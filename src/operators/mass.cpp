#include "skinfield/operators/mass.h"

#include "operators/voronoi_shares.h"
#include "skinfield/base/parallel.h"
#include "skinfield/operators/stiffness.h"

#include <vector>

namespace skinfield {
namespace {

template <class Elements>
Vector lump(const Points& V, const Elements& E, MassKind kind) {
  constexpr std::size_t corners = Elements::ColsAtCompileTime;
  const Vector volume = element_volumes(V, E);
  std::vector<std::array<double, corners>> share(static_cast<std::size_t>(E.rows()));
  parallel_for(share.size(), 1024, [&](std::size_t t) {
    const auto e = static_cast<Eigen::Index>(t);
    if (!(volume[e] > 0)) {
      share[t].fill(0);
    } else if (kind == MassKind::barycentric) {
      share[t].fill(volume[e] / static_cast<double>(corners));
    } else {
      std::array<Vec3, corners> corner;
      for (std::size_t i = 0; i < corners; ++i)
        corner[i] = V.row(E(e, static_cast<Eigen::Index>(i)));
      share[t] = voronoi_shares(corner);
    }
  });
  Vector M = Vector::Zero(V.rows());
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    for (Eigen::Index i = 0; i < E.cols(); ++i)
      M[E(e, i)] += share[static_cast<std::size_t>(e)][static_cast<std::size_t>(i)];
  }
  const double mean = M.size() > 0 && M.sum() > 0 ? M.mean() : 1.0;
  for (double& m : M) {
    if (!(m > 0)) m = 1e-12 * mean;
  }
  return M;
}

}  // namespace

Vector lumped_mass(const Points& V, const Tetrahedra& T, MassKind kind) { return lump(V, T, kind); }
Vector lumped_mass(const Points& V, const Triangles& F, MassKind kind) { return lump(V, F, kind); }

Vector barycentric_mass(const Points& V, const Tetrahedra& T) {
  return lump(V, T, MassKind::barycentric);
}
Vector barycentric_mass(const Points& V, const Triangles& F) {
  return lump(V, F, MassKind::barycentric);
}

}  // namespace skinfield
