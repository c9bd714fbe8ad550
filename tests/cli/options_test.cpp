// The options of bind that change which weights come out.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"
#include "support/gltf_builder.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::read_weights;
using skinfield::RowMatrix;
using skinfield::SkinWeights;

RowMatrix dense(const TemporaryFolder& folder, const std::string& file) {
  return RowMatrix(read_weights(folder / file).W);
}

Json bind_report(const TemporaryFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "bind");
  arguments.insert(arguments.end(), {"--json", "--quiet"});
  return Json::parse(expect_runs(folder, arguments).out);
}

std::vector<std::string> box(const std::string& output, const std::vector<std::string>& more = {}) {
  std::vector<std::string> all{"box.obj", "--skeleton", "box.tgf", "--nodes", "200", "-o", output};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(Options, JointsThatDeform) {
  const BoxFolder folder;
  write_file(folder / "square.glb", skinned_square().glb());
  const auto left_out = [&folder](const std::vector<std::string>& more) {
    std::vector<std::string> all{"square.glb", "-o", "out.glb"};
    all.insert(all.end(), more.begin(), more.end());
    return bind_report(folder, all)["input"]["joints_left_out"].get<std::vector<std::string>>();
  };
  const std::vector<std::string> none, a{"a"}, b{"b"};
  EXPECT_EQ(left_out({}), none);
  EXPECT_EQ(left_out({"--joints", "all"}), none);
  EXPECT_EQ(left_out({"--joints", "used"}), none);
  EXPECT_EQ(left_out({"--joints", "b"}), a);
  EXPECT_EQ(left_out({"--joints", "a,zz*"}), b);
  EXPECT_EQ(left_out({"--exclude", "b*"}), b);
  const auto weights = skinfield::read_gltf(folder / "out.glb").characters.front().weights;
  ASSERT_TRUE(weights.has_value());
  EXPECT_EQ(weights->W.cols(), 2) << "a column stays for the joint that does not deform";
  EXPECT_EQ(RowMatrix(weights->W).col(1).maxCoeff(), 0);
}

TEST(Options, LeafAsPointOrBone) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "8000", "-o", "gecko.glb"});
  // The gecko's leaves own bones that end at their `_end` nodes.
  expect_runs(folder, {"bind", "gecko.glb", "--nodes", "600", "-o", "extend.npz"});
  expect_runs(folder,
              {"bind", "gecko.glb", "--nodes", "600", "--leaf", "point", "-o", "point.npz"});
  EXPECT_GT(
      skinfield::compare(read_weights(folder / "extend.npz"), read_weights(folder / "point.npz"))
          .mean,
      1e-3);
  const Json inspected =
      Json::parse(expect_runs(folder, {"inspect", "gecko.glb", "--leaf", "point", "--json"}).out);
  int points = 0;
  for (const Json& handle : inspected["characters"][0]["handles"])
    points += handle["kind"] == "point";
  EXPECT_GT(points, 5);
}

TEST(Options, PaintIsKeptExactly) {
  const BoxFolder folder;
  write_file(folder / "paint.csv", "0,0,1\n19,0.25,0.75\n");
  bind_report(folder, box("w.npz", {"--paint", "paint.csv"}));
  const RowMatrix W = dense(folder, "w.npz");
  EXPECT_NEAR(W(0, 1), 1, 1e-12);
  EXPECT_NEAR(W(19, 0), 0.25, 1e-12);
  bind_report(folder, box("plain.npz"));
  EXPECT_GT(dense(folder, "plain.npz")(0, 0), 0.5) << "without paint the near bone has it";
}

TEST(Options, PaintAloneMakesItsColumnsTheHandles) {
  const BoxFolder folder;
  write_file(folder / "paint.csv", "0,1,0\n1,1,0\n2,1,0\n3,1,0\n16,0,1\n17,0,1\n18,0,1\n19,0,1\n");
  bind_report(folder, {"box.obj", "--paint", "paint.csv", "--nodes", "200", "-o", "w.npz"});
  const RowMatrix W = dense(folder, "w.npz");
  ASSERT_EQ(W.cols(), 2);
  EXPECT_NEAR(W(0, 0), 1, 1e-12);
  EXPECT_NEAR(W(19, 1), 1, 1e-12);
  EXPECT_GT(W(4, 0), W(4, 1));
  EXPECT_LT(W(12, 0), W(12, 1));
}

TEST(Options, LockedColumnsAreKept) {
  const BoxFolder folder;
  write_file(folder / "three.tgf",
             "1 0.3 .5 .5\n2 1.2 .5 .5\n3 2.5 .5 .5\n4 3.7 .5 .5\n#\n1 2\n2 3\n3 4\n");
  std::string given = "one,two,three\n";
  for (int v = 0; v < 20; ++v) given += v < 8 ? "0.7,0.2,0.1\n" : "0.1,0.3,0.6\n";
  write_file(folder / "given.csv", given);
  const std::vector<std::string> base{"box.obj", "--skeleton", "three.tgf", "--nodes", "200"};
  auto arguments = base;
  arguments.insert(arguments.end(), {"-o", "plain.npz"});
  bind_report(folder, arguments);
  const SkinWeights plain = read_weights(folder / "plain.npz");
  ASSERT_EQ(plain.names.size(), 3U);
  arguments = base;
  arguments.insert(arguments.end(),
                   {"--weights-in", "given.csv", "--lock", plain.names[0], "-o", "w.npz"});
  bind_report(folder, arguments);
  const RowMatrix W = dense(folder, "w.npz");
  for (int v = 0; v < 20; ++v) {
    EXPECT_NEAR(W(v, 0), v < 8 ? 0.7 : 0.1, 1e-9) << v;
    EXPECT_NEAR(W.row(v).sum(), 1, 1e-9) << v;
  }
  EXPECT_GT((W - RowMatrix(plain.W)).cwiseAbs().maxCoeff(), 0.05);
}

TEST(Options, WeightsInAloneOnlyStartTheSolve) {
  const BoxFolder folder;
  bind_report(folder, box("cold.npz", {"--tolerance", "1e-6"}));
  bind_report(folder, box("warm.npz", {"--tolerance", "1e-6", "--weights-in", "cold.npz"}));
  EXPECT_LT(
      skinfield::compare(read_weights(folder / "cold.npz"), read_weights(folder / "warm.npz")).max,
      1e-3)
      << "the optimum does not depend on the start";
}

TEST(Options, InfluencesAndPruning) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "8000", "-o", "gecko.glb"});
  const Json two = bind_report(folder, {"gecko.glb", "--nodes", "600", "--max-influences", "2",
                                        "-o", "two.glb", "--weights", "two.npz"});
  for (const auto& [influences, rows] : two["weights"]["influences"].items())
    EXPECT_LE(std::stoi(influences), 2) << rows;
  const SkinWeights weights = read_weights(folder / "two.npz");
  EXPECT_EQ(weights.W.cols(),
            skinfield::read_gltf(folder / "two.glb").characters.front().skeleton.columns);
  const Json all = bind_report(
      folder, {"gecko.glb", "--nodes", "600", "--max-influences", "0", "-o", "all.glb"});
  EXPECT_GT(all["weights"]["influences"].size(), two["weights"]["influences"].size());
  const RunResult validated = validate_gltf(folder / "all.glb", folder / "gecko.glb");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out;
}

TEST(Options, SymmetryMirrorsTheWeights) {
  const BoxFolder folder;
  write_file(folder / "pair.tgf",
             "1 0.5 .5 .5\n2 1.7 .5 .5\n3 2.3 .5 .5\n4 3.5 .5 .5\n#\n1 2\n4 3\n");
  bind_report(folder, {"box.obj", "--skeleton", "pair.tgf", "--nodes", "200", "--symmetry", "x",
                       "-o", "w.npz"});
  const RowMatrix W = dense(folder, "w.npz");
  for (int x = 0; x <= 4; ++x)
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(W(4 * x + k, 0), W(4 * (4 - x) + k, 1), 1e-9) << x << " " << k;
}

TEST(Options, DomainOnTheSurface) {
  const BoxFolder folder;
  const Json report = bind_report(folder, box("w.npz", {"--domain", "tris"}));
  EXPECT_EQ(report["domain"]["rung"], "surface");
  EXPECT_EQ(report["weights"]["row_sum_error"].get<double>() < 1e-6, true);
  const RowMatrix W = dense(folder, "w.npz");
  EXPECT_GT(W(0, 0), 0.5);
  EXPECT_GT(W(19, 1), 0.5);
}

TEST(Options, BindsInPlace) {
  const BoxFolder folder;
  write_file(folder / "square.glb", skinned_square().glb());
  const std::string before = read_file(folder / "square.glb");
  bind_report(folder, {"square.glb", "-o", "square.glb"});
  EXPECT_NE(read_file(folder / "square.glb"), before);
  EXPECT_EQ(skinfield::read_gltf(folder / "square.glb").characters.size(), 1U);
  for (const auto& [name, bytes] : contents(folder))
    EXPECT_EQ(name.find(".part"), std::string::npos) << name;
}

TEST(Options, ExtremaAreMarkedInPicturesOfWeights) {
  const BoxFolder folder;
  std::string monotone, bumpy;
  for (int v = 0; v < 20; ++v) {
    const double w = 0.25 * (v / 4) + (v == 9 ? 0.4 : 0);
    bumpy += std::to_string(1 - w) + "," + std::to_string(w) + "\n";
    monotone += std::to_string(1 - 0.25 * (v / 4)) + "," + std::to_string(0.25 * (v / 4)) + "\n";
  }
  write_file(folder / "bumpy.csv", bumpy);
  write_file(folder / "monotone.csv", monotone);
  const auto drawn = [&](const std::string& weights, const std::vector<std::string>& more) {
    std::vector<std::string> all{"render", "box.obj", "--weights", weights,    "-o",
                                 "w.png",  "--width", "128",       "--height", "96"};
    all.insert(all.end(), more.begin(), more.end());
    return expect_runs(folder, all).err;
  };
  drawn("bumpy.csv", {});
  const std::string without = read_file(folder / "w.png");
  EXPECT_NE(drawn("bumpy.csv", {"--extrema"}).find("2 local extrema"), std::string::npos);
  EXPECT_NE(read_file(folder / "w.png"), without);
  EXPECT_NE(drawn("monotone.csv", {"--extrema"}).find("0 local extrema"), std::string::npos);
  expect_refused(folder,
                 {"render", "box.obj", "--weights", "bumpy.csv", "--extrema", "--kind", "posed",
                  "-o", "w.png"},
                 2, {"--extrema", "posed"});
}

}  // namespace
}  // namespace skinfield_test
