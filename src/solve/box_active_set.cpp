// Bounds by active sets, a column at a time.
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/solve/active_set.h"
#include "skinfield/solve/sparse_factor.h"
#include "solve/free_rows.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

namespace skinfield {
namespace {

enum class Pin : char { none, lower, upper };

/// One column of the program.
class Column {
 public:
  Column(const FreeRows& free, Eigen::Index column, Vector start)
      : free_(free), R_(free.R.col(column)), w_(std::move(start)), pin_(free.node.size()) {}

  /// False if no set changed: then w is the optimum.
  bool iterate() {
    bool changed = release();
    for (std::size_t i = 0; i < pin_.size(); ++i) {
      if (pin_[i] != Pin::none) continue;
      const double w = w_[static_cast<Eigen::Index>(i)];
      if (w < 0) pin_[i] = Pin::lower;
      if (w > upper(i)) pin_[i] = Pin::upper;
      changed = changed || pin_[i] != Pin::none;
    }
    if (changed) solve();
    return changed;
  }
  const Vector& weights() const { return w_; }

 private:
  double upper(std::size_t i) const { return free_.row_sum[static_cast<Eigen::Index>(i)]; }

  /// Lets go what the energy pulls inward.
  bool release() {
    bool changed = false;
    for (std::size_t i = 0; i < pin_.size(); ++i) {
      if (pin_[i] == Pin::none) continue;
      const auto row = static_cast<Eigen::Index>(i);
      double multiplier = -R_[row];
      for (SparseRows::InnerIterator it(free_.Q, row); it; ++it) {
        multiplier += it.value() * w_[it.col()];
      }
      if (pin_[i] == Pin::lower ? multiplier >= 0 : multiplier <= 0) continue;
      pin_[i] = Pin::none;
      changed = true;
    }
    return changed;
  }

  /// The minimiser with the pinned entries at their bounds.
  void solve() {
    std::vector<int> node, position(pin_.size(), -1);
    for (std::size_t i = 0; i < pin_.size(); ++i) {
      if (pin_[i] == Pin::lower) w_[static_cast<Eigen::Index>(i)] = 0;
      if (pin_[i] == Pin::upper) w_[static_cast<Eigen::Index>(i)] = upper(i);
      if (pin_[i] != Pin::none) continue;
      position[i] = static_cast<int>(node.size());
      node.push_back(static_cast<int>(i));
    }
    if (node.empty()) return;
    const auto n = static_cast<Eigen::Index>(node.size());
    SparseRows A(n, n);
    A.reserve(free_.Q.nonZeros());
    RowMatrix b(n, 1);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int row = node[static_cast<std::size_t>(i)];
      A.startVec(i);
      b(i, 0) = R_[row];
      for (SparseRows::InnerIterator it(free_.Q, row); it; ++it) {
        const int j = position[static_cast<std::size_t>(it.col())];
        if (j >= 0) {
          A.insertBack(i, j) = it.value();
        } else {
          b(i, 0) -= it.value() * w_[it.col()];
        }
      }
    }
    A.finalize();
    SparseFactor factor;
    factor.analyse(A);
    factor.factor(A);
    factor.solve(b);
    for (Eigen::Index i = 0; i < n; ++i) w_[node[static_cast<std::size_t>(i)]] = b(i, 0);
  }

  const FreeRows& free_;
  Vector R_, w_;
  std::vector<Pin> pin_;
};

}  // namespace

SimplexSolution solve_box_active_set(const SimplexProblem& problem, int iterations,
                                     double time_limit_s, const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const auto late = [&] {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    return time_limit_s > 0 && spent.count() > time_limit_s;
  };
  const FreeRows free(problem);
  if (!free.boxes() || !free.unrestricted()) {
    throw SolveError("the rows are not boxes, or have supports", "box active set");
  }
  RowMatrix X = free.R;
  SparseFactor factor;
  factor.analyse(free.Q);
  factor.factor(free.Q);
  factor.solve(X);
  RowMatrix Z = X;
  const auto columns = static_cast<std::size_t>(free.columns());
  std::vector<int> used(columns, 0);
  std::vector<char> settled(columns, 0);
  parallel_for(columns, 1, [&](std::size_t c) {
    const auto j = static_cast<Eigen::Index>(c);
    Column column(free, j, X.col(j));
    while (used[c] < iterations && !settled[c] && !late()) {
      progress.check();
      settled[c] = !column.iterate();
      used[c] += !settled[c];
    }
    Z.col(j) = column.weights();
  });
  free.project(RowMatrix(Z), Z);
  SimplexSolution solution;
  SolveStats& stats = solution.stats;
  stats.iterations = *std::max_element(used.begin(), used.end());
  if (std::count(settled.begin(), settled.end(), 0) > 0) stats.status = SolveStats::Status::limit;
  const RowMatrix G = free.gradient(Z);
  stats.energy = free.energy(Z, G);
  stats.lower_bound = free.lower_bound(Z, G);
  stats.kkt_residual = free.kkt_residual(Z, G);
  const double scale = std::max(std::abs(stats.energy), std::numeric_limits<double>::min());
  stats.relative_gap = std::max(0.0, stats.energy - stats.lower_bound) / scale;
  solution.W = free.scatter(Z);
  return solution;
}

}  // namespace skinfield
