#include "skinfield/solve/active_set.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "support/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace skinfield {
namespace {

using skinfield_test::grid_program;

SimplexSolution alternating(const SimplexProblem& p) {
  SimplexOptions options;
  options.tolerance = 1e-7;
  options.max_iterations = 3000;
  return solve_simplex_qp(p, options);
}

SimplexProblem boxes(int s, int m) {
  SimplexProblem p = grid_program(s, m);
  p.row_set = RowSet::box;
  return p;
}

TEST(SimplexActiveSet, ReachesTheOptimum) {
  for (const int m : {2, 5}) {
    const SimplexProblem p = grid_program(6, m);
    const SimplexSolution exact = solve_simplex_active_set(p);
    EXPECT_EQ(exact.stats.status, SolveStats::Status::converged);
    EXPECT_LE(exact.stats.relative_gap, 1e-9);
    EXPECT_LT(exact.stats.kkt_residual, 1e-8);
    const SimplexSolution other = alternating(p);
    EXPECT_LT((exact.W - other.W).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_NEAR(exact.stats.energy, other.stats.energy, 1e-9 * other.stats.energy);
    EXPECT_GE(exact.W.minCoeff(), 0);
    EXPECT_LT((exact.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    const double energy = 0.5 * exact.W.cwiseProduct(p.Q * exact.W).sum();
    EXPECT_NEAR(exact.stats.energy, energy, 1e-12 * energy);
  }
}

TEST(SimplexActiveSet, KeepsRowSumsAndSupports) {
  SimplexProblem p = grid_program(5, 3);
  p.row_sum = Vector::Constant(p.Q.rows(), 0.75);
  p.row_sum[9] = 0;
  p.fixed.weights *= 0.75;
  p.support.assign(static_cast<std::size_t>(p.Q.rows()), {0, 1, 2});
  p.support[60] = {1, 2};
  const SimplexSolution exact = solve_simplex_active_set(p);
  EXPECT_EQ(exact.stats.status, SolveStats::Status::converged);
  EXPECT_LT((exact.W - alternating(p).W).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_EQ(exact.W(60, 0), 0);
  EXPECT_EQ(exact.W.row(9).sum(), 0);
}

TEST(SimplexActiveSet, EveryIterateIsValidAndLower) {
  const SimplexProblem p = grid_program(7, 5);
  ActiveSetOptions options;
  double before = std::numeric_limits<double>::infinity();
  for (int iterations = 0; iterations < 4; ++iterations) {
    options.max_iterations = iterations;
    const SimplexSolution solution = solve_simplex_active_set(p, options);
    EXPECT_LE(solution.stats.energy, before);
    EXPECT_LE(solution.stats.lower_bound, solution.stats.energy);
    EXPECT_GE(solution.W.minCoeff(), 0);
    before = solution.stats.energy;
  }
  options.max_iterations = 100;
  const SimplexSolution cold = solve_simplex_active_set(p, options);
  options.start = cold.W;
  const SimplexSolution warm = solve_simplex_active_set(p, options);
  EXPECT_EQ(warm.stats.iterations, 0);
  EXPECT_LE(warm.stats.energy, cold.stats.energy * (1 + 1e-12));
}

TEST(BoxActiveSet, SettlesAtTheOptimum) {
  const SimplexProblem p = boxes(6, 4);
  const SimplexSolution settled = solve_box_active_set(p, 100);
  EXPECT_EQ(settled.stats.status, SolveStats::Status::converged);
  EXPECT_LT(settled.stats.relative_gap, 1e-9);
  EXPECT_LT((settled.W - alternating(p).W).cwiseAbs().maxCoeff(), 1e-5);
  // Conditions of optimality, entry by entry.
  const RowMatrix G = p.Q * settled.W;
  for (Eigen::Index i = 0; i < G.rows(); ++i) {
    if (std::count(p.fixed.node.begin(), p.fixed.node.end(), static_cast<int>(i))) continue;
    for (int j = 0; j < p.columns; ++j) {
      const double w = settled.W(i, j);
      EXPECT_TRUE(w <= 0 || G(i, j) < 1e-9) << i << ' ' << j << ' ' << G(i, j);
      EXPECT_TRUE(w >= 1 || G(i, j) > -1e-9) << i << ' ' << j << ' ' << G(i, j);
    }
  }
}

TEST(BoxActiveSet, FewIterationsAreValidButNotOptimal) {
  const SimplexProblem p = boxes(8, 4);
  const SimplexSolution late = solve_box_active_set(p, 100, 1e-9);
  EXPECT_EQ(late.stats.status, SolveStats::Status::limit);
  EXPECT_EQ(late.stats.iterations, 0);
  const SimplexSolution few = solve_box_active_set(p, 1);
  EXPECT_EQ(few.stats.status, SolveStats::Status::limit);
  EXPECT_EQ(few.stats.iterations, 1);
  EXPECT_GE(few.W.minCoeff(), 0);
  EXPECT_LE(few.W.maxCoeff(), 1);
  EXPECT_GT(few.stats.energy, solve_box_active_set(p, 100).stats.energy);
}

TEST(ActiveSet, SameBytesAtAnyThreadCount) {
  const SimplexProblem p = grid_program(7, 5), q = boxes(7, 5);
  RowMatrix simplex[2], box[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    simplex[threads - 1] = solve_simplex_active_set(p).W;
    box[threads - 1] = solve_box_active_set(q).W;
  }
  EXPECT_TRUE(simplex[0] == simplex[1]);
  EXPECT_TRUE(box[0] == box[1]);
}

TEST(ActiveSet, TrivialAndRefused) {
  SimplexProblem all = grid_program(2, 2);
  all.fixed.node.resize(8);
  std::iota(all.fixed.node.begin(), all.fixed.node.end(), 0);
  all.fixed.weights = RowMatrix::Constant(8, 2, 0.5);
  EXPECT_TRUE(solve_simplex_active_set(all).W == all.fixed.weights);
  const SimplexProblem one = grid_program(4, 1);
  EXPECT_TRUE((solve_simplex_active_set(one).W.array() == 1.0).all());
  EXPECT_THROW(solve_simplex_active_set(boxes(3, 2)), SolveError);
  EXPECT_THROW(solve_box_active_set(grid_program(3, 2)), SolveError);
  ActiveSetOptions options;
  options.start = RowMatrix::Zero(3, 2);
  EXPECT_THROW(solve_simplex_active_set(grid_program(3, 2), options), SolveError);
}

}  // namespace
}  // namespace skinfield
