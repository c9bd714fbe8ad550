// The iteration behind solve_simplex_qp.
#pragma once

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
  /// Both the distance between the halves of the splitting, which measured 0.7 to 1.5 times the
  /// distance to the optimum, and the movement since the last check are below the tolerance.
  /// That holds for a soft penalty: a stiff one pulls the halves together without moving them to
  /// the optimum. So success with a stiff one only ends its turn, and with a soft one it must be
  /// seen twice.
  bool converged();
  /// One step with full columns: do they stay below the tolerance outside the active rows? If not,
  /// those rows become active.
  bool complete();
  /// A lower bound of the energy, by some steps with full columns.
  double certify();

  const RowMatrix& start() const { return start_; }
  /// The iterate, feasible, without weights far below the tolerance.
  RowMatrix result() const;
  double change() const { return change_; }
  std::int64_t factor_entries() const { return factor_.nonzeros(); }

 private:
  RowMatrix unconstrained();
  Vector landscape(const Vector& M) const;
  /// Leaves out weights below `dust` of their row's sum; rows keep their sums.
  void drop_dust(double dust, RowMatrix& W) const;
  template <class Body>
  void for_entries(const Body& body) const;
  template <class Body>
  void for_rows(const Body& body) const;
  /// In the norm of the penalty.
  double distance(const Vector& A, const Vector& B) const;

  /// The rows that columns with this support ask for, `rings` of Q's graph beyond it.
  ColumnSets around(const ColumnSets& support, int rings) const;
  ColumnSets support() const;
  void activate(ColumnSets sets);
  /// Moves the iterate to new sets; returns the old numbers of the entries.
  std::vector<std::int64_t> reactivate(ColumnSets sets);
  void grow();
  void shrink();
  Vector active_part(const RowMatrix& W) const;
  RowMatrix full(const Vector& values) const;

  /// Z := proj(S), W := (Q + D)^-1 (D (2Z - S) + R).
  void full_step(const RowMatrix& S, RowMatrix& Z, RowMatrix& W);
  void project(const Vector& from, Vector& to) const;
  void split();
  void step();
  void check();
  void compare_residuals();
  void turn(int it);
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
  Vector S_, Z_, W_, F_, previous_, checked_;
  RowMatrix start_;
  double change_ = std::numeric_limits<double>::infinity();
  double log_ratio_ = 0;  ///< sum of logarithms of primal over dual residuals in a soft turn
  int ratios_ = 0;        ///< so many
  double soft_;           ///< factor of soft turns
  int turn_at_;           ///< the turn's last iteration
  bool stiff_ = false, turned_ = false;  ///< a stiff turn now; was there one?
  int confirmed_ = 0;
  bool fresh_check_ = false;
};

}  // namespace skinfield
