// The exact program by a primal active-set method.
#include "skinfield/base/error.h"
#include "skinfield/solve/active_set.h"
#include "skinfield/solve/sparse_factor.h"
#include "solve/free_rows.h"
#include "solve/simplex_face.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr int kSweeps = 5;
constexpr double kDecrease = 1e-4;  // Armijo's condition along the projected path
constexpr int kMaxHalvings = 20;

using Clock = std::chrono::steady_clock;

RowMatrix first_point(const FreeRows& free, const RowMatrix& start) {
  RowMatrix X, Z;
  if (start.size()) {
    X = free.gather(start);
  } else {
    X = free.R;
    SparseFactor factor;
    factor.analyse(free.Q);
    factor.factor(free.Q);
    factor.solve(X);
  }
  free.project(X, Z);
  return Z;
}

/// The longest t <= 1 with Z + t step >= 0.
double room(const RowMatrix& Z, const RowMatrix& step) {
  double t = 1;
  for (Eigen::Index e = 0; e < Z.size(); ++e) {
    if (step.data()[e] < 0) t = std::min(t, Z.data()[e] / -step.data()[e]);
  }
  return t;
}

/// From Z towards Z + step along the projected path: the first of 1, 1/2, 1/4, ... that lowers the
/// energy well, or the longest feasible step, which always lowers it.
RowMatrix search(const FreeRows& free, const RowMatrix& Z, const RowMatrix& G,
                 const RowMatrix& step) {
  const double before = free.energy(Z, G), feasible = room(Z, step);
  RowMatrix V;
  double t = 1;
  for (int halving = 0; halving < kMaxHalvings && t > feasible; ++halving, t *= 0.5) {
    free.project(Z + t * step, V);
    const double change = G.cwiseProduct(V - Z).sum();
    if (free.energy(V, free.gradient(V)) <= before + kDecrease * change && change < 0) return V;
  }
  free.project(Z + std::min(t, feasible) * step, V);
  return V;
}

}  // namespace

SimplexSolution solve_simplex_active_set(const SimplexProblem& problem,
                                         const ActiveSetOptions& options,
                                         const Progress& progress) {
  const auto begin = Clock::now();
  const FreeRows free(problem);
  if (free.boxes()) throw SolveError("the rows are not simplices", "simplex active set");
  if (options.start.size() &&
      (options.start.rows() != problem.Q.rows() || options.start.cols() != problem.columns)) {
    throw SolveError("the start has a wrong size", "simplex active set");
  }
  SimplexSolution solution;
  SolveStats& stats = solution.stats;
  stats.status = SolveStats::Status::limit;
  stats.lower_bound = -std::numeric_limits<double>::infinity();
  RowMatrix Z = first_point(free, options.start);
  RowMatrix before = Z;
  while (true) {
    progress.check();
    free.gauss_seidel(Z, kSweeps, progress);
    const RowMatrix G = free.gradient(Z);
    stats.energy = free.energy(Z, G);
    stats.lower_bound = std::max(stats.lower_bound, free.lower_bound(Z, G));
    stats.kkt_residual = free.kkt_residual(Z, G);
    stats.largest_change = Z.size() ? (Z - before).cwiseAbs().maxCoeff() : 0.0;
    const double scale = std::max(std::abs(stats.energy), std::numeric_limits<double>::min());
    stats.relative_gap = std::max(0.0, stats.energy - stats.lower_bound) / scale;
    if (stats.relative_gap <= options.relative_gap) {
      stats.status = SolveStats::Status::converged;
      break;
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    if (options.time_limit_s > 0 && seconds > options.time_limit_s) break;
    if (stats.iterations >= options.max_iterations) break;
    before = Z;
    Z = search(free, before, G, face_step(free, before, G));
    ++stats.iterations;
    progress("solve", static_cast<double>(stats.iterations) / options.max_iterations);
  }
  solution.W = free.scatter(Z);
  return solution;
}

}  // namespace skinfield
