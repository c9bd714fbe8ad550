// Quadratic programs over products of simplices: the exact weights problem, partition of unity
// inside it, for any positive semidefinite energy.
//
//   minimise  1/2 tr(W' Q W) + <B, W>
//   subject to  W_ij >= 0,  sum_j W_ij = s_i,  W_ij = 0 where not allowed,  fixed rows given;
//   or without the sums:  0 <= W_ij <= s_i  (RowSet::box).
//
// Method (findings.md B): alternating directions with a per-node penalty, Anderson acceleration,
// one Cholesky factor of Q + D, projected block Gauss-Seidel sweeps at the end. Every iterate that
// is returned is exactly feasible.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/base/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace skinfield {

struct FixedRows {
  std::vector<int> node;  ///< distinct, ascending
  RowMatrix weights;      ///< (k,m), each row on the simplex
};

/// Where a row may lie; s is its target.
enum class RowSet {
  simplex,  ///< w >= 0, sum w = s
  box,      ///< 0 <= w <= s, every entry by itself: the columns have nothing to do with each other
};

struct SimplexProblem {
  SparseRows Q;  ///< (N,N) symmetric positive semidefinite, full (both triangles)
  RowMatrix B;   ///< (N,m) linear term, or empty for none
  Vector M;      ///< (N) > 0 node masses: scales the penalties
  SparseRows K;  ///< (N,N) or empty: if Q = K M^-1 K, the stiffness; the local
                 ///< |K w|^2 / M^2 then sets the penalties (faster on bad meshes)
  FixedRows fixed;
  int columns = 0;  ///< m
  RowSet row_set = RowSet::simplex;
  Vector row_sum;  ///< (N) targets s_i >= 0, or empty for all 1
  /// (N) lists of the columns a row may use, or empty for all: the kept support of a re-solve.
  std::vector<std::vector<int>> support;
};

struct SolveStats {
  enum class Status { converged, limit, cancelled };
  Status status = Status::converged;
  int iterations = 0;
  double energy = 0, lower_bound = 0;
  double relative_gap = 0;  ///< (energy - lower_bound) / energy
  double kkt_residual = 0;  ///< largest violation of the optimality conditions, in weight units
  /// Of a weight, at the last check; of solve_simplex_qp what it may still change, by the rate of
  /// its last movements.
  double largest_change = 0;
  /// Entries of the Cholesky factor of solve_simplex_qp: what an iteration costs. 0: not told.
  std::int64_t factor_entries = 0;
};

struct SimplexOptions {
  double tolerance = 1e-3;  ///< stop when no weight is expected to change by more
  int max_iterations = 500;
  double time_limit_s = 0;  ///< 0: none
  RowMatrix start;          ///< warm start (N,m), or empty
  /// Rings of Q's graph around the start's support where a column is stored at first, at least 1;
  /// more follow where they are needed.
  int margin = 2;
};

struct SimplexSolution {
  RowMatrix W;  ///< (N,m), feasible
  SolveStats stats;
};

/// @throws SolveError if a component of Q's graph has no fixed row (singular), or Q is indefinite.
SimplexSolution solve_simplex_qp(const SimplexProblem& problem, const SimplexOptions& options = {},
                                 const Progress& progress = {});

/// Euclidean projection of a row onto {w >= 0, sum w = s} (in place, sort-free with capped loop).
void project_to_simplex(double* w, int m, double s = 1);
/// The same onto {0 <= w <= s}.
void project_to_box(double* w, int m, double s = 1);

}  // namespace skinfield
