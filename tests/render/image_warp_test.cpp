#include "skinfield/render/image_warp.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/render/colour.h"

#include <gtest/gtest.h>

#include <limits>

namespace skinfield {
namespace {

constexpr int kWidth = 24, kHeight = 16;

Image pattern() {
  Image image(kWidth, kHeight, {0, 0, 0});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image.set(x, y,
                {static_cast<std::uint8_t>(10 * x), static_cast<std::uint8_t>(15 * y),
                 static_cast<std::uint8_t>(37 * x + 91 * y)});
    }
  }
  return image;
}

/// A sheet of 6 x 4 squares over [0,6] x [0,4], two triangles each.
struct Sheet {
  PlanarPoints V;
  Triangles F;
  Sheet() : V(7 * 5, 2), F(2 * 6 * 4, 3) {
    Eigen::Index f = 0;
    for (int i = 0; i <= 6; ++i) {
      for (int j = 0; j <= 4; ++j) {
        V.row(i * 5 + j) << i, j;
        if (i == 6 || j == 4) continue;
        F.row(f++) << i * 5 + j, i * 5 + 5 + j, i * 5 + 6 + j;
        F.row(f++) << i * 5 + j, i * 5 + 6 + j, i * 5 + j + 1;
      }
    }
  }
  Image warp(const Image& image, const PlanarPoints& posed) const {
    return warp_image(image, frame_around(V), V, posed, F);
  }
};

TEST(ImageWarp, TheIdentityGivesThePictureBack) {
  const Sheet sheet;
  const Image image = pattern();
  EXPECT_EQ(sheet.warp(image, sheet.V).rgb, image.rgb);
  // Whatever the mesh's unit.
  const PlanarPoints far = (0.37 * sheet.V).rowwise() + Eigen::RowVector2d(100, -20);
  EXPECT_EQ(warp_image(image, frame_around(far), far, far, sheet.F).rgb, image.rgb);
}

TEST(ImageWarp, GrowsByWholePixelsWhereTheMeshGoes) {
  const Sheet sheet;
  const Image image = pattern();
  // A unit is four pixels: three to the right, five up.
  const PlanarPoints posed = sheet.V.rowwise() + Eigen::RowVector2d(0.75, 1.25);
  const Image moved = sheet.warp(image, posed);
  ASSERT_EQ(moved.width, kWidth + 3);
  ASSERT_EQ(moved.height, kHeight + 5);
  for (int y = 0; y < moved.height; ++y) {
    for (int x = 0; x < moved.width; ++x) {
      const bool inside = x >= 3 && y < kHeight;
      EXPECT_EQ(moved.at(x, y), inside ? image.at(x - 3, y) : (Rgb8{255, 255, 255}));
    }
  }
}

TEST(ImageWarp, AQuarterTurnMovesPixelsWhole) {
  const Sheet sheet;
  const Image image = pattern();
  PlanarPoints posed(sheet.V.rows(), 2);
  posed.col(0) = 4 - sheet.V.col(1).array();
  posed.col(1) = sheet.V.col(0);
  const Image turned = sheet.warp(image, posed);
  // Turned to the left, over the lower left corner: as high as it was wide.
  ASSERT_EQ(turned.height, kWidth);
  for (int y = 0; y < kWidth; ++y) {
    for (int x = 0; x < kHeight; ++x) {
      EXPECT_EQ(turned.at(x, y), image.at(kWidth - 1 - y, x)) << x << " " << y;
    }
  }
}

TEST(ImageWarp, HalfTheSizeIsTheMeanOfFourPixels) {
  const Sheet sheet;
  const Image image = pattern();
  const Image half = sheet.warp(image, 0.5 * sheet.V);
  ASSERT_EQ(half.width, kWidth);
  ASSERT_EQ(half.height, kHeight);
  for (int y = 0; y < kHeight / 2; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      Vec3 mean = Vec3::Zero();
      for (int k = 0; k < 4; ++k) mean += to_linear(image.at(2 * x + k % 2, 2 * y + k / 2)) / 4;
      EXPECT_EQ(half.at(x, kHeight / 2 + y), to_srgb(mean));
    }
  }
  EXPECT_EQ(half.at(0, 0), (Rgb8{255, 255, 255}));
}

TEST(ImageWarp, EdgesAreSmooth) {
  const Sheet sheet;
  const Image black(kWidth, kHeight, {0, 0, 0});
  const PlanarPoints posed = sheet.V.rowwise() + Eigen::RowVector2d(0.125, 0);  // half a pixel
  const Image moved = sheet.warp(black, posed);
  ASSERT_EQ(moved.width, kWidth + 1);
  EXPECT_EQ(moved.at(0, 5), to_srgb(Vec3::Constant(0.5)));
  EXPECT_EQ(moved.at(1, 5), (Rgb8{0, 0, 0}));
  EXPECT_EQ(moved.at(kWidth, 5), to_srgb(Vec3::Constant(0.5)));
}

TEST(ImageWarp, LaterTrianglesCoverEarlierOnes) {
  Image image(2, 1, {255, 0, 0});
  image.set(1, 0, {0, 0, 255});
  PlanarPoints rest(8, 2), posed(8, 2);
  rest << 0, 0, 1, 0, 1, 1, 0, 1, 1, 0, 2, 0, 2, 1, 1, 1;
  posed = rest;
  posed.bottomRows(4).col(0).array() -= 1;  // the blue square onto the red one
  Triangles F(4, 3);
  F << 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7;
  const ImageFrame frame = frame_around(rest);
  EXPECT_GT(warp_image(image, frame, rest, posed, F).at(0, 0)[2], 100);
  const Triangles turned = F.colwise().reverse();
  EXPECT_GT(warp_image(image, frame, rest, posed, turned).at(0, 0)[0], 100);
}

TEST(ImageWarp, ACutOutLeavesTheRestOfThePictureAway) {
  const Sheet sheet;
  const Image image = pattern();
  // The sheet lies on the picture's left half: what is beside it is not shown.
  const Image cut = warp_image(image, {{0, 0}, {12, 4}}, sheet.V, sheet.V, sheet.F);
  EXPECT_EQ(cut.width, kWidth);
  for (int y = 0; y < kHeight; ++y) {
    EXPECT_EQ(cut.at(kWidth / 2 - 1, y), image.at(kWidth / 2 - 1, y));
    EXPECT_EQ(cut.at(kWidth / 2, y), (Rgb8{255, 255, 255}));
  }
  // And what of the sheet is beside the picture shows nothing either.
  const Image narrow = warp_image(image, {{0, 0}, {3, 4}}, sheet.V, sheet.V, sheet.F);
  EXPECT_EQ(narrow.width, 2 * kWidth);
  EXPECT_EQ(narrow.at(kWidth, 3), (Rgb8{255, 255, 255}));
}

TEST(ImageWarp, IsTheSameAtAnyThreadCount) {
  const Sheet sheet;
  PlanarPoints posed = sheet.V;
  posed.col(1).array() += posed.col(0).array().sin();
  Image large(400, 300, {9, 9, 9});
  paste(large, pattern(), 150, 100);
  const ThreadLimit one(1);
  const Image a = sheet.warp(large, posed);
  const ThreadLimit two(2);
  EXPECT_EQ(a.rgb, sheet.warp(large, posed).rgb);
}

TEST(ImageWarp, RefusesWhatMakesNoSense) {
  const Sheet sheet;
  const Image image = pattern();
  EXPECT_THROW(sheet.warp(image, sheet.V.topRows(3)), InputError);
  EXPECT_THROW(sheet.warp(image, sheet.V * 1e6), InputError);
  PlanarPoints bad = sheet.V;
  bad(3, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(sheet.warp(image, bad), InputError);
  EXPECT_THROW(warp_image(image, {{0, 0}, {0, 4}}, sheet.V, sheet.V, sheet.F), InputError);
  const Triangles wrong = sheet.F.array() + 1;
  EXPECT_THROW(warp_image(image, frame_around(sheet.V), sheet.V, sheet.V, wrong), InputError);
  // Collapsed triangles show nothing, and that is no error.
  EXPECT_EQ(sheet.warp(image, 0 * sheet.V).rgb, Image(kWidth, kHeight, {255, 255, 255}).rgb);
}

}  // namespace
}  // namespace skinfield
