#include "skinfield/geometry/normals.h"

#include "geometry/shapes.h"
#include "skinfield/geometry/winding_number.h"

#include <gtest/gtest.h>

using namespace skinfield_test;

namespace {

Points sphere_points(int count, const Vec3& centre, double radius, std::uint64_t seed) {
  Points P(count, 3);
  for (int i = 0; i < count; ++i)
    P.row(i) = (centre + radius * Random(seed, i).direction()).transpose();
  return P;
}

TEST(PointNormals, OfASphereAreItsRadii) {
  const Points P = sphere_points(2000, {1, 2, 3}, 2, 1);
  for (const Points& inside : {Points(0, 3), Points(Eigen::RowVector3d(1, 2, 3.5))}) {
    const Points N = estimate_point_normals(P, inside);
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
      EXPECT_NEAR(N.row(i).norm(), 1, 1e-12);
      EXPECT_GT(row(N, i).dot((row(P, i) - Vec3(1, 2, 3)) / 2), 0.95);
    }
  }
}

TEST(PointNormals, OfTwoApartAndOfATorus) {
  const Mesh torus = torus_mesh(1, 0.35, 90, 40);
  Points P(torus.V.rows() + 800, 3);
  P << torus.V, sphere_points(800, {4, 0, 0}, 0.5, 3);
  const Points inside{{1, 0, 0}, {-1, 0, 0}, {4, 0, 0}};
  const Points N = estimate_point_normals(P, inside);
  const Points expected = vertex_normals(torus.V, torus.F);
  for (Eigen::Index i = 0; i < torus.V.rows(); ++i) EXPECT_GT(N.row(i).dot(expected.row(i)), 0.95);
  for (Eigen::Index i = torus.V.rows(); i < P.rows(); ++i)
    EXPECT_GT(row(N, i).dot(row(P, i) - Vec3(4, 0, 0)), 0.45);
}

TEST(PointNormals, CopiesOfAPointShareIt) {
  Points P(600, 3);
  P << sphere_points(300, {0, 0, 0}, 1, 4), sphere_points(300, {0, 0, 0}, 1, 4);
  const Points N = estimate_point_normals(P, Points(0, 3));
  EXPECT_EQ(N.topRows(300), N.bottomRows(300));
  EXPECT_GT(N.row(5).dot(P.row(5)), 0.8);
}

TEST(PointAreas, AddUpToTheSurface) {
  const Points P = sphere_points(3000, {0, 0, 0}, 1, 5);
  EXPECT_NEAR(point_areas(P, P).sum() / (4 * std::numbers::pi), 1, 0.02);
  Points twice(P.rows() * 2, 3);
  twice << P, P;
  EXPECT_NEAR(point_areas(twice, twice).sum() / (4 * std::numbers::pi), 1, 0.02);
  EXPECT_GT(point_areas(P, P).minCoeff(), 0);
}

TEST(PointAreas, OfAGridAreItsCells) {
  Points P(400, 3);
  for (int i = 0; i < 400; ++i) P.row(i) << 0.1 * (i % 20), 0.1 * (i / 20), 0;
  const Points N = Eigen::RowVector3d(0, 0, 1).replicate(400, 1);
  const Vector area = point_areas(P, N);
  EXPECT_NEAR(area[10 * 20 + 10], 0.01, 1e-9);
  EXPECT_LT(area.maxCoeff(), 0.06);  // the corners, where nothing but the reach bounds the cell
}

TEST(PointAreas, MakeTheWindingNumberOne) {
  const Points P = sphere_points(3000, {0, 0, 0}, 1, 6);
  const Points N = estimate_point_normals(P, Points(0, 3));
  const WindingNumber w(P, N, point_areas(P, N));
  EXPECT_NEAR(w.at(Vec3(0.1, 0.2, 0.3)), 1, 0.03);
  EXPECT_NEAR(w.at(Vec3(1.5, 0.2, 0.3)), 0, 0.03);
}

}  // namespace
