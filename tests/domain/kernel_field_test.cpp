#include "skinfield/domain/kernel_field.h"

#include "domain/fixtures.h"
#include "skinfield/domain/interior_sampler.h"
#include "skinfield/geometry/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skinfield {
namespace {

using namespace skinfield_test;

Points samples_of(const std::vector<Handle>& handles) {
  std::vector<Vec3> all;
  for (const Handle& h : handles)
    for (const auto& [a, b] : h.segments)
      for (int k = 0; k <= 20; ++k) all.push_back(a + (b - a) * (k / 20.0));
  Points X(static_cast<Eigen::Index>(all.size()), 3);
  for (std::size_t i = 0; i < all.size(); ++i)
    X.row(static_cast<Eigen::Index>(i)) = all[i].transpose();
  return X;
}

struct Case {
  Solid solid;
  InteriorSampler sampler;
  KernelField field;
  Case(const Mesh& mesh, const Points& handles, int points, const KernelFieldOptions& options = {},
       const SolidOptions& rules = {})
      : solid(mesh, handles, rules),
        sampler(solid, 3),
        field(solid, sampler.spread({points / 4, points}, 3, {}), options) {}
};

const Case& ball() {
  static const Case c(sphere_mesh(0.5), Points::Zero(1, 3), 1000);
  return c;
}

TEST(KernelField, WeightsAreAPartitionOfUnityEverywhere) {
  for (const auto kernel :
       {KernelFieldOptions::Kernel::compact, KernelFieldOptions::Kernel::gaussian}) {
    KernelFieldOptions options;
    options.kernel = kernel;
    const Case c(sphere_mesh(0.5), Points::Zero(1, 3), 600, options);
    // Inside, on the surface, and far outside.
    const Points X = random_points(300, -0.9, 0.9, 4);
    std::vector<std::int32_t> seen;
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      const Vec3 x = row(X, i);
      c.field.see(c.field.points()[static_cast<std::size_t>(i)], c.field.radius(), seen);
      ASSERT_FALSE(seen.empty());
      std::vector<float> phi(seen.size());
      c.field.weights(x, seen, phi.data());
      EXPECT_GE(*std::min_element(phi.begin(), phi.end()), 0);
      EXPECT_NEAR(std::accumulate(phi.begin(), phi.end(), 0.0), 1, 1e-5);
    }
  }
}

TEST(KernelField, FollowsItsFormula) {
  const KernelField& field = ball().field;
  std::vector<std::int32_t> seen;
  const Vec3 x(0.05, 0.02, -0.1);
  field.near(x, field.radius(), seen);
  ASSERT_GT(seen.size(), 10u);
  std::vector<float> phi(seen.size());
  field.weights(x, seen, phi.data());
  std::vector<double> want;
  double sum = 0;
  for (const std::int32_t i : seen) {
    const double t =
        (field.points()[static_cast<std::size_t>(i)].x - x).norm() / (2.1 * field.sigma());
    want.push_back(std::pow(1 - t * t, 3));
    sum += want.back();
  }
  for (std::size_t k = 0; k < seen.size(); ++k)
    EXPECT_NEAR(static_cast<double>(phi[k]), want[k] / sum, 1e-6);
}

TEST(KernelField, SigmaIsTheMedianDistanceToTheNinthNeighbour) {
  const auto& points = ball().field.points();
  std::vector<double> ninth;
  for (const Site& p : points) {
    std::vector<double> d;
    for (const Site& q : points) d.push_back((p.x - q.x).norm());
    std::nth_element(d.begin(), d.begin() + 9, d.end());
    ninth.push_back(d[9]);
  }
  std::nth_element(ninth.begin(), ninth.begin() + static_cast<std::ptrdiff_t>(ninth.size() / 2),
                   ninth.end());
  EXPECT_NEAR(ball().field.sigma(), ninth[ninth.size() / 2], 1e-12);
}

TEST(KernelField, SeesWhatTheSolidSays) {
  const Case c(fork_mesh(0.02), samples_of(fork_bones(0.02)), 1500);
  const auto& points = c.field.points();
  std::vector<std::int32_t> seen;
  int blocked = 0;
  for (std::size_t i = 0; i < points.size(); i += 37) {
    c.field.see(points[i], 0.15, seen);
    std::vector<std::int32_t> want;
    for (std::size_t j = 0; j < points.size(); ++j) {
      if ((points[j].x - points[i].x).norm() >= 0.15) continue;
      if (c.solid.blocked(points[i], points[j]))
        ++blocked;
      else
        want.push_back(static_cast<std::int32_t>(j));
    }
    EXPECT_EQ(seen, want);
  }
  EXPECT_GT(blocked, 0);
}

TEST(KernelField, DoesNotLookAcrossAGap) {
  const double gap = 0.002;
  const Case c(fork_mesh(gap), samples_of(fork_bones(gap)), 1500);
  std::vector<std::int32_t> seen;
  const Site left = c.solid.site({0.1 - 1e-4, 0.7, 0.05});
  c.field.see(left, c.field.radius(), seen);
  ASSERT_FALSE(seen.empty());
  for (const std::int32_t i : seen)
    EXPECT_LT(c.field.points()[static_cast<std::size_t>(i)].x[0], 0.1 + 0.5 * gap);
}

TEST(KernelField, AnyHitCutsWhatTheCountingRuleJoins) {
  // Two boxes that overlap: their inner walls block under the paper's rule only.
  const Mesh boxes =
      together(box_mesh({0, 0, 0}, {0.6, 0.3, 0.3}), box_mesh({0.4, 0.01, 0.01}, {1, 0.29, 0.29}));
  const Points handles = samples_of({bone({0.1, 0.15, 0.15}, {0.9, 0.15, 0.15})});
  SolidOptions any_hit;
  any_hit.visibility = SolidOptions::Visibility::any_hit;
  const Solid counted(boxes, handles), paper(boxes, handles, any_hit);
  const Vec3 a(0.2, 0.15, 0.15), b(0.8, 0.15, 0.15), outside(0.5, 0.5, 0.5);
  EXPECT_FALSE(counted.blocked(counted.site(a), counted.site(b)));
  EXPECT_TRUE(paper.blocked(paper.site(a), paper.site(b)));
  EXPECT_TRUE(paper.inside(a));
  EXPECT_TRUE(paper.inside(b));
  EXPECT_FALSE(paper.inside(outside));
}

TEST(KernelField, WithoutVisibilityNothingBlocks) {
  const double gap = 0.02;
  const Mesh fork = fork_mesh(gap);
  SolidOptions open;
  open.visibility = SolidOptions::Visibility::none;
  const Points handles = samples_of(fork_bones(gap));
  const Solid solid(fork, handles), unmasked(fork, handles, open);
  // Across the gap, and what is inside stays what it was.
  const Vec3 a(0.1 - gap, 0.7, 0.05), b(0.1 + 2 * gap, 0.7, 0.05),
      between(0.1 + 0.5 * gap, 0.7, 0.05);
  EXPECT_TRUE(solid.blocked(solid.site(a), solid.site(b)));
  EXPECT_FALSE(unmasked.blocked(unmasked.site(a), unmasked.site(b)));
  for (const Vec3& x : {a, b, between}) EXPECT_EQ(solid.inside(x), unmasked.inside(x));
  double t = 1;
  unsigned char hit = 1;
  const Vec3 direction = Vec3::UnitX();
  unmasked.reach(unmasked.site(a), {&direction, 1}, {&t, 1}, {&hit, 1});
  EXPECT_EQ(t, 1);
  EXPECT_EQ(hit, 0);
}

TEST(KernelField, TheSameForPointsInAnyOrder) {
  std::vector<Site> points = ball().field.points();
  std::reverse(points.begin(), points.end());
  const KernelField again(ball().solid, points);
  EXPECT_EQ(again.sigma(), ball().field.sigma());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(again.points()[i].x, ball().field.points()[i].x);
}

TEST(InteriorSampler, SpreadsNestedPointsEvenly) {
  const std::vector<Site> points = ball().sampler.spread({200, 800}, 1, {});
  ASSERT_EQ(points.size(), 800u);
  const double volume = ball().sampler.volume();
  EXPECT_NEAR(volume, std::numbers::pi / 6, 0.02 * volume);
  for (const std::size_t count : {std::size_t{200}, std::size_t{800}}) {
    double nearest = 1e300;
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(ball().solid.inside(points[i]));
      for (std::size_t j = 0; j < i; ++j)
        nearest = std::min(nearest, (points[i].x - points[j].x).norm());
    }
    EXPECT_GT(nearest, 0.5 * std::cbrt(volume / static_cast<double>(count)));
  }
}

TEST(InteriorSamples, IntegrateWithoutBias) {
  const std::vector<std::pair<Vec3, Vec3>> segments{{Vec3(0, 0, -0.3), Vec3(0, 0, 0.2)},
                                                    {Vec3(0.2, 0, 0), Vec3(0.2, 0, 0)}};
  for (const double share : {0.0, 0.5}) {
    const InteriorSamples source(ball().sampler, ball().solid, segments, 0.1, share);
    double volume = 0, second = 0;
    int near = 0;
    const auto drawn = source.draw(20000, 5, 1000);
    for (const WeightedSite& s : drawn) {
      volume += s.weight;
      second += s.weight * s.site.x.squaredNorm();
      near += distance_to_segment(segments[0].first, segments[0].second, s.site.x) < 0.1;
      EXPECT_TRUE(ball().solid.inside(s.site));
    }
    EXPECT_NEAR(volume, std::numbers::pi / 6, 0.02);
    EXPECT_NEAR(second, 4 * std::numbers::pi / 5 * std::pow(0.5, 5), 0.004);
    if (share > 0) {
      EXPECT_GT(near, 5000);
    }
  }
}

}  // namespace
}  // namespace skinfield
