#include "skinfield/methods/decoupled_biharmonic.h"

#include "methods/nodal_program.h"
#include "skinfield/solve/active_set.h"

#include <algorithm>
#include <utility>

namespace skinfield {
namespace {

constexpr double kNothing = 1e-12;  // a row sum below this says nothing about the shares

double target(const SimplexProblem& program, Eigen::Index i) {
  return program.row_sum.size() ? program.row_sum[i] : 1.0;
}

/// Rows scaled to their targets. Where there is nothing to scale, the neighbours know.
RowMatrix normalised(const SimplexProblem& program, const RowMatrix& raw) {
  RowMatrix W = raw;
  std::vector<char> done(static_cast<std::size_t>(raw.rows()), 0);
  std::vector<int> empty;
  const auto scale = [&](Eigen::Index i) {
    const double sum = W.row(i).sum(), s = target(program, i);
    if (s > 0 && !(sum > kNothing)) return false;
    if (s > 0) {
      W.row(i) *= s / sum;
    } else {
      W.row(i).setZero();
    }
    done[static_cast<std::size_t>(i)] = 1;
    return true;
  };
  for (std::size_t k = 0; k < program.fixed.node.size(); ++k) {
    done[static_cast<std::size_t>(program.fixed.node[k])] = 1;  // exact as they are
  }
  for (int i = 0; i < W.rows(); ++i) {
    if (!done[static_cast<std::size_t>(i)] && !scale(i)) empty.push_back(i);
  }
  while (!empty.empty()) {
    std::vector<int> left, filled;
    for (const int i : empty) {
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(W.cols());
      for (SparseRows::InnerIterator it(program.Q, i); it; ++it) {
        if (done[static_cast<std::size_t>(it.col())]) sum += W.row(it.col());
      }
      (sum.sum() > kNothing ? filled : left).push_back(i);
      if (sum.sum() > kNothing) W.row(i) = sum;
    }
    for (const int i : filled) scale(i);
    if (filled.empty()) {
      // Locked columns leave nothing to any neighbour.
      for (const int i : left) W.row(i).setConstant(target(program, i) / program.columns);
      break;
    }
    empty.swap(left);
  }
  return W;
}

SimplexSolution solve(const SimplexProblem& program, RowMatrix start,
                      const DecoupledBiharmonicOptions& options, const Progress& progress,
                      std::vector<DualRecord>& history) {
  if (options.solver == DecoupledSolver::active_set) {
    return solve_box_active_set(program, options.active_iterations, options.time_limit_s, progress);
  }
  if (options.solver == DecoupledSolver::dual) {
    DualOptions dual = options.dual;
    dual.start = std::move(start);
    if (options.time_limit_s > 0) dual.time_limit_s = options.time_limit_s;
    DualSolution solution = solve_simplex_dual(program, dual, progress);
    history = std::move(solution.history);
    return {std::move(solution.W), solution.stats};
  }
  SimplexOptions simplex;
  simplex.tolerance = options.tolerance;
  simplex.max_iterations = options.max_iterations;
  simplex.time_limit_s = options.time_limit_s;
  simplex.start = std::move(start);
  return solve_simplex_qp(program, simplex, progress);
}

}  // namespace

DecoupledBiharmonicResult decoupled_biharmonic(const BoundedBiharmonicProblem& problem,
                                               const DecoupledBiharmonicOptions& options,
                                               const Progress& progress) {
  NodalProgram nodal(problem, {options.start, options.locked, options.paint, {}},
                     "decoupled biharmonic weights");
  DecoupledBiharmonicResult result;
  result.unreached = nodal.unreached();
  if (!nodal.open()) {
    result.W = result.raw = nodal.weights({});
    return result;
  }
  nodal.program.row_set = RowSet::box;
  if (!options.penalties_from_stiffness) nodal.program.K.resize(0, 0);
  const SimplexSolution solution =
      solve(nodal.program, std::move(nodal.start), options, progress, result.history);
  result.stats = solution.stats;
  const RowMatrix W = normalised(nodal.program, solution.W);
  result.normalised_energy = 0.5 * W.cwiseProduct(nodal.program.Q * W).sum();
  result.W = nodal.weights(W);
  result.raw = nodal.weights(solution.W);
  return result;
}

}  // namespace skinfield
