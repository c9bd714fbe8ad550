#include "skinfield/domain/grading.h"

#include "domain/fixtures.h"
#include "skinfield/domain/interior_sampler.h"
#include "skinfield/domain/kernel_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

using namespace skinfield_test;

/// A ball with a long bone and a short one.
const Grading::Segments& bones() {
  static const Grading::Segments segments{{Vec3(-0.4, 0, 0), Vec3(0.2, 0, 0)},
                                          {Vec3(0.3, 0.1, 0), Vec3(0.35, 0.1, 0)}};
  return segments;
}

struct GradedBall {
  Solid solid{sphere_mesh(0.5), Points::Zero(1, 3)};
  InteriorSampler sampler{solid, 3};
  GradedBall() {
    Points places(500, 3);
    for (Eigen::Index i = 0; i < places.rows(); ++i)
      places.row(i) = sampler.draw(1, static_cast<std::uint64_t>(i)).x;
    sampler.grade({bones(), places, 0.25}, 1);
  }
};

const GradedBall& ball() {
  static const GradedBall graded;
  return graded;
}

bool beside_short(const Vec3& x) { return (x - Vec3(0.325, 0.1, 0)).norm() < 0.08; }

TEST(Grading, NarrowBesideShortBonesAndSlowlyWider) {
  const Grading& grading = ball().sampler.grading();
  EXPECT_DOUBLE_EQ(grading.at({0.33, 0.1, 0}), 0.25);
  EXPECT_DOUBLE_EQ(grading.at({-0.45, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(grading.density({0.33, 0.1, 0}), 64);
  const Points X = random_points(200, -0.5, 0.5, 4);
  for (Eigen::Index i = 0; i + 1 < X.rows(); i += 2) {
    const Vec3 a = X.row(i).transpose(), b = X.row(i + 1).transpose();
    EXPECT_LE(std::abs(grading.at(a) - grading.at(b)), grading.slope() * (a - b).norm() + 1e-12);
  }
  EXPECT_TRUE(Grading().uniform());
  EXPECT_EQ(Grading().at({9, 9, 9}), 1);
  // Points alone ask for nothing.
  EXPECT_TRUE(Grading({{Vec3::Zero(), Vec3::Zero()}}, X, 0.25).uniform());
}

TEST(Grading, SamplesIntegrateWithoutBias) {
  for (const double share : {0.0, 0.5}) {
    const InteriorSamples source(ball().sampler, ball().solid, bones(), 0.1, share);
    double volume = 0, second = 0;
    int beside = 0;
    for (const WeightedSite& s : source.draw(40000, 5, 1000)) {
      volume += s.weight;
      second += s.weight * s.site.x.squaredNorm();
      beside += beside_short(s.site.x);
    }
    EXPECT_NEAR(volume, ball().sampler.volume(), 0.01);
    EXPECT_NEAR(second, 4 * std::numbers::pi / 5 * std::pow(0.5, 5), 0.004);
    // Uniformly they would be 160.
    EXPECT_GT(beside, 1000);
  }
}

TEST(Grading, PointsAreDenserBesideShortBonesAndKernelsNarrower) {
  const std::vector<Site> points = ball().sampler.spread({500, 2000}, 2, {});
  ASSERT_EQ(points.size(), 2000u);
  int beside = 0;
  for (const Site& p : points) beside += beside_short(p.x);
  EXPECT_GT(beside, 80) << "uniformly they would be 8";
  const KernelField field(ball().solid, points, {}, ball().sampler.grading());
  // Everywhere the kernels of about as many points reach, and weights are a partition of unity.
  const Points X = random_points(100, -0.25, 0.25, 6);
  std::vector<std::int32_t> seen;
  for (Eigen::Index i = 0; i <= X.rows(); ++i) {
    const Vec3 x = i < X.rows() ? Vec3(X.row(i).transpose()) : Vec3(0.325, 0.1, 0);
    field.see(ball().solid.site(x), field.radius(), seen);
    EXPECT_GT(seen.size(), 15u) << x.transpose();
    EXPECT_LT(seen.size(), 200u) << x.transpose();
    std::vector<float> phi(seen.size());
    field.weights(x, seen, phi.data());
    float sum = 0;
    for (const float p : phi) {
      EXPECT_GE(p, 0);
      sum += p;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

}  // namespace
}  // namespace skinfield
