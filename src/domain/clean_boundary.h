// What bounds the clean parts of a solid, whatever it is made of: triangles in space, or segments
// in the plane.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/geometry/ray_scene.h"

#include <memory>
#include <span>
#include <vector>

namespace skinfield {

/// Thread-safe for queries.
class CleanBoundary {
 public:
  virtual ~CleanBoundary() = default;
  virtual bool occluded(const Vec3& a, const Vec3& b) const = 0;
  virtual void all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const = 0;
  virtual void first_hits(const Vec3& origin, std::span<const Vec3> directions,
                          std::span<const double> t_max, std::span<RayHit> hits) const = 0;
  virtual double winding(const Vec3& x) const = 0;
  virtual double distance(const Vec3& x) const = 0;
};

/// @param accuracy of the fast winding number.
std::unique_ptr<CleanBoundary> boundary_of_triangles(const Points& V, const Triangles& F,
                                                     double accuracy);
/// The winding number of segments that close is counted, that of others measured by their angles.
std::unique_ptr<CleanBoundary> boundary_of_segments(const Points& V, const Segments& closed,
                                                    const Segments& open);

}  // namespace skinfield
