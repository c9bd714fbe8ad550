// Fast generalized winding number of triangle soups and oriented point clouds (Barill, Dickson,
// Schmidt, Levin, Jacobson: "Fast winding numbers for soups and clouds", SIGGRAPH 2018),
// second-order expansion. 1 inside a closed outward-oriented surface, 0 outside.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <memory>

namespace skinfield {

struct WindingNumberOptions {
  /// A cluster of radius r is expanded from distance accuracy * r on; larger is more exact.
  double accuracy = 2.0;
};

class WindingNumber {
 public:
  WindingNumber(const Points& V, const Triangles& F, const WindingNumberOptions& options = {});
  /// Oriented points: dipoles N_i * area_i at P_i (N unit, outward; area > 0, (n)).
  WindingNumber(const Points& P, const Points& N, const Vector& area,
                const WindingNumberOptions& options = {});
  ~WindingNumber();
  WindingNumber(WindingNumber&&) noexcept;
  WindingNumber& operator=(WindingNumber&&) noexcept;

  double at(const Vec3& x) const;
  /// (k) values at (k,3) points, in parallel.
  Vector at(const Points& X) const;
  /// Smoothed, for dirty soups and clouds: 1/4pi sum A n.(c-x) / (|c-x|^2 + epsilon^2)^(3/2) over
  /// triangle centroids (or points) c, hierarchically (findings.md E, rule 4).
  double smoothed(const Vec3& x, double epsilon) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The oracle: the direct sum over triangles (van Oosterom and Strackee 1983), one by one.
double winding_number_direct(const Points& V, const Triangles& F, const Vec3& x);

/// The solid angle / 4 pi of one triangle seen from x, signed.
double solid_angle_fraction(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x);

}  // namespace skinfield
