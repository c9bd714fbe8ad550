#include "skinfield/methods/polyharmonic.h"

#include "skinfield/base/error.h"
#include "skinfield/base/random.h"
#include "skinfield/operators/biharmonic.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/operators/triharmonic.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <numeric>

namespace skinfield {
namespace {

using skinfield_test::box_tets;

struct Case {
  Mesh mesh;
  SparseRows K;
  Vector M;
  FixedRows fixed;
  BoundedBiharmonicProblem problem() const { return {K, M, fixed}; }
};

/// A jittered box, obtuse tets included, with m point handles along it.
Case jittered_box(int m = 4) {
  Case box{box_tets(10, 3, 3, 0.1), {}, {}, {}};
  Random random(7);
  for (double& x : box.mesh.V.reshaped()) x += 0.04 * random.uniform();
  box.K = stiffness(box.mesh.V, box.mesh.T);
  box.M = barycentric_mass(box.mesh.V, box.mesh.T);
  for (int h = 0; h < m; ++h) box.fixed.node.push_back((10 * h / (m - 1) * 4 + 1) * 4 + 1 + h % 2);
  box.fixed.weights = RowMatrix::Identity(m, m);
  return box;
}

/// n equal steps on the unit interval, the rows of `ends` nodes at both ends given as (f, 1 - f).
Case chain(int n, int ends, double (*f)(double)) {
  Case line;
  line.K.resize(n + 1, n + 1);
  line.M = Vector::Constant(n + 1, 1.0 / n);
  line.M[0] = line.M[n] = 0.5 / n;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) entries.emplace_back(i + a, i + b, a == b ? n : -n);
  line.K.setFromTriplets(entries.begin(), entries.end());
  line.fixed.weights.resize(2 * ends, 2);
  for (int k = 0; k < 2 * ends; ++k) {
    const int i = k < ends ? k : n + 1 - 2 * ends + k;
    line.fixed.node.push_back(i);
    line.fixed.weights.row(k) << f(1.0 * i / n), 1 - f(1.0 * i / n);
  }
  return line;
}

RowMatrix solve(const Case& c, int order) {
  PolyharmonicOptions options;
  options.order = order;
  return polyharmonic(c.problem(), options).W;
}

TEST(Polyharmonic, ReproducesItsPolynomialsOnALine) {
  const auto linear = [](double x) { return x; };
  const auto cubic = [](double x) { return x * x * (3 - 2 * x); };
  const auto quintic = [](double x) { return x * x * x * (10 + x * (6 * x - 15)); };
  double (*const f[3])(double) = {linear, cubic, quintic};
  for (int order = 1; order <= 3; ++order) {
    const int n = 20;
    const RowMatrix W = solve(chain(n, order, f[order - 1]), order);
    for (int i = 0; i <= n; ++i)
      EXPECT_NEAR(W(i, 0), f[order - 1](1.0 * i / n), 1e-9) << order << " " << i;
  }
  // Not of the order above: a cubic is no solution of the harmonic problem.
  EXPECT_GT(std::abs(solve(chain(20, 1, cubic), 1)(5, 0) - cubic(0.25)), 0.05);
}

TEST(Polyharmonic, HarmonicIsLinearAlongABox) {
  Case box{box_tets(10, 3, 3, 0.1), {}, {}, {}};
  const Points& V = box.mesh.V;
  box.K = stiffness(V, box.mesh.T);
  box.M = barycentric_mass(V, box.mesh.T);
  for (int i = 0; i < 32; ++i) box.fixed.node.push_back(i < 16 ? i : 144 + i);  // both ends
  box.fixed.weights = RowMatrix::Zero(32, 2);
  box.fixed.weights.col(0).head(16).setOnes();
  box.fixed.weights.col(1).tail(16).setOnes();
  const RowMatrix W = solve(box, 1);
  EXPECT_LT((W.col(1) - V.col(0)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Polyharmonic, HarmonicObeysTheMaximumPrincipleOnMMatrices) {
  const int n = 300, m = 5;
  Random random(3);
  std::vector<Eigen::Triplet<double>> entries;
  const auto link = [&](int a, int b, double w) {
    entries.emplace_back(a, a, w);
    entries.emplace_back(b, b, w);
    entries.emplace_back(a, b, -w);
    entries.emplace_back(b, a, -w);
  };
  for (int i = 1; i < n; ++i) {
    for (int k = 0; k < 3; ++k)
      link(i, static_cast<int>(random.below(static_cast<std::uint32_t>(i))),
           std::pow(10.0, -4 * random.uniform()));
  }
  Case graph;
  graph.K.resize(n, n);
  graph.K.setFromTriplets(entries.begin(), entries.end());
  graph.M = Vector::Ones(n);
  for (int h = 0; h < m; ++h) graph.fixed.node.push_back(50 * h + 3);
  graph.fixed.weights = RowMatrix::Identity(m, m);
  const RowMatrix W = solve(graph, 1);
  EXPECT_GE(W.minCoeff(), -1e-13);
  EXPECT_LE(W.maxCoeff(), 1 + 1e-13);
  for (int i = 0; i < n; ++i) {
    const auto& given = graph.fixed.node;
    if (std::count(given.begin(), given.end(), i) > 0) continue;
    EXPECT_LT(W.row(i).maxCoeff(), 1) << "strictly inside, node " << i;
  }
}

TEST(Polyharmonic, AgreesWithADenseSolveAndSumsToOne) {
  const Case box = jittered_box();
  const Eigen::MatrixXd K(box.K), Mi = box.M.cwiseInverse().asDiagonal();
  Eigen::MatrixXd A = K;
  for (int order = 1; order <= 3; ++order) {
    if (order > 1) A = (A * Mi * K).eval();
    const RowMatrix W = solve(box, order);
    std::vector<int> free;
    for (int i = 0; i < K.rows(); ++i)
      if (std::count(box.fixed.node.begin(), box.fixed.node.end(), i) == 0) free.push_back(i);
    const Eigen::MatrixXd X =
        -A(free, free).ldlt().solve(A(free, box.fixed.node) * Eigen::MatrixXd(box.fixed.weights));
    EXPECT_LT((Eigen::MatrixXd(W(free, Eigen::all)) - X).cwiseAbs().maxCoeff(), 1e-7) << order;
    EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-8) << order;
    for (std::size_t h = 0; h < 4; ++h)
      EXPECT_EQ(W(box.fixed.node[h], static_cast<Eigen::Index>(h)), 1);
    PolyharmonicOptions options;
    options.order = order;
    const SolveStats stats = polyharmonic(box.problem(), options).stats;
    EXPECT_EQ(stats.status, SolveStats::Status::converged);
    const double energy = 0.5 * (Eigen::MatrixXd(W).transpose() * A * Eigen::MatrixXd(W)).trace();
    EXPECT_NEAR(stats.energy, energy, 1e-6 * energy) << order;
  }
}

TEST(Polyharmonic, DoesNotDependOnTheOrderOfNodes) {
  const Case box = jittered_box();
  const auto n = static_cast<int>(box.K.rows());
  std::vector<int> to(static_cast<std::size_t>(n));
  std::iota(to.begin(), to.end(), 0);
  Random random(5);
  for (int i = n - 1; i > 0; --i)
    std::swap(to[static_cast<std::size_t>(i)], to[random.below(static_cast<std::uint32_t>(i + 1))]);
  Case turned;
  Eigen::PermutationMatrix<Eigen::Dynamic> P(n);
  for (int i = 0; i < n; ++i) P.indices()[i] = to[static_cast<std::size_t>(i)];
  turned.K = Eigen::MatrixXd(P * Eigen::MatrixXd(box.K) * P.transpose()).sparseView();
  turned.M = P * box.M;
  std::vector<std::pair<int, int>> moved;
  for (int h = 0; h < 4; ++h)
    moved.emplace_back(to[static_cast<std::size_t>(box.fixed.node[static_cast<std::size_t>(h)])],
                       h);
  std::sort(moved.begin(), moved.end());
  turned.fixed.weights = RowMatrix::Zero(4, 4);
  for (int k = 0; k < 4; ++k) {
    turned.fixed.node.push_back(moved[static_cast<std::size_t>(k)].first);
    turned.fixed.weights(k, moved[static_cast<std::size_t>(k)].second) = 1;
  }
  for (int order = 1; order <= 3; ++order)
    EXPECT_LT((P * solve(box, order) - solve(turned, order)).cwiseAbs().maxCoeff(), 1e-7) << order;
}

TEST(Polyharmonic, BoundsCostEnergyAndClampingMore) {
  const Case box = jittered_box();
  PolyharmonicOptions options;
  options.order = 2;
  const PolyharmonicResult raw = polyharmonic(box.problem(), options);
  const RowMatrix valid = valid_weights(raw.W);
  EXPECT_LT(raw.W.minCoeff(), -1e-3) << "else this shows nothing";
  const double bounded = bounded_biharmonic(box.problem()).stats.energy;
  const double clamped = 0.5 * valid.cwiseProduct(biharmonic(box.K, box.M) * valid).sum();
  EXPECT_LT(raw.stats.energy, bounded);
  EXPECT_LT(bounded, clamped);
}

TEST(Polyharmonic, ValidWeightsAreOnTheSimplex) {
  RowMatrix raw(4, 3);
  raw << 0.5, 0.75, -0.25, 0, 0, 0, 1, 0, 0, -0.5, -0.5, 2;
  const RowMatrix W = valid_weights(raw);
  RowMatrix wanted(4, 3);
  wanted << 0.4, 0.6, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((W - wanted).cwiseAbs().maxCoeff(), 1e-15);
  raw << 0.5, 0.75, -0.25, 0, 0, 0, 1, 0, 0, 0.25, -0.5, -2;
  wanted << 0.5, 0.5, 0, 0, 0, 0, 1, 0, 0, 0.25, 0.375, 0.375;
  EXPECT_LT((valid_weights(raw, {0}) - wanted).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Polyharmonic, LeavesUnreachedComponentsOut) {
  const Case box = jittered_box();
  const Eigen::Index n = box.K.rows();
  SparseRows K(2 * n, 2 * n);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i)
    for (SparseRows::InnerIterator it(box.K, i); it; ++it) {
      entries.emplace_back(it.row(), it.col(), it.value());
      entries.emplace_back(it.row() + n, it.col() + n, it.value());
    }
  K.setFromTriplets(entries.begin(), entries.end());
  Vector M(2 * n);
  M << box.M, box.M;
  for (int order = 1; order <= 3; ++order) {
    PolyharmonicOptions options;
    options.order = order;
    const PolyharmonicResult both = polyharmonic({K, M, box.fixed}, options);
    ASSERT_EQ(both.unreached.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(both.unreached.front(), n);
    EXPECT_TRUE(both.W.topRows(n) == solve(box, order));
    EXPECT_TRUE(both.W.bottomRows(n).isZero(0));
  }
}

TEST(Polyharmonic, PaintWinsAndLocksKeepColumns) {
  const Case box = jittered_box();
  PolyharmonicOptions options;
  options.order = 2;
  options.paint.node = {5, box.fixed.node[3]};
  options.paint.weights.resize(2, 4);
  options.paint.weights << 0.2, 0.3, 0.5, 0, 0.5, 0, 0.5, 0;
  const RowMatrix painted = polyharmonic(box.problem(), options).W;
  for (int k = 0; k < 2; ++k)
    EXPECT_TRUE(painted.row(options.paint.node[static_cast<std::size_t>(k)]) ==
                options.paint.weights.row(k));

  PolyharmonicOptions locking;
  locking.order = 2;
  locking.start = valid_weights(solve(box, 2));
  locking.start.col(1) *= 0.5;
  locking.locked = {1};
  const RowMatrix W = valid_weights(polyharmonic(box.problem(), locking).W, locking.locked);
  EXPECT_TRUE(W.col(1) == locking.start.col(1));
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_NEAR(W(box.fixed.node[1], 1), 0.5, 1e-15);
  locking.locked = {0, 1, 2, 3};
  const RowMatrix all = valid_weights(polyharmonic(box.problem(), locking).W, locking.locked);
  EXPECT_LT((all.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
}

TEST(Polyharmonic, RefusesWhatItCannotSolve) {
  Case box = jittered_box();
  PolyharmonicOptions options;
  options.order = 4;
  EXPECT_THROW(polyharmonic(box.problem(), options), SolveError);
  options.order = 1;
  options.locked = {0};
  EXPECT_THROW(polyharmonic(box.problem(), options), SolveError);
  box.fixed = {};
  EXPECT_THROW(polyharmonic(box.problem()), SolveError);
}

}  // namespace
}  // namespace skinfield
