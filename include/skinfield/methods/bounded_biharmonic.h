// Bounded biharmonic weights with partition of unity inside the minimisation, solved exactly
// (Jacobson, Baran, Popovic, Sorkine 2011, equations 2 to 5, with the sum constraint kept).
#pragma once

#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

/// What a domain gives (domain.h): views, to be kept alive by the caller.
struct BoundedBiharmonicProblem {
  const SparseRows& K;     ///< (N,N) symmetric positive semidefinite, K 1 = 0
  const Vector& M;         ///< (N) > 0
  const FixedRows& fixed;  ///< (k,m): m is the number of columns
};

struct BoundedBiharmonicOptions {
  double tolerance = 1e-3;  ///< largest expected change of a weight
  int max_iterations = 500;
  double time_limit_s = 0;  ///< 0: none; else the best valid weights so far, status limit
  RowMatrix start;          ///< (N,m) warm start and the values of locked columns, or empty
  std::vector<int> locked;  ///< columns kept from `start`
  FixedRows paint;          ///< more fixed rows; they win over the problem's
  /// Local penalties from K (meshes: slivers and cells of all sizes) or from Q alone (point
  /// domains: well-shaped cells, a third fewer iterations).
  bool penalties_from_stiffness = true;
  /// (N) lists of the columns a node may use, or empty for all (see support.h).
  std::vector<std::vector<int>> support;
};

struct BoundedBiharmonicResult {
  RowMatrix W;                 ///< (N,m) nodal weights, rows on the simplex
  std::vector<int> unreached;  ///< nodes whose component has no fixed row: zero rows in W
  SolveStats stats;            ///< energies are 1/2 tr(W' K M^-1 K W) over the columns not locked
};

/// Locked columns hold exactly; where they sum to more than 1 they are scaled down, and the other
/// columns share what they leave.
/// @throws SolveError if no row is fixed, or sizes do not fit.
BoundedBiharmonicResult bounded_biharmonic(const BoundedBiharmonicProblem& problem,
                                           const BoundedBiharmonicOptions& options = {},
                                           const Progress& progress = {});

/// The rows of both, ascending; `over` wins where both fix a node.
FixedRows merge(const FixedRows& under, const FixedRows& over);

}  // namespace skinfield
