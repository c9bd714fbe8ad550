// The blocks of [Q C'; C 0]^-1, applied by a factorisation made once (convex duality, equation 7).
#pragma once

#include "skinfield/solve/sparse_factor.h"

#include <memory>

namespace skinfield {

class ConstrainedInverse {
 public:
  /// Q (n,n) symmetric positive semidefinite, C (k,n), k may be 0. Without constraints Q must be
  /// positive definite and our Cholesky factors it. With constraints the matrix is indefinite, and
  /// Q alone may be singular: 1e-9 (of Q's median diagonal entry) is added to Q's diagonal and
  /// taken off the zero block's, as the paper does; fixed steps of refinement take its effect back.
  /// @throws SolveError if the matrix cannot be factored.
  ConstrainedInverse(const SparseRows& Q, const SparseRows& C);
  ~ConstrainedInverse();

  /// (U; D) <- [Q C'; C 0]^-1 (U; D). D (k,m) may be empty for zero; its multipliers come back.
  void apply(RowMatrix& U, RowMatrix& D) const;
  /// U <- Q11 U.
  void apply(RowMatrix& U) const;

 private:
  struct Indefinite;
  SparseFactor cholesky_;
  std::unique_ptr<Indefinite> indefinite_;
};

}  // namespace skinfield
