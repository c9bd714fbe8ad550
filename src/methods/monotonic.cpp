#include "skinfield/methods/monotonic.h"

#include "methods/monotone_order.h"
#include "methods/monotone_solver.h"
#include "methods/positive_links.h"
#include "methods/reached.h"
#include "operators/apply.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/solve/sparse_factor.h"

#include <string>

namespace skinfield {
namespace {

constexpr const char* kWhere = "monotonic weights";

void check(const MonotonicProblem& problem, const MonotonicOptions& options,
           const FixedRows& fixed) {
  const Eigen::Index n = problem.K.rows();
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (problem.K.cols() != n || problem.M.size() != n) refuse("K and M differ in size");
  if (fixed.node.empty()) {
    throw SolveError("no row is fixed", kWhere, "give at least one handle inside the shape");
  }
  if (options.representative.size() && (options.representative.rows() != n ||
                                        options.representative.cols() != fixed.weights.cols())) {
    refuse("the representative has a wrong size");
  }
}

/// Solutions of the Laplace equation with positive links, which have no extrema at free nodes.
RowMatrix harmonic_representative(const SparseRows& K, const FixedRows& fixed) {
  const SparseRows L = positive_links(K);
  const NodeSubset free = free_nodes(K.rows(), fixed.node);
  RowMatrix u = RowMatrix::Zero(K.rows(), fixed.weights.cols());
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    u.row(fixed.node[k]) = fixed.weights.row(static_cast<Eigen::Index>(k));
  }
  RowMatrix flow;
  apply(L, u, flow);
  const SparseRows free_L = restrict_to(L, free);
  SparseFactor factor;
  factor.analyse(free_L);
  factor.factor(free_L);
  RowMatrix X = -flow(free.node, Eigen::all);
  factor.solve(X);
  for (std::size_t k = 0; k < free.node.size(); ++k) {
    u.row(free.node[k]) = X.row(static_cast<Eigen::Index>(k));
  }
  return u;
}

}  // namespace

MonotonicResult monotonic(const MonotonicProblem& problem, const MonotonicOptions& options,
                          const Progress& progress) {
  const FixedRows all = merge(problem.fixed, options.paint);
  check(problem, options, all);
  const NodeSubset reached = reached_nodes(problem.K, all.node);
  const SparseRows K = reached.left_out.empty() ? problem.K : restrict_to(problem.K, reached);
  const Vector M = problem.M(reached.node);
  FixedRows fixed;
  fixed.weights = all.weights;
  std::vector<char> is_fixed(reached.node.size(), 0);
  for (const int v : all.node) {
    const int i = reached.position[static_cast<std::size_t>(v)];
    fixed.node.push_back(i);
    is_fixed[static_cast<std::size_t>(i)] = 1;
  }

  RowMatrix u;
  if (options.representative.size()) {
    u = options.representative(reached.node, Eigen::all);
    for (std::size_t k = 0; k < fixed.node.size(); ++k) {
      u.row(fixed.node[k]) = fixed.weights.row(static_cast<Eigen::Index>(k));
    }
  } else {
    u = harmonic_representative(K, fixed);
  }
  progress.check();

  MonotoneProgram program{K,
                          M,
                          fixed,
                          {},
                          options.coupled,
                          options.tolerance,
                          options.max_iterations,
                          options.time_limit_s};
  program.order.resize(static_cast<std::size_t>(u.cols()));
  parallel_for(program.order.size(), 1, [&](std::size_t j) {
    program.order[j] = monotone_order(K, u.col(static_cast<Eigen::Index>(j)), is_fixed);
  });
  const MonotoneSolution solution = solve_monotone(program, progress);

  MonotonicResult result;
  result.stats = solution.stats;
  result.unreached = reached.left_out;
  result.W = RowMatrix::Zero(problem.K.rows(), u.cols());
  result.monotone = result.W;
  RowMatrix normalised = solution.W.cwiseMax(0.0);
  for (Eigen::Index i = 0; i < normalised.rows(); ++i) {
    const double sum = normalised.row(i).sum();
    // Columns solved one by one may all vanish where no handle is near.
    if (sum > 0) {
      normalised.row(i) /= sum;
    } else {
      normalised.row(i) = u.row(i).cwiseMax(0.0) / u.row(i).cwiseMax(0.0).sum();
    }
  }
  for (std::size_t k = 0; k < reached.node.size(); ++k) {
    result.W.row(reached.node[k]) = normalised.row(static_cast<Eigen::Index>(k));
    result.monotone.row(reached.node[k]) = solution.W.row(static_cast<Eigen::Index>(k));
  }
  for (std::size_t k = 0; k < all.node.size(); ++k) {
    result.W.row(all.node[k]) = all.weights.row(static_cast<Eigen::Index>(k));
  }
  RowMatrix KW;
  apply(problem.K, result.W, KW);
  result.normalised_energy = 0.5 * (KW.array().square().colwise() / problem.M.array()).sum();
  return result;
}

}  // namespace skinfield
