// The weights' quadratic program by alternating directions (Douglas-Rachford splitting of the
// energy and the simplices) with Anderson acceleration: findings.md section B.
#include "skinfield/solve/simplex_qp.h"

#include "skinfield/base/parallel.h"
#include "skinfield/solve/sparse_factor.h"
#include "solve/anderson.h"
#include "solve/free_rows.h"
#include "solve/penalty.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 256;
constexpr int kMemory = 8;
constexpr double kRelaxation = 1.6;
constexpr int kCheckEvery = 5;
constexpr int kBalanceEvery = 10;
constexpr int kSettle = 4;            // first iterations, which say nothing about the balance
constexpr double kBalanced = 0.8;     // primal over dual residual
constexpr double kHonestRaise = 8.0;  // see Alternation::converged
constexpr int kSweeps = 4;

double largest_difference(const RowMatrix& A, const RowMatrix& B) {
  return parallel_reduce(
      static_cast<std::size_t>(A.rows()), kRowsPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        const auto at = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        return (A.middleRows(at, count) - B.middleRows(at, count)).cwiseAbs().maxCoeff();
      },
      [](double a, double b) { return std::max(a, b); });
}

class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class Alternation {
 public:
  Alternation(const SimplexProblem& problem, const SimplexOptions& options, const FreeRows& free,
              const Progress& progress)
      : options_(options), free_(free), progress_(progress), anderson_(kMemory, Vector()) {
    progress_.check();
    factor_.analyse(free_.Q);
    RowMatrix X = options_.start.size() ? free_.gather(options_.start) : unconstrained();
    free_.project(X, start_);
    d_ = local_penalty(problem, free_, X, start_);
    S_ = start_;
    if (options_.start.size()) {
      // At the optimum this S is the fixed point itself, multipliers included.
      S_ -= d_.cwiseInverse().asDiagonal() * free_.gradient(start_);
    }
    Z_ = checked_ = start_;
    progress_.check();
    factor_.factor(free_.Q, d_);
    anderson_.set_weight(d_);
  }

  /// One iteration; `it` counts from 1.
  void iterate(int it) {
    progress_.check();
    if (it % kBalanceEvery == kSettle) balance();
    previous_.swap(Z_);
    free_.project(S_, Z_);
    split();
    factor_.solve(W_);
    const double primal = distance(W_, Z_), dual = distance(Z_, previous_);
    if (it > kSettle && primal > 0 && dual > 0) {
      log_ratio_ += std::log(primal / dual);
      ++ratios_;
    }
    if (it % kCheckEvery == 0) check();
    step();
  }

  /// Both the distance between the halves of the splitting, which measured 0.7 to 1.5 times the
  /// distance to the optimum, and the movement since the last check are below the tolerance.
  /// That holds near the starting penalty: a raised one pulls the halves together without moving
  /// them to the optimum. So the first success only lowers the penalty; two more must follow.
  bool converged() {
    if (!fresh_check_) return false;
    fresh_check_ = false;
    if (!(change_ < options_.tolerance)) {
      confirmed_ = 0;
      return false;
    }
    if (!confirming_) {
      confirming_ = true;
      confirmed_ = 1;
      if (raised_ > kHonestRaise) {
        scale_penalty(kHonestRaise / raised_);
        confirmed_ = 0;
      }
      return false;
    }
    return ++confirmed_ >= 2;
  }

  const RowMatrix& start() const { return start_; }
  RowMatrix& result() { return Z_; }
  double lower_bound() const { return lower_; }
  double change() const { return change_; }

 private:
  RowMatrix unconstrained() {
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

  template <class Body>
  void for_rows(const Body& body) const {
    parallel_for(static_cast<std::size_t>(S_.rows()), kRowsPerBlock,
                 [&](std::size_t i) { body(static_cast<Eigen::Index>(i)); });
  }

  double distance(const RowMatrix& A, const RowMatrix& B) const {
    return std::sqrt(parallel_reduce(
        static_cast<std::size_t>(A.rows()), kRowsPerBlock, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double sum = 0;
          for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
            sum += d_[i] * (A.row(i) - B.row(i)).squaredNorm();
          }
          return sum;
        },
        [](double a, double b) { return a + b; }));
  }

  void split() {
    W_.resizeLike(S_);
    for_rows(
        [&](Eigen::Index i) { W_.row(i) = d_[i] * (2 * Z_.row(i) - S_.row(i)) + free_.R.row(i); });
  }

  void step() {
    F_.resizeLike(S_);
    for_rows([&](Eigen::Index i) { F_.row(i) = kRelaxation * (W_.row(i) - Z_.row(i)); });
    anderson_.advance(S_, F_);
  }

  void check() {
    // (Q + D) W = D (2Z - S) + R gives Q W - R without another product.
    RowMatrix& L = F_;
    L.resizeLike(S_);
    for_rows([&](Eigen::Index i) { L.row(i) = d_[i] * (2 * Z_.row(i) - S_.row(i) - W_.row(i)); });
    lower_ = std::max(lower_, free_.lower_bound(W_, L));
    change_ = std::max(largest_difference(W_, Z_), largest_difference(Z_, checked_));
    checked_ = Z_;
    fresh_check_ = true;
  }

  /// Residual balancing (He, Yang, Wang 2000; Wohlberg 2017) in the norm of the penalty.
  void balance() {
    if (ratios_ < kBalanceEvery) return;
    const double ratio = std::exp(log_ratio_ / ratios_) / kBalanced;
    log_ratio_ = 0;
    ratios_ = 0;
    const double factor = std::clamp(ratio * ratio, 0.2, 8.0);
    if (factor > 2 && !confirming_) scale_penalty(factor);
    if (factor < 0.4 && raised_ > 1e-2) scale_penalty(factor);
  }

  void scale_penalty(double factor) {
    // S - Z is the multiplier divided by the penalty.
    for_rows([&](Eigen::Index i) {
      Eigen::RowVectorXd z = S_.row(i);
      free_.project_row(i, z.data());
      S_.row(i) = z + (S_.row(i) - z) / factor;
    });
    d_ *= factor;
    raised_ *= factor;
    log_ratio_ = 0;
    ratios_ = 0;
    factor_.factor(free_.Q, d_);
    anderson_.set_weight(d_);
  }

  const SimplexOptions& options_;
  const FreeRows& free_;
  const Progress& progress_;
  SparseFactor factor_;
  Anderson anderson_;
  Vector d_;
  RowMatrix S_, Z_, W_, F_, previous_, checked_, start_;
  double lower_ = -std::numeric_limits<double>::infinity();
  double change_ = std::numeric_limits<double>::infinity();
  double log_ratio_ = 0, raised_ = 1;
  int ratios_ = 0, confirmed_ = 0;
  bool confirming_ = false, fresh_check_ = false;
};

/// The same feasible point with less energy, and its certificate.
void finish(const FreeRows& free, RowMatrix& Z, SolveStats& stats, const Progress& progress) {
  free.gauss_seidel(Z, kSweeps, progress);
  const RowMatrix G = free.gradient(Z);
  stats.energy = free.energy(Z, G);
  stats.lower_bound = std::max(stats.lower_bound, free.lower_bound(Z, G));
  stats.kkt_residual = free.kkt_residual(Z, G);
  const double scale = std::max(std::abs(stats.energy), std::numeric_limits<double>::min());
  stats.relative_gap = std::max(0.0, stats.energy - stats.lower_bound) / scale;
}

}  // namespace

SimplexSolution solve_simplex_qp(const SimplexProblem& problem, const SimplexOptions& options,
                                 const Progress& progress) {
  const Clock clock;
  const FreeRows free(problem);
  if (options.start.size() &&
      (options.start.rows() != problem.Q.rows() || options.start.cols() != problem.columns)) {
    throw SolveError("the start has a wrong size", "simplex program");
  }
  SimplexSolution result;
  SolveStats& stats = result.stats;
  stats.lower_bound = -std::numeric_limits<double>::infinity();
  RowMatrix Z = RowMatrix::Zero(free.rows(), free.columns());
  if (free.rows() == 0 || free.columns() == 1) {
    Z.colwise() = free.row_sum;
  } else {
    Alternation alternation(problem, options, free, progress);
    stats.status = SolveStats::Status::limit;
    while (stats.iterations < options.max_iterations) {
      if (options.time_limit_s > 0 && clock.seconds() > options.time_limit_s) break;
      alternation.iterate(++stats.iterations);
      progress("solve", static_cast<double>(stats.iterations) / options.max_iterations);
      if (!alternation.converged()) continue;
      stats.status = SolveStats::Status::converged;
      break;
    }
    Z.swap(alternation.result());
    stats.lower_bound = alternation.lower_bound();
    stats.largest_change = alternation.change();
    if (stats.status == SolveStats::Status::limit) {
      const RowMatrix& start = alternation.start();
      const double before = free.energy(start, free.gradient(start));
      if (before < free.energy(Z, free.gradient(Z))) Z = start;
    }
  }
  finish(free, Z, stats, progress);
  result.W = free.scatter(Z);
  return result;
}

}  // namespace skinfield
