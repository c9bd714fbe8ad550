// Constant gradients of the hat functions of one element.
#pragma once

#include "skinfield/base/types.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace skinfield {

/// Gradients of the corners' hat functions as rows of G, and the element's volume or area.
/// volume = 0 and G = 0 for degenerate elements.
template <int Corners>
struct Element {
  Eigen::Matrix<double, Corners, 3> G = Eigen::Matrix<double, Corners, 3>::Zero();
  double volume = 0;
};

inline Element<4> element(const Points& V, const Tetrahedra& T, Eigen::Index e) {
  Element<4> result;
  const Vec3 a = V.row(T(e, 0)), b = V.row(T(e, 1)), c = V.row(T(e, 2)), d = V.row(T(e, 3));
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double det = u.dot(v.cross(w));
  const double longest =
      std::sqrt(std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm(), (c - b).squaredNorm(),
                          (d - b).squaredNorm(), (d - c).squaredNorm()}));
  if (!(std::abs(det) > 1e-16 * longest * longest * longest) || !std::isfinite(det)) return result;
  result.G.row(1) = v.cross(w) / det;
  result.G.row(2) = w.cross(u) / det;
  result.G.row(3) = u.cross(v) / det;
  result.G.row(0) = -(result.G.row(1) + result.G.row(2) + result.G.row(3));
  result.volume = std::abs(det) / 6;
  return result;
}

inline Element<3> element(const Points& V, const Triangles& F, Eigen::Index e) {
  Element<3> result;
  const Vec3 a = V.row(F(e, 0)), b = V.row(F(e, 1)), c = V.row(F(e, 2));
  const Vec3 u = b - a, v = c - a;
  const Vec3 n = u.cross(v);
  const double doubled = n.norm();
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (c - b).squaredNorm()});
  if (!(doubled > 1e-12 * longest) || !std::isfinite(doubled)) return result;
  const Vec3 normal = n / doubled;
  result.G.row(1) = v.cross(normal) / doubled;
  result.G.row(2) = normal.cross(u) / doubled;
  result.G.row(0) = -(result.G.row(1) + result.G.row(2));
  result.volume = doubled / 2;
  return result;
}

}  // namespace skinfield
