// Closest point on a triangle soup.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <memory>

namespace skinfield {

struct ClosestPoint {
  int face = -1;
  Vec3 point = Vec3::Zero();
  Vec3 barycentric = Vec3::Zero();
  double distance = 0;
};

/// An immutable bounding-volume hierarchy. Thread-safe for queries.
class ClosestPointQuery {
 public:
  ClosestPointQuery(const Points& V, const Triangles& F);
  ~ClosestPointQuery();
  ClosestPointQuery(ClosestPointQuery&&) noexcept;
  ClosestPointQuery& operator=(ClosestPointQuery&&) noexcept;

  /// face = -1 if there are no triangles, or none within max_distance.
  ClosestPoint at(const Vec3& x, double max_distance = 1e300) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Closest point of segment a-b to x; the parameter in [0,1].
double closest_on_segment(const Vec3& a, const Vec3& b, const Vec3& x);
double distance_to_segment(const Vec3& a, const Vec3& b, const Vec3& x);

}  // namespace skinfield
