// The dual objective of the weights' program in squared variables.
#pragma once

#include "solve/constrained_inverse.h"
#include "solve/free_rows.h"

namespace skinfield {

/// Constraints on the free rows: those of the fixed ones are moved to the right-hand side.
struct FreeConstraints {
  SparseRows C;  ///< (k,n), k = 0 for none
  RowMatrix D;   ///< (k,m)
};

/// Convex duality, equations 12 to 16 (simplices) and B6, B7 (boxes):
///   f(T) = 1/2 <T, Q11 T P> + <R, T> (+ <s, U>),  T = Y or Y - U,  Y, U >= 0,
/// with Y_ij = scale x_ij^2 (Chou, Maly, Verdun 2022), and U alike. P = P_m for simplices, the
/// identity for boxes. Recovers W = R + Q11 T P.
class DualObjective {
 public:
  /// upper: whether boxes have their upper side.
  DualObjective(const FreeRows& free, const FreeConstraints& constraints,
                const ConstrainedInverse& inverse, double scale, bool upper);

  Eigen::Index size() const { return (upper_ ? 2 : 1) * R_.size(); }
  /// f and its gradient with respect to x.
  double evaluate(const Vector& x, Vector& g);
  /// Variables whose multipliers are those of the weights W.
  Vector variables(const RowMatrix& W) const;
  /// Variables to start from without weights.
  Vector cold() const;

  /// After evaluate(): the weights and objectives there.
  const RowMatrix& weights() const { return W_; }
  double primal() const { return base_ + 0.5 * quadratic_; }
  double dual() const { return base_ - value_; }
  double violation() const { return violation_; }
  /// A lower bound on the optimum that does not rest on the accuracy of the inverse (what the row
  /// sets allow against the tangent plane at W), and Q W - R + C'Z.
  double lower_bound(RowMatrix& L) const;

  /// R + Q11 T P at T = 0.
  const RowMatrix& offset() const { return R_; }

 private:
  void centre(RowMatrix& T) const;

  const FreeRows& free_;
  const FreeConstraints& constraints_;
  const ConstrainedInverse& inverse_;
  double scale_;
  bool upper_;
  RowMatrix R_;  ///< the paper's R: equation 14
  RowMatrix Z0_, T_, V_, W_;
  double base_ = 0;  ///< energy at T = 0: the constants that equations 12 and B6 leave out
  double quadratic_ = 0, value_ = 0, violation_ = 0;
};

}  // namespace skinfield
