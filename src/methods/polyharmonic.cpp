#include "skinfield/methods/polyharmonic.h"

#include "methods/direct_solve.h"
#include "methods/locks.h"
#include "methods/reached.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/biharmonic.h"
#include "skinfield/operators/triharmonic.h"

#include <string>

namespace skinfield {
namespace {

constexpr const char* kWhere = "polyharmonic weights";

void check(const BoundedBiharmonicProblem& problem, const PolyharmonicOptions& options,
           const FixedRows& fixed) {
  const Eigen::Index n = problem.K.rows(), columns = fixed.weights.cols();
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (options.order < 1 || options.order > 3) refuse("the order is not 1, 2 or 3");
  if (problem.K.cols() != n || problem.M.size() != n) refuse("K and M differ in size");
  if (options.start.size() && (options.start.rows() != n || options.start.cols() != columns)) {
    refuse("the start has a wrong size");
  }
  if (!options.locked.empty() && options.start.size() == 0) refuse("locked columns need a start");
  for (const int j : options.locked) {
    if (j < 0 || j >= columns) refuse("locked column " + std::to_string(j) + " does not exist");
  }
  if (fixed.node.empty()) {
    throw SolveError("no row is fixed", kWhere, "give at least one handle inside the shape");
  }
}

/// The energy's matrix on the nodes that were reached.
SparseRows energy_matrix(const SparseRows& K, const Vector& M, int order) {
  if (order == 1) return K;
  return order == 2 ? biharmonic(K, M) : triharmonic(K, M);
}

}  // namespace

PolyharmonicResult polyharmonic(const BoundedBiharmonicProblem& problem,
                                const PolyharmonicOptions& options, const Progress& progress) {
  const FixedRows fixed = merge(problem.fixed, options.paint);
  const Eigen::Index columns = fixed.weights.cols();
  check(problem, options, fixed);
  const Locks locks(options.locked, columns);
  const NodeSubset reached = reached_nodes(problem.K, fixed.node);
  const auto n = static_cast<Eigen::Index>(reached.node.size());

  PolyharmonicResult result;
  result.unreached = reached.left_out;
  result.W = RowMatrix::Zero(problem.K.rows(), columns);
  FixedRows given;
  given.weights.resize(static_cast<Eigen::Index>(fixed.node.size()),
                       static_cast<Eigen::Index>(locks.open().size()));
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    const int v = fixed.node[k];
    const auto row = static_cast<Eigen::Index>(k);
    given.node.push_back(reached.position[static_cast<std::size_t>(v)]);
    if (!locks.any()) {
      given.weights.row(row) = fixed.weights.row(row);
      continue;
    }
    const double left = std::max(0.0, 1 - locks.part(options.start, v).sum());
    given.weights.row(row) = locks.rest(fixed.weights.row(row), options.start, v, left);
  }
  Vector M(n);
  for (Eigen::Index i = 0; i < n; ++i) M[i] = problem.M[reached.node[static_cast<std::size_t>(i)]];
  const SparseRows A = energy_matrix(
      result.unreached.empty() ? problem.K : restrict_to(problem.K, reached), M, options.order);
  const DirectSolution solution = solve_with_fixed_rows(A, {}, given, progress);
  result.stats = solution.stats;
  result.stats.energy = 0.5 * solution.X.cwiseProduct(A * solution.X).sum();
  result.stats.lower_bound = result.stats.energy;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int v = reached.node[static_cast<std::size_t>(i)];
    if (locks.any()) result.W.row(v) = locks.part(options.start, v);
    for (std::size_t t = 0; t < locks.open().size(); ++t) {
      result.W(v, locks.open()[t]) = solution.X(i, static_cast<Eigen::Index>(t));
    }
  }
  return result;
}

RowMatrix valid_weights(const RowMatrix& raw, const std::vector<int>& locked) {
  const Locks locks(locked, raw.cols());
  RowMatrix W = raw.cwiseMax(0.0);
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    if (raw.row(i).isZero(0)) continue;
    const Eigen::RowVectorXd kept = locks.part(raw, i);
    const Eigen::RowVectorXd rest = locks.rest(W.row(i), W, i, std::max(0.0, 1 - kept.sum()));
    W.row(i) = kept;
    for (std::size_t t = 0; t < locks.open().size(); ++t) {
      W(i, locks.open()[t]) = rest[static_cast<Eigen::Index>(t)];
    }
    if (locks.open().empty()) W.row(i) /= kept.sum();
  }
  return W;
}

}  // namespace skinfield
