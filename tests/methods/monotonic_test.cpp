#include "skinfield/methods/monotonic.h"

#include "methods/monotone_order.h"
#include "methods/positive_links.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/weights/statistics.h"
#include "support/box_tets.h"
#include "support/grid_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace skinfield {
namespace {

struct Case {
  Mesh mesh;
  SparseRows K;
  Vector M;
  FixedRows fixed;
  MonotonicProblem problem() const { return {K, M, fixed}; }
};

Case plate(const Mesh& mesh, const std::vector<int>& handles) {
  Case result;
  result.mesh = mesh;
  result.K = stiffness(mesh.V, mesh.F);
  result.M = barycentric_mass(mesh.V, mesh.F);
  result.fixed.node = handles;
  const auto m = static_cast<Eigen::Index>(handles.size());
  result.fixed.weights = RowMatrix::Identity(m, m);
  return result;
}

/// A trunk with an arm that turns up, handles at its top and bottom (the paper's figure 4).
Case cactus() {
  const int n = 24;
  Mesh mesh = skinfield_test::grid_triangles(n, n, 1.0 / n);
  std::vector<int> keep;
  for (int f = 0; f < mesh.F.rows(); ++f) {
    double x = 0, y = 0;
    for (int c = 0; c < 3; ++c) {
      x += mesh.V(mesh.F(f, c), 0) / 3;
      y += mesh.V(mesh.F(f, c), 1) / 3;
    }
    const bool trunk = x > 14.0 / n && x < 19.0 / n;
    const bool arm = (y > 9.0 / n && y < 12.0 / n && x > 3.0 / n && x < 15.0 / n) ||
                     (x > 3.0 / n && x < 7.0 / n && y > 9.0 / n && y < 20.0 / n);
    if (trunk || arm) keep.push_back(f);
  }
  mesh.F = Triangles(mesh.F(keep, Eigen::all));
  return plate(mesh, {16 * (n + 1) + 1, 16 * (n + 1) + n - 1});
}

Case four_handles() {
  const int n = 16;
  return plate(skinfield_test::grid_triangles(n, n, 1.0 / n),
               {4 * 17 + 4, 4 * 17 + 12, 8 * 17 + 14, 12 * 17 + 5});
}

Eigen::Index extrema(const RowMatrix& W, const Mesh& mesh, double tolerance = 1e-4) {
  SkinWeights weights;
  weights.W = W.sparseView();
  const Extrema found = local_extrema(weights, mesh, tolerance);
  return found.maxima + found.minima;
}

void expect_simplex_rows(const RowMatrix& W) {
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
}

TEST(MonotoneOrder, PicksTheHighestAndLowestNeighbour) {
  const Case grid = four_handles();
  const Vector u = grid.mesh.V.col(0) + 0.3 * grid.mesh.V.col(1);
  std::vector<char> fixed(static_cast<std::size_t>(u.size()), 0);
  fixed.front() = fixed.back() = 1;  // where u is lowest and highest
  const MonotoneOrder order = monotone_order(grid.K, u, fixed);
  ASSERT_EQ(order.from_above.size(), fixed.size() - 2);
  ASSERT_EQ(order.from_below.size(), fixed.size() - 2);
  for (const int v : order.from_above) {
    double high = u[v], low = u[v];
    for (SparseRows::InnerIterator it(grid.K, v); it; ++it) {
      high = std::max(high, u[it.col()]);
      low = std::min(low, u[it.col()]);
    }
    EXPECT_EQ(u[order.up[static_cast<std::size_t>(v)]], high);
    EXPECT_EQ(u[order.down[static_cast<std::size_t>(v)]], low);
  }
  EXPECT_EQ(violation(order, u), 0);
}

TEST(MonotoneOrder, LevelsBumpsAndAlwaysFits) {
  const Case grid = four_handles();
  Vector u = grid.mesh.V.col(0);
  u[8 * 17 + 8] += 0.3;   // a bump
  u[12 * 17 + 3] -= 0.4;  // and a dent
  std::vector<char> fixed(static_cast<std::size_t>(u.size()), 0);
  for (int i = 0; i < 17; ++i) fixed[static_cast<std::size_t>(i)] = 1;
  for (int i = 16 * 17; i < 17 * 17; ++i) fixed[static_cast<std::size_t>(i)] = 1;
  const MonotoneOrder order = monotone_order(grid.K, u, fixed);
  EXPECT_GT(violation(order, u), 0.1);
  Vector w = u;
  EXPECT_LE(make_monotone(order, w, 1e-12, 100), 1e-12);
  for (int v = 0; v < u.size(); ++v) {
    if (fixed[static_cast<std::size_t>(v)]) {
      EXPECT_EQ(w[v], u[v]);
    }
  }
  EXPECT_EQ(extrema(w, grid.mesh, 1e-9), 0);
}

TEST(Monotonic, PositiveLinksMakeALaplacian) {
  const Mesh box = skinfield_test::box_tets(3, 3, 3);
  const SparseRows L = positive_links(stiffness(box.V, box.T));
  EXPECT_LT((L * Vector::Ones(L.rows())).cwiseAbs().maxCoeff(), 1e-12);
  for (Eigen::Index i = 0; i < L.rows(); ++i) {
    for (SparseRows::InnerIterator it(L, i); it; ++it) {
      if (it.col() != i) {
        EXPECT_LT(it.value(), 0);
      }
    }
  }
}

TEST(Monotonic, NoExtremaWhereBoundedBiharmonicHasThem) {
  const Case shape = cactus();
  BoundedBiharmonicOptions exact;
  exact.tolerance = 1e-5;
  const BoundedBiharmonicResult bbw = bounded_biharmonic({shape.K, shape.M, shape.fixed}, exact);
  EXPECT_GT(extrema(bbw.W, shape.mesh, 1e-6), 0);
  for (const bool coupled : {false, true}) {
    MonotonicOptions options;
    options.coupled = coupled;
    const MonotonicResult result = monotonic(shape.problem(), options);
    EXPECT_EQ(extrema(result.monotone, shape.mesh, 1e-6), 0);
    EXPECT_EQ(extrema(result.W, shape.mesh), 0);
    // A constraint more costs energy; the program's own bound says how near the optimum is.
    EXPECT_GE(result.stats.energy, bbw.stats.lower_bound);
    EXPECT_GE(result.normalised_energy, bbw.stats.lower_bound);
    EXPECT_LT(result.stats.relative_gap, 0.01);
  }
}

TEST(Monotonic, CoupledAndDecoupled) {
  const Case grid = four_handles();
  MonotonicOptions options;
  const MonotonicResult coupled = monotonic(grid.problem(), options);
  options.coupled = false;
  const MonotonicResult apart = monotonic(grid.problem(), options);
  const BoundedBiharmonicResult exact = bounded_biharmonic({grid.K, grid.M, grid.fixed});
  for (const MonotonicResult* result : {&coupled, &apart}) {
    expect_simplex_rows(result->W);
    EXPECT_EQ(extrema(result->monotone, grid.mesh), 0);
    EXPECT_GE(result->stats.energy, result->stats.lower_bound);
    EXPECT_LT(result->stats.relative_gap, 0.01);
    EXPECT_GE(result->normalised_energy, exact.stats.lower_bound);
  }
  EXPECT_LT((coupled.monotone.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-2);
  EXPECT_GT((apart.monotone.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-2);
  // Dropping a constraint cannot cost energy.
  EXPECT_LE(apart.stats.lower_bound, coupled.stats.energy);
  EXPECT_LT((coupled.W - apart.W).cwiseAbs().maxCoeff(), 0.2);
}

TEST(Monotonic, TwoHandlesNeedNoCoupling) {
  // One column is 1 minus the other, and so are the bounds: both programs have one solution.
  Case box;
  box.mesh = skinfield_test::box_tets(10, 3, 3, 0.1);
  box.K = stiffness(box.mesh.V, box.mesh.T);
  box.M = barycentric_mass(box.mesh.V, box.mesh.T);
  box.fixed.node = {5, 10 * 16 + 6};
  box.fixed.weights = RowMatrix::Identity(2, 2);
  MonotonicOptions options;
  options.tolerance = 1e-5;
  options.max_iterations = 2000;
  const MonotonicResult coupled = monotonic(box.problem(), options);
  options.coupled = false;
  const MonotonicResult apart = monotonic(box.problem(), options);
  EXPECT_LT((coupled.W - apart.W).cwiseAbs().maxCoeff(), 5e-3);
  EXPECT_EQ(extrema(coupled.W, box.mesh), 0);
}

TEST(Monotonic, PaintUnreachedNodesAndThreads) {
  Case grid = four_handles();
  const Eigen::Index n = grid.mesh.V.rows();
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (SparseRows::InnerIterator it(grid.K, i); it; ++it) {
      entries.emplace_back(it.row(), it.col(), it.value());
      entries.emplace_back(it.row() + n, it.col() + n, it.value());
    }
  }
  grid.K.resize(2 * n, 2 * n);
  grid.K.setFromTriplets(entries.begin(), entries.end());
  grid.M = Vector(grid.M.replicate(2, 1));
  MonotonicOptions options;
  options.max_iterations = 40;
  options.paint.node = {20};
  options.paint.weights.resize(1, 4);
  options.paint.weights << 0.1, 0.2, 0.3, 0.4;
  std::array<RowMatrix, 2> W;
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    const MonotonicResult result = monotonic(grid.problem(), options);
    EXPECT_EQ(result.unreached.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(result.W.bottomRows(n).cwiseAbs().maxCoeff(), 0);
    EXPECT_TRUE(result.W.row(20) == options.paint.weights.row(0));
    expect_simplex_rows(result.W.topRows(n));
    W[static_cast<std::size_t>(threads) - 1] = result.W;
  }
  EXPECT_TRUE(W[0] == W[1]);
}

TEST(Monotonic, RefusesWhatItCannotSolve) {
  Case grid = four_handles();
  MonotonicOptions options;
  options.representative = RowMatrix::Zero(3, 4);
  EXPECT_THROW(monotonic(grid.problem(), options), SolveError);
  grid.fixed = FixedRows();
  EXPECT_THROW(monotonic(grid.problem()), SolveError);
}

}  // namespace
}  // namespace skinfield
