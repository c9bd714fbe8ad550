#include "skinfield/rig/handle_geometry.h"

#include "rig/fixtures.h"
#include "skinfield/base/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

Handle bone(const Vec3& a, const Vec3& b) {
  Handle handle;
  handle.segments = {{a, b}};
  return handle;
}

Handle point(const Vec3& x) {
  Handle handle;
  handle.kind = Handle::Kind::point;
  handle.point = x;
  return handle;
}

TEST(SampleHandle, CoversSegmentsWithBothEnds) {
  Handle handle = bone({0, 0, 0}, {1, 0, 0});
  handle.segments.push_back({{0, 0, 0}, {0, 0.35, 0}});
  const Points samples = sample_handle(handle, 0.1);
  EXPECT_EQ(samples.rows(), 11 + 4);  // the common head once
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    EXPECT_NEAR(handle_distance(handle, samples.row(i).transpose()), 0, 1e-15);
    double nearest = 1;
    for (Eigen::Index k = 0; k < samples.rows(); ++k) {
      if (k != i) nearest = std::min(nearest, (samples.row(i) - samples.row(k)).norm());
    }
    EXPECT_LE(nearest, 0.1 + 1e-12);
  }
  EXPECT_EQ(samples.row(10), Eigen::RowVector3d(1, 0, 0));
  EXPECT_THROW(sample_handle(handle, 0), InputError);
}

TEST(SampleHandle, KnowsPointsAndRegions) {
  EXPECT_EQ(sample_handle(point({1, 2, 3}), 0.1), Eigen::RowVector3d(1, 2, 3));
  Points V(2, 3);
  V << 0, 0, 0, 4, 0, 0;
  Handle region;
  region.kind = Handle::Kind::region;
  region.vertices = {1};
  EXPECT_EQ(sample_handle(region, 0.1, V), V.row(1));
  EXPECT_EQ(handle_distance(region, Vec3(4, 3, 0), V), 3);
  EXPECT_TRUE(std::isinf(handle_distance(region, Vec3(4, 3, 0))));
  region.vertices = {2};
  EXPECT_THROW(sample_handle(region, 0.1, V), InputError);
}

TEST(HandleDistance, IsThatOfTheNearestSegment) {
  Handle handle = bone({0, 0, 0}, {2, 0, 0});
  handle.segments.push_back({{0, 0, 0}, {0, 2, 0}});
  EXPECT_DOUBLE_EQ(handle_distance(handle, {1, 0, 3}), 3);
  EXPECT_DOUBLE_EQ(handle_distance(handle, {0.5, 2, 0}), 0.5);
  EXPECT_DOUBLE_EQ(handle_distance(point({1, 0, 0}), {1, 0, -2}), 2);
}

TEST(ClassifyHandle, TellsInsidePartlyAndOutsideOfASphere) {
  const Mesh mesh = skinfield_test::sphere();
  const WindingNumber winding(mesh.V, mesh.F);
  EXPECT_EQ(classify_handle(bone({-0.5, 0, 0}, {0.5, 0.2, 0}), winding), HandlePlace::inside);
  EXPECT_EQ(classify_handle(bone({0, 0, 0}, {0, 0, 1}), winding), HandlePlace::inside);
  EXPECT_EQ(classify_handle(bone({0, 0, 0}, {2, 0, 0}), winding), HandlePlace::partly);
  EXPECT_EQ(classify_handle(bone({2, 0, 0}, {3, 0, 0}), winding), HandlePlace::outside);
  EXPECT_EQ(classify_handle(point({0.3, 0, 0}), winding), HandlePlace::inside);
  EXPECT_EQ(classify_handle(point({0, 1.3, 0}), winding), HandlePlace::outside);
}

TEST(InsidePart, IsBisectedToTheSurface) {
  const InsideTest ball = [](const Vec3& x) { return x.norm() < 1; };
  const HandleInside through = inside_part(bone({-2, 0.6, 0}, {3, 0.6, 0}), ball);
  ASSERT_EQ(through.segments.size(), 1u);
  EXPECT_NEAR(through.segments[0].first[0], -0.8, 1e-9);
  EXPECT_NEAR(through.segments[0].second[0], 0.8, 1e-9);
  EXPECT_NEAR(through.fraction, 1.6 / 5, 1e-9);

  const InsideTest two = [](const Vec3& x) { return std::abs(x[0]) > 1; };
  const HandleInside gap = inside_part(bone({-2, 0, 0}, {2, 0, 0}), two);
  ASSERT_EQ(gap.segments.size(), 2u);
  EXPECT_EQ(gap.segments[0].first, Vec3(-2, 0, 0));
  EXPECT_NEAR(gap.segments[0].second[0], -1, 1e-9);
  EXPECT_EQ(gap.segments[1].second, Vec3(2, 0, 0));
  EXPECT_EQ(gap.place, HandlePlace::partly);
}

}  // namespace
}  // namespace skinfield
