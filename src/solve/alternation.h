// The iteration behind solve_simplex_qp.
#pragma once

#include "skinfield/base/parallel.h"
#include "skinfield/solve/simplex_qp.h"
#include "skinfield/solve/sparse_factor.h"
#include "solve/anderson.h"
#include "solve/column_sets.h"
#include "solve/free_rows.h"

#include <limits>

namespace skinfield {

/// Alternating directions (Douglas-Rachford splitting of the energy and the simplices) with
/// Anderson acceleration: findings.md section B.
///
/// Columns are truncated: each is stored only on its active rows and taken as zero elsewhere. With
/// every row of the optimum's support and their neighbours in Q's graph active, the optimum is
/// the fixed point, since its multipliers Q W - R vanish farther out. Active sets grow as
/// the support does, and certify() checks at last that nothing was missed.
class Alternation {
 public:
  Alternation(const SimplexProblem& problem, const SimplexOptions& options, const FreeRows& free,
              const Progress& progress);

  /// One iteration; `it` counts from 1.
  void iterate(int it);
  /// Is what the nearest feasible weights to W will still move, by the rate of their last two
  /// movements, below the tolerance, and are nearly all rows of W feasible within it? That holds
  /// for a soft penalty: a stiff one slows the movement itself, so success with it only ends its
  /// turn. (Z - W says nothing: Z lags behind where the penalty is far softer than the energy, and
  /// single rows there, long settled in W, would cost many iterations.)
  bool converged();
  /// One step with full columns: do they stay below the tolerance outside the active rows? If not,
  /// those rows become active.
  bool complete();
  /// A lower bound of the energy, by some steps with full columns: fewer where it comes close to
  /// `energy`, that of a feasible point.
  double certify(double energy);

  const RowMatrix& start() const { return start_; }
  /// The better of the two feasible iterates, without weights far below the tolerance, and its
  /// energy.
  RowMatrix result(double& energy) const;
  double change() const { return change_; }
  std::int64_t factor_entries() const { return factor_.nonzeros(); }

 private:
  static constexpr std::size_t kRowsPerBlock = 256, kEntriesPerBlock = 4096;
  static constexpr double kRelaxation = 1.6;
  /// Turns of the penalty (see turn()): iterations, and multiples of the first penalty.
  static constexpr int kFirstTurn = 10, kStiffTurn = 15, kSoftTurn = 20;
  static constexpr double kSoft = 3, kFirstStiff = 50, kStiff = 500, kWarm = 8;

  RowMatrix unconstrained();
  Vector landscape(const Vector& M) const;
  /// Leaves out weights below `dust` of their row's sum; rows keep their sums.
  void drop_dust(double dust, RowMatrix& W) const;
  template <class Body>
  void for_entries(const Body& body) const;
  template <class Body>
  void for_rows(const Body& body) const;
  static double largest_difference(const Vector& A, const Vector& B);
  /// In the norm of the penalty.
  double distance(const Vector& A, const Vector& B) const;

  /// The rows that columns with this support ask for, `rings` of Q's graph beyond it.
  ColumnSets around(const ColumnSets& support, int rings) const;
  ColumnSets support() const;
  void activate(ColumnSets sets);
  /// Moves the iterate to new sets; returns the old numbers of the entries.
  std::vector<std::int64_t> reactivate(ColumnSets sets);
  /// Gives S of new entries (old number -1) the threshold of their row's projection, or zero where
  /// that is less: they start at weight zero. Zero would be right at the optimum, where
  /// thresholds are not negative; before, it hands them a part of the row.
  void enter_at_zero(const std::vector<std::int64_t>& old);
  void grow();
  void shrink();
  Vector active_part(const RowMatrix& W) const;
  RowMatrix full(const Vector& values) const;

  /// Z := proj(S), W := (Q + D)^-1 (D (2Z - S) + R).
  void full_step(const RowMatrix& S, RowMatrix& Z, RowMatrix& W);
  void project(const Vector& from, Vector& to) const;
  void split();
  void step();
  /// Distance of W's rows from their sets; `feasible` is its projection.
  double infeasibility(const Vector& feasible) const;
  void check();
  void compare_residuals();
  void turn(int it);
  /// What the soft penalties should be multiplied by, from the ratios so far.
  double imbalance() const;
  /// By so much that it does not wait for the turn's end?
  bool far_off() const;
  void balance();
  /// The penalty becomes `factor` times the first, balanced.
  void raise_penalty(double factor);

  const SimplexOptions& options_;
  const FreeRows& free_;
  const Progress& progress_;
  PanelStorage storage_;  ///< of Q + D; Q alone is too badly conditioned for single precision
  SparseFactor factor_;
  Anderson anderson_;
  Vector first_, balance_, d_;  ///< (n) penalties: at first, factors of soft turns, now
  Vector primal_, dual_;        ///< (n) squared residuals, summed over a soft turn
  ColumnSets reach_, linear_;   ///< where columns may matter at all; where R is not zero
  ColumnSets sets_;
  ActiveRows active_;
  Vector weight_, R_;          ///< of the active entries: penalty, linear term
  std::vector<char> allowed_;  ///< of the active entries: in the support, or empty for all
  Vector S_, Z_, W_, F_, previous_;
  Vector checked_;  ///< W's projection at the last check
  RowMatrix start_;
  double change_ = std::numeric_limits<double>::infinity();
  double log_ratio_ = 0;  ///< sum of logarithms of primal over dual residuals in a soft turn
  int ratios_ = 0;        ///< so many
  double soft_;           ///< factor of soft turns
  int turn_at_;           ///< the turn's last iteration
  bool stiff_ = false, turned_ = false;                     ///< a stiff turn now; was there one?
  int checks_ = 0;                                          ///< in this turn
  double moved_ = std::numeric_limits<double>::infinity();  ///< before the last of them
  bool fresh_check_ = false;
};

template <class Body>
void Alternation::for_entries(const Body& body) const {
  parallel_blocks(static_cast<std::size_t>(active_.size()), kEntriesPerBlock,
                  [&](std::size_t begin, std::size_t end) {
                    body(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
                  });
}

/// body(row, first entry, end of entries)
template <class Body>
void Alternation::for_rows(const Body& body) const {
  parallel_for(static_cast<std::size_t>(active_.rows()), kRowsPerBlock, [&](std::size_t i) {
    body(static_cast<Eigen::Index>(i), active_.start[i], active_.start[i + 1]);
  });
}

}  // namespace skinfield
