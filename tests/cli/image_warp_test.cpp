// A picture on a flat mesh, moved by point and bone handles.
#include "cli/characters.h"
#include "skinfield/render/image.h"

namespace skinfield_test {
namespace {

using skinfield::decode_png;
using skinfield::Image;
using skinfield::Rgb8;

constexpr int kWidth = 40, kHeight = 20;

Image pattern() {
  Image image(kWidth, kHeight, {0, 0, 0});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      image.set(x, y,
                {static_cast<std::uint8_t>(6 * x), static_cast<std::uint8_t>(12 * y),
                 static_cast<std::uint8_t>(7 * (x + y))});
  return image;
}

/// A picture, a sheet of [0,8] x [0,4] below it, and two point handles and a bone.
struct SheetFolder : TemporaryFolder {
  SheetFolder() {
    std::string text;
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; j <= 4; ++j)
        text += "v " + std::to_string(i) + " " + std::to_string(j) + " 0\n";
    const auto name = [](int i, int j) { return " " + std::to_string(5 * i + j + 1); };
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 4; ++j)
        text += "f" + name(i, j) + name(i + 1, j) + name(i + 1, j + 1) + name(i, j + 1) + "\n";
    write_file(*this / "sheet.obj", text);
    write_file(*this / "sheet.tgf", "1 1 2 0\n2 7 2 0\n3 3 2 0\n4 5 2 0\n#\n3 4\n");
    skinfield::write_png(*this / "in.png", pattern());
    write_file(*this / "out.png", "precious");
    expect_runs(*this, {"bind", "sheet.obj", "--skeleton", "sheet.tgf", "-o", "w.npz", "--quiet"});
    expect_runs(*this, {"bind", "sheet.obj", "--skeleton", "sheet.tgf", "-o", "sheet.glb",
                        "--max-influences", "0", "--quiet"});
  }
  Image warped(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"pose", "--image", "in.png", "-o", "warped.png"};
    all.insert(all.end(), more.begin(), more.end());
    expect_runs(*this, all);
    return decode_png(read_file(*this / "warped.png"), "warped.png");
  }
  const std::vector<std::string> matrix{"sheet.obj", "--skeleton", "sheet.tgf", "--weights",
                                        "w.npz"};
};

std::vector<std::string> with(std::vector<std::string> some, const std::vector<std::string>& more) {
  some.insert(some.end(), more.begin(), more.end());
  return some;
}

TEST(ImageWarpCommand, RestsAndMovesWithTheHandles) {
  const SheetFolder folder;
  const Image image = pattern();
  EXPECT_EQ(folder.warped(with(folder.matrix, {"--pose", "bind"})).rgb, image.rgb);
  EXPECT_EQ(folder.warped({"sheet.glb", "--pose", "bind"}).rgb, image.rgb);
  // All handles two units up: ten pixels.
  write_file(folder / "up.json",
             R"({"0": {"translation": [0, 2, 0]}, "1": {"translation": [0, 2, 0]},
                 "2": {"translation": [0, 2, 0]}})");
  const Image up = folder.warped(with(folder.matrix, {"--pose", "up.json"}));
  ASSERT_EQ(up.width, kWidth);
  ASSERT_EQ(up.height, kHeight + 10);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(up.at(x, y), image.at(x, y));
  EXPECT_EQ(up.at(3, kHeight + 5), (Rgb8{255, 255, 255}));
  // One point alone: what hangs on the other stays where it was.
  write_file(folder / "one.json", R"({"1": {"translation": [1, 0, 0]}})");
  const Image one = folder.warped(with(folder.matrix, {"--pose", "one.json"}));
  EXPECT_GT(one.width, kWidth);
  EXPECT_EQ(one.at(5, 10), image.at(5, 10)) << "beside a handle that stays";
  EXPECT_NE(one.at(30, 10), image.at(30, 10));
}

TEST(ImageWarpCommand, LiesWhereItIsPut) {
  const SheetFolder folder;
  const Image image = pattern();
  // Twice as large as the sheet, whose lower left part it shows.
  const Image part =
      folder.warped(with(folder.matrix, {"--pose", "bind", "--image-box", "0", "0", "16", "8"}));
  ASSERT_EQ(part.width, kWidth);
  EXPECT_EQ(part.at(kWidth / 2 - 1, kHeight - 1), image.at(kWidth / 2 - 1, kHeight - 1));
  EXPECT_EQ(part.at(kWidth / 2, kHeight - 1), (Rgb8{255, 255, 255}));
  EXPECT_EQ(part.at(3, kHeight / 2 - 1), (Rgb8{255, 255, 255}));
}

TEST(ImageWarpCommand, WhatMakesNoSenseIsRefused) {
  const SheetFolder folder;
  const auto refused = [&](int code, const std::vector<std::string>& more,
                           const std::vector<std::string>& words) {
    expect_refused(folder, with(with({"pose"}, folder.matrix), more), code, words);
  };
  refused(3, {"--image", "none.png", "-o", "out.png"}, {"none.png"});
  refused(3, {"--image", "sheet.tgf", "-o", "out.png"}, {"sheet.tgf", "PNG"});
  refused(2, {"--image", "in.png", "-o", "out.obj"}, {"out.obj", ".png"});
  refused(2, {"-o", "out.png"}, {"out.png", "--image"});
  refused(2, {"--image-box", "0", "0", "1", "1", "-o", "out.obj"}, {"--image-box"});
  refused(2, {"--image", "in.png", "--image-box", "0", "0", "0", "1", "-o", "out.png"},
          {"--image-box", "less"});
  refused(5, {"--image", "in.png", "-o", "none/out.png"}, {"none/out.png"});
  const BoxFolder box;
  skinfield::write_png(box / "in.png", pattern());
  expect_runs(box, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "200", "-o", "w.npz"});
  expect_refused(box,
                 {"pose", "box.obj", "--skeleton", "box.tgf", "--weights", "w.npz", "--image",
                  "in.png", "-o", "out.png"},
                 3, {"box.obj", "not flat"});
}

}  // namespace
}  // namespace skinfield_test
