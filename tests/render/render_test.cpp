#include "skinfield/render/render.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/render/colour.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

/// A latitude-longitude sphere around y, symmetric in x, y and z.
Mesh sphere(int rings, int around) {
  Mesh mesh;
  mesh.V.resize((rings - 1) * around + 2, 3);
  for (int i = 1; i < rings; ++i) {
    const double theta = std::numbers::pi * i / rings;
    for (int j = 0; j < around; ++j) {
      const double phi = 2 * std::numbers::pi * j / around;
      mesh.V.row((i - 1) * around + j) << std::sin(theta) * std::sin(phi), std::cos(theta),
          std::sin(theta) * std::cos(phi);
    }
  }
  const int north = (rings - 1) * around, south = north + 1;
  mesh.V.row(north) << 0, 1, 0;
  mesh.V.row(south) << 0, -1, 0;
  mesh.F.resize(2 * around * (rings - 1), 3);
  int f = 0;
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around, last = (rings - 2) * around;
    mesh.F.row(f++) << north, j, k;
    mesh.F.row(f++) << south, last + k, last + j;
    for (int i = 0; i + 2 < rings; ++i) {
      const int a = i * around, b = a + around;
      mesh.F.row(f++) << a + j, b + j, b + k;
      mesh.F.row(f++) << a + j, b + k, a + k;
    }
  }
  return mesh;
}

RenderOptions frontal(int size) {
  RenderOptions options;
  options.width = options.height = size;
  options.samples_per_side = 2;
  options.camera.yaw = options.camera.pitch = 0;
  return options;
}

int covered(const Image& image, Rgb8 background) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += image.at(x, y) != background;
  }
  return count;
}

TEST(Render, SphereIsRoundSymmetricAndLeavesTheBackground) {
  const Mesh mesh = sphere(48, 96);
  for (const double field_of_view : {0.0, 28.0}) {
    RenderOptions options = frontal(120);
    options.camera.field_of_view = field_of_view;
    const Image image = render_posed(mesh.V, mesh.F, {}, options);
    int asymmetric = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 120; ++x) {
        const bool here = image.at(x, y) != options.background;
        asymmetric += here != (image.at(119 - x, y) != options.background);
        asymmetric += here != (image.at(x, 119 - y) != options.background);
      }
    }
    EXPECT_LE(asymmetric, 8);  // rays that graze the silhouette, in single precision
    const double radius = 0.45 * 120;
    EXPECT_NEAR(covered(image, options.background), std::numbers::pi * radius * radius,
                0.04 * std::numbers::pi * radius * radius);
    EXPECT_EQ(image.at(0, 0), options.background);
    EXPECT_EQ(image.at(2, 60), options.background);
    EXPECT_NE(image.at(60, 60), options.background);
  }
}

TEST(Render, HeatMapHasTenBandsAndNineLines) {
  // A flat strip with weights from 0 to 1: along a row, a dark or light line at every tenth.
  Points V(4, 3);
  V << 0, 0, 0, 1, 0, 0, 1, 0.2, 0, 0, 0.2, 0;
  Triangles F(2, 3);
  F << 0, 1, 2, 0, 2, 3;
  Vector w(4);
  w << 0, 1, 1, 0;
  RenderOptions options = frontal(600);
  options.camera.field_of_view = 0;
  options.camera.margin = 0;
  const Image image = render_heat_map(V, F, w, options);
  int lines = 0;
  for (int k = 1; k <= 9; ++k) {
    const auto brightness = [&](int x) {
      const Rgb8 c = image.at(x, 300);
      return static_cast<int>(c[0]) + c[1] + c[2];
    };
    const int at = 60 * k;
    const int on = (brightness(at - 1) + brightness(at)) / 2;
    const int off = (brightness(at - 20) + brightness(at + 20)) / 2;
    lines += std::abs(on - off) > 40;
  }
  EXPECT_EQ(lines, 9);
  // A constant weight has no line anywhere.
  const Image plain = render_heat_map(V, F, Vector::Constant(4, 0.5), options);
  EXPECT_EQ(plain.at(100, 300), plain.at(500, 300));
}

TEST(Render, HeatMapFollowsTheColourMap) {
  double before = -1;
  for (int i = 0; i <= 20; ++i) {
    const Vec3 c = heat_colour(i / 20.0);
    const double luminance = 0.2126 * c.x() + 0.7152 * c.y() + 0.0722 * c.z();
    EXPECT_GT(luminance, before);
    before = luminance;
  }
  EXPECT_EQ(heat_colour(-1), heat_colour(0));
  EXPECT_EQ(heat_colour(2), heat_colour(1));
}

TEST(Render, NeighbouringBonesHaveDifferentColours) {
  for (int i = 0; i < 60; ++i) {
    for (int j = i + 1; j < i + 6; ++j) {
      EXPECT_GT((bone_colour(i) - bone_colour(j)).norm(), 0.05) << i << ' ' << j;
    }
  }
}

TEST(Render, SrgbRoundTrips) {
  for (int i = 0; i < 256; ++i) {
    const auto b = static_cast<std::uint8_t>(i);
    EXPECT_EQ(to_srgb(to_linear({b, 128, b})), (Rgb8{b, 128, b}));
  }
}

TEST(Render, OneAndManyThreadsGiveTheSameBytes) {
  const Mesh mesh = sphere(20, 40);
  SparseRows W(mesh.V.rows(), 2);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    W.insert(v, 0) = 0.5 + 0.5 * mesh.V(v, 1);
    W.insert(v, 1) = 0.5 - 0.5 * mesh.V(v, 1);
  }
  RenderOptions options = frontal(160);
  options.skeleton.bones = {{Vec3(0, -0.8, 0), Vec3(0, 0.8, 0)}};
  options.skeleton.dots = {Vec3(0, 0.8, 0)};
  options.caption = "sphere";
  const Image many = render_contact_sheet(mesh.V, mesh.F, W, {"top", "bottom"}, options);
  const Image many_dominant = render_dominant(mesh.V, mesh.F, W, options);
  const ThreadLimit one(1);
  EXPECT_EQ(render_contact_sheet(mesh.V, mesh.F, W, {"top", "bottom"}, options).rgb, many.rgb);
  EXPECT_EQ(render_dominant(mesh.V, mesh.F, W, options).rgb, many_dominant.rgb);
}

TEST(Render, SkeletonShinesThroughTheBody) {
  const Mesh mesh = sphere(24, 48);
  RenderOptions options = frontal(200);
  const Image without = render_posed(mesh.V, mesh.F, {}, options);
  options.skeleton.bones = {{Vec3(0, -0.8, 0), Vec3(0, 0.8, 0)}};
  const Image with = render_posed(mesh.V, mesh.F, {}, options);
  EXPECT_NE(with.at(100, 140), without.at(100, 140));
  EXPECT_EQ(with.at(40, 100), without.at(40, 100));
}

TEST(Render, OverlayFollowsTheColumnsTransforms) {
  Skeleton skeleton;
  Handle bone, point;
  bone.segments = {{Vec3(0, 0, 0), Vec3(1, 0, 0)}};
  point.kind = Handle::Kind::point;
  point.point = Vec3(0, 2, 0);
  skeleton.handles = {bone, point};
  skeleton.column = {1, 0};
  std::vector<Transform> columns(2, Transform::Identity());
  columns[1](2, 3) = 5;
  const SkeletonOverlay overlay = skeleton_overlay(skeleton, columns);
  ASSERT_EQ(overlay.bones.size(), 1u);
  EXPECT_EQ(overlay.bones[0].second, Vec3(1, 0, 5));
  EXPECT_EQ(overlay.dots.size(), 3u);
  EXPECT_THROW(skeleton_overlay(skeleton, std::span(columns).first(1)), InputError);
}

TEST(Render, PointCloudsAreDrawn) {
  const Mesh mesh = sphere(40, 80);
  const RenderOptions options = frontal(100);
  const Image image = render_posed(mesh.V, Triangles(0, 3), {}, options);
  EXPECT_GT(covered(image, options.background), 4000);
  EXPECT_EQ(image.at(0, 0), options.background);
}

TEST(Render, CreasesStayFlatAndSmoothSurfacesDoNot) {
  // A cube's face has one colour; faces of a sphere do not show.
  Points V(8, 3);
  for (int i = 0; i < 8; ++i) V.row(i) << (i & 1), (i >> 1 & 1), (i >> 2 & 1);
  Triangles F(12, 3);
  F << 4, 5, 7, 4, 7, 6, 0, 2, 3, 0, 3, 1, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 2, 6, 7, 2, 7, 3, 0,
      1, 5, 0, 5, 4;
  RenderOptions options = frontal(100);
  options.camera.field_of_view = 0;
  const Image cube = render_posed(V, F, {}, options);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    EXPECT_NEAR(cube.at(30, 30)[i], cube.at(70, 70)[i], 3);  // only the highlight's tail differs
  }
  const Mesh ball = sphere(24, 48);
  const Image round = render_posed(ball.V, ball.F, {}, options);
  int steps = 0;
  for (int x = 30; x < 70; ++x) {
    steps = std::max(steps, std::abs(round.at(x, 50)[1] - round.at(x + 1, 50)[1]));
  }
  EXPECT_LE(steps, 8);
}

TEST(Render, CameraKeepsEveryPointInsideItsMargin) {
  const Mesh mesh = sphere(10, 20);
  Points V = mesh.V;
  V.col(2) *= 6;
  for (const double field_of_view : {0.0, 30.0, 70.0}) {
    for (const double yaw : {0.0, 35.0, 200.0}) {
      CameraOptions options;
      options.field_of_view = field_of_view;
      options.yaw = yaw;
      const Camera camera = fit_camera(V, 400, 300, options);
      double tightest = 1e9;
      for (Eigen::Index v = 0; v < V.rows(); ++v) {
        const Vec3 p = camera.project(V.row(v));
        tightest = std::min({tightest, p.x(), 400 - p.x(), p.y(), 300 - p.y()});
        EXPECT_GT(p.z(), 0);
        // Casting the ray through the pixel comes back to the point.
        const Vec3 back =
            camera.ray_origin(p.x(), p.y()) + p.z() * camera.ray_direction(p.x(), p.y());
        EXPECT_LT((back - V.row(v).transpose()).norm(), 1e-9);
      }
      EXPECT_NEAR(tightest, 15, 1e-6);
    }
  }
}

TEST(Render, RefusesWhatCannotBeDrawn) {
  const Mesh mesh = sphere(4, 8);
  EXPECT_THROW(render_posed(Points(0, 3), Triangles(0, 3)), InputError);
  EXPECT_THROW(render_heat_map(mesh.V, mesh.F, Vector::Zero(3)), InputError);
  Triangles wrong = mesh.F;
  wrong(0, 0) = 1000;
  EXPECT_THROW(render_posed(mesh.V, wrong), InputError);
  Points broken = mesh.V;
  broken(0, 0) = NAN;
  EXPECT_THROW(render_posed(broken, mesh.F), InputError);
  RenderOptions options;
  options.progress.cancelled = [] { return true; };
  EXPECT_THROW(render_posed(mesh.V, mesh.F, {}, options), Cancelled);
}

TEST(Extrema, AreDiscsInFrontAndRingsBehind) {
  const Mesh ball = sphere(24, 48);
  const Vector half = Vector::Constant(ball.V.rows(), 0.45);
  const RenderOptions plain = frontal(96);
  const Image without = render_heat_map(ball.V, ball.F, half, plain);
  const auto brightness = [](const Image& image, int x, int y) {
    const Rgb8 c = image.at(x, y);
    return c[0] + c[1] + c[2];
  };
  for (const bool maximum : {true, false}) {
    for (const bool front : {true, false}) {
      RenderOptions options = plain;
      options.extrema = {{Vec3(0, 0, front ? 1 : -1), 0, maximum}};
      const Image with = render_heat_map(ball.V, ball.F, half, options);
      const int middle = brightness(with, 48, 48), before = brightness(without, 48, 48);
      EXPECT_EQ(middle - before > 0, front && maximum);
      EXPECT_EQ(middle - before < 0, front && !maximum);
      // Elsewhere nothing changes.
      EXPECT_EQ(with.at(48, 20), without.at(48, 20));
      EXPECT_NE(with.rgb, without.rgb);
    }
  }
}

TEST(Extrema, OfAColumnAreInItsTileAndTheFirst) {
  const Mesh ball = sphere(12, 24);
  RowMatrix W(ball.V.rows(), 2);
  W.setConstant(0.5);
  const SparseRows sparse = W.sparseView();
  RenderOptions options = frontal(200);
  options.width = 300;
  const ContactSheetOptions row{.columns = 3, .tile_aspect = 1};
  const Image without = render_contact_sheet(ball.V, ball.F, sparse, {}, options, row);
  options.extrema = {{Vec3(0, 0, 1), 1, true}};
  const Image with = render_contact_sheet(ball.V, ball.F, sparse, {}, options, row);
  std::array<int, 3> changed{};
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x)
      changed[static_cast<std::size_t>(std::min(x / 100, 2))] += with.at(x, y) != without.at(x, y);
  EXPECT_GT(changed[0], 0);
  EXPECT_EQ(changed[1], 0);
  EXPECT_EQ(changed[2], changed[0]);
}

}  // namespace
}  // namespace skinfield
