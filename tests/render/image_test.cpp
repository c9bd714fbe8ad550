#include "skinfield/render/image.h"

#include "skinfield/base/error.h"
#include "skinfield/render/text.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace skinfield {
namespace {

Image pattern() {
  Image image(37, 23, {10, 20, 30});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      image.set(x, y,
                {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y),
                 static_cast<std::uint8_t>(x * y)});
    }
  }
  return image;
}

std::string text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

/// The PNG of another format's pixels, by the library itself.
std::string png_of(int width, int height, png_uint_32 format, const void* pixels) {
  png_image description;
  std::memset(&description, 0, sizeof description);
  description.version = PNG_IMAGE_VERSION;
  description.width = static_cast<png_uint_32>(width);
  description.height = static_cast<png_uint_32>(height);
  description.format = format;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(description);
  std::string bytes(size, 0);
  EXPECT_TRUE(png_image_write_to_memory(&description, bytes.data(), &size, 0, pixels, 0, nullptr));
  bytes.resize(size);
  return bytes;
}

TEST(Png, OtherFormatsBecomeRgb) {
  const std::array<std::uint8_t, 3> grey = {0, 128, 255};
  const Image one = decode_png(png_of(3, 1, PNG_FORMAT_GRAY, grey.data()), "grey.png");
  EXPECT_EQ(one.at(1, 0), (Rgb8{128, 128, 128}));
  const std::array<std::uint8_t, 8> rgba = {200, 100, 50, 255, 200, 100, 50, 0};
  const std::string seen_through = png_of(2, 1, PNG_FORMAT_RGBA, rgba.data());
  EXPECT_EQ(decode_png(seen_through, "a.png").at(0, 0), (Rgb8{200, 100, 50}));
  EXPECT_EQ(decode_png(seen_through, "a.png").at(1, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(decode_png(seen_through, "a.png", {1, 2, 3}).at(1, 0), (Rgb8{1, 2, 3}));
}

TEST(Png, DamagedFilesAreRefusedByName) {
  const std::string good = text(encode_png(pattern()));
  std::string flipped = good;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 0x55);
  std::string huge = good;
  huge.replace(16, 8, std::string("\x00\x00\x7f\xff\x00\x00\x7f\xff", 8));
  for (const std::string& bad : {std::string(), std::string("no picture"), good.substr(0, 20),
                                 good.substr(0, good.size() / 2), flipped, huge}) {
    try {
      decode_png(bad, "bad.png");
      ADD_FAILURE() << "read " << bad.size() << " bytes";
    } catch (const InputError& error) {
      EXPECT_EQ(error.where(), "bad.png");
      EXPECT_EQ(error.message().find('\n'), std::string::npos);
    }
  }
}

TEST(Png, DecodesToWhatWasWritten) {
  const Image image = pattern(), back = decode_png(text(encode_png(image)), "a.png");
  EXPECT_EQ(back.width, image.width);
  EXPECT_EQ(back.height, image.height);
  EXPECT_EQ(back.rgb, image.rgb);
}

TEST(Png, FileHoldsTheEncodedBytesAndNothingIsLeftBeside) {
  const auto folder = std::filesystem::temp_directory_path() / "skinfield_image_test";
  std::filesystem::create_directories(folder);
  const Image image = pattern();
  write_png(folder / "a.png", image);
  std::ifstream file(folder / "a.png", std::ios::binary);
  const std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(bytes, encode_png(image));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_THROW(write_png(folder / "missing" / "a.png", image), IoError);
  std::filesystem::remove_all(folder);
}

TEST(ImageTest, RefusesImpossibleSizes) {
  EXPECT_THROW(Image(0, 10, {}), InputError);
  EXPECT_THROW(Image(10, 100000, {}), InputError);
}

TEST(ImageTest, PasteCutsWhatLiesOutside) {
  Image target(10, 10, {0, 0, 0});
  paste(target, Image(6, 6, {255, 0, 0}), 7, -3);
  int red = 0;
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) red += target.at(x, y)[0] == 255;
  }
  EXPECT_EQ(red, 3 * 3);
  EXPECT_EQ(target.at(7, 2)[0], 255);
  paste(target, Image(6, 6, {255, 0, 0}), 50, 50);
  EXPECT_EQ(target.at(0, 9)[0], 0);
}

TEST(Font, EveryGlyphIsInkedAndDifferent) {
  std::set<std::array<std::uint8_t, glyph_height>> seen;
  for (char c = 32; c < 127; ++c) {
    const auto& rows = glyph(c);
    int ink = 0;
    for (const std::uint8_t row : rows) {
      EXPECT_LT(row, 32) << c;
      for (int bit = 0; bit < glyph_width; ++bit) ink += row >> bit & 1;
    }
    if (c == ' ') {
      EXPECT_EQ(ink, 0);
    } else {
      EXPECT_GE(ink, 2) << c;
    }
    EXPECT_TRUE(seen.insert(rows).second) << c;
  }
  EXPECT_EQ(glyph('\x01'), glyph('?'));
  // Capitals and digits stand on the base line and fill the height above it.
  for (const char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")) {
    EXPECT_NE(glyph(c)[0], 0) << c;
    EXPECT_NE(glyph(c)[6], 0) << c;
    EXPECT_EQ(glyph(c)[7] | glyph(c)[8], 0) << c;
  }
}

TEST(Font, TextIsDrawnWhereItIsMeasured) {
  Image image(60, 20, {0, 0, 0});
  draw_text(image, 3, 2, "HH", {255, 255, 255}, 2);
  EXPECT_EQ(text_width("HH", 2), 22);
  int first = 60, last = -1;
  for (int x = 0; x < 60; ++x) {
    for (int y = 0; y < 20; ++y) {
      if (image.at(x, y)[0] == 0) continue;
      first = std::min(first, x);
      last = std::max(last, x);
    }
  }
  EXPECT_EQ(first, 3);
  EXPECT_EQ(last, 3 + 22 - 1);
}

TEST(Font, LongNamesKeepBothEnds) {
  const std::string name = "leg_front_left_toe_1";
  EXPECT_EQ(shortened(name, 1000, 1), name);
  const std::string cut = shortened(name, 72, 1);
  EXPECT_LE(text_width(cut, 1), 72);
  EXPECT_EQ(cut.substr(0, 3), "leg");
  EXPECT_EQ(cut.substr(cut.size() - 5), "toe_1");
  EXPECT_EQ(shortened("é", 100, 1), "é");
}

}  // namespace
}  // namespace skinfield
