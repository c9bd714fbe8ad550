// Bounded biharmonic weights without partition of unity: every handle by itself between 0 and 1,
// rows normalised afterwards, as most tools have it (Jacobson, Baran, Popovic, Sorkine 2011,
// section 3; "convex duality", appendix A). For comparison: bounded_biharmonic's energy is never
// above that of the normalised weights.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/solve/simplex_dual.h"

#include <vector>

namespace skinfield {

enum class DecoupledSolver {
  primal,      ///< the alternating directions of solve_simplex_qp, all handles with one factor
  dual,        ///< the paper's appendix B
  active_set,  ///< what is in use elsewhere: 8 iterations, optimal or not (solve/active_set.h)
};

struct DecoupledBiharmonicOptions {
  DecoupledSolver solver = DecoupledSolver::primal;
  double tolerance = 1e-3;    ///< primal: the largest expected change of a weight
  int max_iterations = 500;   ///< primal
  double time_limit_s = 0;    ///< primal, dual; 0: none
  DualOptions dual;           ///< dual: when to stop, and whether w <= 1 is kept (upper_bound)
  int active_iterations = 8;  ///< active_set
  RowMatrix start;            ///< (N,m) warm start and the values of locked columns, or empty
  std::vector<int> locked;    ///< columns kept from `start`
  FixedRows paint;            ///< more fixed rows; they win over the problem's
  bool penalties_from_stiffness = true;  ///< primal: see BoundedBiharmonicOptions
};

struct DecoupledBiharmonicResult {
  RowMatrix W;                   ///< (N,m) normalised: rows on the simplex, fixed rows exact
  RowMatrix raw;                 ///< (N,m) before that: within the bounds, row sums near 1 at best
  std::vector<int> unreached;    ///< nodes whose component has no fixed row: zero rows in both
  SolveStats stats;              ///< of raw
  double normalised_energy = 0;  ///< of W, over the columns not locked
  std::vector<DualRecord> history;  ///< dual, if asked for
};

/// The columns share nothing but the factor. Locked columns hold exactly; the others then lie
/// between 0 and what the locked ones leave, and are normalised to that. A row that is zero in
/// every open column takes the mean of its neighbours' rows.
/// @throws SolveError as bounded_biharmonic.
DecoupledBiharmonicResult decoupled_biharmonic(const BoundedBiharmonicProblem& problem,
                                               const DecoupledBiharmonicOptions& options = {},
                                               const Progress& progress = {});

}  // namespace skinfield
