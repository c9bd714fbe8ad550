// Implicit shapes: a smooth union of capsules and ellipsoids, negative inside.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield::sample_detail {

/// A capsule with a radius at each end, or an axis-aligned ellipsoid.
struct Primitive {
  bool ellipsoid = false;
  Vec3 a, b;  ///< ends; of an ellipsoid its centre and radii
  double radius_a = 0, radius_b = 0;
  double blend = 0.01;  ///< width of the fillet with what came before

  /// Near the surface its distance, negative inside.
  double distance(const Vec3& x) const;
};

/// Primitives are united in order; each blends with the union of those before it.
class ImplicitShape {
 public:
  void capsule(const Vec3& a, double radius_a, const Vec3& b, double radius_b, double blend);
  void ellipsoid(const Vec3& centre, const Vec3& radii, double blend);

  Box3 box() const;
  double at(const Vec3& x) const;
  /// How thick the shape is near x: the radius of the nearest primitive.
  double thickness(const Vec3& x, const std::vector<int>& which) const;
  /// The same as at(x), of the listed primitives only.
  double at(const Vec3& x, const std::vector<int>& which) const;
  /// Primitives that matter within `radius` of x.
  std::vector<int> near(const Vec3& x, double radius) const;

 private:
  std::vector<Primitive> primitives_;
};

}  // namespace skinfield::sample_detail
