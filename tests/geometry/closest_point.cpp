#include "skinfield/geometry/closest_point.h"

#include "geometry/shapes.h"

#include <gtest/gtest.h>

#include <limits>

using namespace skinfield_test;

namespace {

/// The plane of every face and all its edges.
double brute_distance(const Mesh& mesh, const Vec3& x) {
  double best = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const Vec3 a = row(mesh.V, mesh.F(f, 0)), b = row(mesh.V, mesh.F(f, 1)),
               c = row(mesh.V, mesh.F(f, 2));
    for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      best = std::min(best, distance_to_segment(p, q, x));
    Eigen::Matrix<double, 3, 2> E;
    E << b - a, c - a;
    const Eigen::Vector2d uv = E.colPivHouseholderQr().solve(x - a);
    if (uv.minCoeff() >= 0 && uv.sum() <= 1) best = std::min(best, (a + E * uv - x).norm());
  }
  return best;
}

TEST(ClosestPoint, AgreesWithEveryFaceAskedInTurn) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Mesh soup = random_soup(150, 0.05 + 0.1 * static_cast<double>(seed), seed);
    const ClosestPointQuery query(soup.V, soup.F);
    const Points X = random_points(100, -0.5, 1.5, seed);
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      const Vec3 x = row(X, i);
      const ClosestPoint found = query.at(x);
      EXPECT_NEAR(found.distance, brute_distance(soup, x), 1e-12);
      EXPECT_NEAR((found.point - x).norm(), found.distance, 1e-12);
      Vec3 from_corners = Vec3::Zero();
      for (int k = 0; k < 3; ++k)
        from_corners += found.barycentric[k] * row(soup.V, soup.F(found.face, k));
      EXPECT_LT((from_corners - found.point).norm(), 1e-12);
      EXPECT_NEAR(found.barycentric.sum(), 1, 1e-12);
      EXPECT_GE(found.barycentric.minCoeff(), 0);
    }
  }
}

TEST(ClosestPoint, DistanceToASphereIsKnown) {
  const Mesh sphere = sphere_mesh(1, 60);
  const ClosestPointQuery query(sphere.V, sphere.F);
  for (int i = 0; i < 50; ++i) {
    const Vec3 d = Random(1, i).direction();
    EXPECT_NEAR(query.at(2.5 * d).distance, 1.5, 3e-3);
    EXPECT_NEAR(query.at(0.5 * d).distance, 0.5, 3e-3);
  }
}

TEST(ClosestPoint, ReachIsRespectedAndNothingIsFoundInNothing) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const ClosestPointQuery query(box.V, box.F);
  EXPECT_EQ(query.at({0.5, 0.5, 2}, 0.99).face, -1);
  EXPECT_GE(query.at({0.5, 0.5, 2}, 1.01).face, 0);
  EXPECT_EQ(ClosestPointQuery(Points(0, 3), Triangles(0, 3)).at({0, 0, 0}).face, -1);
}

TEST(ClosestPoint, FacesWithoutAreaAreSegmentsOrPoints) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {1, 1, 1}});
  const ClosestPointQuery query(mesh.V, mesh.F);
  EXPECT_NEAR(query.at({1.5, 1, 0}).distance, 1, 1e-15);
  EXPECT_NEAR(query.at({3, 0, 0}).distance, 1, 1e-15);
}

TEST(ClosestPoint, OfTwoEqualFacesTheFirst) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}, {0, 1, 2}});
  EXPECT_EQ(ClosestPointQuery(mesh.V, mesh.F).at({0.2, 0.2, 1}).face, 0);
}

TEST(Segment, ClosestParameterIsClamped) {
  EXPECT_EQ(closest_on_segment({0, 0, 0}, {2, 0, 0}, {-1, 1, 0}), 0);
  EXPECT_EQ(closest_on_segment({0, 0, 0}, {2, 0, 0}, {5, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(closest_on_segment({0, 0, 0}, {2, 0, 0}, {0.5, 1, 0}), 0.25);
  EXPECT_DOUBLE_EQ(distance_to_segment({1, 1, 1}, {1, 1, 1}, {1, 1, 3}), 2);
}

}  // namespace
