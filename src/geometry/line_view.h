// Exact side tests of a line against edges.
#pragma once

#include "skinfield/base/types.h"

#include <Eigen/Dense>

#include <cmath>

namespace skinfield {

/// A line seen along itself: space sheared so that the line becomes the origin of a plane. Every
/// point has one image, so that what faces decide about shared edges and corners agrees.
class LineView {
 public:
  LineView(const Vec3& origin, const Vec3& direction) : origin_(origin) {
    direction.cwiseAbs().maxCoeff(&depth_);
    slope_ = direction / direction[depth_];
    turned_ = direction[depth_] < 0;
  }
  Eigen::Vector2d operator()(const Vec3& x) const {
    const Vec3 r = x - origin_;
    const int i = (depth_ + 1) % 3, j = (depth_ + 2) % 3;
    return {r[i] - slope_[i] * r[depth_], r[j] - slope_[j] * r[depth_]};
  }
  /// On which side the line passes the edge p-q (images): +1 or -1, never 0, exactly. Ties are
  /// broken as if the line were moved by (e, e^2), e -> 0 (Edelsbrunner and Muecke 1990).
  int side(const Eigen::Vector2d& p, const Eigen::Vector2d& q) const {
    const double left = p.x() * q.y(), right = p.y() * q.x();
    if (left != right) return (left > right) != turned_ ? 1 : -1;
    double side = std::fma(p.x(), q.y(), -left) - std::fma(p.y(), q.x(), -right);
    if (side == 0) side = p.y() - q.y();
    if (side == 0) side = q.x() - p.x();
    return (side > 0) != turned_ ? 1 : -1;
  }

 private:
  Vec3 origin_, slope_;
  int depth_ = 0;
  bool turned_ = false;
};

}  // namespace skinfield
