// Closed, evenly meshed boxes and solids of revolution, appended to one mesh.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <array>
#include <utility>
#include <vector>

namespace skinfield::sample_detail {

class SolidBuilder {
 public:
  /// @param edge about the length of an edge.
  explicit SolidBuilder(double edge) : edge_(edge) {}

  /// Edges rounded by `radius` <= every half size; all equal: a sphere.
  void rounded_box(const Vec3& centre, const Vec3& half_size, double radius);
  /// From a to b, the radius running from radius_a to radius_b, rims rounded.
  void cylinder(const Vec3& a, double radius_a, const Vec3& b, double radius_b, double rim);

  int faces() const { return static_cast<int>(faces_.size()); }
  int vertices() const { return static_cast<int>(positions_.size()); }
  Mesh finish() const;

 private:
  double edge_;
  std::vector<Vec3> positions_;
  std::vector<std::array<int, 3>> faces_;
};

}  // namespace skinfield::sample_detail
