// The weights' quadratic program: alternating directions, then projected Gauss-Seidel sweeps.
#include "skinfield/solve/simplex_qp.h"

#include "skinfield/base/error.h"
#include "solve/alternation.h"
#include "solve/free_rows.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr int kSweeps = 4;

class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
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
  if (free.rows() == 0 || (free.columns() == 1 && !free.boxes())) {
    Z.colwise() = free.row_sum;
  } else {
    Alternation alternation(problem, options, free, progress);
    stats.status = SolveStats::Status::limit;
    while (stats.iterations < options.max_iterations) {
      if (options.time_limit_s > 0 && clock.seconds() > options.time_limit_s) break;
      alternation.iterate(++stats.iterations);
      progress("solve", static_cast<double>(stats.iterations) / options.max_iterations);
      if (!alternation.converged() || !alternation.complete()) continue;
      stats.status = SolveStats::Status::converged;
      break;
    }
    double energy = 0;
    Z = alternation.result(energy);
    stats.lower_bound = alternation.certify(energy);
    stats.largest_change = alternation.change();
    stats.factor_entries = alternation.factor_entries();
    if (stats.status == SolveStats::Status::limit) {
      const RowMatrix& start = alternation.start();
      if (free.energy(start, free.gradient(start)) < energy) Z = start;
    }
  }
  finish(free, Z, stats, progress);
  result.W = free.scatter(Z);
  return result;
}

}  // namespace skinfield
