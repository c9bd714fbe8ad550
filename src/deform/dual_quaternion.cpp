#include "skinfield/deform/dual_quaternion.h"

#include "deform/check.h"
#include "skinfield/base/parallel.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <vector>

namespace skinfield {
namespace {

using Coefficients = Eigen::Vector4d;  // x y z w

/// T x = rotation(real) * stretch * x + translation, the translation being in `dual`.
struct Motion {
  Coefficients real = Coefficients::UnitW();
  Coefficients dual = Coefficients::Zero();
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
};

Motion motion_of(const Transform& T) {
  const Eigen::Matrix3d A = T.topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  // A reflection goes into the stretch along the direction that shrinks most.
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) *= -1;
  const Eigen::Matrix3d R = U * svd.matrixV().transpose();
  const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  Eigen::Quaterniond t(0, 0, 0, 0);
  t.vec() = T.topRightCorner<3, 1>();
  Motion motion;
  motion.real = q.coeffs();
  motion.dual = 0.5 * (t * q).coeffs();
  motion.stretch = R.transpose() * A;
  return motion;
}

struct Blend {
  Eigen::Quaterniond rotation;
  Vec3 translation;
  Eigen::Matrix3d stretch;
};

class Blender {
 public:
  explicit Blender(std::span<const Transform> columns) {
    motions_.reserve(columns.size());
    for (const Transform& T : columns) motions_.push_back(motion_of(T));
  }

  /// False if the vertex has no weights.
  bool at(const SkinWeights& weights, Eigen::Index i, Blend& blend) const {
    double largest = 0;
    const Motion* pivot = nullptr;
    for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
      if (it.value() > largest) {
        largest = it.value();
        pivot = &motions_[static_cast<std::size_t>(it.col())];
      }
    }
    if (!pivot) return false;
    Coefficients real = Coefficients::Zero(), dual = Coefficients::Zero();
    blend.stretch.setZero();
    for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
      const Motion& motion = motions_[static_cast<std::size_t>(it.col())];
      const double w = motion.real.dot(pivot->real) < 0 ? -it.value() : it.value();
      real += w * motion.real;
      dual += w * motion.dual;
      blend.stretch += it.value() * motion.stretch;
    }
    // Opposite half turns can cancel; the strongest influence then decides.
    if (real.squaredNorm() < 1e-20 * largest * largest) {
      real = pivot->real;
      dual = pivot->dual;
    }
    const double norm = real.norm();
    blend.rotation = Eigen::Quaterniond(Coefficients(real / norm));
    const Eigen::Quaterniond d(Coefficients(dual / norm));
    blend.translation = 2 * (d * blend.rotation.conjugate()).vec();
    return true;
  }

 private:
  std::vector<Motion> motions_;
};

template <class Move>
Points deform(const Points& X, const SkinWeights& weights, std::span<const Transform> columns,
              const Move& move) {
  check_deformation(X.rows(), weights.vertices(), weights.columns(), columns);
  const Blender blender(columns);
  Points result = X;
  parallel_for(static_cast<std::size_t>(X.rows()), deform_block, [&](std::size_t k) {
    const auto i = static_cast<Eigen::Index>(k);
    Blend blend;
    if (blender.at(weights, i, blend)) {
      result.row(i) = move(blend, Vec3(X.row(i).transpose())).transpose();
    }
  });
  return result;
}

}  // namespace

Points dual_quaternion(const Points& V, const SkinWeights& weights,
                       std::span<const Transform> columns) {
  return deform(V, weights, columns, [](const Blend& blend, const Vec3& x) -> Vec3 {
    return blend.rotation * Vec3(blend.stretch * x) + blend.translation;
  });
}

Points dual_quaternion_normals(const Points& N, const SkinWeights& weights,
                               std::span<const Transform> columns) {
  return deform(N, weights, columns, [](const Blend& blend, const Vec3& normal) -> Vec3 {
    return unit_or_zero(blend.rotation * Vec3(normal_matrix(blend.stretch) * normal));
  });
}

}  // namespace skinfield
