#include "skinfield/deform/linear_blend.h"

#include "deform/check.h"
#include "skinfield/base/parallel.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace skinfield {
namespace {

using Affine = Eigen::Matrix<double, 3, 4>;

/// move(i, blended matrix) for every vertex that has weights.
template <class Move>
void for_each_blend(const SkinWeights& weights, std::span<const Transform> columns,
                    const Move& move) {
  parallel_for(static_cast<std::size_t>(weights.vertices()), deform_block, [&](std::size_t k) {
    const auto i = static_cast<Eigen::Index>(k);
    Affine blend = Affine::Zero();
    bool any = false;
    for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
      if (it.value() == 0) continue;
      blend += it.value() * columns[static_cast<std::size_t>(it.col())].topRows<3>();
      any = true;
    }
    if (any) move(i, blend);
  });
}

}  // namespace

Points linear_blend(const Points& V, const SkinWeights& weights,
                    std::span<const Transform> columns) {
  check_deformation(V.rows(), weights.vertices(), weights.columns(), columns);
  Points result = V;
  for_each_blend(weights, columns, [&](Eigen::Index i, const Affine& blend) {
    const Vec3 x = V.row(i).transpose();
    result.row(i) = (blend.leftCols<3>() * x + blend.col(3)).transpose();
  });
  return result;
}

Points linear_blend_normals(const Points& N, const SkinWeights& weights,
                            std::span<const Transform> columns) {
  check_deformation(N.rows(), weights.vertices(), weights.columns(), columns);
  Points result = N;
  for_each_blend(weights, columns, [&](Eigen::Index i, const Affine& blend) {
    const Vec3 normal = N.row(i).transpose();
    result.row(i) = unit_or_zero(normal_matrix(blend.leftCols<3>()) * normal).transpose();
  });
  return result;
}

}  // namespace skinfield
