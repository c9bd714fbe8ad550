// The weights' quadratic program through its convex dual (Solomon and Stein 2025, "Computing
// skinning weights via convex duality"): a non-negative least-squares problem, solved with squared
// variables by L-BFGS; the weights follow in closed form. An independent second route to what
// solve_simplex_qp computes, and the one that takes general linear constraints.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

/// C W = D (the paper's equation 3): beside the fixed rows, or in their place.
struct LinearConstraints {
  SparseRows C;  ///< (k,N); rows may repeat each other
  RowMatrix D;   ///< (k,m); with RowSet::simplex, D 1 = C s
};

struct DualOptions {
  double relative_gap = 1e-4;  ///< stop when the certified gap is at most this; 0: never
  /// Stop as the paper's program does (scipy's `tol`): when an iteration lowers the dual objective
  /// by less than this share, or no entry of its gradient is larger; 0: never.
  double tolerance = 0;
  int max_iterations = 20000;
  double time_limit_s = 0;  ///< 0: none
  int memory = 10;          ///< of L-BFGS
  RowMatrix start;          ///< weights to start from (N,m), or empty
  bool upper_bound = true;  ///< of RowSet::box: false leaves W <= s out (appendix A, figure A1)
  bool keep_history = false;
};

/// One iteration, as in the paper's figure 9.
struct DualRecord {
  int iteration = 0;
  double primal_objective = 0;      ///< energy of the recovered W, which may be infeasible
  double dual_objective = 0;        ///< up to rounding below the optimum
  double constraint_violation = 0;  ///< |min(W, 0)|_2; boxes: the excess over s counts too
  double gradient = 0;              ///< largest entry, in the squared variables
};

struct DualSolution {
  RowMatrix W;                      ///< (N,m), rows in their sets, fixed rows exact
  SolveStats stats;                 ///< energy: of W; largest_change: from the recovered W to W
  double recovered_energy = 0;      ///< of the recovered W, before it was made feasible
  double constraint_violation = 0;  ///< of the recovered W
  double constraint_residual = 0;   ///< largest entry of |C W - D| of the W returned
  int evaluations = 0;              ///< applications of the inverse
  std::vector<DualRecord> history;
};

/// problem.B (linear term), fixed and row_sum as in solve_simplex_qp; problem.support must be
/// empty; K sets the scale of the variables. With constraints, components without a fixed row are
/// taken, and W is brought back to C W = D by alternating projections that end on the rows' sets.
/// @throws SolveError as solve_simplex_qp, or for supports.
DualSolution solve_simplex_dual(const SimplexProblem& problem, const DualOptions& options = {},
                                const Progress& progress = {},
                                const LinearConstraints& constraints = {});

}  // namespace skinfield
