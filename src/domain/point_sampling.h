// Nodes of the point domain: samples on the handles, Poisson-disk points inside, Lloyd steps.
#pragma once

#include "skinfield/domain/point_domain.h"

#include <algorithm>
#include <vector>

namespace skinfield {

/// Nodes with prescribed weights: points on the handles, inside the shape (those that k handles
/// share have 1/k of each), and painted points.
struct FixedNodes {
  Points X;           ///< (k,3) distinct positions
  RowMatrix weights;  ///< (k,m)
};

/// Target distance between nodes, h(x) = clamp(c * min_i max(base_i, slope |x - y_i|)).
class SizeField {
 public:
  /// Constant h.
  explicit SizeField(double h) : low_(h), high_(h) {}
  SizeField(Points centres, Vector base, double slope)
      : centres_(std::move(centres)), base_(std::move(base)), slope_(slope) {}
  void scale(double c, double low, double high) { c_ = c, low_ = low, high_ = high; }
  void stretch(double factor) { c_ *= factor, low_ *= factor, high_ *= factor; }
  double at(const Vec3& x) const { return of_shape(shape(x)); }
  /// The field before it is scaled and clamped, and the field for that.
  double shape(const Vec3& x) const;
  double of_shape(double shape) const {
    return low_ >= high_ ? low_ : std::clamp(c_ * shape, low_, high_);
  }
  /// The same field within `radius` of x: without the centres that are nowhere least there.
  SizeField near(const Vec3& x, double radius) const;
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  Points centres_;
  Vector base_;
  double slope_ = 0.3, c_ = 1, low_ = 0, high_ = 1e300;
};

struct SampledNodes {
  Points X;  ///< fixed nodes first
  std::vector<Site> sites;
  FixedNodes fixed;
  Vector spacing;  ///< (N) local h
  double volume = 0;
};

/// @throws DomainError if the shape has no volume or no handle a part inside.
SampledNodes sample_nodes(const Solid& solid, const std::vector<Handle>& handles,
                          const PaintedPoints& paint, const PointDomainOptions& options,
                          PointDomainFacts& facts, const Progress& progress);

}  // namespace skinfield
