// The one precondition of all deformers.
#pragma once

#include "skinfield/base/error.h"
#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/skin_weights.h"

#include <span>
#include <string>

namespace skinfield {

constexpr std::size_t deform_block = 4096;  ///< vertices

inline void check_deformation(Eigen::Index vertices, Eigen::Index rows, Eigen::Index weight_columns,
                              std::span<const Transform> columns) {
  if (vertices != rows) {
    throw InputError(
        std::to_string(rows) + " weight rows for " + std::to_string(vertices) + " vertices",
        "deform");
  }
  if (static_cast<Eigen::Index>(columns.size()) != weight_columns) {
    throw InputError(std::to_string(columns.size()) + " transforms for " +
                         std::to_string(weight_columns) + " weight columns",
                     "deform");
  }
}

/// The cofactor matrix: the inverse transpose up to a positive factor, also of singular matrices;
/// of a reflection with the sign that keeps normals outward.
inline Eigen::Matrix3d normal_matrix(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d C;
  C.row(0) = A.row(1).cross(A.row(2));
  C.row(1) = A.row(2).cross(A.row(0));
  C.row(2) = A.row(0).cross(A.row(1));
  return A.determinant() < 0 ? Eigen::Matrix3d(-C) : C;
}

/// Unit length, or zero.
inline Vec3 unit_or_zero(const Vec3& x) {
  const double length = x.norm();
  return length > 0 ? Vec3(x / length) : Vec3(Vec3::Zero());
}

}  // namespace skinfield
