#include "skinfield/methods/bounded_biharmonic_dual.h"

#include "methods/box_case.h"
#include "skinfield/base/error.h"
#include "skinfield/methods/bounded_biharmonic_active_set.h"
#include "skinfield/operators/biharmonic.h"
#include "support/data.h"
#include "support/fem_case.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace skinfield {
namespace {

using skinfield_test::BoxCase;

double largest_difference(const RowMatrix& A, const RowMatrix& B) {
  return (A - B).cwiseAbs().maxCoeff();
}

void expect_simplex_rows(const RowMatrix& W) {
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
}

/// The same conditions for three solvers.
struct Three {
  BoundedBiharmonicOptions primal;
  BoundedBiharmonicDualOptions dual;
  BoundedBiharmonicActiveSetOptions active_set;

  Three() {
    primal.tolerance = 1e-6;
    primal.max_iterations = 3000;
    dual.dual.relative_gap = 1e-7;
  }
  void set(const RowMatrix& start, const std::vector<int>& locked, const FixedRows& paint) {
    primal.start = dual.start = active_set.start = start;
    primal.locked = dual.locked = active_set.locked = locked;
    primal.paint = dual.paint = active_set.paint = paint;
  }
  void expect_agreement(const BoundedBiharmonicProblem& problem) const {
    const BoundedBiharmonicResult a = bounded_biharmonic(problem, primal);
    const BoundedBiharmonicDualResult b = bounded_biharmonic_dual(problem, dual);
    const BoundedBiharmonicResult c = bounded_biharmonic_active_set(problem, active_set);
    for (const SolveStats* stats : {&a.stats, &b.stats, &c.stats}) {
      EXPECT_EQ(stats->status, SolveStats::Status::converged);
      EXPECT_NEAR(stats->energy, c.stats.energy, 1e-6 * c.stats.energy);
      EXPECT_LE(stats->lower_bound, c.stats.energy * (1 + 1e-9));
    }
    expect_simplex_rows(b.W);
    expect_simplex_rows(c.W);
    EXPECT_LT(largest_difference(a.W, c.W), 1e-4);
    EXPECT_LT(largest_difference(b.W, c.W), 5e-3);
    EXPECT_EQ(a.unreached, b.unreached);
    EXPECT_EQ(a.unreached, c.unreached);
  }
};

TEST(BoundedBiharmonicDual, ThreeSolversAgree) {
  const BoxCase box(4);
  Three().expect_agreement(box.problem());
}

TEST(BoundedBiharmonicDual, PaintAndLocksHoldInEverySolver) {
  const BoxCase box(4);
  Three three;
  RowMatrix start = bounded_biharmonic(box.problem()).W;
  start.col(2) *= 0.5;
  FixedRows paint;
  paint.node = {5, box.fixed.node[1]};
  std::sort(paint.node.begin(), paint.node.end());
  paint.weights.resize(2, 4);
  paint.weights << 0.2, 0.3, 0, 0.5, 0.5, 0, 0, 0.5;
  three.set({}, {}, paint);
  three.expect_agreement(box.problem());
  const RowMatrix painted = bounded_biharmonic_dual(box.problem(), three.dual).W;
  EXPECT_TRUE(painted.row(5) == paint.weights.row(paint.node[0] == 5 ? 0 : 1));
  three.set(start, {2}, {});
  three.expect_agreement(box.problem());
  EXPECT_TRUE(bounded_biharmonic_dual(box.problem(), three.dual).W.col(2) == start.col(2));
  EXPECT_TRUE(bounded_biharmonic_active_set(box.problem(), three.active_set).W.col(2) ==
              start.col(2));
  three.set(start, {0, 1, 2, 3}, {});
  expect_simplex_rows(bounded_biharmonic_dual(box.problem(), three.dual).W);
  three.set({}, {0}, {});
  EXPECT_THROW(bounded_biharmonic_dual(box.problem(), three.dual), SolveError);
  EXPECT_THROW(bounded_biharmonic_active_set(box.problem(), three.active_set), SolveError);
}

TEST(BoundedBiharmonicDual, LeavesUnreachedComponentsOut) {
  BoxCase box(3);
  const Eigen::Index n = box.K.rows();
  SparseRows K(n + 2, n + 2);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (SparseRows::InnerIterator it(box.K, i); it; ++it) {
      entries.emplace_back(it.row(), it.col(), it.value());
    }
  }
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) entries.emplace_back(n + a, n + b, a == b ? 1 : -1);
  }
  K.setFromTriplets(entries.begin(), entries.end());
  Vector M(n + 2);
  M << box.M, 1, 1;
  const BoundedBiharmonicDualResult whole = bounded_biharmonic_dual({K, M, box.fixed});
  EXPECT_EQ(whole.unreached.size(), 2u);
  EXPECT_TRUE(whole.W.topRows(n) == bounded_biharmonic_dual(box.problem()).W);
  EXPECT_EQ(whole.W.bottomRows(2).cwiseAbs().maxCoeff(), 0);
}

TEST(BoundedBiharmonicDual, NaturalBoundariesLetLinearWeightsBe) {
  // Ends given, sides free: without Neumann conditions linear weights cost nothing.
  const int nx = 8, ny = 3, nz = 3;
  const Mesh mesh = skinfield_test::box_tets(nx, ny, nz, 1.0 / nx);
  const SparseRows K = stiffness(mesh.V, mesh.T);
  const Vector M = barycentric_mass(mesh.V, mesh.T);
  std::vector<int> boundary, ends;
  for (int v = 0; v < mesh.V.rows(); ++v) {
    const int k = v % (nz + 1), j = v / (nz + 1) % (ny + 1), i = v / (nz + 1) / (ny + 1);
    if (i == 0 || i == nx) ends.push_back(v);
    if (i % nx == 0 || j % ny == 0 || k % nz == 0) boundary.push_back(v);
  }
  SimplexProblem program;
  program.Q = natural_biharmonic(K, M, boundary);
  program.M = M;
  program.columns = 2;
  program.fixed.weights.resize(0, 2);
  LinearConstraints constraints;
  constraints.C.resize(static_cast<Eigen::Index>(ends.size()), mesh.V.rows());
  constraints.D.resize(static_cast<Eigen::Index>(ends.size()), 2);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto row = static_cast<Eigen::Index>(e);
    constraints.C.insert(row, ends[e]) = 1;
    const double x = mesh.V(ends[e], 0);
    constraints.D.row(row) << 1 - x, x;
  }
  constraints.C.makeCompressed();
  RowMatrix linear(mesh.V.rows(), 2);
  linear << (1 - mesh.V.col(0).array()).matrix(), mesh.V.col(0);
  const double neumann = 0.5 * linear.cwiseProduct(biharmonic(K, M) * linear).sum();
  EXPECT_GT(neumann, 1);
  EXPECT_LT(linear.cwiseProduct(program.Q * linear).sum(), 1e-12 * neumann);
  DualOptions options;
  options.max_iterations = 300;
  const DualSolution natural = solve_simplex_dual(program, options, {}, constraints);
  expect_simplex_rows(natural.W);
  EXPECT_LT(natural.constraint_residual, 1e-8);
  EXPECT_LT(natural.stats.energy, 1e-6 * neumann);
  EXPECT_GE(natural.stats.energy, natural.stats.lower_bound);
}

TEST(BoundedBiharmonicDual, ReachesTheCertifiedOptimumOfTheHand) {
  SKINFIELD_NEEDS_DATA(mesh_path, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(bones_path, "fem/hand.tgf");
  const skinfield_test::FemCase hand = skinfield_test::read_fem_case(mesh_path, bones_path);
  ASSERT_EQ(hand.fixed.node.size(), 221u);
  constexpr double optimum = 13288.142716;  // by three independent methods
  const BoundedBiharmonicDualResult usual = bounded_biharmonic_dual(hand.problem());
  EXPECT_EQ(usual.stats.status, SolveStats::Status::converged);
  EXPECT_NEAR(usual.stats.energy, optimum, 1e-4 * optimum);
  BoundedBiharmonicDualOptions options;
  options.dual.relative_gap = 1e-6;
  const BoundedBiharmonicDualResult tight = bounded_biharmonic_dual(hand.problem(), options);
  expect_simplex_rows(tight.W);
  EXPECT_EQ(tight.stats.status, SolveStats::Status::converged);
  EXPECT_GE(tight.stats.energy, optimum * (1 - 1e-9));
  EXPECT_LE(tight.stats.energy, optimum * (1 + 1e-6));
  EXPECT_LE(tight.stats.lower_bound, optimum * (1 + 1e-9));
  EXPECT_LT(tight.stats.kkt_residual, 1e-3);
  BoundedBiharmonicOptions primal;
  primal.tolerance = 1e-4;
  const RowMatrix W = bounded_biharmonic(hand.problem(), primal).W;
  EXPECT_LT(largest_difference(tight.W, W), 1e-2);
  EXPECT_LT((tight.W - W).cwiseAbs().mean(), 1e-4);
}

}  // namespace
}  // namespace skinfield
