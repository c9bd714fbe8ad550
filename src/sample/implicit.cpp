#include "sample/implicit.h"

#include <algorithm>
#include <limits>

namespace skinfield::sample_detail {
namespace {

/// Exactly min(a,b) where they differ by more than k; else a quadratic fillet.
double smooth_min(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0);
  return std::min(a, b) - (h > 0 ? h * h / (4 * k) : 0.0);
}

}  // namespace

double Primitive::distance(const Vec3& x) const {
  if (ellipsoid) {
    // First-order distance q (q - 1) / |grad| with q the scaled radius: exact on the surface.
    const Vec3 scaled = (x - a).cwiseQuotient(b);
    const double q = scaled.norm(), slope = scaled.cwiseQuotient(b).norm();
    return slope > 0 ? q * (q - 1) / slope : -b.minCoeff();
  }
  const Vec3 axis = b - a;
  const double t = std::clamp((x - a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (x - a - t * axis).norm() - (radius_a + t * (radius_b - radius_a));
}

void ImplicitShape::capsule(const Vec3& a, double radius_a, const Vec3& b, double radius_b,
                            double blend) {
  primitives_.push_back({false, a, b, radius_a, radius_b, blend});
}

void ImplicitShape::ellipsoid(const Vec3& centre, const Vec3& radii, double blend) {
  primitives_.push_back({true, centre, radii, 0, 0, blend});
}

Box3 ImplicitShape::box() const {
  Box3 box;
  box.row(0).setConstant(std::numeric_limits<double>::infinity());
  box.row(1) = -box.row(0);
  for (const Primitive& p : primitives_) {
    const Vec3 margin = Vec3::Constant(p.blend);
    const Vec3 a = p.ellipsoid ? p.b : Vec3::Constant(p.radius_a);
    const Vec3 other = p.ellipsoid ? p.a : p.b;
    const Vec3 b = p.ellipsoid ? p.b : Vec3::Constant(p.radius_b);
    const Vec3 low = (p.a - a).cwiseMin(other - b) - margin;
    const Vec3 high = (p.a + a).cwiseMax(other + b) + margin;
    box.row(0) = box.row(0).cwiseMin(low.transpose());
    box.row(1) = box.row(1).cwiseMax(high.transpose());
  }
  return box;
}

double ImplicitShape::at(const Vec3& x) const {
  double value = std::numeric_limits<double>::max();
  for (const Primitive& p : primitives_) value = smooth_min(value, p.distance(x), p.blend);
  return value;
}

double ImplicitShape::at(const Vec3& x, const std::vector<int>& which) const {
  double value = std::numeric_limits<double>::max();
  for (const int i : which) {
    const Primitive& p = primitives_[static_cast<std::size_t>(i)];
    value = smooth_min(value, p.distance(x), p.blend);
  }
  return value;
}

double ImplicitShape::thickness(const Vec3& x, const std::vector<int>& which) const {
  double nearest = std::numeric_limits<double>::max(), thickness = 0;
  for (const int i : which) {
    const Primitive& p = primitives_[static_cast<std::size_t>(i)];
    const double distance = p.distance(x);
    if (distance >= nearest) continue;
    nearest = distance;
    thickness = p.ellipsoid ? p.b.minCoeff() : std::min(p.radius_a, p.radius_b);
  }
  return thickness;
}

std::vector<int> ImplicitShape::near(const Vec3& x, double radius) const {
  double nearest = std::numeric_limits<double>::max(), blend = 0;
  for (const Primitive& p : primitives_) {
    nearest = std::min(nearest, p.distance(x));
    blend = std::max(blend, p.blend);
  }
  std::vector<int> which;
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    if (primitives_[i].distance(x) <= nearest + 2.5 * radius + 2 * blend) {
      which.push_back(static_cast<int>(i));
    }
  }
  return which;
}

}  // namespace skinfield::sample_detail
