#include "solve/penalty.h"

#include "skinfield/solve/active_set.h"
#include "support/grid.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

using skinfield_test::grid_program;

/// A chain of n nodes of mass 1, handles at the first ones, `step` apart.
SimplexProblem chain(int n, int handles, int step) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i + 1 < n; ++i) {
    entries.emplace_back(i, i, 1.0);
    entries.emplace_back(i + 1, i + 1, 1.0);
    entries.emplace_back(i, i + 1, -1.0);
    entries.emplace_back(i + 1, i, -1.0);
  }
  SimplexProblem p;
  p.K.resize(n, n);
  p.K.setFromTriplets(entries.begin(), entries.end());
  p.M = Vector::Ones(n);
  p.Q = p.K * p.K;
  p.Q.makeCompressed();
  p.columns = handles;
  for (int k = 0; k < handles; ++k) p.fixed.node.push_back(k * step);
  p.fixed.weights = RowMatrix::Identity(handles, handles);
  return p;
}

TEST(Penalty, IsSoftWhereALongLimbHasNoHandle) {
  const SimplexProblem p = chain(300, 3, 10);
  const FreeRows free(p);
  // A clamped end and 279 free nodes: deflection l^4 / 8 under a unit load.
  Vector u(free.rows());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double at = free.node[static_cast<std::size_t>(i)] - 20.0, l = 279;
    u[i] = at < 0 ? 1.0 : at * at * (6 * l * l - 4 * l * at + at * at) / 24;
  }
  const RowMatrix X = RowMatrix::Constant(free.rows(), 3, 1.0 / 3);
  const Vector stiff = local_penalty(p, free, X, X, {});
  const Vector soft = local_penalty(p, free, X, X, u);
  EXPECT_TRUE((soft.array() > 0).all());
  EXPECT_TRUE((soft.array() <= stiff.array()).all());
  EXPECT_LT(soft[free.rows() - 1], 1e-2 * stiff[free.rows() - 1]);
}

TEST(Penalty, ALimbWithoutHandlesIsSolvedLikeTheRest) {
  const SimplexProblem p = chain(300, 3, 10);
  const SimplexSolution solution = solve_simplex_qp(p);
  const SimplexSolution exact = solve_simplex_active_set(p);
  EXPECT_EQ(solution.stats.status, SolveStats::Status::converged);
  // The limb's weights are 0 and 1 with multipliers that are nearly 0: weights are ill-conditioned,
  // energy and its bound are not.
  EXPECT_LT((solution.W - exact.W).cwiseAbs().maxCoeff(), 5e-3);
  EXPECT_LT(solution.stats.energy, exact.stats.energy * (1 + 1e-6));
  EXPECT_LT(solution.stats.relative_gap, 2e-4);
}

TEST(Penalty, BalancingMovesRowsTowardsTheRatioAimedAt) {
  const SimplexProblem p = grid_program(6, 3);
  const FreeRows free(p);
  const auto n = free.rows();
  const auto balanced = [&](double primal, double dual) {
    Vector scale = Vector::Ones(n);
    balance_rows(free, Vector::Constant(n, primal), Vector::Constant(n, dual), scale);
    return scale;
  };
  const double aim = 0.6 * 0.6;
  EXPECT_LT((balanced(aim, 1).array() - 1).abs().maxCoeff(), 1e-9);
  EXPECT_LT((balanced(2 * aim, 1).array() - 2).abs().maxCoeff(), 1e-9);
  EXPECT_LT((balanced(aim, 2).array() - 0.5).abs().maxCoeff(), 1e-9);
  EXPECT_EQ(balanced(1, 0).maxCoeff(), 10);
  EXPECT_EQ(balanced(0, 1).minCoeff(), 0.1);
  EXPECT_EQ(balanced(0, 0), Vector::Ones(n));

  // Local: what happens at one end does not reach the other.
  Vector primal = Vector::Constant(n, aim), dual = Vector::Ones(n), scale = Vector::Ones(n);
  primal[0] *= 1000;
  balance_rows(free, primal, dual, scale);
  EXPECT_GT(scale[0], 2);
  EXPECT_NEAR(scale[n - 1], 1, 1e-9);
  EXPECT_LE(scale.maxCoeff(), 10);
}

}  // namespace
}  // namespace skinfield
