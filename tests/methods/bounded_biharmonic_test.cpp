#include "skinfield/methods/bounded_biharmonic.h"

#include "methods/box_case.h"
#include "skinfield/base/error.h"
#include "skinfield/methods/support.h"
#include "skinfield/operators/biharmonic.h"
#include "support/data.h"
#include "support/fem_case.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace skinfield {
namespace {

using skinfield_test::BoxCase;

void expect_simplex_rows(const RowMatrix& W) {
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
}

TEST(BoundedBiharmonic, WeightsOfABox) {
  const BoxCase box(4);
  const BoundedBiharmonicResult result = bounded_biharmonic(box.problem());
  expect_simplex_rows(result.W);
  EXPECT_TRUE(result.unreached.empty());
  EXPECT_EQ(result.stats.status, SolveStats::Status::converged);
  for (int h = 0; h < 4; ++h)
    EXPECT_EQ(result.W(box.fixed.node[static_cast<std::size_t>(h)], h), 1);
}

TEST(BoundedBiharmonic, LeavesUnreachedComponentsOut) {
  const BoxCase box(3);
  const Eigen::Index n = box.K.rows();
  // The same box twice, side by side, the handles in the first.
  SparseRows K(2 * n, 2 * n);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (SparseRows::InnerIterator it(box.K, i); it; ++it) {
      entries.emplace_back(it.row(), it.col(), it.value());
      entries.emplace_back(it.row() + n, it.col() + n, it.value());
    }
  }
  K.setFromTriplets(entries.begin(), entries.end());
  Vector M(2 * n);
  M << box.M, box.M;
  const BoundedBiharmonicResult both = bounded_biharmonic({K, M, box.fixed});
  const BoundedBiharmonicResult one = bounded_biharmonic(box.problem());
  EXPECT_EQ(both.unreached.size(), static_cast<std::size_t>(n));
  EXPECT_EQ(both.unreached.front(), n);
  EXPECT_TRUE(both.W.topRows(n) == one.W);
  EXPECT_EQ(both.W.bottomRows(n).cwiseAbs().maxCoeff(), 0);
}

TEST(BoundedBiharmonic, PaintWins) {
  const BoxCase box(3);
  BoundedBiharmonicOptions options;
  options.paint.node = {5, box.fixed.node[1]};
  std::sort(options.paint.node.begin(), options.paint.node.end());
  options.paint.weights.resize(2, 3);
  options.paint.weights << 0.2, 0.3, 0.5, 0.5, 0, 0.5;
  const BoundedBiharmonicResult result = bounded_biharmonic(box.problem(), options);
  expect_simplex_rows(result.W);
  for (int k = 0; k < 2; ++k) {
    EXPECT_TRUE(result.W.row(options.paint.node[static_cast<std::size_t>(k)]) ==
                options.paint.weights.row(k));
  }
}

TEST(BoundedBiharmonic, LocksKeepColumns) {
  const BoxCase box(4);
  BoundedBiharmonicOptions options;
  options.start = bounded_biharmonic(box.problem()).W;
  // Lock a column with altered values: half of what it was.
  options.start.col(2) *= 0.5;
  options.locked = {2};
  const BoundedBiharmonicResult result = bounded_biharmonic(box.problem(), options);
  expect_simplex_rows(result.W);
  EXPECT_TRUE(result.W.col(2) == options.start.col(2));
  options.locked = {0, 1, 2, 3};
  options.start.col(3).array() += 0.3;  // sums above 1 are scaled down
  expect_simplex_rows(bounded_biharmonic(box.problem(), options).W);
}

TEST(BoundedBiharmonic, RefusesWhatItCannotSolve) {
  BoxCase box(2);
  BoundedBiharmonicOptions options;
  options.locked = {0};
  EXPECT_THROW(bounded_biharmonic(box.problem(), options), SolveError);
  box.fixed = FixedRows();
  EXPECT_THROW(bounded_biharmonic(box.problem()), SolveError);
}

/// Rows cut to their k largest entries; returns the largest mass cut.
double cut(RowMatrix& W, int k) {
  double most = 0;
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    std::vector<double> sorted(W.row(i).begin(), W.row(i).end());
    std::sort(sorted.rbegin(), sorted.rend());
    double sum = 0;
    for (double& w : W.row(i)) {
      if (w < sorted[static_cast<std::size_t>(k - 1)]) w = 0;
      sum += w;
    }
    most = std::max(most, 1 - sum);
    W.row(i) /= sum;
  }
  return most;
}

TEST(Support, PrunedWeightsAreSmootherThanCutOnes) {
  const BoxCase box(7, 24);
  const RowMatrix full = bounded_biharmonic(box.problem()).W;
  // Vertices: averages of the nodes of a tet, so that a vertex meets several supports.
  SparseRows P(box.mesh.T.rows(), box.mesh.V.rows());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index t = 0; t < box.mesh.T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) entries.emplace_back(t, box.mesh.T(t, c), 0.25);
  }
  P.setFromTriplets(entries.begin(), entries.end());
  SupportOptions options;
  options.influences = 2;
  const BoundedBiharmonicResult kept = resolve_on_support(box.problem(), full, P, options);
  expect_simplex_rows(kept.W);
  RowMatrix before = P * full, after = P * kept.W;
  const double cut_before = cut(before, 2), cut_after = cut(after, 2);
  EXPECT_GT(cut_before, 0.05);
  EXPECT_LT(cut_after, 0.3 * cut_before);
  // Largest jump between vertices that share a node.
  const SparseRows near = P * SparseRows(P.transpose());
  const auto jump = [&](const RowMatrix& W) {
    double largest = 0;
    for (Eigen::Index i = 0; i < near.rows(); ++i) {
      for (SparseRows::InnerIterator it(near, i); it; ++it) {
        if (it.value() < 0.18) continue;  // three shared nodes: neighbours across a face
        largest = std::max(largest, (W.row(i) - W.row(it.col())).cwiseAbs().maxCoeff());
      }
    }
    return largest;
  };
  EXPECT_LT(jump(after), jump(before));
}

TEST(Support, AllowsEverythingWhereNothingIsCut) {
  const BoxCase box(3);
  const RowMatrix W = bounded_biharmonic(box.problem()).W;
  SparseRows P(W.rows(), W.rows());
  P.setIdentity();
  SupportOptions options;
  options.influences = 3;
  const BoundedBiharmonicResult again = resolve_on_support(box.problem(), W, P, options);
  EXPECT_LT((again.W - W).cwiseAbs().maxCoeff(), 2e-3);
}

TEST(BoundedBiharmonic, ReachesTheCertifiedOptimumOfTheHand) {
  SKINFIELD_NEEDS_DATA(mesh_path, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(bones_path, "fem/hand.tgf");
  const skinfield_test::FemCase hand = skinfield_test::read_fem_case(mesh_path, bones_path);
  ASSERT_EQ(hand.fixed.node.size(), 221u);
  const BoundedBiharmonicResult result = bounded_biharmonic(hand.problem());
  expect_simplex_rows(result.W);
  EXPECT_EQ(result.stats.status, SolveStats::Status::converged);
  constexpr double optimum = 13288.142716;  // by two independent methods
  EXPECT_NEAR(result.stats.energy, optimum, 1e-6 * optimum);
  EXPECT_GE(result.stats.energy, optimum * (1 - 1e-9));
  EXPECT_LE(result.stats.lower_bound, optimum * (1 + 1e-9));
  EXPECT_LT(result.stats.relative_gap, 1e-3);
  const double energy = 0.5 * result.W.cwiseProduct(biharmonic(hand.K, hand.M) * result.W).sum();
  EXPECT_NEAR(result.stats.energy, energy, 1e-9 * energy);
}

}  // namespace
}  // namespace skinfield
