// Exact bounded biharmonic weights through the convex dual (Solomon and Stein 2025, "Computing
// skinning weights via convex duality"): the same weights as bounded_biharmonic by an independent
// route. Other energies and general constraints C W = D (natural boundaries, say):
// solve_simplex_dual takes them as the paper's equation 3 has them.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/solve/simplex_dual.h"

#include <vector>

namespace skinfield {

struct BoundedBiharmonicDualOptions {
  DualOptions dual;         ///< when to stop; its start is replaced by the one below
  RowMatrix start;          ///< (N,m) warm start and the values of locked columns, or empty
  std::vector<int> locked;  ///< columns kept from `start`
  FixedRows paint;          ///< more fixed rows; they win over the problem's
};

struct BoundedBiharmonicDualResult {
  RowMatrix W;                      ///< (N,m) nodal weights, rows on the simplex
  std::vector<int> unreached;       ///< nodes whose component has no fixed row: zero rows in W
  SolveStats stats;                 ///< of W; energies as in BoundedBiharmonicResult
  double recovered_energy = 0;      ///< of equation 15's W, before it was made feasible
  double constraint_violation = 0;  ///< |min(W, 0)|_2 of that W
  int evaluations = 0;              ///< solves with the factor, all columns at once
  std::vector<DualRecord> history;  ///< if dual.keep_history
};

/// Locks, paint and errors as bounded_biharmonic.
BoundedBiharmonicDualResult bounded_biharmonic_dual(
    const BoundedBiharmonicProblem& problem, const BoundedBiharmonicDualOptions& options = {},
    const Progress& progress = {});

}  // namespace skinfield
