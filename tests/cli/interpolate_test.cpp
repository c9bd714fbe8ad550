// Data given for each handle, spread over a mesh.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/matrix_file.h"

namespace skinfield_test {
namespace {

using skinfield::read_matrix;
using skinfield::RowMatrix;

struct BoundBox : BoxFolder {
  BoundBox() {
    std::string ends;
    for (int v = 0; v < 20; ++v) ends += v < 4 ? "1,0\n" : v < 16 ? "0,0\n" : "0,1\n";
    write_file(*this / "ends.csv", ends);
    expect_runs(*this, {"bind", "box.obj", "--regions", "ends.csv", "--nodes", "300", "-o", "w.npz",
                        "--quiet"});
  }
  RowMatrix values(const std::string& data, const std::string& output = "v.npy") const {
    write_file(*this / "data.csv", data);
    expect_runs(*this, {"interpolate", "box.obj", "--weights", "w.npz", "--data", "data.csv", "-o",
                        output});
    return read_matrix(*this / output);
  }
};

TEST(Interpolate, KeepsConstantsHandlesAndTheHull) {
  const BoundBox folder;
  const RowMatrix constant = folder.values("0.3,-7\n0.3,-7\n");
  ASSERT_EQ(constant.rows(), 20);
  EXPECT_LT((constant.col(0).array() - 0.3).abs().maxCoeff(), 1e-15);
  EXPECT_LT((constant.col(1).array() + 7).abs().maxCoeff(), 1e-14);
  for (const std::string output : {"v.npz", "v.npy", "v.dmat", "v.csv"}) {
    const RowMatrix values = folder.values("1,5,0\n-2,5,10\n", output);
    ASSERT_EQ(values.cols(), 3);
    for (int v = 0; v < 20; ++v) {
      EXPECT_GE(values(v, 0), -2 - 1e-14);
      EXPECT_LE(values(v, 0), 1 + 1e-14);
      // Affine in one another, as the data are.
      EXPECT_NEAR(values(v, 2), (1 - values(v, 0)) / 3 * 10, 1e-12);
    }
    EXPECT_NEAR(values(2, 0), 1, 1e-14) << "a handle's vertex has its value";
    EXPECT_NEAR(values(18, 0), -2, 1e-14);
  }
}

TEST(Interpolate, WritesColoursAndPictures) {
  const BoundBox folder;
  write_file(folder / "data.csv", "1,0,0\n0,0,1\n");
  write_file(folder / "heights.csv", "height\n3\n8\n");
  for (const std::string data : {"data.csv", "heights.csv"})
    for (const std::string output : {"c.glb", "c.gltf", "c.ply", "c.obj", "c.png"}) {
      SCOPED_TRACE(data + " " + output);
      expect_runs(folder,
                  {"interpolate", "box.obj", "--weights", "w.npz", "--data", data, "-o", output});
      EXPECT_GT(read_file(folder / output).size(), 100U);
    }
  for (const std::string output : {"c.glb", "c.ply", "c.obj"})
    expect_runs(folder, {"inspect", output});
  EXPECT_NE(read_file(folder / "c.gltf").find("COLOR_0"), std::string::npos);
  EXPECT_NE(read_file(folder / "c.ply").find("property uchar red"), std::string::npos);
  expect_runs(folder, {"interpolate", "box.obj", "--weights", "w.npz", "--data", "data.csv", "-o",
                       "c.obj"});
  const std::string obj = read_file(folder / "c.obj");
  EXPECT_TRUE(obj.starts_with("v 0 0 0 1 0 0\n")) << obj.substr(0, 40);
}

TEST(Interpolate, TakesTheWeightsOfARiggedFile) {
  const BoundBox folder;
  expect_runs(folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "300", "-o",
                       "rig.glb", "--quiet"});
  // A row a joint: two bones and the extra one at the leaf.
  write_file(folder / "data.csv", "1\n2\n3\n");
  expect_runs(folder, {"interpolate", "rig.glb", "--data", "data.csv", "-o", "v.csv"});
  const RowMatrix values = read_matrix(folder / "v.csv");
  EXPECT_GE(values.minCoeff(), 1 - 1e-12);
  EXPECT_LE(values.maxCoeff(), 2 + 1e-12);
}

TEST(Interpolate, WhatDoesNotFitIsRefused) {
  const BoundBox folder;
  const auto refused = [&](const std::string& data, const std::vector<std::string>& more, int code,
                           const std::vector<std::string>& words) {
    write_file(folder / "data.csv", data);
    std::vector<std::string> all{"interpolate", "box.obj", "--data", "data.csv"};
    all.insert(all.end(), more.begin(), more.end());
    expect_refused(folder, all, code, words);
  };
  const std::vector<std::string> weights{"--weights", "w.npz", "-o"};
  const auto to = [&](const std::string& output) {
    std::vector<std::string> all = weights;
    all.push_back(output);
    return all;
  };
  refused("1\n2\n3\n", to("v.csv"), 3, {"data.csv", "3 rows", "2 handles"});
  refused("1,2\n3,4\n", to("c.png"), 3, {"data.csv", "2 columns", "red"});
  refused("1,0,2\n0,0,0\n", to("c.glb"), 3, {"data.csv", "0 to 1"});
  refused("1\n2\n", to("v.txt"), 2, {"v.txt", ".npz"});
  refused("1\n2\n", {"--weights", "w.npz", "-o", "v.csv", "--yaw", "3"}, 2, {"--yaw", "picture"});
  refused("1\n2\n", {"-o", "v.csv"}, 3, {"box.obj", "no weights"});
  std::string empty;
  for (int v = 0; v < 20; ++v) empty += v == 7 ? "0,0\n" : "1,0\n";
  write_file(folder / "empty.csv", empty);
  refused("1\n2\n", {"--weights", "empty.csv", "-o", "v.csv"}, 3,
          {"empty.csv", "vertex 7", "no weights"});
}

}  // namespace
}  // namespace skinfield_test
