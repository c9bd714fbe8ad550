#include "skinfield/solve/simplex_dual.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "support/grid.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

namespace skinfield {
namespace {

using skinfield_test::grid_program;

SimplexSolution primal(const SimplexProblem& p) {
  SimplexOptions options;
  options.tolerance = 1e-7;
  options.max_iterations = 3000;
  return solve_simplex_qp(p, options);
}

DualOptions to_gap(double gap) {
  DualOptions options;
  options.relative_gap = gap;
  return options;
}

double largest_difference(const RowMatrix& A, const RowMatrix& B) {
  return (A - B).cwiseAbs().maxCoeff();
}

/// Every row fixed in `p` as a constraint instead.
LinearConstraints as_constraints(const FixedRows& fixed, Eigen::Index n) {
  LinearConstraints constraints;
  constraints.C.resize(static_cast<Eigen::Index>(fixed.node.size()), n);
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    constraints.C.insert(static_cast<Eigen::Index>(k), fixed.node[k]) = 1;
  }
  constraints.C.makeCompressed();
  constraints.D = fixed.weights;
  return constraints;
}

TEST(SimplexDual, AgreesWithThePrimal) {
  const SimplexProblem p = grid_program(6, 4);
  const DualSolution dual = solve_simplex_dual(p, to_gap(1e-8));
  const SimplexSolution other = primal(p);
  EXPECT_EQ(dual.stats.status, SolveStats::Status::converged);
  EXPECT_LE(dual.stats.relative_gap, 1e-8);
  EXPECT_LT(largest_difference(dual.W, other.W), 1e-3);
  EXPECT_NEAR(dual.stats.energy, other.stats.energy, 2e-8 * other.stats.energy);
  EXPECT_LE(dual.stats.lower_bound, other.stats.energy * (1 + 1e-12));
  EXPECT_NEAR(dual.recovered_energy, other.stats.energy, 1e-4 * other.stats.energy);
  EXPECT_LT(dual.constraint_violation, 1e-3);
  EXPECT_LT(dual.stats.kkt_residual, 1e-4);
  EXPECT_GE(dual.W.minCoeff(), 0);
  EXPECT_LT((dual.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  const double energy = 0.5 * dual.W.cwiseProduct(p.Q * dual.W).sum();
  EXPECT_NEAR(dual.stats.energy, energy, 1e-9 * energy);
  for (std::size_t k = 0; k < p.fixed.node.size(); ++k) {
    EXPECT_TRUE(dual.W.row(p.fixed.node[k]) == p.fixed.weights.row(static_cast<Eigen::Index>(k)));
  }
}

TEST(SimplexDual, HistoryTellsOfBothObjectives) {
  const SimplexProblem p = grid_program(6, 4);
  DualOptions options = to_gap(1e-7);
  options.keep_history = true;
  const DualSolution dual = solve_simplex_dual(p, options);
  const double optimum = primal(p).stats.energy;
  ASSERT_EQ(dual.history.size(), static_cast<std::size_t>(dual.stats.iterations) + 1);
  EXPECT_GE(dual.evaluations, dual.stats.iterations);
  double before = -std::numeric_limits<double>::infinity();
  for (const DualRecord& record : dual.history) {
    // L-BFGS only ever lowers the dual's negative, and weak duality bounds it.
    EXPECT_GE(record.dual_objective, before - 1e-12 * optimum);
    EXPECT_LE(record.dual_objective, optimum * (1 + 1e-9));
    before = record.dual_objective;
  }
  const DualRecord &first = dual.history.front(), &last = dual.history.back();
  EXPECT_NEAR(last.dual_objective, optimum, 1e-5 * optimum);
  EXPECT_NEAR(last.primal_objective, optimum, 1e-4 * optimum);
  EXPECT_LT(last.constraint_violation, 0.01 * first.constraint_violation);
  EXPECT_LT(last.gradient, 0.01 * first.gradient);
}

TEST(SimplexDual, TakesLinearTermsAndRowSums) {
  SimplexProblem p = grid_program(5, 3);
  const Eigen::Index n = p.Q.rows();
  Random random(8);
  p.B.resize(n, p.columns);
  for (double& b : p.B.reshaped()) b = 0.2 * p.Q.coeffs().maxCoeff() * random.normal();
  p.row_sum.resize(n);
  for (double& s : p.row_sum) s = 0.25 + 0.5 * random.uniform();
  p.row_sum[7] = 0;
  p.fixed.weights *= 0.5;
  for (const int v : p.fixed.node) p.row_sum[v] = 0.5;
  const DualSolution dual = solve_simplex_dual(p, to_gap(1e-8));
  EXPECT_LT(largest_difference(dual.W, primal(p).W), 1e-3);
  EXPECT_LT((dual.W.rowwise().sum() - p.row_sum).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SimplexDual, BoxesAgreeWithThePrimal) {
  SimplexProblem p = grid_program(6, 4);
  p.row_set = RowSet::box;
  const DualSolution dual = solve_simplex_dual(p, to_gap(1e-8));
  const SimplexSolution other = primal(p);
  EXPECT_EQ(other.stats.status, SolveStats::Status::converged);
  EXPECT_LT(other.stats.relative_gap, 1e-8);
  EXPECT_LT(largest_difference(dual.W, other.W), 1e-3);
  EXPECT_NEAR(dual.stats.energy, other.stats.energy, 2e-8 * other.stats.energy);
  // Columns have nothing to do with each other: one alone comes out the same.
  SimplexProblem one = p;
  one.columns = 1;
  one.fixed.weights = p.fixed.weights.col(2);
  EXPECT_LT(largest_difference(primal(one).W, other.W.col(2)), 1e-5);
  EXPECT_LT(largest_difference(solve_simplex_dual(one, to_gap(1e-8)).W, dual.W.col(2)), 2e-3);
  // Without the sums the minimum is lower.
  p.row_set = RowSet::simplex;
  EXPECT_LT(other.stats.energy, primal(p).stats.energy);
}

TEST(SimplexDual, UpperSidesOfBoxesMatter) {
  // Two neighbours far apart in value pull the energy's minimiser above 1 (figure A1).
  SimplexProblem p = grid_program(6, 2);
  p.fixed.node = {42, 43};
  p.row_set = RowSet::box;
  const DualSolution bounded = solve_simplex_dual(p, to_gap(1e-7));
  DualOptions options = to_gap(1e-7);
  options.upper_bound = false;
  const DualSolution open = solve_simplex_dual(p, options);
  EXPECT_LE(bounded.W.maxCoeff(), 1);
  EXPECT_GT(open.W.maxCoeff(), 1.05);
  EXPECT_GE(open.W.minCoeff(), 0);
  EXPECT_LT(open.stats.energy, bounded.stats.energy);
  EXPECT_LE(open.stats.relative_gap, 1e-7);
}

TEST(SimplexDual, ConstraintsCanReplaceFixedRows) {
  const SimplexProblem p = grid_program(5, 3);
  const SimplexSolution expected = primal(p);
  SimplexProblem loose = p;
  loose.fixed = FixedRows{{}, RowMatrix(0, 3)};
  LinearConstraints constraints = as_constraints(p.fixed, p.Q.rows());
  const DualSolution dual = solve_simplex_dual(loose, to_gap(1e-7), {}, constraints);
  EXPECT_EQ(dual.stats.status, SolveStats::Status::converged);
  EXPECT_LT(largest_difference(dual.W, expected.W), 2e-3);
  EXPECT_LT(dual.constraint_residual, 1e-8);
  EXPECT_LE(dual.stats.lower_bound, expected.stats.energy * (1 + 1e-9));
  // Rows that repeat each other make the system singular; the regulariser does not mind.
  SparseRows twice(2 * constraints.C.rows(), constraints.C.cols());
  for (Eigen::Index k = 0; k < twice.rows(); ++k) {
    for (SparseRows::InnerIterator it(constraints.C, k % constraints.C.rows()); it; ++it) {
      twice.insert(k, it.col()) = it.value();
    }
  }
  twice.makeCompressed();
  constraints.C = twice;
  constraints.D = p.fixed.weights.replicate(2, 1);
  const DualSolution again = solve_simplex_dual(loose, to_gap(1e-7), {}, constraints);
  EXPECT_LT(largest_difference(again.W, dual.W), 2e-3);
}

TEST(SimplexDual, GeneralConstraintsHoldBesideFixedRows) {
  SimplexProblem p = grid_program(5, 3);
  const RowMatrix without = primal(p).W;
  // Two nodes that must agree, and one whose weights average to a given row with its neighbour's.
  LinearConstraints constraints;
  constraints.C.resize(2, p.Q.rows());
  constraints.C.insert(0, 3) = 1;
  constraints.C.insert(0, 97) = -1;
  constraints.C.insert(1, 50) = 0.5;
  constraints.C.insert(1, 51) = 0.5;
  constraints.C.makeCompressed();
  constraints.D = RowMatrix::Zero(2, 3);
  constraints.D.row(1) << 0.1, 0.3, 0.6;
  const DualSolution dual = solve_simplex_dual(p, to_gap(1e-6), {}, constraints);
  EXPECT_EQ(dual.stats.status, SolveStats::Status::converged);
  EXPECT_GT(largest_difference(without.row(3), without.row(97)), 0.05);
  EXPECT_LT(largest_difference(dual.W.row(3), dual.W.row(97)), 1e-8);
  EXPECT_LT((constraints.C * dual.W - constraints.D).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((dual.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_GE(dual.W.minCoeff(), 0);
  // Optimal: no feasible direction towards other feasible points lowers the energy.
  EXPECT_GT(dual.stats.energy, primal(p).stats.energy);
  EXPECT_LE(dual.stats.lower_bound, dual.stats.energy);
}

TEST(SimplexDual, WarmStartsSaveIterations) {
  const SimplexProblem p = grid_program(6, 4);
  DualOptions options = to_gap(1e-6);
  const DualSolution cold = solve_simplex_dual(p, options);
  options.start = primal(p).W;
  const DualSolution warm = solve_simplex_dual(p, options);
  EXPECT_LT(warm.stats.iterations, cold.stats.iterations);
  EXPECT_LT(largest_difference(warm.W, cold.W), 5e-3);
}

TEST(SimplexDual, StopsAsToldTo) {
  const SimplexProblem p = grid_program(7, 4);
  DualOptions options = to_gap(1e-12);
  options.max_iterations = 3;
  const DualSolution few = solve_simplex_dual(p, options);
  EXPECT_EQ(few.stats.status, SolveStats::Status::limit);
  EXPECT_EQ(few.stats.iterations, 3);
  EXPECT_LT((few.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_LE(few.stats.lower_bound, few.stats.energy);
  options.max_iterations = 20000;
  options.time_limit_s = 1e-9;
  EXPECT_EQ(solve_simplex_dual(p, options).stats.status, SolveStats::Status::limit);
  options.time_limit_s = 0;
  options.tolerance = 1e-4;
  const DualSolution paper = solve_simplex_dual(p, options);
  EXPECT_EQ(paper.stats.status, SolveStats::Status::converged);
  EXPECT_GT(paper.stats.relative_gap, 1e-12);
  Progress progress;
  int polls = 0;
  progress.cancelled = [&polls] { return ++polls > 4; };
  EXPECT_THROW(solve_simplex_dual(p, {}, progress), Cancelled);
}

TEST(SimplexDual, SameBytesAtAnyThreadCount) {
  const SimplexProblem p = grid_program(9, 5);
  SimplexProblem loose = p;
  loose.fixed = FixedRows{{}, RowMatrix(0, 5)};
  const LinearConstraints constraints = as_constraints(p.fixed, p.Q.rows());
  DualOptions options = to_gap(1e-3);
  options.max_iterations = 40;
  RowMatrix fixed[2], constrained[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    fixed[threads - 1] = solve_simplex_dual(p, options).W;
    constrained[threads - 1] = solve_simplex_dual(loose, options, {}, constraints).W;
  }
  EXPECT_TRUE(fixed[0] == fixed[1]);
  EXPECT_TRUE(constrained[0] == constrained[1]);
}

TEST(SimplexDual, TrivialPrograms) {
  SimplexProblem all = grid_program(2, 2);
  all.fixed.node.resize(8);
  std::iota(all.fixed.node.begin(), all.fixed.node.end(), 0);
  all.fixed.weights = RowMatrix::Constant(8, 2, 0.5);
  EXPECT_TRUE(solve_simplex_dual(all).W == all.fixed.weights);
  const SimplexProblem one = grid_program(4, 1);
  EXPECT_LT((solve_simplex_dual(one).W.array() - 1).abs().maxCoeff(), 1e-12);
}

TEST(SimplexDual, RefusesWhatItCannotSolve) {
  SimplexProblem p = grid_program(3, 2);
  p.support.assign(static_cast<std::size_t>(p.Q.rows()), {0, 1});
  EXPECT_THROW(solve_simplex_dual(p), SolveError);
  p.support.clear();
  LinearConstraints constraints;
  constraints.C.resize(1, p.Q.rows());
  constraints.C.insert(0, 4) = 1;
  constraints.C.makeCompressed();
  constraints.D = RowMatrix::Constant(1, 2, 0.7);  // a row that would sum to 1.4
  EXPECT_THROW(solve_simplex_dual(p, {}, {}, constraints), SolveError);
  constraints.D = RowMatrix::Constant(2, 2, 0.5);
  EXPECT_THROW(solve_simplex_dual(p, {}, {}, constraints), SolveError);
  DualOptions options;
  options.start = RowMatrix::Zero(3, 2);
  EXPECT_THROW(solve_simplex_dual(p, options), SolveError);
  p.fixed = FixedRows{{}, RowMatrix(0, 2)};  // nothing anchors it
  EXPECT_THROW(solve_simplex_dual(p), SolveError);
}

}  // namespace
}  // namespace skinfield
