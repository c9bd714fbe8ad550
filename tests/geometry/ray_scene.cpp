#include "skinfield/geometry/ray_scene.h"

#include "geometry/shapes.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/winding_number.h"

#include <gtest/gtest.h>

using namespace skinfield_test;

namespace {

double sum_of_signs(const std::vector<RayHit>& hits) {
  double sum = 0;
  for (const RayHit& hit : hits) sum += hit.sign;
  return sum;
}

TEST(RayScene, CrossingsAddUpToTheWindingDifference) {
  const Mesh torus = torus_mesh(0.35, 0.13);
  const RayScene scene(torus.V, torus.F);
  const Points X = random_points(2000, -0.5, 0.5, 1);
  std::vector<RayHit> hits;
  for (Eigen::Index i = 0; i + 1 < X.rows(); i += 2) {
    const Vec3 a = row(X, i), b = row(X, i + 1);
    scene.all_hits(a, b, hits);
    const double difference = std::round(winding_number_direct(torus.V, torus.F, b)) -
                              std::round(winding_number_direct(torus.V, torus.F, a));
    EXPECT_EQ(sum_of_signs(hits), difference);
    EXPECT_EQ(scene.occluded(a, b), !hits.empty());
    for (const RayHit& hit : hits) {
      const Vec3 p = (1 - hit.u - hit.v) * row(torus.V, torus.F(hit.face, 0)) +
                     hit.u * row(torus.V, torus.F(hit.face, 1)) +
                     hit.v * row(torus.V, torus.F(hit.face, 2));
      EXPECT_LT((p - (a + hit.t * (b - a))).norm(), 1e-5);
    }
  }
}

TEST(RayScene, CrossingsThroughEdgesAndCornersCountOnce) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const RayScene scene(box.V, box.F);
  std::vector<RayHit> hits;
  const Vec3 inside(0.5, 0.5, 0.5);
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {  // face diagonals, edges and corners all lie this way
        if (x == 0 && y == 0 && z == 0) continue;
        scene.all_hits(inside, inside + Vec3(x, y, z), hits);
        EXPECT_EQ(sum_of_signs(hits), -1) << x << ' ' << y << ' ' << z;
        scene.all_hits(inside - Vec3(x, y, z), inside + Vec3(x, y, z), hits);
        EXPECT_EQ(sum_of_signs(hits), 0) << x << ' ' << y << ' ' << z;
      }
  // Along a silhouette edge and through a corner from outside nothing changes in total.
  scene.all_hits({-1, 0.5, 1}, {1, 0.5, 3}, hits);
  EXPECT_EQ(sum_of_signs(hits), 0);
  scene.all_hits({0, 0, 2}, {2, 2, 0}, hits);
  EXPECT_EQ(sum_of_signs(hits), 0);
}

TEST(RayScene, CrossingsThroughEveryCornerOfAFineMeshAddUp) {
  const Mesh sphere = sphere_mesh(0.5, 16, 0.1);
  const RayScene scene(sphere.V, sphere.F);
  std::vector<RayHit> hits;
  const Vec3 inside(0.01, 0.02, 0.03);
  for (Eigen::Index i = 0; i < sphere.V.rows(); ++i) {
    scene.all_hits(inside, inside + 3 * (row(sphere.V, i) - inside), hits);
    EXPECT_EQ(sum_of_signs(hits), -1) << i;
  }
  for (Eigen::Index f = 0; f < sphere.F.rows(); ++f) {
    const Vec3 middle = (row(sphere.V, sphere.F(f, 0)) + row(sphere.V, sphere.F(f, 1))) / 2;
    scene.all_hits(inside, inside + 3 * (middle - inside), hits);
    EXPECT_EQ(sum_of_signs(hits), -1) << f;
  }
}

TEST(RayScene, AllHitsAreSortedAndDuplicatesAllReported) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-9}, {1, 0, 1e-9}, {0, 1, 1e-9}},
                        {{0, 1, 2}, {3, 4, 5}, {0, 1, 2}, {2, 1, 0}});
  const RayScene scene(mesh.V, mesh.F);
  std::vector<RayHit> hits;
  scene.all_hits({0.2, 0.3, 1}, {0.2, 0.3, -1}, hits);
  ASSERT_EQ(hits.size(), 4u);
  EXPECT_EQ(hits[0].face, 1);  // a billionth above: below single precision
  EXPECT_EQ(hits[1].face, 0);
  EXPECT_EQ(hits[2].face, 2);
  EXPECT_EQ(hits[3].face, 3);
  EXPECT_EQ(hits[0].sign, 1);
  EXPECT_EQ(hits[3].sign, -1);
}

TEST(RayScene, FirstHitKnowsDistanceFaceAndSide) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const RayScene scene(box.V, box.F);
  const RayHit in = scene.first_hit({0.3, 0.4, -1}, {0, 0, 2}, 0, 10);
  ASSERT_TRUE(in);
  EXPECT_NEAR(in.t, 0.5, 1e-6);
  EXPECT_LT(in.face, 2);
  EXPECT_EQ(in.sign, 1);
  const RayHit out = scene.first_hit({0.3, 0.4, 0.5}, {0, 0, 1}, 0, 10);
  ASSERT_TRUE(out);
  EXPECT_NEAR(out.t, 0.5, 1e-6);
  EXPECT_EQ(out.sign, -1);
  EXPECT_FALSE(scene.first_hit({0.3, 0.4, 0.5}, {0, 0, 1}, 0, 0.4));
  EXPECT_FALSE(scene.first_hit({0.3, 0.4, 0.5}, {0, 0, 1}, 0.6, 10));
  EXPECT_FALSE(scene.first_hit({2, 2, 2}, {0, 0, 1}, 0, 10));
}

TEST(RayScene, SkippedEndsDoNotBlock) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const RayScene scene(box.V, box.F);
  const Vec3 on(0.3, 0.4, 1), inside(0.3, 0.4, 0.5), outside(0.3, 0.4, 1.2);
  EXPECT_FALSE(scene.occluded(on, inside, 1e-4, 0));
  EXPECT_FALSE(scene.occluded(inside, on, 0, 1e-4));
  EXPECT_TRUE(scene.occluded(inside, outside, 1e-4, 1e-4));
  EXPECT_FALSE(scene.occluded(inside, outside, 0, 0.25));
  EXPECT_FALSE(scene.occluded(inside, inside));
  EXPECT_FALSE(scene.occluded(inside, outside, 1, 1));
}

TEST(RayScene, ManyAtOnceAreTheSameAsOneByOne) {
  const Mesh soup = random_soup(400, 0.05, 3);
  const RayScene scene(soup.V, soup.F);
  const Points X = random_points(333, 0, 1, 2);
  std::vector<Vec3> targets, directions;
  std::vector<double> reach;
  const Vec3 origin(0.5, 0.4, 0.6);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    targets.push_back(row(X, i));
    directions.push_back(row(X, i) - origin);
    reach.push_back(0.2 + 0.01 * static_cast<double>(i));
  }
  std::vector<unsigned char> blocked(targets.size());
  std::vector<RayHit> hits(targets.size());
  scene.occluded(origin, targets, blocked);
  scene.first_hits(origin, directions, reach, hits);
  int found = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    EXPECT_EQ(blocked[i] != 0, scene.occluded(origin, targets[i])) << i;
    const RayHit one = scene.first_hit(origin, directions[i], 0, reach[i]);
    EXPECT_EQ(hits[i].face, one.face) << i;
    if (one) {
      EXPECT_NEAR(hits[i].t, one.t, 1e-6);
    }
    found += static_cast<bool>(one);
  }
  EXPECT_GT(found, 20);
}

TEST(RayScene, DegenerateFacesKeepTheirNumbers) {
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 0, std::nan("")}},
                        {{0, 0, 1}, {0, 1, 3}, {0, 1, 4}, {0, 1, 2}});
  const RayScene scene(mesh.V, mesh.F);
  EXPECT_FALSE(scene.empty());
  EXPECT_EQ(scene.first_hit({0.2, 0.2, 1}, {0, 0, -1}, 0, 5).face, 3);
  EXPECT_TRUE(RayScene(mesh.V, mesh.F.topRows(3)).empty());
  const RayScene nothing(Points(0, 3), Triangles(0, 3));
  EXPECT_TRUE(nothing.empty());
  EXPECT_FALSE(nothing.occluded({0, 0, 0}, {1, 1, 1}));
  EXPECT_FALSE(nothing.first_hit({0, 0, 0}, {1, 1, 1}, 0, 1));
}

TEST(RayScene, UnitsAndPlaceDoNotMatter) {
  const Mesh torus = torus_mesh(0.35, 0.13);
  const RayScene scene(torus.V, torus.F);
  const Vec3 away(1e4, -3e4, 2e4);
  const RayScene far(1e3 * (torus.V.rowwise() + away.transpose()), torus.F);
  const Points X = random_points(400, -0.5, 0.5, 6);
  std::vector<RayHit> hits, moved;
  for (Eigen::Index i = 0; i + 1 < X.rows(); i += 2) {
    scene.all_hits(row(X, i), row(X, i + 1), hits);
    far.all_hits(1e3 * (row(X, i) + away), 1e3 * (row(X, i + 1) + away), moved);
    EXPECT_EQ(hits.size(), moved.size());
  }
}

TEST(RayScene, TiesFallTheSameWayAtAnyThreadCount) {
  Mesh mesh = torus_mesh(0.35, 0.13, 160, 80);
  const Eigen::Index f = mesh.F.rows();
  mesh.F.conservativeResize(2 * f, 3);
  mesh.F.bottomRows(f) = mesh.F.topRows(f).eval();
  const auto shoot = [&] {
    const RayScene scene(mesh.V, mesh.F);
    std::vector<int> faces;
    for (int i = 0; i < 500; ++i)
      faces.push_back(scene.first_hit({0.35, 0, 0}, Random(1, i).direction(), 0, 1).face);
    return faces;
  };
  const std::vector<int> many = shoot();
  const ThreadLimit one(1);
  EXPECT_EQ(many, shoot());
}

}  // namespace
