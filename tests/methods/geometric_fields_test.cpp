#include "skinfield/methods/geometric_fields.h"

#include "domain/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

using namespace skinfield_test;
using Solver = GeometricFieldsOptions::Solver;

GeometricFieldsOptions small(Solver solver = Solver::convex) {
  GeometricFieldsOptions options;
  options.solver = solver;
  options.points = 400;
  options.samples_per_step = 128;
  return options;
}

const Mesh& bar() {
  static const Mesh mesh = fine_box({0, 0, 0}, {1, 0.25, 0.25}, {16, 4, 4});
  return mesh;
}

const std::vector<Handle>& two_bones() {
  static const std::vector<Handle> handles{bone({0.08, 0.12, 0.12}, {0.42, 0.12, 0.12}),
                                           bone({0.58, 0.12, 0.12}, {0.92, 0.12, 0.12})};
  return handles;
}

void expect_simplex_rows(const RowMatrix& W) {
  ASSERT_TRUE(W.allFinite());
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-9);
}

double mean_difference(const RowMatrix& A, const RowMatrix& B) {
  return 0.5 * (A - B).cwiseAbs().rowwise().sum().mean();
}

const GeometricFieldsResult& solved() {
  static const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, small());
  return result;
}

TEST(GeometricFields, WeightsOfABar) {
  const GeometricFieldsResult& result = solved();
  expect_simplex_rows(result.W);
  EXPECT_EQ(result.stats.status, SolveStats::Status::converged);
  EXPECT_EQ(result.facts.vertices.seen, bar().V.rows());
  EXPECT_EQ(result.facts.unreached_points, 0);
  EXPECT_LE(result.stats.lower_bound, result.stats.energy);
  for (Eigen::Index v = 0; v < bar().V.rows(); ++v) {
    const double x = bar().V(v, 0);
    if (x < 0.3) {
      EXPECT_GT(result.W(v, 0), 0.9) << x;
    }
    if (x > 0.7) {
      EXPECT_GT(result.W(v, 1), 0.9) << x;
    }
    if (std::abs(x - 0.5) < 1e-9) {
      EXPECT_NEAR(result.W(v, 0), 0.5, 0.12);
    }
  }
}

TEST(GeometricFields, ConvergedMeansThatNoWeightMoves) {
  GeometricFieldsOptions options = small();
  options.tolerance = 1e-12;
  const GeometricFieldsResult tight = geometric_fields(bar(), two_bones(), {}, options);
  EXPECT_EQ(tight.stats.status, SolveStats::Status::limit) << "held-out energy ended it";
  EXPECT_GT(tight.stats.largest_change, 0);
  for (const double tolerance : {0.1, 1e-2}) {
    options.tolerance = tolerance;
    const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, options);
    if (result.stats.status == SolveStats::Status::converged) {
      EXPECT_LT(result.stats.largest_change, tolerance);
    }
    EXPECT_LT((result.W - tight.W).cwiseAbs().maxCoeff(), 10 * tolerance);
  }
  EXPECT_EQ(solved().stats.status, SolveStats::Status::converged);
}

TEST(GeometricFields, OptimisersAgree) {
  GeometricFieldsOptions options = small(Solver::adam_pool);
  options.max_iterations = 2400;
  const GeometricFieldsResult pool = geometric_fields(bar(), two_bones(), {}, options);
  expect_simplex_rows(pool.W);
  EXPECT_LT(mean_difference(pool.W, solved().W), 0.05);
}

TEST(GeometricFields, HandlesHaveTheirValueExactly) {
  std::vector<Fill> fill;
  Points X(3, 3);
  X << 0.1, 0.12, 0.12, 0.3, 0.12, 0.12, 0.7, 0.12, 0.12;
  const RowMatrix W = solved().field->at(X, {}, fill);
  EXPECT_NEAR(W(0, 0), 1, 1e-12);
  EXPECT_NEAR(W(1, 0), 1, 1e-12);
  EXPECT_NEAR(W(2, 1), 1, 1e-12);
}

TEST(GeometricFields, CanBeAskedAnywhere) {
  std::vector<Fill> fill;
  const Points X = random_points(300, -0.3, 1.3, 3);
  expect_simplex_rows(solved().field->at(X, {}, fill));
  int outside = 0;
  for (const Fill f : fill) outside += f == Fill::passenger;
  EXPECT_GT(outside, 100);
  const RowMatrix again = solved().field->at(bar().V, solved().field->solid().normals(), fill);
  EXPECT_LT((again - solved().W).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(GeometricFields, NormalDerivativeVanishesUnderNeumann) {
  // On the interiors of facets (proposition 4.1), for parameters that are anything but flat.
  double slopes[2] = {0, 0};
  for (const auto boundary :
       {GeometricFieldsOptions::Boundary::natural, GeometricFieldsOptions::Boundary::neumann}) {
    GeometricFieldsOptions options = small();
    options.boundary = boundary;
    options.max_iterations = 5;
    // Weights that change across the bar, so that natural boundaries have a slope.
    const std::vector<Handle> across{bone({0.1, 0.05, 0.12}, {0.9, 0.05, 0.12}),
                                     bone({0.1, 0.2, 0.12}, {0.9, 0.2, 0.12})};
    const GeometricFieldsResult result = geometric_fields(bar(), across, {}, options);
    const double t = 0.1 * (result.facts.radii.neumann > 0 ? result.facts.radii.neumann : 0.03);
    double worst = 0;
    for (int k = 1; k < 40; ++k) {
      const double u = 0.1 + 0.8 * k / 40;
      const Vec3 p(u, 0.25, 0.07 + 0.002 * k);
      Points X(2, 3);
      X.row(0) = (p - Vec3(0, 1e-6, 0)).transpose();
      X.row(1) = (p - Vec3(0, t, 0)).transpose();
      std::vector<Fill> fill;
      const RowMatrix W = result.field->at(X, {}, fill);
      worst = std::max(worst, std::abs(W(1, 0) - W(0, 0)) / t);
    }
    slopes[boundary == GeometricFieldsOptions::Boundary::neumann] = worst;
  }
  EXPECT_GT(slopes[0], 0.1);
  EXPECT_LT(slopes[1], 1e-3);
}

TEST(GeometricFields, SameBytesForOneAndTwoThreads) {
  for (const Solver solver : {Solver::convex, Solver::adam, Solver::adam_pool}) {
    GeometricFieldsOptions options = small(solver);
    options.max_iterations = 20;
    RowMatrix W[2];
    for (const int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      W[threads - 1] = geometric_fields(bar(), two_bones(), {}, options).W;
    }
    EXPECT_EQ(W[0], W[1]);
  }
}

TEST(GeometricFields, PausedAndResumedIsTheSame) {
  GeometricFieldsOptions options = small(Solver::adam);
  options.max_iterations = 40;
  const RowMatrix straight = geometric_fields(bar(), two_bones(), {}, options).W;
  options.max_iterations = 15;
  const GeometricFieldsResult paused = geometric_fields(bar(), two_bones(), {}, options);
  EXPECT_EQ(paused.stats.status, SolveStats::Status::limit);
  EXPECT_EQ(paused.state.steps, 15);
  options.max_iterations = 40;
  const GeometricFieldsResult resumed =
      geometric_fields(bar(), two_bones(), {}, options, &paused.state);
  EXPECT_EQ(resumed.state.steps, 40);
  EXPECT_EQ(resumed.W, straight);
}

TEST(GeometricFields, RefusesAStateThatDoesNotFit) {
  FieldState state = solved().state;
  EXPECT_THROW(geometric_fields(bar(), two_bones(), {}, small(Solver::adam), &state), InputError);
  EXPECT_THROW(geometric_fields(bar(), {two_bones()[0]}, {}, small(), &state), InputError);
  state.F(0, 0) = std::nanf("");
  EXPECT_THROW(geometric_fields(bar(), two_bones(), {}, small(), &state), InputError);
}

TEST(GeometricFields, PaintGivesAnEarThatNoBoneReachesItsWeights) {
  // The ear: a box of its own beside the bar. The paper's figure 6.
  const Mesh ear = fine_box({0.45, 0.3, 0.05}, {0.55, 0.5, 0.2}, {3, 6, 4});
  const Mesh mesh = together(bar(), ear);
  const std::vector<Handle> handles{two_bones()[0], two_bones()[1],
                                    point_handle({0.5, 0.4, 0.9})};  // outside: binds nothing
  GeometricFieldsOptions options = small();
  const GeometricFieldsResult before = geometric_fields(mesh, handles, {}, options);
  expect_simplex_rows(before.W);
  EXPECT_EQ(before.W.col(2).maxCoeff(), 0);
  PaintedVertices paint;
  for (int v = static_cast<int>(bar().V.rows()); v < mesh.V.rows(); ++v)
    if (mesh.V(v, 1) == 0.3 || mesh.V(v, 1) == 0.5) paint.vertex.push_back(v);
  paint.weights = RowMatrix::Zero(static_cast<Eigen::Index>(paint.vertex.size()), 3);
  for (std::size_t k = 0; k < paint.vertex.size(); ++k)
    paint.weights(static_cast<Eigen::Index>(k), mesh.V(paint.vertex[k], 1) == 0.3 ? 0 : 2) = 1;
  const GeometricFieldsResult after =
      geometric_fields(mesh, handles, paint, options, &before.state);
  expect_simplex_rows(after.W);
  for (std::size_t k = 0; k < paint.vertex.size(); ++k)
    EXPECT_EQ(after.W.row(paint.vertex[k]), paint.weights.row(static_cast<Eigen::Index>(k)));
  EXPECT_EQ(before.facts.vertices.passengers, ear.V.rows());
  EXPECT_EQ(after.facts.vertices.passengers, 0);
  EXPECT_EQ(after.facts.unreached_points, 0);
  // Between the painted ends the ear blends from one to the other.
  for (Eigen::Index v = bar().V.rows(); v < mesh.V.rows(); ++v)
    if (std::abs(mesh.V(v, 1) - 0.4) < 1e-9) {
      EXPECT_NEAR(after.W(v, 0), 0.5, 0.25);
      EXPECT_NEAR(after.W(v, 0) + after.W(v, 2), 1, 0.02);
    }
  // The bar is what it was.
  EXPECT_LT(mean_difference(after.W.topRows(bar().V.rows()), before.W.topRows(bar().V.rows())),
            0.05);
}

TEST(GeometricFields, DoesNotBleedAcrossAGap) {
  const double gap = 0.01;
  GeometricFieldsOptions options = small();
  options.points = 1000;
  const GeometricFieldsResult result =
      geometric_fields(fork_mesh(gap), fork_bones(gap), {}, options);
  expect_simplex_rows(result.W);
  const Mesh mesh = fork_mesh(gap);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v)
    if (mesh.V(v, 1) > 0.5) {
      EXPECT_LT(result.W(v, mesh.V(v, 0) < 0.105 ? 1 : 0), 0.02);
    }
}

TEST(GeometricFields, TakesSoupsAndClouds) {
  const std::vector<Handle> handles{bone({0, 0, -0.3}, {0, 0, -0.05}),
                                    bone({0, 0, 0.05}, {0, 0, 0.3})};
  const Mesh soup = soup_of(sphere_mesh(0.5), 0.3, 0.01, 2);
  const Mesh cloud = sphere_cloud(0.5, 800, true);
  for (const Mesh& mesh : {soup, cloud}) {
    const GeometricFieldsResult result = geometric_fields(mesh, handles, {}, small());
    expect_simplex_rows(result.W);
    int right = 0, judged = 0;
    for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
      if (std::abs(mesh.V(v, 2)) < 0.25) continue;
      ++judged;
      right += result.W(v, mesh.V(v, 2) < 0 ? 0 : 1) > 0.5;
    }
    EXPECT_GT(right, 0.97 * judged);
  }
}

TEST(GeometricFields, ErrorsSayWhatIsWrong) {
  EXPECT_THROW(geometric_fields(bar(), {bone({2, 2, 2}, {3, 3, 3})}, {}, small()), DomainError);
  EXPECT_THROW(geometric_fields(bar(), {}, {}, small()), DomainError);
  EXPECT_THROW(geometric_fields(Mesh{}, two_bones(), {}, small()), DomainError);
}

TEST(GeometricFields, StopsWhenAskedAndInTime) {
  Progress progress;
  int polls = 0;
  progress.cancelled = [&polls] { return ++polls > 30; };
  const ThreadLimit limit(1);
  EXPECT_THROW(geometric_fields(bar(), two_bones(), {}, small(), nullptr, progress), Cancelled);
  GeometricFieldsOptions options = small();
  options.time_limit_s = 1e-6;
  const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, options);
  EXPECT_EQ(result.stats.status, SolveStats::Status::limit);
  expect_simplex_rows(result.W);
}

TEST(GeometricFields, JudgedEnergyIsTheIntegralOfSquaredLaplacians) {
  // In a convex shape everything is in view, so that the field asked anywhere gives the same.
  GeometricFieldsOptions options = small();
  const double h = options.judged_step = 0.03;
  const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, options);
  EXPECT_EQ(result.W, solved().W) << "judging changes nothing";
  ASSERT_FALSE(result.facts.judged.empty());
  EXPECT_EQ(result.facts.judged.back().iteration, result.stats.iterations);
  const int n[3] = {60, 14, 14};
  double integral = 0, volume = 0;
  Points X(7, 3);
  std::vector<Fill> fill;
  for (int i = 0; i < n[0] * n[1] * n[2]; ++i) {
    const Vec3 inset = Vec3::Constant(h), size = Vec3(1, 0.25, 0.25) - 2 * inset;
    const Vec3 cell(i % n[0] + 0.5, i / n[0] % n[1] + 0.5, i / n[0] / n[1] + 0.5);
    X.rowwise() =
        (inset + size.cwiseProduct(cell).cwiseQuotient(Vec3(n[0], n[1], n[2]))).transpose();
    for (int axis = 0; axis < 3; ++axis) X(1 + 2 * axis, axis) += h, X(2 + 2 * axis, axis) -= h;
    const RowMatrix W = result.field->at(X, {}, fill);
    integral += (W.bottomRows(6).colwise().sum() - 6 * W.row(0)).squaredNorm();
    volume += 1;
  }
  integral *= (1 - 2 * h) * std::pow(0.25 - 2 * h, 2) / volume / std::pow(h, 4);
  // The shell that differences would leave has the rest, and most of it is beside the bones.
  EXPECT_GT(result.facts.judged.back().energy, 0.95 * integral);
  EXPECT_LT(result.facts.judged.back().energy, 1.3 * integral);
  // One handle has the weight 1 everywhere.
  const GeometricFieldsResult one = geometric_fields(bar(), {two_bones()[0]}, {}, options);
  EXPECT_NEAR(one.facts.judged.back().energy, 0, 1e-3);
}

TEST(GeometricFields, IterationsEndWhereTheyShould) {
  for (const Solver solver : {Solver::convex, Solver::adam, Solver::adam_pool})
    for (const int limit : {1, 7, 30}) {
      GeometricFieldsOptions options = small(solver);
      options.levels = 3;
      options.tolerance = 1e-9;
      options.max_iterations = limit;
      const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, options);
      EXPECT_LE(result.stats.iterations, limit);
      EXPECT_EQ(result.stats.status, SolveStats::Status::limit);
      expect_simplex_rows(result.W);
    }
}

TEST(GeometricFields, LevelsByNumber) {
  for (const Solver solver : {Solver::convex, Solver::adam, Solver::adam_pool})
    for (const int levels : {1, 3}) {
      GeometricFieldsOptions options = small(solver);
      options.levels = levels;
      options.max_iterations = 3;
      const GeometricFieldsResult result = geometric_fields(bar(), two_bones(), {}, options);
      EXPECT_EQ(result.state.counts.size(), static_cast<std::size_t>(levels));
      EXPECT_EQ(result.state.counts.back(), options.points);
      EXPECT_EQ(result.state.X.rows() == options.points, levels == 1);
    }
  // All steps are there, however few the levels.
  GeometricFieldsOptions options = small(Solver::adam_pool);
  options.points = 60, options.samples_per_step = 8, options.levels = 1;
  EXPECT_EQ(geometric_fields(bar(), two_bones(), {}, options).stats.iterations, 2400);
}

TEST(GeometricFields, WithoutVisibilityWeightsBleed) {
  const double gap = 0.01;
  GeometricFieldsOptions options = small();
  options.points = 1000;
  options.visibility = SolidOptions::Visibility::none;
  const Mesh mesh = fork_mesh(gap);
  const RowMatrix W = geometric_fields(mesh, fork_bones(gap), {}, options).W;
  expect_simplex_rows(W);
  double across = 0;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v)
    if (mesh.V(v, 1) > 0.5) across = std::max(across, W(v, mesh.V(v, 0) < 0.105 ? 1 : 0));
  EXPECT_GT(across, 0.1) << "DoesNotBleedAcrossAGap: below 0.02";
}

TEST(GeometricFields, SettingsComeBack) {
  GeometricFieldsOptions options = small(Solver::adam_pool), back;
  options.boundary = GeometricFieldsOptions::Boundary::neumann;
  options.kernel.kernel = KernelFieldOptions::Kernel::gaussian;
  options.step = 0.75;
  options.visibility = SolidOptions::Visibility::none;
  apply_settings(settings_of(options), back);
  EXPECT_EQ(settings_of(back), settings_of(options));
}

}  // namespace
}  // namespace skinfield
