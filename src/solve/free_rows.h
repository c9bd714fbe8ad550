// The row-simplex quadratic program with its fixed rows eliminated.
#pragma once

#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

/// minimise 1/2 tr(W'QW) - <R, W> + constant over the free rows W (n,m).
class FreeRows {
 public:
  /// @throws SolveError for inconsistent sizes, rows without a feasible value, components of Q's
  /// graph without a fixed row.
  explicit FreeRows(const SimplexProblem& problem) : FreeRows(problem, true) {}
  /// `anchored`: whether components without a fixed row are refused.
  FreeRows(const SimplexProblem& problem, bool anchored);

  Eigen::Index rows() const { return static_cast<Eigen::Index>(node.size()); }
  int columns() const { return columns_; }

  /// May all rows use all columns?
  bool unrestricted() const { return problem_.support.empty(); }
  /// Boxes, not simplices?
  bool boxes() const { return problem_.row_set == RowSet::box; }
  /// The columns that a row may use. Precondition: !unrestricted().
  const std::vector<int>& support(Eigen::Index i) const {
    return problem_.support[static_cast<std::size_t>(node[static_cast<std::size_t>(i)])];
  }

  /// Z := the nearest feasible rows to those of S.
  void project(const RowMatrix& S, RowMatrix& Z) const;
  void project_row(Eigen::Index i, double* w) const;
  /// Onto the set of row i, restricted to `count` columns of it.
  void project_entries(Eigen::Index i, double* w, int count) const {
    boxes() ? project_to_box(w, count, row_sum[i]) : project_to_simplex(w, count, row_sum[i]);
  }
  /// Z <- exact minimisation over one row after the other, all rows `sweeps` times; energy never
  /// grows. Rows that share no entry of Q run in parallel (multicolour order).
  void gauss_seidel(RowMatrix& Z, int sweeps, const Progress& progress) const;
  /// G = Q Z - R.
  RowMatrix gradient(const RowMatrix& Z) const;
  /// Energy of a feasible Z, given its gradient.
  double energy(const RowMatrix& Z, const RowMatrix& G) const;
  /// Largest distance of Z from a fixed point of the projected gradient with steps 1 / Q_ii.
  double kkt_residual(const RowMatrix& Z, const RowMatrix& G) const;
  /// Valid lower bound on the energy of every feasible point: the tangent plane at any W, where
  /// L = Q W - R.
  double lower_bound(const RowMatrix& W, const RowMatrix& L) const;
  /// All N rows: the fixed ones and these.
  RowMatrix scatter(const RowMatrix& Z) const;
  RowMatrix gather(const RowMatrix& W) const;

  std::vector<int> node;  ///< (n) free rows, ascending
  SparseRows Q;           ///< (n,n)
  RowMatrix R;            ///< (n,m)
  Vector row_sum;         ///< (n)
  double constant = 0;    ///< energy of the fixed rows by themselves

 private:
  void check_components(const SimplexProblem& problem, const std::vector<int>& position) const;
  void colour() const;

  const SimplexProblem& problem_;
  int columns_ = 0;
  mutable std::vector<std::vector<int>> colours_;  ///< built by the first sweep
};

}  // namespace skinfield
