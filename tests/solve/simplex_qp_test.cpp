#include "skinfield/solve/simplex_qp.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "support/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace skinfield {
namespace {

using skinfield_test::grid_program;

/// Oracle: the threshold by sorting (Held, Wolfe, Crowder 1974).
void project_by_sorting(std::vector<double>& w, double s) {
  std::vector<double> sorted = w;
  std::sort(sorted.rbegin(), sorted.rend());
  double sum = 0, threshold = sorted[0];
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    sum += sorted[k];
    const double t = (sum - s) / static_cast<double>(k + 1);
    if (sorted[k] > t) threshold = t;
  }
  for (double& x : w) x = std::max(0.0, x - threshold);
}

/// Oracle: a long accelerated projected-gradient run on dense matrices.
RowMatrix projected_gradient(const SimplexProblem& p, int iterations) {
  const Eigen::MatrixXd Q(p.Q);
  const double step = 1 / Q.cwiseAbs().rowwise().sum().maxCoeff();
  RowMatrix W = RowMatrix::Constant(Q.rows(), p.columns, 1.0 / p.columns);
  const auto project = [&](RowMatrix& X) {
    for (Eigen::Index i = 0; i < X.rows(); ++i) project_to_simplex(X.row(i).data(), p.columns);
    for (std::size_t k = 0; k < p.fixed.node.size(); ++k) {
      X.row(p.fixed.node[k]) = p.fixed.weights.row(static_cast<Eigen::Index>(k));
    }
  };
  project(W);
  RowMatrix Y = W;
  double t = 1;
  for (int i = 0; i < iterations; ++i) {
    RowMatrix next = Y - step * (Q * Y);
    if (p.B.size()) next -= step * p.B;
    project(next);
    const double t_next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
    if ((Y - next).cwiseProduct(next - W).sum() > 0) {
      t = 1;
      Y = next;
    } else {
      Y = next + ((t - 1) / t_next) * (next - W);
      t = t_next;
    }
    W = next;
  }
  return W;
}

void expect_feasible(const SimplexProblem& p, const RowMatrix& W) {
  ASSERT_EQ(W.rows(), p.Q.rows());
  ASSERT_EQ(W.cols(), p.columns);
  EXPECT_GE(W.minCoeff(), 0);
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    EXPECT_NEAR(W.row(i).sum(), p.row_sum.size() ? p.row_sum[i] : 1.0, 1e-12);
  }
  for (std::size_t k = 0; k < p.fixed.node.size(); ++k) {
    EXPECT_TRUE(W.row(p.fixed.node[k]) == p.fixed.weights.row(static_cast<Eigen::Index>(k)));
  }
}

SimplexOptions tight() {
  SimplexOptions options;
  options.tolerance = 1e-6;
  options.max_iterations = 2000;
  return options;
}

TEST(SimplexProjection, AgreesWithSorting) {
  Random random(11);
  for (int trial = 0; trial < 2000; ++trial) {
    const int m = 1 + static_cast<int>(random.below(30));
    const double s = trial % 7 == 0 ? 0 : random.uniform() * 2;
    const double scale = std::pow(10.0, static_cast<int>(random.below(7)) - 3);
    std::vector<double> w(static_cast<std::size_t>(m));
    for (double& x : w) x = trial % 5 == 0 ? std::round(random.normal()) : scale * random.normal();
    std::vector<double> expected = w;
    project_by_sorting(expected, s);
    project_to_simplex(w.data(), m, s);
    EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), s, 1e-13);
    for (std::size_t j = 0; j < w.size(); ++j) EXPECT_NEAR(w[j], expected[j], 1e-12 * (1 + scale));
  }
}

TEST(SimplexQp, AgreesWithProjectedGradient) {
  const SimplexProblem p = grid_program(5, 3);
  const SimplexSolution solution = solve_simplex_qp(p, tight());
  expect_feasible(p, solution.W);
  EXPECT_EQ(solution.stats.status, SolveStats::Status::converged);
  const RowMatrix other = projected_gradient(p, 20000);
  EXPECT_LT((solution.W - other).cwiseAbs().maxCoeff(), 1e-5);
  const double energy = 0.5 * solution.W.cwiseProduct(p.Q * solution.W).sum();
  EXPECT_NEAR(solution.stats.energy, energy, 1e-9 * energy);
  EXPECT_LE(solution.stats.lower_bound, energy * (1 + 1e-12));
  EXPECT_LT(solution.stats.relative_gap, 1e-6);
  EXPECT_LT(solution.stats.kkt_residual, 1e-6);
}

TEST(SimplexQp, LinearTermAgreesWithProjectedGradient) {
  SimplexProblem p = grid_program(4, 3);
  Random random(5);
  p.B.resize(p.Q.rows(), p.columns);
  for (double& b : p.B.reshaped()) b = 0.2 * p.Q.coeffs().maxCoeff() * random.normal();
  const SimplexSolution solution = solve_simplex_qp(p, tight());
  expect_feasible(p, solution.W);
  const RowMatrix other = projected_gradient(p, 40000);
  EXPECT_LT((solution.W - other).cwiseAbs().maxCoeff(), 1e-5);
  const double energy =
      0.5 * solution.W.cwiseProduct(p.Q * solution.W).sum() + p.B.cwiseProduct(solution.W).sum();
  EXPECT_NEAR(solution.stats.energy, energy, 1e-9 * std::abs(energy));
  EXPECT_GE(solution.stats.relative_gap, 0);
}

TEST(SimplexQp, TheToleranceIsHonest) {
  for (const auto& [side, columns] : {std::pair{8, 6}, {12, 6}, {13, 20}}) {
    const SimplexProblem p = grid_program(side, columns);
    const SimplexSolution exact = solve_simplex_qp(p, tight());
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
      SimplexOptions options;
      options.tolerance = tolerance;
      const SimplexSolution solution = solve_simplex_qp(p, options);
      EXPECT_EQ(solution.stats.status, SolveStats::Status::converged);
      EXPECT_LE(solution.stats.largest_change, tolerance);
      EXPECT_LT((solution.W - exact.W).cwiseAbs().maxCoeff(), 1.5 * tolerance);
      EXPECT_LE(solution.stats.lower_bound, exact.stats.energy * (1 + 1e-9));
      EXPECT_GE(solution.stats.energy, exact.stats.energy * (1 - 1e-9));
    }
  }
}

TEST(SimplexQp, ScaleAndPermutationDoNotMatter) {
  const SimplexProblem p = grid_program(5, 4);
  const RowMatrix W = solve_simplex_qp(p, tight()).W;
  SimplexProblem scaled = p;
  scaled.Q *= 1e6;
  scaled.M *= 1e-3;
  scaled.K *= std::sqrt(1e6 * 1e-3);
  EXPECT_LT((solve_simplex_qp(scaled, tight()).W - W).cwiseAbs().maxCoeff(), 1e-5);

  const auto n = static_cast<int>(p.Q.rows());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> P(n);
  P.setIdentity();
  Random random(2);
  for (int i = n - 1; i > 0; --i) {
    std::swap(P.indices()[i], P.indices()[random.below(static_cast<std::uint32_t>(i + 1))]);
  }
  SimplexProblem turned = p;
  turned.Q = P * p.Q * P.transpose();
  turned.K = P * p.K * P.transpose();
  turned.M = P * p.M;
  std::vector<std::pair<int, int>> order;
  for (std::size_t k = 0; k < p.fixed.node.size(); ++k) {
    order.emplace_back(P.indices()[p.fixed.node[k]], static_cast<int>(k));
  }
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) {
    turned.fixed.node[k] = order[k].first;
    turned.fixed.weights.row(static_cast<Eigen::Index>(k)) = p.fixed.weights.row(order[k].second);
  }
  const RowMatrix back = P.transpose() * solve_simplex_qp(turned, tight()).W;
  EXPECT_LT((back - W).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(SimplexQp, SameBytesAtAnyThreadCount) {
  const SimplexProblem p = grid_program(9, 5);
  RowMatrix W[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    W[threads - 1] = solve_simplex_qp(p).W;
  }
  EXPECT_TRUE((W[0].array() == W[1].array()).all());
}

TEST(SimplexQp, WarmStartIsFaster) {
  const SimplexProblem p = grid_program(8, 5);
  const SimplexSolution cold = solve_simplex_qp(p, tight());
  SimplexOptions options;
  options.start = cold.W;
  const SimplexSolution warm = solve_simplex_qp(p, options);
  EXPECT_EQ(warm.stats.status, SolveStats::Status::converged);
  EXPECT_LE(warm.stats.iterations, 15);
  EXPECT_LT((warm.W - cold.W).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SimplexQp, ColumnsAreStoredWhereverTheyTurnOutToBeNeeded) {
  const SimplexProblem p = grid_program(12, 6);
  SimplexOptions options;
  options.tolerance = 1e-5;
  options.max_iterations = 2000;
  const SimplexSolution cold = solve_simplex_qp(p, options);
  EXPECT_EQ(cold.stats.status, SolveStats::Status::converged);
  EXPECT_LT(cold.stats.relative_gap, 1e-5);
  // From a start that gives everything to one column, the others must spread.
  options.start = RowMatrix::Zero(p.Q.rows(), p.columns);
  options.start.col(2).setOnes();
  options.margin = 1;
  const SimplexSolution grown = solve_simplex_qp(p, options);
  EXPECT_EQ(grown.stats.status, SolveStats::Status::converged);
  EXPECT_LT(grown.stats.relative_gap, 1e-5);
  EXPECT_LT((cold.W - grown.W).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(SimplexQp, RowSumsAndSupportsAreKept) {
  SimplexProblem p = grid_program(6, 4);
  const Eigen::Index n = p.Q.rows();
  Random random(9);
  p.row_sum.resize(n);
  p.support.resize(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    p.row_sum[i] = i % 10 == 0 ? 0.0 : 0.25 + 0.5 * random.uniform();
    auto& columns = p.support[static_cast<std::size_t>(i)];
    for (int j = 0; j < p.columns; ++j) {
      if (j == static_cast<int>(i) % p.columns || random.uniform() < 0.6) columns.push_back(j);
    }
  }
  p.fixed.weights *= 0.5;
  for (const int v : p.fixed.node) p.row_sum[v] = 0.5;
  const SimplexSolution solution = solve_simplex_qp(p, tight());
  expect_feasible(p, solution.W);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::count(p.fixed.node.begin(), p.fixed.node.end(), static_cast<int>(i))) continue;
    for (int j = 0; j < p.columns; ++j) {
      const auto& columns = p.support[static_cast<std::size_t>(i)];
      const bool allowed = std::count(columns.begin(), columns.end(), j) > 0;
      EXPECT_TRUE(allowed || solution.W(i, j) == 0.0);
    }
  }
  EXPECT_LT(solution.stats.relative_gap, 1e-4);
  EXPECT_LT(solution.stats.kkt_residual, 1e-5);
}

TEST(SimplexQp, WorksWithoutTheStiffness) {
  SimplexProblem p = grid_program(6, 4);
  const RowMatrix W = solve_simplex_qp(p, tight()).W;
  p.K = SparseRows();
  EXPECT_LT((solve_simplex_qp(p, tight()).W - W).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(SimplexQp, TrivialPrograms) {
  SimplexProblem one = grid_program(4, 1);
  one.row_sum = Vector::Constant(one.Q.rows(), 1.0);
  EXPECT_TRUE((solve_simplex_qp(one).W.array() == 1.0).all());

  SimplexProblem all = grid_program(2, 2);
  all.fixed.node.resize(8);
  std::iota(all.fixed.node.begin(), all.fixed.node.end(), 0);
  all.fixed.weights = RowMatrix::Constant(8, 2, 0.5);
  all.fixed.weights.row(3) << 1, 0;
  const SimplexSolution solution = solve_simplex_qp(all);
  EXPECT_TRUE(solution.W == all.fixed.weights);
  const double energy = 0.5 * solution.W.cwiseProduct(all.Q * solution.W).sum();
  EXPECT_NEAR(solution.stats.energy, energy, 1e-12 * energy);
  EXPECT_NEAR(solution.stats.relative_gap, 0, 1e-12);
}

TEST(SimplexQp, NamesTheComponentThatNoHandleReaches) {
  SimplexProblem p = grid_program(3, 2);
  const Eigen::Index n = p.Q.rows();
  p.Q.conservativeResize(n + 2, n + 2);
  p.Q.coeffRef(n, n) = p.Q.coeffRef(n + 1, n + 1) = 1;
  p.Q.coeffRef(n, n + 1) = p.Q.coeffRef(n + 1, n) = -1;
  p.Q.makeCompressed();
  p.K = SparseRows();
  p.M = Vector::Ones(n + 2);
  try {
    solve_simplex_qp(p);
    FAIL() << "a singular program was accepted";
  } catch (const SolveError& error) {
    EXPECT_NE(std::string(error.what()).find("component of node 27"), std::string::npos)
        << error.what();
  }
}

TEST(SimplexQp, RefusesRowsWithoutAFeasibleValue) {
  SimplexProblem p = grid_program(3, 2);
  p.support.assign(static_cast<std::size_t>(p.Q.rows()), {0, 1});
  p.support[13].clear();
  EXPECT_THROW(solve_simplex_qp(p), SolveError);
  p.support.clear();
  p.row_sum = Vector::Ones(p.Q.rows());
  p.row_sum[13] = -0.1;
  EXPECT_THROW(solve_simplex_qp(p), SolveError);
}

TEST(SimplexQp, RefusesIndefiniteEnergies) {
  SimplexProblem p = grid_program(3, 2);
  p.Q *= -1;
  EXPECT_THROW(solve_simplex_qp(p), SolveError);
}

TEST(SimplexQp, StopsWhenAskedTo) {
  const SimplexProblem p = grid_program(7, 4);
  SimplexOptions options = tight();
  for (const int limit : {1, 3, 5, 11, 14, 27}) {  // within turns of the penalty, and at their ends
    options.max_iterations = limit;
    const SimplexSolution few = solve_simplex_qp(p, options);
    EXPECT_EQ(few.stats.status, SolveStats::Status::limit);
    EXPECT_EQ(few.stats.iterations, limit);
    expect_feasible(p, few.W);
  }
  options = tight();
  options.time_limit_s = 1e-9;
  const SimplexSolution none = solve_simplex_qp(p, options);
  EXPECT_EQ(none.stats.status, SolveStats::Status::limit);
  expect_feasible(p, none.W);
  Progress progress;
  int polls = 0;
  progress.cancelled = [&polls] { return ++polls > 4; };
  EXPECT_THROW(solve_simplex_qp(p, {}, progress), Cancelled);
}

}  // namespace
}  // namespace skinfield
