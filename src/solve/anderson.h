// Anderson acceleration of a fixed-point iteration (type II: the least-squares residual).
#pragma once

#include "skinfield/base/types.h"

#include <cstdint>
#include <vector>

namespace skinfield {

/// Walker and Ni 2011, "Anderson acceleration for fixed-point iterations", with a weighted norm.
class Anderson {
 public:
  static constexpr int kMemory = 8;

  /// S: the iterate, F: its residual (the plain step is S + F). weight: of each entry, > 0: the
  /// norm is sum_e weight_e F_e^2. Replaces S by the next iterate.
  void advance(const Vector& weight, Vector& S, const Vector& F);
  /// Forgets the history; the next step is a plain one. To be called when the norm changes.
  void forget();
  /// The iterate gets new entries: old[e] is the old number of entry e, -1 for a new one, whose
  /// history is zero. No old entry may be dropped.
  void remap(const std::vector<std::int64_t>& old);

 private:
  Vector previous_S_, previous_F_;
  double previous_norm_ = 0;
  std::vector<Vector> dG_, dF_;  ///< rings of differences: of S + F, and of F
  Eigen::MatrixXd gram_;         ///< <dF_a, dF_b> of the filled slots
  int filled_ = 0, next_ = 0;
};

/// values[old[e]] for every e, 0 where that is -1.
Vector remapped(const Vector& values, const std::vector<std::int64_t>& old);

}  // namespace skinfield
