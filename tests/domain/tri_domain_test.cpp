#include "skinfield/domain/tri_domain.h"

#include "domain/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

using namespace skinfield_test;

/// A square of n x n cells in the plane z = 0.
Mesh square(int n) {
  Mesh mesh;
  mesh.V.resize((n + 1) * (n + 1), 3);
  mesh.F.resize(2 * n * n, 3);
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) mesh.V.row(j * (n + 1) + i) << double(i) / n, double(j) / n, 0;
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, f = 2 * (j * n + i);
      mesh.F.row(f) << a, a + 1, a + n + 2;
      mesh.F.row(f + 1) << a, a + n + 2, a + n + 1;
    }
  }
  return mesh;
}

Mesh turned(Mesh mesh, const Eigen::AngleAxisd& turn) {
  mesh.V *= turn.toRotationMatrix().transpose();
  return mesh;
}

double row_of(const FixedRows& fixed, int node, int column) {
  const auto at = std::find(fixed.node.begin(), fixed.node.end(), node);
  return at == fixed.node.end() ? -1 : fixed.weights(at - fixed.node.begin(), column);
}

TEST(TriDomain, AMeshWithVerticesOnEveryHandleIsNotChanged) {
  const Mesh mesh = square(10);
  // Two bones that meet in vertex 60 (0.5, 0.5), and a point.
  const TriDomain domain(mesh, {bone({0.1, 0.5, 0}, {0.5, 0.5, 0}),
                                bone({0.5, 0.5, 0}, {0.9, 0.5, 0}), point_handle({0.3, 0.9, 0})});
  EXPECT_EQ(domain.nodes(), mesh.V);
  EXPECT_EQ(domain.triangles(), mesh.F);
  EXPECT_EQ(domain.facts().added_nodes, 0);
  EXPECT_TRUE(domain.facts().planar);
  const FixedRows& fixed = domain.fixed();
  EXPECT_EQ(fixed.node, (std::vector<int>{56, 57, 58, 59, 60, 61, 62, 63, 64, 102}));
  EXPECT_EQ(row_of(fixed, 60, 0), 0.5);
  EXPECT_EQ(row_of(fixed, 60, 1), 0.5);
  EXPECT_EQ(row_of(fixed, 56, 0), 1);
  EXPECT_EQ(row_of(fixed, 64, 1), 1);
  EXPECT_EQ(row_of(fixed, 102, 2), 1);
  // Within 1e-6 of the diagonal is on it; beyond is not.
  const Handle near = point_handle({0.3 + 1e-6, 0.9, 0}), far = point_handle({0.3 + 2e-6, 0.9, 0});
  EXPECT_EQ(TriDomain(mesh, {near}).facts().added_nodes, 0);
  EXPECT_GT(TriDomain(mesh, {far}).facts().added_nodes, 0);
}

TEST(TriDomain, IsTheFiniteElementsOfItsTriangles) {
  const Mesh mesh = square(6);
  const TriDomain domain(mesh, {point_handle({0.5, 0.5, 0})});
  EXPECT_EQ((domain.stiffness() - stiffness(mesh.V, mesh.F)).norm(), 0);
  EXPECT_EQ(domain.mass(), barycentric_mass(mesh.V, mesh.F));
  EXPECT_NEAR(domain.mass().sum(), 1, 1e-12);
  const Vector ones = Vector::Ones(mesh.V.rows());
  EXPECT_LT((domain.stiffness() * ones).cwiseAbs().maxCoeff(), 1e-12);
  // Linear precision: inside, a linear function has no Laplacian; its Dirichlet energy is exact.
  const Vector linear = 2 * mesh.V.col(0) - 3 * mesh.V.col(1);
  const Vector L = domain.stiffness() * linear;
  for (Eigen::Index i = 0; i < L.size(); ++i) {
    const bool border =
        mesh.V(i, 0) < 0.01 || mesh.V(i, 0) > 0.99 || mesh.V(i, 1) < 0.01 || mesh.V(i, 1) > 0.99;
    if (!border) {
      EXPECT_NEAR(L[i], 0, 1e-12);
    }
  }
  EXPECT_NEAR(linear.dot(L), 13, 1e-10);
}

TEST(TriDomain, SplitsWhereAHandleHasNoVertex) {
  for (const Eigen::AngleAxisd& turn :
       {Eigen::AngleAxisd(0.0, Vec3::UnitX()), Eigen::AngleAxisd(0.8, Vec3(1, 2, 2) / 3)}) {
    const Mesh mesh = turned(square(60), turn);
    const auto at = [&](double x, double y, double z = 0) -> Vec3 { return turn * Vec3(x, y, z); };
    // The second one hovers over the plane, the third leaves the square.
    const std::vector<Handle> handles{bone(at(0.111, 0.222), at(0.432, 0.456)),
                                      point_handle(at(0.777, 0.333, 0.2)),
                                      bone(at(0.511, 0.877), at(0.511, 1.3))};
    const TriDomain domain(mesh, handles);
    EXPECT_EQ(Points(domain.nodes().topRows(mesh.V.rows())), mesh.V);
    EXPECT_EQ(domain.facts().added_nodes, domain.nodes().rows() - mesh.V.rows());
    EXPECT_EQ(domain.facts().handle_nodes, static_cast<int>(domain.fixed().node.size()));
    EXPECT_NEAR(domain.mass().sum(), 1, 1e-9);
    EXPECT_NEAR(domain.facts().area, 1, 1e-9);
    // Dense enough: two a mean edge length, 1/60 * (2 + sqrt 2) / 3.
    const double spacing = 0.5 * (2 + std::sqrt(2.0)) / 3 / 60;
    int on[3] = {0, 0, 0};
    for (std::size_t k = 0; k < domain.fixed().node.size(); ++k) {
      for (int j = 0; j < 3; ++j) {
        on[j] += domain.fixed().weights(static_cast<Eigen::Index>(k), j) == 1;
      }
    }
    EXPECT_GE(on[0], Vec3(0.321, 0.234, 0).norm() / spacing);
    EXPECT_LT(on[0], Vec3(0.321, 0.234, 0).norm() / spacing + 4);
    EXPECT_EQ(on[1], 1);
    EXPECT_NEAR(on[2], 0.123 / spacing, 2);  // the part inside
    EXPECT_TRUE(domain.covers(at(0.7, 0.7, 0.4)));
    EXPECT_FALSE(domain.covers(at(1.1, 0.7)));
  }
}

TEST(TriDomain, CoarseMeshesAreRefinedBeforeTheyAreSplit) {
  const std::vector<Handle> handles{point_handle({0.21, 0.2, 0}), point_handle({0.81, 0.8, 0})};
  const TriDomain fine(square(1), handles);
  EXPECT_GT(fine.nodes().rows(), 1000);
  EXPECT_NEAR(fine.mass().sum(), 1, 1e-12);
  TriDomainOptions options;
  options.nodes = 0;
  EXPECT_EQ(TriDomain(square(1), handles, options).nodes().rows(), 4 + 2);
}

TEST(TriDomain, EvaluatesAnywhere) {
  const Mesh mesh = square(8);
  const TriDomain domain(mesh, {bone({0.111, 0.222, 0}, {0.432, 0.456, 0})});
  // The mesh's own vertices exactly; linear functions everywhere inside.
  const Interpolation own = domain.at(mesh.V, {});
  EXPECT_EQ(own.P.nonZeros(), mesh.V.rows());
  for (int i = 0; i < mesh.V.rows(); ++i) EXPECT_EQ(own.P.coeff(i, i), 1);
  Points X(3, 3);
  X << 0.123, 0.456, 0, 0.999, 0.001, 0, 1.2, 0.5, 0.1;
  const Interpolation there = domain.at(X, {});
  const Points Y = there.P * domain.nodes();
  EXPECT_LT((Y.topRows(2) - X.topRows(2)).norm(), 1e-12);
  EXPECT_LT((Y.row(2) - Eigen::RowVector3d(1, 0.5, 0)).norm(), 1e-12);
  for (Eigen::Index i = 0; i < 3; ++i) EXPECT_NEAR(there.P.row(i).sum(), 1, 1e-14);
  // Back from the mesh's vertices to the nodes.
  const SparseRows back = domain.from_mesh();
  ASSERT_EQ(back.rows(), domain.nodes().rows());
  EXPECT_LT((back * mesh.V - domain.nodes()).norm(), 1e-10);
}

TEST(TriDomain, OverlappingPartsDoNotMix) {
  Mesh mesh = together(square(4), square(4));
  mesh.V.bottomRows(25).col(0).array() += 0.6;
  mesh.V.bottomRows(25).col(1).array() += 0.03;
  const TriDomain domain(mesh, {point_handle({0.1, 0.5, 0}), point_handle({1.5, 0.5, 0})});
  const Interpolation own = domain.at(mesh.V, {});
  for (int i = 0; i < mesh.V.rows(); ++i) EXPECT_EQ(own.P.coeff(i, i), 1);
  EXPECT_EQ(domain.facts().components, 2);
  EXPECT_EQ(domain.facts().components_without_handle, 0);
  // A handle where both lie holds a node of each.
  const TriDomain joint(mesh, {point_handle({0.8, 0.5, 0})});
  EXPECT_EQ(joint.fixed().node.size(), 2u);
}

TEST(TriDomain, PartsWithoutAHandleAreCounted) {
  const Mesh mesh = together(square(4), moved(square(2), {2, 0, 0}));
  const TriDomain domain(mesh, {point_handle({0.5, 0.5, 0})});
  EXPECT_EQ(domain.facts().components, 2);
  EXPECT_EQ(domain.facts().components_without_handle, 1);
  EXPECT_NEAR(domain.facts().area_without_handle, 1, 1e-12);
}

TEST(TriDomain, SurfacesInSpaceHoldWhatTheirHandlesSee) {
  const Mesh mesh = fine_box({0, 0, 0}, {1, 0.2, 0.2}, {20, 4, 4});
  const TriDomain domain(
      mesh, {bone({0.02, 0.1, 0.1}, {0.48, 0.1, 0.1}), bone({0.52, 0.1, 0.1}, {0.98, 0.1, 0.1})},
      {.nodes = 0, .mass = {}});
  EXPECT_FALSE(domain.facts().planar);
  EXPECT_EQ(domain.nodes(), mesh.V);
  EXPECT_EQ((domain.stiffness() - stiffness(mesh.V, mesh.F)).norm(), 0);
  ASSERT_GT(domain.fixed().node.size(), 20u);
  for (std::size_t k = 0; k < domain.fixed().node.size(); ++k) {
    const double x = mesh.V(domain.fixed().node[k], 0);
    const auto row = domain.fixed().weights.row(static_cast<Eigen::Index>(k));
    EXPECT_NEAR(row.sum(), 1, 1e-15);
    if (x < 0.45) {
      EXPECT_EQ(row[0], 1) << x;
    }
    if (x > 0.55) {
      EXPECT_EQ(row[1], 1) << x;
    }
  }
  // A vertex on a handle is exact, whatever others see.
  const Vec3 corner = mesh.V.row(0);
  const TriDomain exact(mesh, {point_handle(corner), bone({0.52, 0.1, 0.1}, {0.98, 0.1, 0.1})});
  EXPECT_EQ(row_of(exact.fixed(), 0, 0), 1);
  EXPECT_EQ(exact.fixed().weights.col(0).sum(), 1);
}

TEST(TriDomain, RegionsAreTheirVertices) {
  Handle left, right;
  left.kind = right.kind = Handle::Kind::region;
  left.vertices = {0, 5, 10, 5};
  right.vertices = {4, 10};
  const TriDomain domain(square(4), {left, right});
  EXPECT_EQ(domain.fixed().node, (std::vector<int>{0, 4, 5, 10}));
  EXPECT_EQ(row_of(domain.fixed(), 10, 0), 0.5);
  EXPECT_EQ(row_of(domain.fixed(), 5, 0), 1);
}

TEST(TriDomain, LooseVerticesAndDegenerateTriangles) {
  Mesh mesh = square(4);
  const Eigen::Index n = mesh.V.rows(), f = mesh.F.rows();
  mesh.V.conservativeResize(n + 1, 3);
  mesh.V.row(n) << 0.51, 0.52, 0;  // on no triangle, and a handle lies on it
  mesh.F.conservativeResize(f + 2, 3);
  mesh.F.row(f) << 0, 0, 7;
  mesh.F.row(f + 1) << 0, 1, 2;
  const TriDomain domain(mesh, {point_handle({0.51, 0.52, 0})}, {.nodes = 0, .mass = {}});
  ASSERT_EQ(domain.fixed().node.size(), 1u);
  EXPECT_EQ(domain.fixed().node[0], n + 1);  // a new node in the square
  EXPECT_TRUE((domain.mass().array() > 0).all());
  const Interpolation own = domain.at(mesh.V, {});
  EXPECT_NEAR(own.P.coeff(n, n + 1), 1, 1e-9);
}

TEST(TriDomain, MassesOfTheCaller) {
  const Mesh mesh = square(4);
  TriDomainOptions options;
  options.mass = Vector::Constant(25, 0.5);
  EXPECT_EQ(TriDomain(mesh, {point_handle({0.5, 0.5, 0})}, options).mass(), options.mass);
  EXPECT_THROW(TriDomain(mesh, {point_handle({0.55, 0.5, 0})}, options), InputError);
  options.mass[3] = 0;
  EXPECT_THROW(TriDomain(mesh, {point_handle({0.5, 0.5, 0})}, options), InputError);
  options.mass = Vector::Ones(24);
  EXPECT_THROW(TriDomain(mesh, {point_handle({0.5, 0.5, 0})}, options), InputError);
}

TEST(TriDomain, RefusesWhatHasNoWeights) {
  EXPECT_THROW(TriDomain(square(2), {}), DomainError);
  EXPECT_THROW(TriDomain(square(2), {point_handle({3, 3, 0})}), DomainError);
  Mesh line = square(1);
  line.V.col(1).setZero();
  EXPECT_THROW(TriDomain(line, {point_handle({0.5, 0, 0})}), DomainError);
}

}  // namespace
}  // namespace skinfield
