#include "skinfield/domain/point_domain.h"

#include "domain/fixtures.h"
#include "skinfield/base/parallel.h"

#include <gtest/gtest.h>
#include <Eigen/SparseCholesky>

#include <cmath>
#include <deque>

namespace skinfield {
namespace {

using namespace skinfield_test;

PointDomainOptions small(int nodes = 1500) {
  PointDomainOptions options;
  options.nodes = nodes;
  return options;
}

const std::vector<Handle>& axis() {
  static const std::vector<Handle> handles{bone({0, 0, -0.3}, {0, 0, 0}),
                                           bone({0, 0, 0}, {0, 0, 0.3})};
  return handles;
}

const PointDomain& sphere() {
  static const PointDomain domain(sphere_mesh(0.5), axis(), small());
  return domain;
}

void expect_m_matrix(const PointDomain& domain) {
  const SparseRows& K = domain.stiffness();
  ASSERT_EQ(K.rows(), domain.nodes().rows());
  const SparseRows difference = K - SparseRows(K.transpose());
  EXPECT_EQ(difference.norm(), 0);
  const Vector sums = K * Vector::Ones(K.cols());
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    EXPECT_NEAR(sums[i], 0, 1e-12 * std::max(1.0, K.coeff(i, i)));
    EXPECT_GE(K.coeff(i, i), 0);
    for (SparseRows::InnerIterator it(K, i); it; ++it)
      if (it.col() != i) {
        EXPECT_LE(it.value(), 0);
      }
  }
  EXPECT_GT(domain.mass().minCoeff(), 0);
}

void expect_stochastic(const SparseRows& P) {
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    double sum = 0;
    for (SparseRows::InnerIterator it(P, i); it; ++it) {
      EXPECT_GE(it.value(), 0);
      sum += it.value();
    }
    EXPECT_NEAR(sum, 1, 1e-12) << "row " << i;
  }
}

/// The harmonic function with f given on the `given` nodes.
Vector harmonic(const SparseRows& K, const std::vector<char>& given, const Vector& f) {
  std::vector<int> row(given.size(), -1);
  int n = 0;
  for (std::size_t i = 0; i < given.size(); ++i)
    if (!given[i]) row[i] = n++;
  std::vector<Eigen::Triplet<double>> entries;
  Vector rhs = Vector::Zero(n);
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    const int r = row[static_cast<std::size_t>(i)];
    if (r < 0) continue;
    for (SparseRows::InnerIterator it(K, i); it; ++it) {
      const int c = row[static_cast<std::size_t>(it.col())];
      if (c >= 0)
        entries.emplace_back(r, c, it.value());
      else
        rhs[r] -= it.value() * f[it.col()];
    }
  }
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(A);
  const Vector x = solver.solve(rhs);
  Vector all = f;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (row[i] >= 0) all[static_cast<Eigen::Index>(i)] = x[row[i]];
  return all;
}

TEST(PointDomain, StiffnessIsAnMMatrixThatKillsConstants) {
  expect_m_matrix(sphere());
  EXPECT_EQ(sphere().facts().components, 1);
  EXPECT_EQ(sphere().facts().components_without_handle, 0);
}

TEST(PointDomain, MassesFillTheVolume) {
  const double exact = 4.0 / 3 * std::numbers::pi * 0.125;
  EXPECT_NEAR(sphere().facts().volume, exact, 0.02 * exact);
  EXPECT_NEAR(sphere().mass().sum(), exact, 0.05 * exact);
}

TEST(PointDomain, HasAboutTheNodesThatWereWanted) {
  EXPECT_NEAR(static_cast<double>(sphere().nodes().rows()), 1500, 150);
  PointDomainOptions even = small();
  even.adaptive = false;
  const PointDomain uniform(sphere_mesh(0.5), axis(), even);
  EXPECT_NEAR(static_cast<double>(uniform.nodes().rows()), 1500, 150);
}

TEST(PointDomain, NodesAreInsideAndFixedOnesOnHandles) {
  const Points& X = sphere().nodes();
  for (Eigen::Index i = 0; i < X.rows(); ++i) EXPECT_TRUE(sphere().solid().inside(row(X, i)));
  const FixedRows& fixed = sphere().fixed();
  ASSERT_GT(fixed.node.size(), 4u);
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    const Vec3 x = row(X, fixed.node[k]);
    EXPECT_NEAR(std::hypot(x[0], x[1]), 0, 1e-12);
    const auto w = fixed.weights.row(static_cast<Eigen::Index>(k));
    const double want = std::abs(x[2]) < 1e-9 ? 0.5 : x[2] < 0 ? 1 : 0;
    EXPECT_DOUBLE_EQ(w[0], want);
    EXPECT_DOUBLE_EQ(w[1], 1 - want);
  }
}

TEST(PointDomain, AJointOfThreeBonesIsSharedByThree) {
  const std::vector<Handle> star{bone({0, 0, 0}, {0.3, 0, 0}), bone({0, 0, 0}, {0, 0.3, 0}),
                                 bone({0, 0, 0.3}, {0, 0, 0})};
  const PointDomain domain(sphere_mesh(0.5), star, small(800));
  int shared = 0;
  for (std::size_t k = 0; k < domain.fixed().node.size(); ++k) {
    const auto w = domain.fixed().weights.row(static_cast<Eigen::Index>(k));
    EXPECT_NEAR(w.sum(), 1, 1e-15);
    if (domain.nodes().row(domain.fixed().node[k]).norm() > 1e-9) continue;
    ++shared;
    for (int h = 0; h < 3; ++h) EXPECT_DOUBLE_EQ(w[h], 1.0 / 3);
  }
  EXPECT_EQ(shared, 1);
}

TEST(PointDomain, HandlesAreCutWhereTheyLeaveTheShape) {
  const std::vector<Handle> handles{bone({0, 0, 0}, {0.9, 0, 0}), bone({0, 0.7, 0}, {0, 0.9, 0})};
  const PointDomain domain(sphere_mesh(0.5), handles, small(800));
  for (int i : domain.fixed().node) EXPECT_LT(domain.nodes().row(i).norm(), 0.5);
  EXPECT_EQ(domain.fixed().weights.col(1).sum(), 0);
  EXPECT_THROW(PointDomain(sphere_mesh(0.5), {handles[1]}, small(800)), DomainError);
}

TEST(PointDomain, AFlatShapeHasNoVolume) {
  Mesh flat = make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  EXPECT_THROW(PointDomain(flat, {bone({0.2, 0.5, 0}, {0.8, 0.5, 0})}, small(800)), DomainError);
}

TEST(PointDomain, InterpolationIsRowStochasticEverywhere) {
  const Interpolation mesh = sphere().at_mesh();
  expect_stochastic(mesh.P);
  EXPECT_EQ(mesh.P.rows(), sphere_mesh(0.5).V.rows());
  for (Fill f : mesh.fill) EXPECT_EQ(f, Fill::none);
  expect_stochastic(sphere().at(random_points(500, -0.6, 0.6, 8), {}).P);
  expect_stochastic(sphere().from_mesh());
  // The vertices as any points: the same rows.
  const Mesh ball = sphere_mesh(0.5);
  const Interpolation again = sphere().at(ball.V, vertex_normals(ball.V, ball.F));
  EXPECT_LT((SparseRows(again.P - mesh.P)).norm(), 1e-12);
}

TEST(PointDomain, InterpolationKeepsPlacesRoughly) {
  // The interpolated position is within the node distance (0.07) of the point itself.
  const Interpolation mesh = sphere().at_mesh();
  const Points X = mesh.P * sphere().nodes();
  EXPECT_LT((X - sphere_mesh(0.5).V).rowwise().norm().maxCoeff(), 0.09);
}

TEST(PointDomain, HarmonicFunctionsOfALongBoxAreLinear) {
  const PointDomain domain(fine_box({0, 0, 0}, {1, 0.2, 0.2}, {10, 2, 2}),
                           {bone({0.05, 0.1, 0.1}, {0.95, 0.1, 0.1})}, [] {
                             PointDomainOptions options = small(3000);
                             options.adaptive = false;
                             return options;
                           }());
  const Points& X = domain.nodes();
  std::vector<char> given(static_cast<std::size_t>(X.rows()), 0);
  Vector f = X.col(0);
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    given[static_cast<std::size_t>(i)] = f[i] < 0.15 || f[i] > 0.85;
  const Vector u = harmonic(domain.stiffness(), given, f);
  EXPECT_LT((u - f).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT((u - f).cwiseAbs().mean(), 0.01);
}

TEST(PointDomain, WeightsRiseFromOnePointToTheOther) {
  const PointDomain domain(fine_box({0, 0, 0}, {1, 0.2, 0.2}, {10, 2, 2}),
                           {point_handle({0.02, 0.1, 0.1}), point_handle({0.98, 0.1, 0.1})},
                           small(2000));
  const Points& X = domain.nodes();
  std::vector<char> given(static_cast<std::size_t>(X.rows()), 0);
  Vector f = Vector::Zero(X.rows());
  for (std::size_t k = 0; k < domain.fixed().node.size(); ++k) {
    given[static_cast<std::size_t>(domain.fixed().node[k])] = 1;
    f[domain.fixed().node[k]] = domain.fixed().weights(static_cast<Eigen::Index>(k), 1);
  }
  const Vector u = harmonic(domain.stiffness(), given, f);
  EXPECT_GE(u.minCoeff(), -1e-12);
  EXPECT_LE(u.maxCoeff(), 1 + 1e-12);
  double last = -1;
  for (int slab = 0; slab < 8; ++slab) {
    double sum = 0, mass = 0;
    for (Eigen::Index i = 0; i < X.rows(); ++i)
      if (X(i, 0) >= 0.1 + 0.1 * slab && X(i, 0) < 0.2 + 0.1 * slab) {
        sum += domain.mass()[i] * u[i];
        mass += domain.mass()[i];
      }
    ASSERT_GT(mass, 0);
    EXPECT_GT(sum / mass, last) << "slab " << slab;
    last = sum / mass;
  }
}

TEST(PointDomain, SameBytesForOneAndTwoThreads) {
  const Mesh mesh = sphere_mesh(0.5);
  for (const Mesh& shape : {mesh, soup_of(mesh, 0.3, 0.01, 2)}) {
    std::deque<PointDomain> runs;
    std::vector<SparseRows> P;
    for (int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      runs.emplace_back(shape, axis(), small(600));
      P.push_back(runs.back().at_mesh().P);
    }
    EXPECT_EQ(runs[0].nodes(), runs[1].nodes());
    EXPECT_EQ(runs[0].mass(), runs[1].mass());
    EXPECT_EQ(SparseRows(runs[0].stiffness() - runs[1].stiffness()).norm(), 0);
    EXPECT_EQ(SparseRows(P[0] - P[1]).norm(), 0);
  }
}

TEST(PointDomain, SeedsMoveTheNodesAndNothingElse) {
  PointDomainOptions other = small();
  other.seed = 7;
  const PointDomain domain(sphere_mesh(0.5), axis(), other);
  EXPECT_NEAR(static_cast<double>(domain.nodes().rows()),
              static_cast<double>(sphere().nodes().rows()), 75);
  const Eigen::Index last = std::min(domain.nodes().rows(), sphere().nodes().rows()) - 1;
  EXPECT_NE(domain.nodes().row(last), sphere().nodes().row(last));
  EXPECT_EQ(domain.fixed().weights, sphere().fixed().weights);
}

TEST(PointDomain, PaintedPointsAreFixedNodes) {
  PaintedPoints paint;
  paint.X.resize(3, 3);
  paint.X << 0.5, 0, 0, -0.5, 0, 0, 0, 0.5, 0;
  paint.N = paint.X / 0.5;
  paint.weights.resize(3, 2);
  paint.weights << 1, 0, 0, 1, 0.25, 0.75;
  const PointDomain domain(sphere_mesh(0.5), {}, small(800), paint);
  ASSERT_EQ(domain.fixed().node.size(), 3u);
  EXPECT_EQ(domain.fixed().weights, paint.weights);
  for (int k = 0; k < 3; ++k)
    EXPECT_LT(
        (row(domain.nodes(), domain.fixed().node[static_cast<std::size_t>(k)]) - row(paint.X, k))
            .norm(),
        2e-4);
}

TEST(PointDomain, StopsWhenAsked) {
  Progress progress;
  int polls = 0;
  progress.cancelled = [&polls] { return ++polls > 20; };
  const ThreadLimit limit(1);
  EXPECT_THROW(PointDomain(sphere_mesh(0.5), axis(), small(), {}, progress), Cancelled);
}

TEST(PointDomain, RegionsHoldNodesJustInside) {
  const Mesh box = fine_box({0, 0, 0}, {1, 0.2, 0.2}, {40, 8, 8});
  Handle low, high;
  low.kind = high.kind = Handle::Kind::region;
  for (int v = 0; v < box.V.rows(); ++v) {
    if (box.V(v, 0) == 0) low.vertices.push_back(v);
    if (box.V(v, 0) == 1) high.vertices.push_back(v);
  }
  ASSERT_EQ(low.vertices.size(), 81u);
  for (const Mesh& mesh : {box, turned_inside_out(box)}) {
    const PointDomain domain(mesh, {low, high}, small(600));
    const FixedRows& fixed = domain.fixed();
    ASSERT_FALSE(fixed.node.empty());
    EXPECT_LT(fixed.node.size(), 2 * 81u) << "nearer to each other than the nodes can tell apart";
    for (std::size_t k = 0; k < fixed.node.size(); ++k) {
      const double x = domain.nodes()(fixed.node[k], 0);
      EXPECT_NEAR(std::min(x, 1 - x), 0, 2e-4);
      EXPECT_TRUE(domain.solid().inside(Vec3(domain.nodes().row(fixed.node[k]))));
      EXPECT_EQ(fixed.weights(static_cast<Eigen::Index>(k), x < 0.5 ? 0 : 1), 1);
    }
  }
}

}  // namespace
}  // namespace skinfield
