#include "skinfield/methods/bone_heat.h"

#include "domain/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/methods/polyharmonic.h"
#include "skinfield/operators/stiffness.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <numeric>

namespace skinfield_test {
namespace {

using namespace skinfield;

/// A bar along x, and two bones of equal length end to end in it.
Mesh bar() { return fine_box({0, 0, 0}, {1, 0.2, 0.2}, {20, 4, 4}); }
std::vector<Handle> two_bones() {
  return {bone({0.1, 0.1, 0.1}, {0.5, 0.1, 0.1}), bone({0.5, 0.1, 0.1}, {0.9, 0.1, 0.1})};
}

void expect_partition_of_unity(const BoneHeatResult& result) {
  std::vector<char> zero(static_cast<std::size_t>(result.W.rows()), 0);
  for (const int v : result.unreached) zero[static_cast<std::size_t>(v)] = 1;
  for (Eigen::Index i = 0; i < result.W.rows(); ++i)
    EXPECT_NEAR(result.W.row(i).sum(), zero[static_cast<std::size_t>(i)] ? 0 : 1, 1e-9) << i;
}

TEST(BoneHeat, IsTheSolutionOfThePapersEquation) {
  // In a convex shape every vertex sees everything: the system can be written down.
  const Mesh mesh = bar();
  const std::vector<Handle> bones = two_bones();
  for (const double c : {1.0, 0.22}) {
    BoneHeatOptions options;
    options.heat = c;
    const BoneHeatResult result = bone_heat(mesh, bones, options);
    EXPECT_TRUE(result.unreached.empty());
    EXPECT_EQ(result.heated, mesh.V.rows());
    Eigen::MatrixXd A(stiffness(mesh.V, mesh.F));
    const Vector M = barycentric_mass(mesh.V, mesh.F);
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(A.rows(), 2);
    for (Eigen::Index j = 0; j < A.rows(); ++j) {
      double d[2];
      for (std::size_t b = 0; b < 2; ++b)
        d[b] = distance_to_segment(bones[b].segments[0].first, bones[b].segments[0].second,
                                   mesh.V.row(j));
      const bool shared = std::abs(d[0] - d[1]) < 1e-9;
      for (Eigen::Index b = 0; b < 2; ++b) {
        if (!shared && d[b] > d[1 - b]) continue;
        A(j, j) += M[j] * c / (d[b] * d[b]);
        B(j, b) += M[j] * c / (d[b] * d[b]);
      }
    }
    const Eigen::MatrixXd W = A.ldlt().solve(B);
    EXPECT_LT((result.W - W).cwiseAbs().maxCoeff(), 1e-10);
    expect_partition_of_unity(result);
    EXPECT_EQ(result.stats.status, SolveStats::Status::converged);
    // At the optimum the energy is 1/2 <P, M H (P - W)>: positive, less than nobody's.
    EXPECT_GT(result.stats.energy, 0);
  }
}

TEST(BoneHeat, LessHeatSpreadsMore) {
  BoneHeatOptions weak;
  weak.heat = 0.22;
  const double strong_end = bone_heat(bar(), two_bones()).W.col(0).maxCoeff();
  EXPECT_LT(bone_heat(bar(), two_bones(), weak).W.col(0).maxCoeff(), strong_end);
}

TEST(BoneHeat, DoesNotDependOnUnits) {
  const BoneHeatResult one = bone_heat(bar(), two_bones());
  for (const double unit : {0.01, 100.0}) {
    Mesh mesh = bar();
    mesh.V *= unit;
    std::vector<Handle> bones = two_bones();
    for (Handle& handle : bones)
      for (auto& [a, b] : handle.segments) {
        a *= unit;
        b *= unit;
      }
    const BoneHeatResult other = bone_heat(mesh, bones);
    EXPECT_LT((other.W - one.W).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NEAR(other.stats.energy, one.stats.energy, 1e-9 * one.stats.energy);
  }
}

TEST(BoneHeat, FollowsThePermutationOfVertices) {
  const Mesh mesh = bar();
  const auto n = static_cast<std::int32_t>(mesh.V.rows());
  Mesh turned;
  turned.V = mesh.V.colwise().reverse();
  turned.F = n - 1 - mesh.F.array();
  const RowMatrix W = bone_heat(mesh, two_bones()).W;
  const RowMatrix back = bone_heat(turned, two_bones()).W.colwise().reverse();
  EXPECT_LT((W - back).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(BoneHeat, BonesOutsideAndBehindWallsGiveNoHeat) {
  // The second bone lies just above the bar, nearer to its top than the first one inside.
  const std::vector<Handle> bones{bone({0.1, 0.1, 0.1}, {0.9, 0.1, 0.1}),
                                  bone({0.1, 0.1, 0.22}, {0.9, 0.1, 0.22})};
  const BoneHeatResult outside = bone_heat(bar(), bones);
  EXPECT_EQ(outside.W.col(1).cwiseAbs().maxCoeff(), 0);
  // A second bar beside the first, without a bone: nothing reaches it, however small the gap.
  const Mesh pair = together(bar(), fine_box({0, 0.201, 0}, {1, 0.4, 0.2}, {20, 4, 4}));
  const BoneHeatResult beside = bone_heat(pair, two_bones());
  EXPECT_EQ(beside.unreached.size(), static_cast<std::size_t>(pair.V.rows() - bar().V.rows()));
  expect_partition_of_unity(beside);
}

TEST(BoneHeat, NeighboursHeatVerticesThatSeeNoBone) {
  // A slab across the bar hides its far end; it is no part of the bar's surface.
  const Mesh mesh = together(bar(), fine_box({0.6, 0.001, 0.001}, {0.65, 0.199, 0.199}, {1, 4, 4}));
  const std::vector<Handle> bones{bone({0.1, 0.1, 0.1}, {0.3, 0.1, 0.1}),
                                  bone({0.3, 0.1, 0.1}, {0.5, 0.1, 0.1})};
  const BoneHeatResult result = bone_heat(mesh, bones);
  EXPECT_LT(result.heated, mesh.V.rows() - 50);
  EXPECT_TRUE(result.unreached.empty());
  expect_partition_of_unity(result);
  for (Eigen::Index i = 0; i < bar().V.rows(); ++i) {
    if (mesh.V(i, 0) < 0.7) continue;
    EXPECT_GT(result.W(i, 1), result.W(i, 0)) << i;
  }
}

TEST(BoneHeat, ABoneThroughAVertexHoldsIt) {
  const Mesh mesh = bar();
  const std::vector<Handle> bones{bone({0, 0, 0}, {0.3, 0.1, 0.1}),
                                  bone({0.3, 0.1, 0.1}, {0.9, 0.1, 0.1})};
  Eigen::Index corner = 0;
  ASSERT_EQ(mesh.V.rowwise().norm().minCoeff(&corner), 0);
  EXPECT_NEAR(bone_heat(mesh, bones).W(corner, 0), 1, 1e-6);
}

TEST(BoneHeat, MassesByKindOrGiven) {
  const Mesh mesh = bar();
  BoneHeatOptions voronoi, given;
  voronoi.mass = MassKind::voronoi;
  given.masses = lumped_mass(mesh.V, mesh.F, MassKind::voronoi);
  const RowMatrix W = bone_heat(mesh, two_bones(), voronoi).W;
  EXPECT_TRUE(W == bone_heat(mesh, two_bones(), given).W);
  const double moved = (W - bone_heat(mesh, two_bones()).W).cwiseAbs().maxCoeff();
  EXPECT_GT(moved, 1e-6);
  EXPECT_LT(moved, 0.05);
}

TEST(BoneHeat, PaintWinsAndLocksKeepColumns) {
  const Mesh mesh = bar();
  BoneHeatOptions options;
  options.paint.node = {3, 40};
  options.paint.weights.resize(2, 2);
  options.paint.weights << 0.25, 0.75, 0, 1;
  const RowMatrix painted = bone_heat(mesh, two_bones(), options).W;
  EXPECT_TRUE(painted.row(3) == options.paint.weights.row(0));
  EXPECT_TRUE(painted.row(40) == options.paint.weights.row(1));
  BoneHeatOptions locking;
  locking.start = RowMatrix::Constant(mesh.V.rows(), 2, 0.3);
  locking.locked = {1};
  const RowMatrix W = valid_weights(bone_heat(mesh, two_bones(), locking).W, {1});
  EXPECT_LT((W.col(1).array() - 0.3).abs().maxCoeff(), 1e-15);
  EXPECT_LT((W.col(0).array() - 0.7).abs().maxCoeff(), 1e-12);
}

TEST(BoneHeat, SurvivesDegenerateAndUnusedParts) {
  Mesh mesh = bar();
  const Eigen::Index n = mesh.V.rows(), f = mesh.F.rows();
  mesh.V.conservativeResize(n + 1, 3);
  mesh.V.row(n) << 0.5, 0.1, 0.15;  // in no triangle, yet it sees a bone
  mesh.F.conservativeResize(f + 2, 3);
  mesh.F.row(f) << 0, 0, 5;
  mesh.F.row(f + 1) = mesh.F.row(0);
  const BoneHeatResult result = bone_heat(mesh, two_bones());
  EXPECT_TRUE(result.W.allFinite());
  expect_partition_of_unity(result);
  // With all bones outside the shape may have no inside at all: the sides that face them see them.
  const BoneHeatResult outside = bone_heat(bar(), {bone({5, 5, 5}, {6, 5, 5})});
  EXPECT_GT(outside.heated, 0);
  EXPECT_LT(outside.heated, bar().V.rows());
  EXPECT_LT((outside.W.array() - 1).abs().maxCoeff(), 1e-6);
}

TEST(BoneHeat, SameBytesAtAnyThreadCount) {
  RowMatrix W[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    W[threads - 1] = bone_heat(bar(), two_bones()).W;
  }
  EXPECT_TRUE(W[0] == W[1]);
}

TEST(BoneHeat, RefusesWhatDoesNotFit) {
  Mesh cloud = bar();
  cloud.F.resize(0, 3);
  EXPECT_THROW(bone_heat(cloud, two_bones()), SolveError);
  EXPECT_THROW(bone_heat(bar(), {}), SolveError);
  BoneHeatOptions options;
  options.masses = Vector::Ones(3);
  EXPECT_THROW(bone_heat(bar(), two_bones(), options), SolveError);
  options = {};
  options.heat = 0;
  EXPECT_THROW(bone_heat(bar(), two_bones(), options), SolveError);
  options = {};
  options.locked = {0};
  EXPECT_THROW(bone_heat(bar(), two_bones(), options), SolveError);
}

}  // namespace
}  // namespace skinfield_test
