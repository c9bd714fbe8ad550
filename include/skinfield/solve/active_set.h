// Active-set methods for the weights' quadratic programs: the classic references. Their cost grows
// faster than that of solve_simplex_qp; they are for small meshes and for comparison.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/solve/simplex_qp.h"

namespace skinfield {

struct ActiveSetOptions {
  double relative_gap = 1e-9;  ///< stop when the certified gap is at most this
  int max_iterations = 500;
  double time_limit_s = 0;  ///< 0: none
  RowMatrix start;          ///< (N,m), or empty for the unconstrained solution, projected
};

/// The exact program, sums included, to optimality: a primal active-set method that lets many
/// constraints in and out at once (More and Toraldo 1991, "On the solution of large quadratic
/// programming problems with bound constraints", with row simplices for bounds). Block Gauss-Seidel
/// sweeps choose the face; a sparse Cholesky factor of the energy on that face, pivot columns
/// eliminated by the row sums, gives its minimiser; a projected search goes there. Every iterate
/// is feasible and has less energy than the one before. An iteration factors a system of about
/// N times the mean influences beyond the first: some seconds for 7,000 nodes and 20 columns.
/// problem.row_set must be RowSet::simplex.
/// @throws SolveError as solve_simplex_qp.
SimplexSolution solve_simplex_active_set(const SimplexProblem& problem,
                                         const ActiveSetOptions& options = {},
                                         const Progress& progress = {});

/// Bounds alone, one column after the other, as common tools do: pin what leaves its bounds, solve,
/// let go what has a multiplier of the wrong sign, at most `iterations` times whether that has
/// settled or not, and clamp. Every iteration factors the energy on the free nodes anew.
/// problem.row_set must be RowSet::box, without supports. status: limit where sets still changed.
/// time_limit_s: no column begins another iteration after that; 0: none.
/// @throws SolveError as solve_simplex_qp.
SimplexSolution solve_box_active_set(const SimplexProblem& problem, int iterations = 8,
                                     double time_limit_s = 0, const Progress& progress = {});

}  // namespace skinfield
