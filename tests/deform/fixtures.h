// Random positions, weights and rigid motions.
#pragma once

#include "skinfield/base/random.h"
#include "skinfield/rig/pose.h"
#include "skinfield/weights/operations.h"

#include <vector>

namespace skinfield_test {

inline skinfield::Points random_points(int n, std::uint64_t seed) {
  skinfield::Points P(n, 3);
  skinfield::Random random(seed);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) P(i, k) = 2 * random.uniform() - 1;
  }
  return P;
}

/// At most `influences` a row; row 0 has all its weight on column 0.
inline skinfield::SkinWeights random_simplex(int n, int m, int influences, std::uint64_t seed) {
  skinfield::RowMatrix W(n, m);
  skinfield::Random random(seed, 1);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) W(i, j) = i == 0 ? (j == 0) : random.uniform() + 1e-3;
  }
  return skinfield::prune(skinfield::sparse_weights(W), {.max_influences = influences}).weights;
}

inline skinfield::Transform random_rigid(std::uint64_t seed) {
  skinfield::Random random(seed, 2);
  skinfield::Transform T = skinfield::Transform::Identity();
  T.topLeftCorner<3, 3>() =
      Eigen::AngleAxisd(2 * random.uniform(), random.direction()).toRotationMatrix();
  T.topRightCorner<3, 1>() = random.direction();
  return T;
}

inline skinfield::Points transformed(const skinfield::Transform& T, const skinfield::Points& V) {
  return (V * T.topLeftCorner<3, 3>().transpose()).rowwise() + T.topRightCorner<3, 1>().transpose();
}

inline double largest(const skinfield::Points& difference) {
  return difference.cwiseAbs().maxCoeff();
}

}  // namespace skinfield_test
