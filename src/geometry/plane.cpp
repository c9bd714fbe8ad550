#include "skinfield/geometry/plane.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace skinfield {
namespace {

bool looks_back(const Vec3& n) {
  constexpr double noise = 1e-9;
  for (const int axis : {2, 1, 0}) {
    if (std::abs(n[axis]) > noise) return n[axis] < 0;
  }
  return false;
}

}  // namespace

std::optional<Plane> plane_of(const Points& V, double tolerance) {
  if (V.rows() == 0) return std::nullopt;
  const Eigen::RowVector3d mean = V.colwise().mean();
  const Points r = V.rowwise() - mean;
  Plane plane;
  plane.origin = mean.transpose();
  const auto fits = [&] {
    const Vector height = r * plane.n;
    return height.maxCoeff() - height.minCoeff() <= tolerance;
  };
  // The axes first, so that flat files keep their coordinates; z also for points on a line.
  const bool along_axis = [&] {
    for (const int axis : {2, 1, 0}) {
      plane.n = Vec3::Unit(axis);
      if (fits()) return true;
    }
    return false;
  }();
  if (!along_axis) {
    const Eigen::Matrix3d spread = r.transpose() * r;
    plane.n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
    if (!fits()) return std::nullopt;
    if (looks_back(plane.n)) plane.n = -plane.n;
  }
  const Vec3 up = std::abs(plane.n.y()) > 0.9 ? Vec3(0, 0, -1) : Vec3(0, 1, 0);
  plane.u = up.cross(plane.n).normalized();
  plane.v = plane.n.cross(plane.u);
  return plane;
}

}  // namespace skinfield
