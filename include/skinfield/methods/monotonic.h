// Bounded biharmonic weights that are monotonic: every node has a neighbour that weighs no less and
// one that weighs no more, so that no weight has a local extremum away from the handles (Jacobson,
// Weinkauf, Sorkine 2012, "Smooth shape-aware functions with controlled extrema").
#pragma once

#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

/// Views, to be kept alive by the caller.
struct MonotonicProblem {
  const SparseRows& K;  ///< (N,N) symmetric positive semidefinite, K 1 = 0; its graph's edges are
                        ///< those along which weights are compared
  const Vector& M;      ///< (N) > 0
  const FixedRows& fixed;  ///< (k,m): m is the number of columns
};

struct MonotonicOptions {
  /// Partition of unity inside the minimisation. Without, columns are solved one by one and rows
  /// divided by their sums afterwards, as in the paper; that can bring extrema back.
  bool coupled = true;
  double tolerance = 1e-3;  ///< largest expected change of a weight
  int max_iterations = 1500;
  double time_limit_s = 0;  ///< 0: none; else the best weights so far, status limit
  FixedRows paint;          ///< more fixed rows; they win over the problem's
  /// (N,m) whose order along edges the weights follow, or empty for harmonic weights. Extrema of
  /// its own are levelled.
  RowMatrix representative;
};

struct MonotonicResult {
  RowMatrix W;                 ///< (N,m) nodal weights, rows on the simplex
  RowMatrix monotone;          ///< (N,m) before rows were divided by their sums
  std::vector<int> unreached;  ///< nodes whose component has no fixed row: zero rows
  /// Energies are 1/2 tr(W' K M^-1 K W) of `monotone`; lower_bound is of the program solved.
  SolveStats stats;
  double normalised_energy = 0;  ///< the same of W
};

/// @throws SolveError if no row is fixed, or sizes do not fit.
MonotonicResult monotonic(const MonotonicProblem& problem, const MonotonicOptions& options = {},
                          const Progress& progress = {});

}  // namespace skinfield
