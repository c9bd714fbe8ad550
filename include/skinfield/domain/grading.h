// Where kernels are narrower: beside short bones, so that the fingers of a whole human get
// resolution (geometric fields; the paper's open failure, its figure 19).
#pragma once

#include "skinfield/base/types.h"

#include <utility>
#include <vector>

namespace skinfield {

/// Width relative to the largest: s(x) = min over bones b of max(|b|, dist(x, b)) over a reference
/// length, between `least` and 1. Points are spread with density
/// s^-d in d dimensions. Positions in the unit box.
class Grading {
 public:
  using Segments = std::vector<std::pair<Vec3, Vec3>>;
  /// 1 everywhere.
  Grading() = default;
  /// @param segments of no length (point handles) ask for nothing. @param places (n,3) uniform in
  /// the shape: at half of them s is 1. @param least in (0,1]. @param dimension 2 or 3.
  Grading(const Segments& segments, const Points& places, double least, int dimension = 3);

  bool uniform() const { return segments_.empty(); }
  double least() const { return least_; }
  double at(const Vec3& x) const;
  /// Of points.
  double density(const Vec3& x) const;
  /// s changes by at most so much a unit of length.
  double slope() const { return uniform() ? 0 : 1 / reference_; }

 private:
  double length_at(const Vec3& x) const;

  Segments segments_;
  double reference_ = 1, least_ = 1;
  int dimension_ = 3;
};

}  // namespace skinfield
