#include "skinfield/geometry/segment_scene.h"

#include "support/outlines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

using namespace skinfield_test;

Mesh star(int points, std::uint64_t seed) {
  Random random(seed);
  Loop loop;
  for (int k = 0; k < 2 * points; ++k) {
    const double angle = std::numbers::pi * k / points;
    const double r = (k % 2 ? 0.2 : 0.45) + 0.05 * random.uniform();
    loop.emplace_back(0.5 + r * std::cos(angle), 0.5 + r * std::sin(angle));
  }
  return outline_of({loop}, 0.03);
}

Vec3 place(Random& random) {
  return {1.4 * random.uniform() - 0.2, 1.4 * random.uniform() - 0.2, 0};
}

TEST(SegmentScene, FindsWhatTestingEverySegmentFinds) {
  Random random(3);
  Points V(400, 3);
  Segments E(200, 2);
  for (Eigen::Index v = 0; v < V.rows(); ++v) V.row(v) = place(random).transpose();
  for (Eigen::Index e = 0; e < E.rows(); ++e)
    E.row(e) << static_cast<int>(2 * e), static_cast<int>(2 * e + 1);
  const SegmentScene scene(V, E);
  std::vector<RayHit> hits;
  int found = 0;
  for (int k = 0; k < 500; ++k) {
    const Vec3 a = place(random), b = place(random), d = b - a;
    std::vector<std::pair<double, int>> wanted;
    for (Eigen::Index e = 0; e < E.rows(); ++e) {
      const Vec3 p = V.row(E(e, 0)).transpose(), r = V.row(E(e, 1)).transpose() - p;
      const double across = d.x() * r.y() - d.y() * r.x();
      const Vec3 f = p - a;
      const double t = (f.x() * r.y() - f.y() * r.x()) / across;
      const double s = (f.x() * d.y() - f.y() * d.x()) / across;
      if (t > 0 && t < 1 && s > 0 && s < 1) wanted.emplace_back(t, static_cast<int>(e));
    }
    std::sort(wanted.begin(), wanted.end());
    scene.all_hits(a, b, hits);
    ASSERT_EQ(hits.size(), wanted.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      EXPECT_EQ(hits[i].face, wanted[i].second);
      EXPECT_NEAR(hits[i].t, wanted[i].first, 1e-9);
      // Left of a segment is inside: crossing from the right enters.
      const Vec3 r = (V.row(E(hits[i].face, 1)) - V.row(E(hits[i].face, 0))).transpose();
      EXPECT_EQ(hits[i].sign, r.x() * d.y() - r.y() * d.x() > 0 ? 1 : -1);
    }
    EXPECT_EQ(scene.occluded(a, b), !hits.empty());
    const RayHit first = scene.first_hit(a, d.normalized(), d.norm());
    EXPECT_EQ(static_cast<bool>(first), !hits.empty());
    if (first) {
      EXPECT_EQ(first.face, hits.front().face);
      EXPECT_NEAR(first.t, hits.front().t * d.norm(), 1e-9);
    }
    found += static_cast<int>(hits.size());
  }
  EXPECT_GT(found, 1000);
}

TEST(SegmentScene, ClosedOutlinesWindOnceInsideAndNotOutside) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Mesh mesh = star(7, seed);
    const SegmentScene scene(mesh.V, mesh.outline.E);
    Random random(seed);
    int inside = 0;
    for (int k = 0; k < 500; ++k) {
      const Vec3 x = place(random);
      const double w = scene.winding(x);
      EXPECT_TRUE(w == 0 || w == 1);
      EXPECT_NEAR(w, winding_number_of_segments(mesh.V, mesh.outline.E, x), 1e-9);
      inside += w == 1;
    }
    EXPECT_GT(inside, 50);
    EXPECT_LT(inside, 300);
  }
}

TEST(SegmentScene, SignsAddUpToTheDifferenceOfWindingNumbers) {
  // On a grid, so that ways run through corners and along sides.
  const Mesh mesh =
      outline_of({{{0, 0}, {4, 0}, {4, 4}, {2, 3}, {0, 4}}, {{1, 1}, {1, 2}, {2, 2}, {2, 1}}}, 1);
  const SegmentScene scene(mesh.V, mesh.outline.E);
  std::vector<RayHit> hits;
  int through_corners = 0;
  for (int i = 0; i < 36; ++i)
    for (int j = 0; j < 36; ++j) {
      // Ends beside the grid's lines, ways of small whole steps between them.
      const Vec3 a(i % 6 - 0.5, i / 6 - 0.5, 0), b(j % 6 - 0.5, j / 6 - 0.5, 0);
      scene.all_hits(a, b, hits);
      double sum = 0;
      for (const RayHit& hit : hits) sum += hit.sign;
      EXPECT_EQ(sum, scene.winding(b) - scene.winding(a)) << i << " " << j;
      through_corners += i % 6 != j % 6 && i / 6 != j / 6;
    }
  EXPECT_GT(through_corners, 500);
}

TEST(SegmentScene, NothingInItBlocksNothing) {
  const SegmentScene none(Points(0, 3), Segments(0, 2));
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.occluded(Vec3::Zero(), Vec3::Ones()));
  EXPECT_EQ(none.winding(Vec3::Zero()), 0);
  EXPECT_FALSE(none.first_hit(Vec3::Zero(), Vec3::UnitX(), 1));
  Points V(2, 3);
  V << 1, 1, 0, 1, 1, 0;
  Segments E(1, 2);
  E << 0, 1;
  EXPECT_TRUE(SegmentScene(V, E).empty()) << "a segment of no length";
}

}  // namespace
}  // namespace skinfield
