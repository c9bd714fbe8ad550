#include "skinfield/methods/decoupled_biharmonic.h"

#include "methods/box_case.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/biharmonic.h"
#include "support/data.h"
#include "support/fem_case.h"
#include "support/tibiman.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

using skinfield_test::BoxCase;

DecoupledBiharmonicOptions tight(DecoupledSolver solver) {
  DecoupledBiharmonicOptions options;
  options.solver = solver;
  options.tolerance = 1e-6;
  options.max_iterations = 3000;
  options.dual.relative_gap = 1e-8;
  options.active_iterations = 100;
  return options;
}

TEST(DecoupledBiharmonic, ThreeSolversAgree) {
  const BoxCase box(4);
  const auto primal = decoupled_biharmonic(box.problem(), tight(DecoupledSolver::primal));
  const auto dual = decoupled_biharmonic(box.problem(), tight(DecoupledSolver::dual));
  const auto active = decoupled_biharmonic(box.problem(), tight(DecoupledSolver::active_set));
  for (const auto* result : {&primal, &dual, &active}) {
    EXPECT_EQ(result->stats.status, SolveStats::Status::converged);
    EXPECT_NEAR(result->stats.energy, active.stats.energy, 1e-7 * active.stats.energy);
    EXPECT_LT((result->raw - active.raw).cwiseAbs().maxCoeff(), 2e-3);
    EXPECT_GE(result->raw.minCoeff(), 0);
    EXPECT_LE(result->raw.maxCoeff(), 1);
    EXPECT_GE(result->W.minCoeff(), 0);
    EXPECT_LT((result->W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    for (std::size_t h = 0; h < box.fixed.node.size(); ++h) {
      EXPECT_EQ(result->W(box.fixed.node[h], static_cast<Eigen::Index>(h)), 1);
    }
  }
  EXPECT_LT((primal.raw - active.raw).cwiseAbs().maxCoeff(), 1e-5);
  const double energy = 0.5 * primal.W.cwiseProduct(biharmonic(box.K, box.M) * primal.W).sum();
  EXPECT_NEAR(primal.normalised_energy, energy, 1e-9 * energy);
}

TEST(DecoupledBiharmonic, NeverBelowTheCoupledOptimumOnceNormalised) {
  for (const int m : {3, 5, 7}) {
    const BoxCase box(m, 16);
    const double coupled = bounded_biharmonic(box.problem()).stats.lower_bound;
    const auto decoupled = decoupled_biharmonic(box.problem());
    EXPECT_GE(decoupled.normalised_energy, coupled);
    EXPECT_LE(decoupled.stats.energy, decoupled.normalised_energy);
  }
}

TEST(DecoupledBiharmonic, PaintAndLocksHold) {
  const BoxCase box(4);
  DecoupledBiharmonicOptions options;
  options.paint.node = {5};
  options.paint.weights.resize(1, 4);
  options.paint.weights << 0.2, 0.3, 0, 0.5;
  options.start = bounded_biharmonic(box.problem()).W;
  options.start.col(2) *= 0.5;
  for (const DecoupledSolver solver :
       {DecoupledSolver::primal, DecoupledSolver::dual, DecoupledSolver::active_set}) {
    options.solver = solver;
    options.locked.clear();
    EXPECT_TRUE(decoupled_biharmonic(box.problem(), options).W.row(5) ==
                options.paint.weights.row(0));
    options.locked = {2};
    const auto result = decoupled_biharmonic(box.problem(), options);
    EXPECT_TRUE(result.W.col(2) == options.start.col(2));
    EXPECT_LT((result.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
    EXPECT_GE(result.W.minCoeff(), 0);
    options.locked = {0, 1, 2, 3};
    const auto all = decoupled_biharmonic(box.problem(), options);
    EXPECT_LT((all.W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  }
  options.locked = {9};
  EXPECT_THROW(decoupled_biharmonic(box.problem(), options), SolveError);
}

TEST(DecoupledBiharmonic, RowsOfZerosTakeTheirNeighboursShares) {
  // Painted to fall steeply at one end: beyond, bounds hold all columns at zero.
  BoxCase box(2);
  box.fixed.node = {0};
  box.fixed.weights.resize(1, 2);
  box.fixed.weights << 1, 0;
  DecoupledBiharmonicOptions options = tight(DecoupledSolver::active_set);
  options.paint.weights = RowMatrix::Zero(32, 2);
  for (int v = 0; v < 32; ++v) {
    options.paint.node.push_back(v);
    options.paint.weights(v, 0) = v < 16 ? 1 : 0.5;
  }
  const auto result = decoupled_biharmonic(box.problem(), options);
  ASSERT_LT(result.raw.bottomRows(16).cwiseAbs().maxCoeff(), 1e-12);
  for (Eigen::Index i = 32; i < result.W.rows(); ++i) {
    EXPECT_NEAR(result.W(i, 0), 1, 1e-12);
    EXPECT_NEAR(result.W(i, 1), 0, 1e-12);
  }
}

TEST(DecoupledBiharmonic, OfTheHand) {
  SKINFIELD_NEEDS_DATA(mesh_path, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(bones_path, "fem/hand.tgf");
  const skinfield_test::FemCase hand = skinfield_test::read_fem_case(mesh_path, bones_path);
  DecoupledBiharmonicOptions options;
  const auto primal = decoupled_biharmonic(hand.problem(), options);
  options.solver = DecoupledSolver::active_set;
  const auto active = decoupled_biharmonic(hand.problem(), options);
  options.solver = DecoupledSolver::dual;
  const auto dual = decoupled_biharmonic(hand.problem(), options);
  constexpr double coupled = 13288.142716;
  EXPECT_LT(primal.stats.energy, coupled);
  EXPECT_NEAR(dual.stats.energy, primal.stats.energy, 2e-4 * primal.stats.energy);
  EXPECT_LE(primal.stats.energy, active.stats.energy);
  // 13387.1 was measured for another program's 8 iterations.
  for (const auto* result : {&primal, &active, &dual}) {
    EXPECT_GT(result->normalised_energy, coupled);
    EXPECT_NEAR(result->normalised_energy, 13387.1, 15);
  }
}

TEST(DecoupledBiharmonic, OfTibimanInItsAuthorsConvention) {
  SKINFIELD_NEEDS_DATA(mesh_path, "fem/tibiman.mesh");
  const skinfield_test::Tibiman man = skinfield_test::tibiman(mesh_path.parent_path());
  const SparseRows K = stiffness(man.mesh.V, man.mesh.T);
  const BoundedBiharmonicProblem problem{K, man.M, man.fixed};
  DecoupledBiharmonicOptions quick;
  quick.tolerance = 3e-3;
  const auto decoupled = decoupled_biharmonic(problem, quick);
  BoundedBiharmonicOptions loose;
  loose.tolerance = 3e-3;
  const auto coupled = bounded_biharmonic(problem, loose);
  // Without the 1/2, as published: 36289.4 for another program's decoupled weights, which we
  // undercut; the exact ones are at 35912.8.
  EXPECT_LE(2 * decoupled.normalised_energy, 36289.4);
  EXPECT_GT(decoupled.normalised_energy, coupled.stats.energy);
  EXPECT_LT(decoupled.stats.energy, coupled.stats.lower_bound);
  EXPECT_NEAR(2 * coupled.stats.energy, 35912.8, 2e-4 * 35912.8);
}

}  // namespace
}  // namespace skinfield
