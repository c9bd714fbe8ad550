// Solids of the plane: inside, and what sees what, for outlines, flat triangles and soups of
// segments.
#include "domain/fixtures.h"
#include "skinfield/domain/field_conditions.h"
#include "skinfield/domain/interior_sampler.h"
#include "support/outlines.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

using namespace skinfield_test;

Solid planar(const Mesh& mesh, const std::vector<Vec3>& handles,
             SolidOptions::Visibility visibility = SolidOptions::Visibility::counted) {
  Points samples(static_cast<Eigen::Index>(handles.size()), 3);
  for (std::size_t k = 0; k < handles.size(); ++k)
    samples.row(static_cast<Eigen::Index>(k)) = handles[k].transpose();
  SolidOptions options;
  options.planar = true;
  options.visibility = visibility;
  return Solid(mesh, samples, options);
}

Loop square(double low, double high) {
  return {{low, low}, {high, low}, {high, high}, {low, high}};
}

Loop backwards(Loop loop) {
  std::reverse(loop.begin(), loop.end());
  return loop;
}

TEST(PlanarSolid, HolesAreOutsideHoweverLoopsAreDrawn) {
  for (const bool turn_outer : {false, true})
    for (const bool turn_hole : {false, true}) {
      const Loop outer = square(0, 1), hole = square(0.4, 0.6);
      const Solid solid = planar(
          outline_of({turn_outer ? backwards(outer) : outer, turn_hole ? backwards(hole) : hole}),
          {{0.2, 0.2, 0}});
      EXPECT_EQ(solid.dimension(), 2);
      EXPECT_TRUE(solid.inside(Vec3(0.2, 0.5, 0)));
      EXPECT_FALSE(solid.inside(Vec3(0.5, 0.5, 0)));
      EXPECT_FALSE(solid.inside(Vec3(1.1, 0.5, 0)));
      EXPECT_TRUE(solid.blocked(solid.site({0.2, 0.5, 0}), solid.site({0.8, 0.5, 0})));
      EXPECT_FALSE(solid.blocked(solid.site({0.2, 0.2, 0}), solid.site({0.8, 0.2, 0})));
      EXPECT_NEAR(solid.site({0.2, 0.5, 0}).clearance, 0.2, 1e-12);
      EXPECT_NEAR(InteriorSampler(solid, 1).volume(), 1 - 0.04, 2e-3);
      // Outward at the rim, and into the hole.
      for (Eigen::Index v = 0; v < 8; ++v) {
        const Vec3 from_middle = Vec3(solid.vertices().row(v).transpose()) - Vec3(0.5, 0.5, 0);
        const double along = solid.normals().row(v).dot(from_middle.normalized());
        EXPECT_NEAR(along, v < 4 ? 1 : -1, 1e-12);
      }
    }
}

TEST(PlanarSolid, ALoopThatCrossesItselfHasBothItsLobes) {
  const Solid solid = planar(outline_of({{{0, 0}, {1, 1}, {1, 0}, {0, 1}}}), {{0.1, 0.5, 0}});
  EXPECT_EQ(solid.vertices().rows(), 5) << "the crossing";
  EXPECT_TRUE(solid.inside(Vec3(0.2, 0.5, 0)));
  EXPECT_TRUE(solid.inside(Vec3(0.8, 0.5, 0)));
  EXPECT_FALSE(solid.inside(Vec3(0.5, 0.8, 0)));
  EXPECT_FALSE(solid.inside(Vec3(0.5, 0.2, 0)));
  EXPECT_NEAR(InteriorSampler(solid, 1).volume(), 0.5, 2e-3);
}

TEST(PlanarSolid, ShapesThatOverlapAreOne) {
  Mesh mesh = outline_of({square(0, 0.6), square(0.4, 1)});
  for (Eigen::Index e = 0; e < mesh.outline.E.rows(); ++e)
    mesh.outline.shape[static_cast<std::size_t>(e)] = e >= 4;
  const Solid solid = planar(mesh, {{0.2, 0.2, 0}});
  EXPECT_TRUE(solid.inside(Vec3(0.5, 0.5, 0)));
  EXPECT_FALSE(solid.blocked(solid.site({0.2, 0.2, 0}), solid.site({0.8, 0.8, 0})));
  EXPECT_TRUE(solid.blocked(solid.site({0.55, 0.1, 0}), solid.site({0.9, 0.45, 0})));
  EXPECT_NEAR(InteriorSampler(solid, 1).volume(), 2 * 0.36 - 0.04, 2e-3);
  const Solid paper = planar(mesh, {{0.2, 0.2, 0}}, SolidOptions::Visibility::any_hit);
  EXPECT_TRUE(paper.blocked(paper.site({0.2, 0.2, 0}), paper.site({0.8, 0.8, 0})));
}

TEST(PlanarSolid, FlatTrianglesAreTheirRim) {
  Mesh mesh;
  mesh.V.resize(6, 3);
  mesh.V << 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0;
  mesh.F.resize(4, 3);
  mesh.F << 0, 1, 4, 0, 3, 4, 1, 2, 5, 1, 4, 5;  // whichever way round
  const Solid solid = planar(mesh, {{0.5, 0.5, 0}}),
              outline = planar(outline_of({square(0, 1)}), {});
  EXPECT_EQ(solid.faces().rows(), 6);
  Random random(1);
  for (int k = 0; k < 300; ++k) {
    const Vec3 x(3 * random.uniform() - 0.5, 2 * random.uniform() - 0.5, 0);
    EXPECT_EQ(solid.inside(x), x.x() > 0 && x.x() < 2 && x.y() > 0 && x.y() < 1);
    const Vec3 half(0.5 * x.x(), x.y(), 0);
    EXPECT_EQ(solid.inside(x), outline.inside(half));
  }
}

TEST(PlanarSolid, SiteNearAgreesWithSite) {
  const Solid solid = planar(outline_of({fork_loop(0.01)}, 0.05), {{0.1, 0.5, 0}});
  Random random(5);
  for (int k = 0; k < 300; ++k) {
    const Vec3 a(0.5 * random.uniform(), random.uniform(), 0);
    const Vec3 b(0.5 * random.uniform(), random.uniform(), 0);
    EXPECT_EQ(solid.site_near(solid.site(a), b).winding, solid.site(b).winding);
    EXPECT_EQ(solid.blocked(solid.site(a), solid.site(b)),
              solid.blocked(solid.site(b), solid.site(a)));
  }
}

TEST(PlanarSolid, ThinSlitsBlock) {
  for (const double gap : {0.02, 1e-3, 1e-5}) {
    const Solid solid = planar(outline_of({fork_loop(gap)}), {{0.1, 0.5, 0}});
    EXPECT_TRUE(solid.blocked(solid.site({0.15, 0.8, 0}), solid.site({0.25 + gap, 0.8, 0})));
    EXPECT_FALSE(solid.blocked(solid.site({0.15, 0.15, 0}), solid.site({0.25 + gap, 0.15, 0})));
  }
}

TEST(PlanarSolid, ASoupHasNearlyTheInsideOfItsOutline) {
  const Mesh whole = outline_of({square(0, 1)}, 0.04);
  std::vector<Vec3> handles;
  for (int k = 1; k < 20; ++k) handles.emplace_back(0.05 * k, 0.5, 0);
  for (const bool clockwise : {false, true}) {
    Mesh soup = segment_soup(whole, 0.3, 0.003, 7);
    if (clockwise) soup.outline.loose = soup.outline.loose.rowwise().reverse().eval();
    const Solid solid = planar(soup, handles);
    EXPECT_TRUE(solid.has_dirty());
    EXPECT_FALSE(solid.has_clean());
    int wrong = 0, judged = 0;
    Random random(2);
    for (int k = 0; k < 1000; ++k) {
      const Vec3 x(1.4 * random.uniform() - 0.2, 1.4 * random.uniform() - 0.2, 0);
      const double depth = std::min(std::min(x.x(), 1 - x.x()), std::min(x.y(), 1 - x.y()));
      if (std::abs(depth) < 0.04) continue;
      ++judged;
      wrong += solid.inside(x) != (depth > 0);
    }
    EXPECT_LT(wrong, judged / 100);
    EXPECT_FALSE(solid.blocked(solid.site({0.1, 0.1, 0}), solid.site({0.9, 0.9, 0})));
    EXPECT_NEAR(InteriorSampler(solid, 1).volume(), 1, 0.05);
  }
}

TEST(PlanarSolid, SamplesAreSpreadAndWeightedByArea) {
  const Mesh mesh = outline_of({square(0, 1), square(0.4, 0.6)});
  const Solid solid = planar(mesh, {{0.2, 0.2, 0}});
  const InteriorSampler sampler(solid, 1);
  const std::vector<Site> points = sampler.spread({100, 400}, 1, {});
  ASSERT_EQ(points.size(), 400u);
  const auto nearest = [&](std::size_t count) {
    double least = 1e9;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < i; ++j)
        least = std::min(least, (points[i].x - points[j].x).norm());
    return least;
  };
  EXPECT_GT(nearest(100), 0.5 * std::sqrt(0.96 / 100));
  EXPECT_GT(nearest(400), 0.5 * std::sqrt(0.96 / 400));
  for (const Site& s : points) EXPECT_EQ(s.x.z(), 0);
  const InteriorSamples::Segments bones{{{0.1, 0.2, 0}, {0.9, 0.2, 0}}};
  const InteriorSamples source(sampler, solid, bones, 0.1, 0.5);
  double area = 0, moment = 0;
  for (const WeightedSite& s : source.draw(20000, 1, 0))
    area += s.weight, moment += s.weight * s.site.x.y();
  EXPECT_NEAR(area, 0.96, 0.02);
  EXPECT_NEAR(moment, 0.48, 0.01);
}

}  // namespace
}  // namespace skinfield
