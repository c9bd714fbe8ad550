// The plane that a flat shape lies in, with coordinates in it.
#pragma once

#include "skinfield/base/types.h"

#include <optional>

namespace skinfield {

/// Orthonormal, right-handed axes: n = u x v. The normal looks to the front (z > 0), else up
/// (y > 0), else to the right; v is y, or -z where the plane is level, as far as it can be.
struct Plane {
  Vec3 origin = Vec3::Zero();
  Vec3 u = Vec3::UnitX(), v = Vec3::UnitY(), n = Vec3::UnitZ();

  Eigen::Vector2d to(const Vec3& x) const { return {u.dot(x - origin), v.dot(x - origin)}; }
  Vec3 from(const Eigen::Vector2d& p) const { return origin + p.x() * u + p.y() * v; }
  /// The nearest place of the plane.
  Vec3 drop(const Vec3& x) const { return x - n.dot(x - origin) * n; }
};

/// The best plane (least squares) if all of V (n,3) lies within `tolerance` of each other along its
/// normal; nothing otherwise. Points on one line lie in many planes and get one of them. Empty V:
/// nothing. Precondition: finite.
std::optional<Plane> plane_of(const Points& V, double tolerance);

}  // namespace skinfield
