// Rays against triangles (Embree behind it). Callers know rays, not the hierarchy.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <memory>
#include <span>
#include <vector>

namespace skinfield {

struct RayHit {
  double t = 0;         ///< in units of the direction's length (for segments: in [0,1])
  int face = -1;        ///< -1: nothing was hit
  double u = 0, v = 0;  ///< barycentric coordinates of corners 1 and 2
  double sign = 0;      ///< +1: the ray enters (runs against the face normal), -1: it leaves
  explicit operator bool() const { return face >= 0; }
};

/// An immutable set of triangles in single precision. Thread-safe for queries. Any units: inside,
/// positions are relative to the box of the triangles (precision: about 1e-7 of its side).
class RayScene {
 public:
  /// Faces with repeated indices or zero area are left out but keep their numbers.
  RayScene(const Points& V, const Triangles& F);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  bool empty() const;
  /// Does any triangle meet the open segment a-b? `skip` at each end: that length is left out
  /// (for end points that lie on the surface).
  bool occluded(const Vec3& a, const Vec3& b, double skip_a = 0, double skip_b = 0) const;
  /// For many segments that start at one point: blocked[i] != 0 where a-B[i] is occluded.
  void occluded(const Vec3& a, std::span<const Vec3> b, std::span<unsigned char> blocked) const;
  /// First hit of origin + t * direction, t in (t_min, t_max).
  RayHit first_hit(const Vec3& origin, const Vec3& direction, double t_min, double t_max) const;
  /// First hits of many rays from one origin ; t_max per ray.
  void first_hits(const Vec3& origin, std::span<const Vec3> directions,
                  std::span<const double> t_max, std::span<RayHit> hits) const;
  /// Every hit along a-b, sorted by (t, face). A triangle is reported once. Coincident duplicate
  /// triangles are all reported. Where the segment meets an edge or a corner, the faces around it
  /// count as if it passed beside, so that on closed surfaces the signs add up to
  /// winding(b) - winding(a). t is exact to double precision.
  void all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const;
  /// The faces that a-b meets as single precision has it, in no order; near edges perhaps one too
  /// many or too few. For callers that make their own test.
  void faces_along(const Vec3& a, const Vec3& b, std::vector<int>& faces) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
