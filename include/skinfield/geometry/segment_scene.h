// Rays against line segments in the plane z = 0: what RayScene is for triangles. Callers know rays,
// not the hierarchy.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/geometry/ray_scene.h"

#include <memory>
#include <span>
#include <vector>

namespace skinfield {

/// An immutable set of segments; x and y alone count. The inside is to the left of a segment: a ray
/// that crosses it from its right side enters (sign +1). Thread-safe for queries. Any units.
class SegmentScene {
 public:
  /// Segments of no length are left out but keep their numbers, which are RayHit's faces.
  SegmentScene(const Points& V, const Segments& E);
  ~SegmentScene();
  SegmentScene(SegmentScene&&) noexcept;
  SegmentScene& operator=(SegmentScene&&) noexcept;

  bool empty() const;
  /// Does any segment cross a-b?
  bool occluded(const Vec3& a, const Vec3& b) const;
  /// The first crossing of origin + t * direction, t in [0, t_max).
  RayHit first_hit(const Vec3& origin, const Vec3& direction, double t_max) const;
  /// Every crossing of a-b, sorted by (t, segment). Where a-b meets an end of segments, they count
  /// as if it passed beside, so that on closed outlines the signs add up to winding(b) -
  /// winding(a).
  void all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const;
  /// Winding number of closed outlines: crossings on the way out.
  double winding(const Vec3& x) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Generalized winding number of any segments: the angles that they subtend at x, over 2 pi.
double winding_number_of_segments(const Points& V, const Segments& E, const Vec3& x);

}  // namespace skinfield
