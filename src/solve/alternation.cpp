#include "solve/alternation.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "solve/penalty.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace skinfield {
namespace {

constexpr int kCheckEvery = 5;
constexpr int kSettle = 4;  // first iterations, which say nothing about the balance
constexpr int kEarly = 8;   // iterations that say enough to balance within a turn
constexpr double kWorthShrinking = 0.8;
constexpr double kMost = 0.999;    // of the rows must be feasible within the tolerance,
constexpr double kFewRows = 4;     // the others within so many times it: the last sweeps mend them
constexpr double kSlowest = 0.95;  // rate of convergence that is believed
constexpr double kRounding = 1e-10;    // of a row's sum, in the start
constexpr double kDust = 1e-3;         // of the tolerance: rounding of the solves spreads as much
constexpr double kFaint = 0.02;        // of the tolerance: smaller weights ask for no active rows
constexpr double kDoubleBelow = 2e-4;  // tolerance: single-precision panels would show

}  // namespace

Alternation::Alternation(const SimplexProblem& problem, const SimplexOptions& options,
                         const FreeRows& free, const Progress& progress)
    : options_(options),
      free_(free),
      progress_(progress),
      storage_(options.tolerance < kDoubleBelow ? PanelStorage::full : PanelStorage::single),
      linear_(free.R),
      soft_(options.start.size() > 0 ? kWarm : kSoft),
      turn_at_(options.start.size() > 0 ? kSoftTurn : kFirstTurn) {
  progress_.check();
  factor_.analyse(free_.Q);
  const bool warm = options_.start.size() > 0;
  const RowMatrix X = warm ? free_.gather(options_.start) : unconstrained();
  free_.project(X, start_);
  // Projections spread the rounding of X over all columns, those without any fixed row as well.
  if (!warm) drop_dust(kRounding, start_);
  first_ = local_penalty(problem, free_, X, start_, warm ? Vector() : landscape(problem.M));
  d_ = first_;
  balance_ = Vector::Ones(free_.rows());
  progress_.check();
  if (!problem.support.empty()) {
    reach_ = ColumnSets(free_.rows(), free_.columns());
    for (Eigen::Index i = 0; i < free_.rows(); ++i) {
      for (const int j : free_.support(i)) reach_.add(i, j);
    }
    reach_ = reach_.grown(free_.Q);
  }
  activate(around(ColumnSets(start_), std::max(1, options_.margin)));
  S_ = active_part(start_);
  if (warm) {
    d_ *= soft_;
    weight_ *= soft_;
    // At the optimum this S is the fixed point itself, multipliers included. They are those of the
    // start as given: where a support cuts it, the projection's are of another scale.
    S_ -= active_part(free_.gradient(X)).cwiseQuotient(weight_);
  }
  Z_ = checked_ = active_part(start_);
  factor_.factor(free_.Q, d_, storage_);
}

RowMatrix Alternation::unconstrained() {
  try {
    factor_.factor(free_.Q);
  } catch (const SolveError&) {
    // Slivers can cost Q its last digits; X only starts the iteration. If Q is indefinite this
    // throws again.
    factor_.factor(free_.Q, 1e-10 * free_.Q.diagonal());
  }
  progress_.check();
  RowMatrix X = free_.R;
  factor_.solve(X);
  return X;
}

/// By the factor of Q that unconstrained() left.
Vector Alternation::landscape(const Vector& M) const {
  RowMatrix u(free_.rows(), 1);
  for (Eigen::Index i = 0; i < free_.rows(); ++i) {
    u(i, 0) = M[free_.node[static_cast<std::size_t>(i)]];
  }
  factor_.solve(u);
  return u.col(0);
}

ColumnSets Alternation::around(const ColumnSets& support, int rings) const {
  ColumnSets sets = support.grown(free_.Q, rings);
  if (!free_.unrestricted()) sets.meet(reach_);
  sets.join(linear_);
  return sets;
}

ColumnSets Alternation::support() const {
  ColumnSets sets(free_.rows(), free_.columns());
  const double faint = kFaint * options_.tolerance;
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    for (auto e = begin; e < end; ++e) {
      if (Z_[e] > faint * free_.row_sum[i])
        sets.add(i, active_.column[static_cast<std::size_t>(e)]);
    }
  });
  return sets;
}

void Alternation::activate(ColumnSets sets) {
  sets_ = std::move(sets);
  active_ = sets_.list();
  weight_.resize(active_.size());
  allowed_.assign(free_.unrestricted() ? 0 : active_.column.size(), 0);
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    for (auto e = begin; e < end; ++e) weight_[e] = d_[i];
    if (free_.unrestricted()) return;
    for (const int j : free_.support(i)) {
      const auto from = active_.column.begin() + begin, to = active_.column.begin() + end;
      const auto at = std::lower_bound(from, to, j);
      if (at != to && *at == j) allowed_[static_cast<std::size_t>(at - active_.column.begin())] = 1;
    }
  });
  R_ = active_part(free_.R);
}

std::vector<std::int64_t> Alternation::reactivate(ColumnSets sets) {
  const ActiveRows before = active_;
  activate(std::move(sets));
  std::vector<std::int64_t> old = old_entries(before, active_);
  for (Vector* values : {&S_, &Z_, &checked_}) *values = remapped(*values, old);
  enter_at_zero(old);
  return old;
}

void Alternation::enter_at_zero(const std::vector<std::int64_t>& old) {
  if (free_.boxes()) return;  // no sums, no thresholds
  const auto is_new = [&](std::int64_t e) { return old[static_cast<std::size_t>(e)] < 0; };
  // Below the row's least by its sum: no share for them.
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    double least = 0;
    for (auto e = begin; e < end; ++e) least = std::min(least, S_[e]);
    for (auto e = begin; e < end; ++e) {
      if (is_new(e)) S_[e] = least - free_.row_sum[i];
    }
  });
  Vector Z;
  project(S_, Z);
  for_rows([&](Eigen::Index, std::int64_t begin, std::int64_t end) {
    double threshold = 0;
    for (auto e = begin; e < end; ++e) {
      if (Z[e] > 0) threshold = std::min(threshold, S_[e] - Z[e]);
    }
    for (auto e = begin; e < end; ++e) {
      if (is_new(e)) S_[e] = threshold;
    }
  });
}

void Alternation::grow() {
  const ColumnSets wanted = around(support(), 1);
  if (sets_.contains(wanted)) return;
  ColumnSets more = around(wanted, 1);  // a ring of room
  more.join(sets_);
  anderson_.remap(reactivate(std::move(more)));
}

void Alternation::shrink() {
  ColumnSets fewer = around(support(), 2);
  fewer.meet(sets_);
  const auto size = static_cast<double>(fewer.list().size());
  if (size > kWorthShrinking * static_cast<double>(active_.size())) return;
  reactivate(std::move(fewer));
  anderson_.forget();
}

Vector Alternation::active_part(const RowMatrix& W) const {
  Vector values(active_.size());
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    for (auto e = begin; e < end; ++e)
      values[e] = W(i, active_.column[static_cast<std::size_t>(e)]);
  });
  return values;
}

RowMatrix Alternation::full(const Vector& values) const {
  RowMatrix W = RowMatrix::Zero(free_.rows(), free_.columns());
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    for (auto e = begin; e < end; ++e)
      W(i, active_.column[static_cast<std::size_t>(e)]) = values[e];
  });
  return W;
}

void Alternation::iterate(int it) {
  progress_.check();
  if (it > turn_at_) {
    turn(it);
  } else if (turned_ && ratios_ >= kEarly && it + kEarly <= turn_at_ && far_off()) {
    balance();
    raise_penalty(soft_);
  }
  previous_.swap(Z_);
  project(S_, Z_);
  split();
  factor_.solve(active_, W_);
  if (it > kSettle && !stiff_) compare_residuals();
  if (it % kCheckEvery == 0) {
    check();
  } else if (it == options_.max_iterations) {
    project(W_, checked_);  // the newest to give out; too soon after the last check to judge by
  }
  step();
  if (it % kCheckEvery == 0) grow();
}

RowMatrix Alternation::result(double& energy) const {
  RowMatrix Z = full(Z_), W = full(checked_);
  for (RowMatrix* each : {&Z, &W}) drop_dust(kDust * options_.tolerance, *each);
  const double of_Z = free_.energy(Z, free_.gradient(Z)), of_W = free_.energy(W, free_.gradient(W));
  energy = std::min(of_Z, of_W);
  return of_W < of_Z ? W : Z;
}

void Alternation::drop_dust(double dust, RowMatrix& W) const {
  parallel_for(static_cast<std::size_t>(W.rows()), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    const double sum = free_.row_sum[i], least = dust * sum;
    for (Eigen::Index j = 0; j < W.cols(); ++j) {
      if (W(i, j) < least) W(i, j) = 0;
    }
    if (free_.boxes()) return;
    const double kept = W.row(i).sum();
    if (kept > 0) W.row(i) *= sum / kept;
  });
}

bool Alternation::converged() {
  if (!fresh_check_) return false;
  fresh_check_ = false;
  if (!(change_ < options_.tolerance)) return false;
  if (stiff_) turn_at_ = 0;  // at once: see the header
  return !stiff_ && checks_ > 1;
}

double Alternation::largest_difference(const Vector& A, const Vector& B) {
  return parallel_reduce(
      static_cast<std::size_t>(A.size()), kEntriesPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        const auto at = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        return (A.segment(at, count) - B.segment(at, count)).cwiseAbs().maxCoeff();
      },
      [](double a, double b) { return std::max(a, b); });
}

double Alternation::distance(const Vector& A, const Vector& B) const {
  return std::sqrt(parallel_reduce(
      static_cast<std::size_t>(A.size()), kEntriesPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        const auto at = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        return ((A.segment(at, count) - B.segment(at, count)).array().square() *
                weight_.segment(at, count).array())
            .sum();
      },
      std::plus<>()));
}

void Alternation::project(const Vector& from, Vector& to) const {
  to.resize(from.size());
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    if (free_.unrestricted()) {
      std::copy(from.data() + begin, from.data() + end, to.data() + begin);
      return free_.project_entries(i, to.data() + begin, static_cast<int>(end - begin));
    }
    // The allowed entries are projected at the front of the row, then spread over it.
    int count = 0;
    for (auto e = begin; e < end; ++e) {
      if (allowed_[static_cast<std::size_t>(e)]) to[begin + count++] = from[e];
    }
    free_.project_entries(i, to.data() + begin, count);
    for (auto e = end; e-- > begin;) {
      to[e] = allowed_[static_cast<std::size_t>(e)] ? to[begin + --count] : 0.0;
    }
  });
}

void Alternation::split() {
  W_.resize(S_.size());
  for_entries([&](Eigen::Index at, Eigen::Index count) {
    W_.segment(at, count) =
        weight_.segment(at, count).cwiseProduct(2 * Z_.segment(at, count) - S_.segment(at, count)) +
        R_.segment(at, count);
  });
}

void Alternation::step() {
  F_.resize(S_.size());
  for_entries([&](Eigen::Index at, Eigen::Index count) {
    F_.segment(at, count) = kRelaxation * (W_.segment(at, count) - Z_.segment(at, count));
  });
  anderson_.advance(weight_, S_, F_);
}

double Alternation::infeasibility(const Vector& feasible) const {
  Vector rows(active_.rows());
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    double largest = 0;
    for (auto e = begin; e < end; ++e) largest = std::max(largest, std::abs(W_[e] - feasible[e]));
    rows[i] = largest;
  });
  const auto most =
      rows.begin() + static_cast<std::ptrdiff_t>(kMost * static_cast<double>(rows.size()));
  std::nth_element(rows.begin(), most, rows.end());
  return std::max(*most, *std::max_element(most, rows.end()) / kFewRows);
}

void Alternation::check() {
  Vector feasible;
  project(W_, feasible);
  const double moved = largest_difference(feasible, checked_);
  // What is left of a geometric series whose last term is `moved`, four times: rates vary.
  const double rate = std::min(moved / moved_, kSlowest);
  change_ = std::max(infeasibility(feasible), moved * std::max(2.0, 4 * rate / (1 - rate)));
  moved_ = moved;
  checked_ = std::move(feasible);
  ++checks_;
  fresh_check_ = true;
}

}  // namespace skinfield
