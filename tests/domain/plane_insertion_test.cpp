#include "domain/plane_insertion.h"

#include "domain/fixtures.h"
#include "skinfield/base/random.h"
#include "skinfield/operators/stiffness.h"

#include <gtest/gtest.h>

#include <set>

namespace skinfield {
namespace {

constexpr double kTolerance = 1e-7;

/// A square of n x n cells in the plane z = 0, every other triangle turned over.
Mesh grid(int n) {
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
      mesh.F.row(f + 1) << a, a + n + 1, a + n + 2;
    }
  }
  return mesh;
}

double area(const PlaneInsertion& t) { return element_volumes(t.vertices(), t.faces()).sum(); }

/// No vertex lies inside the circle of a triangle across an edge.
bool is_delaunay(const Points& V, const Triangles& F) {
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vec3 a = V.row(F(f, 0)), b = V.row(F(f, 1)), c = V.row(F(f, 2));
    const Vec3 ab = b - a, ac = c - a, n = ab.cross(ac);
    const Vec3 centre = a + (ac.squaredNorm() * n.cross(ab) + ab.squaredNorm() * ac.cross(n)) /
                                (2 * n.squaredNorm());
    const double radius = (centre - a).norm();
    for (Eigen::Index i = 0; i < V.rows(); ++i) {
      if ((V.row(i).transpose() - centre).norm() < radius * (1 - 1e-6)) return false;
    }
  }
  return true;
}

TEST(PlaneInsertion, KeepsAreaAndDelaunay) {
  const Mesh mesh = grid(4);
  PlaneInsertion t(mesh.V, mesh.F, *plane_of(mesh.V, 1e-9), kTolerance);
  Random random(3);
  for (int k = 0; k < 60; ++k) {
    const Vec3 x(random.uniform(), random.uniform(), 0.3);  // dropped onto the plane
    const std::vector<int> made = t.insert(x);
    ASSERT_EQ(made.size(), 1u);
    EXPECT_LT((t.vertices().row(made[0]).transpose() - Vec3(x.x(), x.y(), 0)).norm(), 1e-12);
  }
  EXPECT_NEAR(area(t), 1, 1e-12);
  EXPECT_EQ(t.vertices().rows(), 25 + 60);
  EXPECT_EQ(t.faces().rows(), 32 + 2 * 60);  // Euler, as long as none lies on the border
  EXPECT_TRUE(is_delaunay(t.vertices(), t.faces()));
  EXPECT_EQ(Points(t.vertices().topRows(25)), mesh.V);
}

TEST(PlaneInsertion, VerticesEdgesAndTheOutside) {
  const Mesh mesh = grid(2);
  PlaneInsertion t(mesh.V, mesh.F, *plane_of(mesh.V, 1e-9), kTolerance);
  EXPECT_EQ(t.insert({0.5, 0.5, 0}), std::vector<int>{4});
  EXPECT_EQ(t.insert({0.5 + 1e-8, 0.5, 0}), std::vector<int>{4});
  EXPECT_TRUE(t.insert({1.01, 0.5, 0}).empty());
  EXPECT_EQ(t.faces().rows(), 8);
  // On an inner edge: two triangles become four. On the border: one becomes two.
  EXPECT_EQ(t.insert({0.5, 0.25, 0}), std::vector<int>{9});
  EXPECT_EQ(t.faces().rows(), 10);
  EXPECT_EQ(t.insert({0.25, 0, 0}), std::vector<int>{10});
  EXPECT_EQ(t.faces().rows(), 11);
  EXPECT_EQ(t.insert({0.25, 1e-8, 0}), std::vector<int>{10});
  EXPECT_NEAR(area(t), 1, 1e-12);
}

TEST(PlaneInsertion, EverySheetGetsItsVertex) {
  // Two squares over each other that share no vertex, and one beside them.
  Mesh mesh = skinfield_test::together(grid(1), grid(1));
  mesh.V.bottomRows(4).col(0).array() += 0.5;
  PlaneInsertion t(mesh.V, mesh.F, *plane_of(mesh.V, 1e-9), kTolerance);
  EXPECT_EQ(t.insert({0.2, 0.7, 0}).size(), 1u);
  const std::vector<int> both = t.insert({0.8, 0.7, 0});
  EXPECT_EQ(both.size(), 2u);
  EXPECT_NEAR(area(t), 2, 1e-12);
  EXPECT_EQ(connected_components(t.faces(), t.vertices().rows()).count, 2);
}

TEST(PlaneInsertion, AnEdgeOfThreeTrianglesIsSplitInAll) {
  Mesh mesh;
  mesh.V.resize(5, 3);
  mesh.V << 0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, -1, 0, 0.7, 0.8, 0;
  mesh.F.resize(3, 3);
  mesh.F << 0, 1, 2, 0, 1, 3, 1, 0, 4;
  PlaneInsertion t(mesh.V, mesh.F, *plane_of(mesh.V, 1e-9), kTolerance);
  EXPECT_EQ(t.insert({0.4, 0, 0}), std::vector<int>{5});
  EXPECT_EQ(t.faces().rows(), 6);
  EXPECT_NEAR(area(t), 0.5 + 0.5 + 0.4, 1e-12);
}

}  // namespace
}  // namespace skinfield
