// Anderson acceleration of a fixed-point iteration (type II: the least-squares residual).
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// Walker and Ni 2011, "Anderson acceleration for fixed-point iterations", with a weighted norm.
class Anderson {
 public:
  /// @param weight (n) > 0: the norm is sum_i weight_i |F_i|^2 over rows.
  Anderson(int memory, Vector weight) : memory_(memory), weight_(std::move(weight)) {}

  /// S: the iterate, F: its residual (the plain step is S + F). Replaces S by the next iterate.
  void advance(RowMatrix& S, const RowMatrix& F);
  /// Forgets the history; the next step is a plain one.
  void forget();
  /// The norm changes with the penalty: also forgets.
  void set_weight(const Vector& weight);

 private:
  double dot(const RowMatrix& A, const RowMatrix& B) const;

  int memory_;
  Vector weight_;
  RowMatrix previous_S_, previous_F_;
  double previous_norm_ = 0;
  std::vector<RowMatrix> dS_, dF_;  ///< rings of differences
  Eigen::MatrixXd gram_;            ///< <dF_a, dF_b> of the filled slots
  int filled_ = 0, next_ = 0;
};

}  // namespace skinfield
