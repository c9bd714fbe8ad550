#include "skinfield/operators/mass.h"

#include "skinfield/operators/stiffness.h"

namespace skinfield {
namespace {

template <class Elements>
Vector lump(const Points& V, const Elements& E) {
  const Vector volume = element_volumes(V, E);
  Vector M = Vector::Zero(V.rows());
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    for (Eigen::Index i = 0; i < E.cols(); ++i) {
      M[E(e, i)] += volume[e] / static_cast<double>(E.cols());
    }
  }
  const double mean = M.size() > 0 && M.sum() > 0 ? M.mean() : 1.0;
  for (double& m : M) {
    if (!(m > 0)) m = 1e-12 * mean;
  }
  return M;
}

}  // namespace

Vector barycentric_mass(const Points& V, const Tetrahedra& T) { return lump(V, T); }
Vector barycentric_mass(const Points& V, const Triangles& F) { return lump(V, F); }

}  // namespace skinfield
