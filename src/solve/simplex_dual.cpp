#include "skinfield/solve/simplex_dual.h"

#include "skinfield/base/error.h"
#include "skinfield/solve/lbfgs.h"
#include "solve/constraint_projection.h"
#include "solve/dual_objective.h"
#include "solve/penalty.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr const char* kWhere = "dual program";
constexpr int kCheckEvery = 20;
constexpr int kSweeps = 2;
constexpr double kScale = 10;
constexpr double kFarAway = 1e3;  // an upper side that no weight comes near

using Clock = std::chrono::steady_clock;

void check(const SimplexProblem& problem, const DualOptions& options,
           const LinearConstraints& constraints) {
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  const Eigen::Index N = problem.Q.rows();
  if (!problem.support.empty()) refuse("the dual takes no supports");
  if (options.start.size() &&
      (options.start.rows() != N || options.start.cols() != problem.columns)) {
    refuse("the start has a wrong size");
  }
  const Eigen::Index k = constraints.C.rows();
  if (k == 0) return;
  if (constraints.C.cols() != N || constraints.D.rows() != k ||
      constraints.D.cols() != problem.columns) {
    refuse("the constraints have a wrong size");
  }
  if (problem.row_set != RowSet::simplex) return;
  const Vector s = problem.row_sum.size() ? problem.row_sum : Vector::Ones(N);
  const Vector expected = constraints.C * s, given = constraints.D.rowwise().sum();
  for (Eigen::Index i = 0; i < k; ++i) {
    if (std::abs(expected[i] - given[i]) <= 1e-9 * (1 + std::abs(expected[i]))) continue;
    refuse("constraint " + std::to_string(i) + " contradicts the row sums");
  }
}

FreeConstraints restrict(const LinearConstraints& constraints, const SimplexProblem& problem,
                         const FreeRows& free) {
  FreeConstraints result;
  const Eigen::Index k = constraints.C.rows();
  result.C.resize(k, free.rows());
  result.D = constraints.D;
  if (k == 0) return result;
  RowMatrix fixed = RowMatrix::Zero(problem.Q.rows(), problem.columns);
  for (std::size_t f = 0; f < problem.fixed.node.size(); ++f) {
    fixed.row(problem.fixed.node[f]) = problem.fixed.weights.row(static_cast<Eigen::Index>(f));
  }
  result.D -= constraints.C * fixed;
  std::vector<int> position(static_cast<std::size_t>(problem.Q.rows()), -1);
  for (std::size_t i = 0; i < free.node.size(); ++i) {
    position[static_cast<std::size_t>(free.node[i])] = static_cast<int>(i);
  }
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (Eigen::Index r = 0; r < k; ++r) {
    for (SparseRows::InnerIterator it(constraints.C, r); it; ++it) {
      const int at = position[static_cast<std::size_t>(it.col())];
      if (at >= 0) entries.emplace_back(static_cast<std::int32_t>(r), at, it.value());
    }
  }
  result.C.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// The iteration and what it has certified so far.
class Run {
 public:
  Run(const SimplexProblem& problem, const DualOptions& options, const Progress& progress,
      const LinearConstraints& constraints)
      : options_(options),
        progress_(progress),
        free_(problem, constraints.C.rows() == 0),
        constraints_(restrict(constraints, problem, free_)),
        feasible_(free_, constraints_),
        inverse_(free_.Q, constraints_.C),
        dual_(free_, constraints_, inverse_, scale(problem), free_.boxes() && options.upper_bound) {
    if (free_.boxes() && !options.upper_bound) free_.row_sum *= kFarAway;
  }

  DualSolution solve(Clock::time_point begin) {
    const LbfgsObjective f = [&](const Vector& x, Vector& g) {
      progress_.check();
      ++solution_.evaluations;
      return dual_.evaluate(x, g);
    };
    LbfgsOptions lbfgs;
    lbfgs.memory = options_.memory;
    lbfgs.max_iterations = options_.max_iterations;
    lbfgs.gradient_tolerance = lbfgs.value_tolerance = options_.tolerance;
    bool enough = false, late = false;
    const LbfgsObserver observer = [&](const LbfgsState& state) {
      record(state);
      progress_("solve", static_cast<double>(state.iteration) / options_.max_iterations);
      late = options_.time_limit_s > 0 &&
             std::chrono::duration<double>(Clock::now() - begin).count() > options_.time_limit_s;
      if (state.iteration % kCheckEvery == 0) enough = certify(state.x);
      return enough || late;
    };
    Vector x = options_.start.size() ? dual_.variables(free_.gather(options_.start)) : dual_.cold();
    const LbfgsResult result = minimise_lbfgs(f, std::move(x), lbfgs, observer);
    if (certify(result.x)) enough = true;
    using Status = LbfgsResult::Status;
    const bool done = enough || (options_.tolerance > 0 && result.status == Status::converged);
    SolveStats& stats = solution_.stats;
    stats.status = done ? SolveStats::Status::converged : SolveStats::Status::limit;
    stats.iterations = result.iterations;
    solution_.recovered_energy = dual_.primal();
    solution_.constraint_violation = dual_.violation();
    solution_.constraint_residual = feasible_.residual(F_);
    solution_.W = free_.scatter(F_);
    return std::move(solution_);
  }

 private:
  /// One scale for all variables, Y = scale x^2, near the multipliers' size for a unit of weight.
  /// (Q11 preconditions the dual already: a scale a node, such as solve_simplex_qp's penalties,
  /// takes five times the iterations.)
  double scale(const SimplexProblem& problem) const {
    RowMatrix X = free_.R, D = constraints_.D;
    if (X.size() == 0) return 1;
    inverse_.apply(X, D);
    RowMatrix Z;
    free_.project(X, Z);
    return kScale * local_penalty(problem, free_, X, Z, {}).mean();
  }

  void record(const LbfgsState& state) {
    if (!options_.keep_history) return;
    solution_.history.push_back(
        {state.iteration, dual_.primal(), dual_.dual(), dual_.violation(), state.gradient});
  }

  /// Makes W(x) feasible and bounds the optimum; true if that is close enough.
  bool certify(const Vector& x) {
    Vector g(x.size());
    dual_.evaluate(x, g);  // a line search ends elsewhere
    SolveStats& stats = solution_.stats;
    RowMatrix F = dual_.weights(), L;
    const double lower = dual_.lower_bound(L);
    if (std::isfinite(lower) && (!bounded_ || lower > stats.lower_bound)) {
      stats.lower_bound = lower;
      bounded_ = true;
    }
    feasible_.project(F);
    if (constraints_.C.rows() == 0) free_.gauss_seidel(F, kSweeps, progress_);
    RowMatrix G = free_.gradient(F);
    const double energy = free_.energy(F, G);
    if (F_.size() == 0 || energy < stats.energy) {
      stats.energy = energy;
      stats.largest_change = F.size() ? (F - dual_.weights()).cwiseAbs().maxCoeff() : 0.0;
      if (constraints_.C.rows() > 0) G += L - free_.gradient(dual_.weights());  // C'Z
      stats.kkt_residual = free_.kkt_residual(F, G);
      F_ = std::move(F);
    }
    const double size = std::max(std::abs(stats.energy), std::numeric_limits<double>::min());
    stats.relative_gap = std::max(0.0, stats.energy - stats.lower_bound) / size;
    return options_.relative_gap > 0 && stats.relative_gap <= options_.relative_gap;
  }

  const DualOptions& options_;
  const Progress& progress_;
  FreeRows free_;
  FreeConstraints constraints_;
  ConstraintProjection feasible_;
  ConstrainedInverse inverse_;
  DualObjective dual_;
  RowMatrix F_;  ///< the best feasible weights
  bool bounded_ = false;
  DualSolution solution_;
};

}  // namespace

DualSolution solve_simplex_dual(const SimplexProblem& problem, const DualOptions& options,
                                const Progress& progress, const LinearConstraints& constraints) {
  const auto begin = Clock::now();
  check(problem, options, constraints);
  return Run(problem, options, progress, constraints).solve(begin);
}

}  // namespace skinfield
