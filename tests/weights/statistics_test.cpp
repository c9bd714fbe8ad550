#include "skinfield/weights/statistics.h"

#include "skinfield/base/error.h"
#include "weights/fixtures.h"

#include <gtest/gtest.h>

#include <limits>

namespace skinfield {
namespace {

using skinfield_test::grid_mesh;
using skinfield_test::random_weights;

TEST(Compare, IsAMetric) {
  const SkinWeights a = random_weights(800, 7, 1), b = random_weights(800, 7, 2),
                    c = random_weights(800, 7, 3);
  const Comparison ab = compare(a, b), ba = compare(b, a), bc = compare(b, c), ac = compare(a, c);
  EXPECT_EQ(compare(a, a).max, 0);
  EXPECT_EQ(compare(a, a).mean, 0);
  EXPECT_GT(ab.mean, 0);
  EXPECT_DOUBLE_EQ(ab.mean, ba.mean);
  EXPECT_EQ(ab.vertex, ba.vertex);
  EXPECT_LE(ac.mean, ab.mean + bc.mean);
  EXPECT_LE((ac.vertex - ab.vertex - bc.vertex).maxCoeff(), 1e-15);
}

TEST(Compare, IsOneForDisjointSupportsAndOrdersItsQuantiles) {
  RowMatrix A(3, 2), B(3, 2);
  A << 1, 0, 1, 0, 1, 0;
  B << 1, 0, 0.5, 0.5, 0, 1;
  const Comparison c = compare(sparse_weights(A), sparse_weights(B));
  EXPECT_DOUBLE_EQ(c.mean, 0.5);
  EXPECT_DOUBLE_EQ(c.max, 1);
  EXPECT_EQ(c.worst_vertex, 2);
  EXPECT_DOUBLE_EQ(c.p95, 0.95);
  EXPECT_DOUBLE_EQ(c.p99, 0.99);
  EXPECT_DOUBLE_EQ(c.column[0], 0.5);
  EXPECT_DOUBLE_EQ(0.5 * c.column.sum(), c.mean);
}

TEST(Compare, RefusesDifferentSizes) {
  EXPECT_THROW(compare(random_weights(3, 2, 1), random_weights(3, 3, 1)), InputError);
}

TEST(ReorderColumns, FollowsTheNames) {
  SkinWeights weights = random_weights(20, 3, 5);
  weights.names = {"a", "b", "c"};
  const SkinWeights turned = reorder_columns(weights, {"c", "extra", "a", "b"});
  const RowMatrix W = dense_weights(weights), R = dense_weights(turned);
  EXPECT_EQ(R.col(0), W.col(2));
  EXPECT_EQ(R.col(1).norm(), 0);
  EXPECT_EQ(R.col(3), W.col(1));
  EXPECT_THROW(reorder_columns(weights, {"a", "b"}), InputError);
}

TEST(WeightStatistics, CountsWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RowMatrix W(4, 3);
  W << 1, 0, 0, -0.25, 0.75, 0.25, nan, 0, 0, 0.5, 0.5, 0;
  const WeightStatistics s = weight_statistics(sparse_weights(W));
  EXPECT_EQ(s.negative, 1);
  EXPECT_EQ(s.non_finite, 1);
  EXPECT_EQ(s.empty_rows, 1);
  EXPECT_DOUBLE_EQ(s.row_sum_error, 0.25);
  EXPECT_EQ(s.influences, (std::vector<Eigen::Index>{1, 1, 1, 1}));
  EXPECT_EQ(s.without_vertices, std::vector<int>{2});
  const int asked[] = {0, 1};
  EXPECT_TRUE(weight_statistics(sparse_weights(W), asked).without_vertices.empty());
}

TEST(LocalExtrema, FindsABumpAndADentOnly) {
  const Mesh mesh = grid_mesh(9);
  RowMatrix W(81, 2);
  for (int i = 0; i < 81; ++i) {
    W(i, 0) = 0.5 + 0.2 * (mesh.V(i, 0) + 0.3 * mesh.V(i, 1));
    W(i, 1) = 1 - W(i, 0);
  }
  // A linear function has its extrema at two corners of the grid, each counted in both columns.
  const Eigen::Index corners =
      local_extrema(sparse_weights(W), mesh).maxima + local_extrema(sparse_weights(W), mesh).minima;
  EXPECT_EQ(corners, 4);
  W(40, 0) += 0.2;
  W(40, 1) -= 0.2;
  const Extrema bump = local_extrema(sparse_weights(W), mesh);
  EXPECT_EQ(bump.maxima + bump.minima, 6);
  EXPECT_EQ(bump.column[0], 3);
}

TEST(LocalExtrema, LeavesHandlesAndZerosAlone) {
  const Mesh mesh = grid_mesh(5);
  RowMatrix W = RowMatrix::Zero(25, 2);
  W.col(0).setOnes();
  W(12, 0) = 0;
  W(12, 1) = 1;
  const Extrema none = local_extrema(sparse_weights(W), mesh);
  EXPECT_EQ(none.maxima + none.minima, 0);
  W(12, 0) = 0.4;
  W(12, 1) = 0.6;
  const Extrema both = local_extrema(sparse_weights(W), mesh);
  EXPECT_EQ(both.maxima, 1);
  EXPECT_EQ(both.minima, 1);
}

TEST(LocalExtrema, SaysWhereAndByHowMuch) {
  const Mesh mesh = grid_mesh(9);
  RowMatrix W(81, 2);
  for (int i = 0; i < 81; ++i) {
    W(i, 0) = 0.5 + 0.2 * (mesh.V(i, 0) + 0.3 * mesh.V(i, 1));
    W(i, 1) = 1 - W(i, 0);
  }
  const double before = W(40, 0);
  W(40, 0) += 0.2;
  W(40, 1) -= 0.2;
  const Extrema found = local_extrema(sparse_weights(W), mesh);
  ASSERT_EQ(found.places.size(), static_cast<std::size_t>(found.maxima + found.minima));
  int at_bump = 0;
  for (std::size_t k = 0; k < found.places.size(); ++k) {
    const Extremum& place = found.places[k];
    if (k > 0) {
      EXPECT_LE(found.places[k - 1].vertex, place.vertex);
    }
    if (place.vertex != 40) continue;
    ++at_bump;
    EXPECT_EQ(place.maximum, place.column == 0);
    EXPECT_EQ(place.weight, W(40, place.column));
    // A neighbour lies higher than the old weight, but less than the bump.
    EXPECT_GT(place.excess, 0);
    EXPECT_LT(place.excess, W(40, 0) - before);
  }
  EXPECT_EQ(at_bump, 2);
  const std::vector<int> exempt = {40};
  const Extrema rest = local_extrema(sparse_weights(W), mesh, 1e-6, exempt);
  EXPECT_EQ(rest.places.size(), found.places.size() - 2);
  const std::vector<int> wrong = {81};
  EXPECT_THROW(local_extrema(sparse_weights(W), mesh, 1e-6, wrong), InputError);
}

}  // namespace
}  // namespace skinfield
