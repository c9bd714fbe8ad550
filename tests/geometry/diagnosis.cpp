#include "skinfield/geometry/diagnosis.h"

#include "geometry/shapes.h"
#include "skinfield/base/parallel.h"

#include <gtest/gtest.h>

using namespace skinfield_test;

namespace {

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh mesh;
  mesh.V.resize(a.V.rows() + b.V.rows(), 3);
  mesh.V << a.V, b.V;
  mesh.F.resize(a.F.rows() + b.F.rows(), 3);
  mesh.F << a.F, (b.F.array() + static_cast<int>(a.V.rows())).matrix();
  return mesh;
}

TEST(Diagnosis, OfABox) {
  const Diagnosis d = diagnose(box_mesh({1, 2, 3}, {2, 4, 6}));
  EXPECT_EQ(d.vertices, 8);
  EXPECT_EQ(d.faces, 12);
  EXPECT_EQ(d.components, 1);
  EXPECT_TRUE(d.watertight);
  EXPECT_FALSE(d.planar);
  EXPECT_FALSE(d.self_intersecting);
  EXPECT_EQ(d.intersection_faces_tested, 12);
  EXPECT_EQ(d.boundary_edges + d.nonmanifold_edges + d.inconsistent_edges, 0);
  EXPECT_EQ(d.degenerate_faces + d.duplicate_faces + d.unreferenced_vertices, 0);
  EXPECT_NEAR(d.area, 22, 1e-12);
  EXPECT_NEAR(d.volume, 6, 1e-12);
  EXPECT_EQ(d.box.row(1), Eigen::RowVector3d(2, 4, 6));
}

TEST(Diagnosis, SplitVerticesDoNotOpenAMesh) {
  const Mesh torus = torus_mesh(1, 0.3);
  Mesh split;
  split.V.resize(torus.F.size(), 3);
  split.F.resize(torus.F.rows(), 3);
  for (Eigen::Index i = 0; i < torus.F.size(); ++i) {
    split.V.row(i) = torus.V.row(torus.F.data()[i]);
    split.F.data()[i] = static_cast<int>(i);
  }
  const Diagnosis d = diagnose(split);
  EXPECT_EQ(d.merged_vertices, torus.V.rows());
  EXPECT_EQ(d.vertices, torus.F.size());
  EXPECT_EQ(d.components, 1);
  EXPECT_TRUE(d.watertight);
  EXPECT_FALSE(d.self_intersecting);
}

TEST(Diagnosis, AMoebiusStripHasABorderAndDisagrees) {
  constexpr int n = 24;
  const Diagnosis d = diagnose(moebius_strip(n));
  EXPECT_EQ(d.boundary_edges, 2 * n);
  EXPECT_EQ(d.inconsistent_edges, 1);
  EXPECT_EQ(d.nonmanifold_edges, 0);
  EXPECT_FALSE(d.watertight);
}

TEST(Diagnosis, CountsTheBadFaces) {
  const Mesh mesh = make_mesh({{0, 0, 0},
                               {1, 0, 0},
                               {0, 1, 0},
                               {0, 0, 1},
                               {2, 0, 0},
                               {9, 9, 9},
                               {0, 0, 0},
                               {0, std::nan(""), 0}},
                              {{0, 1, 2}, {0, 1, 2}, {2, 1, 6}, {0, 0, 3}, {0, 1, 4}, {6, 3, 1}});
  const Diagnosis d = diagnose(mesh);
  EXPECT_EQ(d.duplicate_faces, 2);   // one the same, one flipped with a corner's copy
  EXPECT_EQ(d.degenerate_faces, 2);  // a repeated corner, three in line
  EXPECT_EQ(d.unreferenced_vertices, 2);
  EXPECT_EQ(d.merged_vertices, 7);
  EXPECT_EQ(d.non_finite_vertices, 1);
  EXPECT_GT(d.nonmanifold_edges, 0);
  EXPECT_FALSE(d.watertight);
  EXPECT_TRUE(std::isfinite(d.area));
  EXPECT_EQ(d.box(1, 0), 9);
}

TEST(Diagnosis, OneFlippedFaceDisagreesAlongThreeEdges) {
  Mesh torus = torus_mesh(1, 0.3);
  std::swap(torus.F(5, 0), torus.F(5, 1));
  EXPECT_EQ(diagnose(torus).inconsistent_edges, 3);
  EXPECT_TRUE(diagnose(torus).watertight);
}

TEST(Diagnosis, AnOutlineUsesItsVertices) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {});
  mesh.outline.E.resize(3, 2);
  mesh.outline.E << 0, 1, 1, 2, 2, 0;
  mesh.outline.shape = {0, 0, 0};
  EXPECT_TRUE(mesh.is_outline());
  EXPECT_TRUE(diagnose(mesh).planar);
  EXPECT_EQ(diagnose(mesh).unreferenced_vertices, 1);
}

TEST(Diagnosis, PlanarIsPlanarInAnyPose) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}});
  EXPECT_TRUE(diagnose(mesh).planar);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.9, Vec3(1, -2, 1).normalized()).toRotationMatrix();
  mesh.V = ((1000 * mesh.V * turn.transpose()).rowwise() + Eigen::RowVector3d(5, 6, 7)).eval();
  EXPECT_TRUE(diagnose(mesh).planar);
  mesh.V.row(3) += 0.01 * turn.col(2).transpose();
  EXPECT_FALSE(diagnose(mesh).planar);
}

TEST(Diagnosis, OverlapIsSelfIntersectionAndTouchingIsNot) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const Diagnosis overlap = diagnose(joined(box, box_mesh({0.5, 0.4, 0.3}, {1.5, 1.4, 1.2})));
  EXPECT_TRUE(overlap.self_intersecting);
  EXPECT_EQ(overlap.components, 2);
  EXPECT_FALSE(diagnose(joined(box, box_mesh({1, 0.2, 0.3}, {2, 0.7, 0.8}))).self_intersecting);
  EXPECT_FALSE(diagnose(joined(box, box_mesh({1.1, 0, 0}, {2, 1, 1}))).self_intersecting);
}

TEST(Diagnosis, IntersectionsAgreeWithAllPairsAndWithAnyThreadCount) {
  const Mesh soup = random_soup(300, 0.08, 4);
  const auto crosses = [&](Eigen::Index f, Eigen::Index g) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = row(soup.V, soup.F(f, k)), q = row(soup.V, soup.F(f, (k + 1) % 3));
      Eigen::Matrix3d A;
      const Vec3 a = row(soup.V, soup.F(g, 0));
      A << q - p, a - row(soup.V, soup.F(g, 1)), a - row(soup.V, soup.F(g, 2));
      const Vec3 x = A.fullPivLu().solve(a - p);
      if (x[0] > 0 && x[0] < 1 && x[1] > 0 && x[2] > 0 && x[1] + x[2] < 1) return true;
    }
    return false;
  };
  std::int64_t pairs = 0;
  for (Eigen::Index f = 0; f < soup.F.rows(); ++f)
    for (Eigen::Index g = 0; g < f; ++g) pairs += crosses(f, g) || crosses(g, f);
  EXPECT_GT(pairs, 10);
  EXPECT_EQ(diagnose(soup).intersecting_pairs_sampled, pairs);
  const ThreadLimit one(1);
  EXPECT_EQ(diagnose(soup).intersecting_pairs_sampled, pairs);
}

TEST(Diagnosis, SamplesNoMoreFacesThanAsked) {
  const Mesh soup = random_soup(300, 0.08, 4);
  const Diagnosis some = diagnose(soup, {50, 1});
  EXPECT_EQ(some.intersection_faces_tested, 50);
  EXPECT_LT(some.intersecting_pairs_sampled, diagnose(soup).intersecting_pairs_sampled);
  EXPECT_EQ(some.intersecting_pairs_sampled, diagnose(soup, {50, 1}).intersecting_pairs_sampled);
}

TEST(Diagnosis, OfCloudsAndNothing) {
  Mesh cloud;
  cloud.V = random_points(30, 0, 1, 1);
  EXPECT_EQ(diagnose(cloud).components, 0);
  EXPECT_EQ(diagnose(cloud).unreferenced_vertices, 0);
  EXPECT_FALSE(diagnose(cloud).watertight);
  EXPECT_FALSE(diagnose(Mesh()).watertight);
}

TEST(Diagnosis, CanBeCancelled) {
  Progress progress;
  progress.cancelled = [] { return true; };
  EXPECT_THROW(diagnose(torus_mesh(1, 0.3), {}, progress), Cancelled);
}

}  // namespace
