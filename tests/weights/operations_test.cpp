#include "skinfield/weights/operations.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "weights/fixtures.h"

#include <gtest/gtest.h>

#include <limits>

namespace skinfield {
namespace {

using skinfield_test::largest_row_error;
using skinfield_test::random_weights;

TEST(SparseWeights, RoundTripsThroughDense) {
  const SkinWeights weights = random_weights(700, 9, 1);
  const RowMatrix W = dense_weights(weights);
  const SkinWeights again = sparse_weights(W);
  EXPECT_EQ(dense_weights(again), W);
  EXPECT_EQ(again.W.nonZeros(), (W.array() != 0).count());
}

TEST(SparseWeights, DropsSmallEntriesAndRefusesWrongNames) {
  RowMatrix W(1, 3);
  W << 0.9, 1e-9, 0.1;
  EXPECT_EQ(sparse_weights(W, {}, 1e-6).W.nonZeros(), 2);
  EXPECT_THROW(sparse_weights(W, {"a", "b"}), InputError);
}

TEST(Normalise, PutsRowsOnTheSimplex) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RowMatrix W(4, 3);
  W << 2, 2, 0, -1, 3, nan, 0, 0, 0, 1e300, 1e300, 1e300;
  const Normalised result = normalise(sparse_weights(W));
  const RowMatrix N = dense_weights(result.weights);
  EXPECT_EQ(result.removed, 2);
  EXPECT_EQ(result.empty_rows, std::vector<int>{2});
  EXPECT_DOUBLE_EQ(N(0, 0), 0.5);
  EXPECT_DOUBLE_EQ(N(1, 1), 1);
  EXPECT_NEAR(N(3, 2), 1.0 / 3, 1e-15);
}

TEST(Prune, KeepsRowsOnTheSimplexWithFewInfluences) {
  const SkinWeights weights = random_weights(900, 17, 2);
  for (const int k : {1, 2, 4}) {
    const Pruned pruned = prune(weights, {.max_influences = k, .epsilon = 1e-3});
    EXPECT_LT(largest_row_error(pruned.weights), 1e-14);
    EXPECT_GT(pruned.mean_mass, 0);
    EXPECT_LE(pruned.mean_mass, pruned.max_mass);
    EXPECT_LT(pruned.max_mass, 1);
    for (Eigen::Index i = 0; i < weights.vertices(); ++i) {
      EXPECT_LE(pruned.weights.W.row(i).nonZeros(), k);
    }
  }
}

TEST(Prune, OfNothingIsTheSameWeights) {
  const SkinWeights weights = random_weights(50, 6, 3);
  const Pruned pruned = prune(weights, {});
  EXPECT_LT((dense_weights(pruned.weights) - dense_weights(weights)).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(pruned.rows_cut, 0);
  EXPECT_EQ(pruned.max_mass, 0);
}

TEST(Prune, BreaksTiesByColumnAndReportsTheCutMass) {
  RowMatrix W(2, 4);
  W << 0.25, 0.25, 0.25, 0.25, 0.0, 0.2, 0.2, 0.6;
  const Pruned pruned = prune(sparse_weights(W), {.max_influences = 2});
  RowMatrix expected(2, 4);
  expected << 0.5, 0.5, 0, 0, 0, 0.25, 0, 0.75;
  EXPECT_LT((dense_weights(pruned.weights) - expected).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NEAR(pruned.max_mass, 0.5, 1e-15);
  EXPECT_NEAR(pruned.mean_mass, 0.35, 1e-15);
  EXPECT_EQ(pruned.rows_cut, 2);
}

TEST(Prune, NeverCutsTheLargestEntry) {
  RowMatrix W(1, 4);
  W << 0.25, 0.25, 0.25, 0.25;
  const Pruned pruned = prune(sparse_weights(W), {.max_influences = 0, .epsilon = 0.9});
  EXPECT_EQ(dense_weights(pruned.weights)(0, 0), 1);
  EXPECT_THROW(prune(sparse_weights(W), {.max_influences = -1}), InputError);
  EXPECT_THROW(prune(sparse_weights(W), {.epsilon = 2}), InputError);
}

TEST(Prune, IsTheSameAtAnyThreadCount) {
  const SkinWeights weights = random_weights(3000, 12, 4);
  const PruneOptions options{.max_influences = 3, .epsilon = 0.01};
  const Pruned all = prune(weights, options);
  const ThreadLimit one(1);
  const Pruned single = prune(weights, options);
  EXPECT_EQ(dense_weights(all.weights), dense_weights(single.weights));
  EXPECT_EQ(all.mean_mass, single.mean_mass);
}

}  // namespace
}  // namespace skinfield
