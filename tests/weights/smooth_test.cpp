#include "skinfield/weights/smooth.h"

#include "skinfield/base/error.h"
#include "skinfield/weights/statistics.h"
#include "weights/fixtures.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

using skinfield_test::grid_mesh;
using skinfield_test::largest_row_error;
using skinfield_test::random_weights;

TEST(Smooth, KeepsConstantsAndTheSimplex) {
  const Mesh mesh = grid_mesh(12);
  RowMatrix same = RowMatrix::Constant(144, 4, 0.25);
  const SkinWeights kept = smooth(sparse_weights(same), mesh, {.steps = 3});
  EXPECT_LT((dense_weights(kept) - same).cwiseAbs().maxCoeff(), 1e-15);
  const SkinWeights noisy = smooth(random_weights(144, 6, 1), mesh, {.steps = 5});
  EXPECT_LT(largest_row_error(noisy), 1e-14);
  EXPECT_GE(dense_weights(noisy).minCoeff(), 0);
}

TEST(Smooth, RemovesExtremaAndContracts) {
  const Mesh mesh = grid_mesh(12);
  const SkinWeights rough = random_weights(144, 5, 2);
  const SkinWeights once = smooth(rough, mesh, {.steps = 1}),
                    more = smooth(rough, mesh, {.steps = 8});
  const auto extrema = [&](const SkinWeights& w) {
    const Extrema e = local_extrema(w, mesh);
    return e.maxima + e.minima;
  };
  EXPECT_LT(extrema(more), extrema(once));
  const auto spread = [](const SkinWeights& w) {
    const RowMatrix W = dense_weights(w);
    return (W.rowwise() - W.colwise().mean()).norm();
  };
  EXPECT_LT(spread(more), spread(once));
}

TEST(Smooth, LockedColumnsAndKeptRowsStay) {
  const Mesh mesh = grid_mesh(10);
  const SkinWeights rough = random_weights(100, 5, 3);
  SmoothOptions options{.steps = 4, .strength = 0.7, .locked = {1, 3}};
  options.keep.assign(100, false);
  options.keep[42] = true;
  const SkinWeights smoothed = smooth(rough, mesh, options);
  const RowMatrix before = dense_weights(rough), after = dense_weights(smoothed);
  EXPECT_EQ(after.col(1), before.col(1));
  EXPECT_EQ(after.col(3), before.col(3));
  EXPECT_EQ(after.row(42), before.row(42));
  EXPECT_GT((after.col(0) - before.col(0)).norm(), 0.1);
  EXPECT_LT(largest_row_error(smoothed), 1e-14);
}

TEST(Smooth, RefusesWhatDoesNotFit) {
  const Mesh mesh = grid_mesh(3);
  EXPECT_THROW(smooth(random_weights(8, 2, 1), mesh, {}), InputError);
  EXPECT_THROW(smooth(random_weights(9, 2, 1), mesh, {.locked = {2}}), InputError);
  EXPECT_THROW(smooth(random_weights(9, 2, 1), mesh, {.strength = 1.5}), InputError);
  Progress stop;
  stop.cancelled = [] { return true; };
  EXPECT_THROW(smooth(random_weights(9, 2, 1), mesh, {}, stop), Cancelled);
}

}  // namespace
}  // namespace skinfield
