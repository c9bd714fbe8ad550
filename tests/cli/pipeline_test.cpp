// The way an artist goes: sample, bind, inspect, compare, pose, render, transfer; and that all
// outputs of one bind agree.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/io.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"
#include "support/gltf_builder.h"
#include "support/gltf_diff.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::compare;
using skinfield::read_gltf;
using skinfield::read_weights;
using skinfield::SkinWeights;

void expect_valid(const SkinWeights& weights) {
  const skinfield::WeightStatistics s = skinfield::weight_statistics(weights);
  EXPECT_LE(s.row_sum_error, 1e-6);
  EXPECT_EQ(s.negative, 0);
  EXPECT_EQ(s.non_finite, 0);
}

Json parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << text.substr(0, 300);
  return json;
}

TEST(Pipeline, FromSampleToPicture) {
  const TemporaryFolder folder;
  EXPECT_EQ(expect_runs(folder, {"sample", "gecko", "-o", "gecko.glb", "--quiet"}).err, "");
  expect_runs(folder, {"bind", "gecko.glb", "--quality", "draft", "-o", "bound.glb"});
  expect_valid(*read_gltf(folder / "bound.glb").characters.front().weights);
  EXPECT_EQ(unexpected_changes(read_file(folder / "gecko.glb"), read_file(folder / "bound.glb")),
            std::vector<std::string>{});

  const Json inspected = parsed(expect_runs(folder, {"inspect", "bound.glb", "--json"}).out);
  EXPECT_EQ(inspected["characters"].size(), 1U);
  EXPECT_EQ(inspected["characters"][0]["weights"], true);
  EXPECT_EQ(inspected["characters"][0]["watertight"], true);
  EXPECT_FALSE(inspected["animations"].empty());
  EXPECT_NE(expect_runs(folder, {"inspect", "bound.glb"}).out.find("watertight"),
            std::string::npos);

  const Json same =
      parsed(expect_runs(folder, {"compare", "bound.glb", "bound.glb", "--json"}).out);
  EXPECT_EQ(same["tv_max"], 0.0);
  EXPECT_EQ(same["motion_rms"], 0.0);
  const Json other =
      parsed(expect_runs(folder, {"compare", "bound.glb", "gecko.glb", "--json"}).out);
  EXPECT_GT(other["tv_mean"], 0.0);
  EXPECT_GT(other["motion_rms"], 0.0);

  const std::string name = inspected["animations"][0]["name"];
  for (const std::string& pose : {std::string("demo"), name + "@0.3", std::string("bind")})
    expect_runs(folder, {"pose", "bound.glb", "--pose", pose, "-o", pose.substr(0, 4) + ".obj"});
  EXPECT_NE(read_file(folder / "demo.obj"), read_file(folder / "bind.obj"));
  expect_runs(folder, {"pose", "bound.glb", "--skinning", "dqs", "-o", "demo.ply"});
  for (const char* kind : {"heat", "dominant", "sheet", "posed"}) {
    const std::string picture = std::string(kind) + ".png";
    expect_runs(folder, {"render", "bound.glb", "--kind", kind, "--pose", "demo", "--width", "160",
                         "--height", "120", "-o", picture});
    EXPECT_TRUE(read_file(folder / picture).starts_with("\x89PNG")) << kind;
  }
  const RunResult validated = validate_gltf(folder / "bound.glb", folder / "gecko.glb");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out;
}

TEST(Pipeline, EverySampleBinds) {
  const TemporaryFolder folder;
  for (const char* name : {"gecko", "robot", "scan"}) {
    const std::string file = std::string(name) + ".glb";
    expect_runs(folder, {"sample", name, "--triangles", "8000", "-o", file});
    expect_runs(folder, {"bind", file, "--nodes", "600", "-o", "bound.glb", "--weights", "w.npz"});
    expect_valid(*read_gltf(folder / "bound.glb").characters.front().weights);
    expect_valid(read_weights(folder / "w.npz"));
  }
}

TEST(Pipeline, OutputsAgree) {
  const BoxFolder folder;
  const auto bind_to = [&folder](const std::string& output) {
    const RunResult result = expect_runs(
        folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "200", "--quiet",
                 "--max-influences", "4", "--prune", "0.0001", "-o", output});
    EXPECT_EQ(result.out + result.err, "") << "--quiet";
  };
  bind_to("out.npz");
  const SkinWeights expected = read_weights(folder / "out.npz");
  ASSERT_EQ(expected.W.rows(), 20) << "one row an input vertex";
  expect_valid(expected);
  for (const char* extension : {".npy", ".dmat", ".csv"}) {
    const std::string output = std::string("out").append(extension);
    bind_to(output);
    EXPECT_EQ(compare(expected, read_weights(folder / output)).max, 0) << output;
  }
  const auto source = skinfield::read_asset(folder / "box.obj").characters.front();
  for (const char* extension : {".glb", ".gltf"}) {
    const std::string output = std::string("out").append(extension);
    bind_to(output);
    // glTF has floats, its vertices in the order of the faces' corners, and a column for each
    // joint of the tree, of which the bones are the first.
    const auto character = read_gltf(folder / output).characters.front();
    expect_valid(*character.weights);
    ASSERT_EQ(character.weights->W.rows(), 20);
    for (int i = 0; i < 20; ++i) {
      const auto position =
          character.mesh.V.row(character.vertex_of_input[static_cast<std::size_t>(i)]);
      int row = -1;
      for (int k = 0; k < 20; ++k)
        if ((source.mesh.V.row(source.vertex_of_input[static_cast<std::size_t>(k)]) - position)
                .norm() < 1e-6)
          row = k;
      ASSERT_GE(row, 0);
      for (int c = 0; c < 2; ++c)
        EXPECT_NEAR(character.weights->W.coeff(i, c), expected.W.coeff(row, c), 1e-6);
    }
  }
  const RunResult validated = validate_gltf(folder / "out.glb");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.out.find("error"), std::string::npos) << validated.out;
  EXPECT_EQ(validated.out.find("warning"), std::string::npos) << validated.out;
}

TEST(Pipeline, SameBytesForAnyThreadsAndRun) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "8000", "-o", "gecko.glb"});
  std::string glb, npz;
  for (const char* threads : {"1", "2", "2"}) {
    expect_runs(folder, {"bind", "gecko.glb", "--quality", "draft", "--threads", threads, "-o",
                         "out.glb", "--weights", "out.npz"});
    if (!glb.empty()) {
      EXPECT_TRUE(glb == read_file(folder / "out.glb")) << threads << " threads";
      EXPECT_TRUE(npz == read_file(folder / "out.npz")) << threads << " threads";
    }
    glb = read_file(folder / "out.glb");
    npz = read_file(folder / "out.npz");
  }
  expect_runs(folder,
              {"bind", "gecko.glb", "--quality", "draft", "--seed", "1", "-o", "other.glb"});
  EXPECT_NE(glb, read_file(folder / "other.glb")) << "another seed is another sampling";
}

TEST(Pipeline, TransfersToACoarserLevel) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "24000", "-o", "fine.glb"});
  expect_runs(folder, {"sample", "gecko", "--triangles", "8000", "-o", "coarse.glb"});
  for (const char* output : {"out.glb", "out.npz"})
    expect_runs(folder, {"transfer", "fine.glb", "coarse.glb", "--quality", "draft", "-o", output});
  expect_runs(folder, {"bind", "coarse.glb", "--quality", "draft", "-o", "bound.npz"});
  const SkinWeights carried = read_weights(folder / "out.npz"),
                    bound = read_weights(folder / "bound.npz");
  expect_valid(carried);
  expect_valid(*read_gltf(folder / "out.glb").characters.front().weights);
  ASSERT_EQ(carried.W.rows(), bound.W.rows());
  EXPECT_LT(compare(carried, bound).mean, 0.05) << "the levels are of one shape";
}

TEST(Pipeline, TurnsAndScalesObj) {
  // The box stands along z in a file with z up, in hundredths.
  const BoxFolder folder;
  const auto bind = [&folder](const std::vector<std::string>& more, const std::string& output) {
    std::vector<std::string> all{"bind",    "box.obj", "--skeleton", "box.tgf",
                                 "--nodes", "200",     "-o",         output};
    all.insert(all.end(), more.begin(), more.end());
    expect_runs(folder, all);
  };
  bind({}, "plain.glb");
  bind({"--up", "z", "--scale", "100"}, "turned.glb");
  const auto plain = read_gltf(folder / "plain.glb"), turned = read_gltf(folder / "turned.glb");
  const auto& a = plain.characters.front();
  const auto& b = turned.characters.front();
  ASSERT_EQ(a.vertex_of_input.size(), b.vertex_of_input.size());
  for (std::size_t i = 0; i < a.vertex_of_input.size(); ++i) {
    const skinfield::Vec3 p = a.mesh.V.row(a.vertex_of_input[i]);
    const skinfield::Vec3 q = b.mesh.V.row(b.vertex_of_input[i]);
    EXPECT_LT((q - 100 * skinfield::Vec3(p.x(), p.z(), -p.y())).norm(), 1e-4);
  }
  const double mean = compare(*a.weights, *b.weights).mean;
  EXPECT_LT(mean, 0.05) << "weights do not depend on axes and units";
}

TEST(Pipeline, TextInBinaryOutIsOneBuffer) {
  GltfBuilder b = skinned_square();
  Json text = Json::parse(b.text());
  text["buffers"].push_back(text["buffers"][0]);
  text["bufferViews"][1]["buffer"] = 1;
  const BoxFolder folder;
  write_file(folder / "square.gltf", text.dump());
  expect_runs(folder, {"bind", "square.gltf", "--quiet", "-o", "out.glb"});
  const auto before = read_gltf(folder / "square.gltf").characters.front();
  const auto after = read_gltf(folder / "out.glb").characters.front();
  EXPECT_EQ(after.mesh.V, before.mesh.V);
  EXPECT_EQ(after.mesh.F, before.mesh.F);
  EXPECT_EQ(read_file(folder / "out.glb").find("data:"), std::string::npos);
  const RunResult validated = validate_gltf(folder / "out.glb", folder / "square.gltf");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out;
}

TEST(Pipeline, MoreThanOneCharacter) {
  // Two squares, each under a skeleton of its own: both are bound, a matrix has room for one.
  GltfBuilder b = skinned_square();
  b.json["meshes"].push_back(b.json["meshes"][0]);
  b.json["meshes"][1]["name"] = "other";
  b.json["skins"].push_back(b.json["skins"][0]);
  b.json["skins"][1]["joints"] = {4, 5};
  b.push("nodes", {{"name", "c"}, {"children", Json::array({5})}});
  b.push("nodes", {{"name", "d"}, {"translation", {0.0, 1.0, 0.0}}});
  b.push("nodes", {{"name", "other"}, {"mesh", 1}, {"skin", 1}});
  b.json["scenes"][0]["nodes"] = {0, 1, 4, 6};
  const BoxFolder folder;
  write_file(folder / "two.glb", b.glb());
  expect_refused(folder, {"bind", "two.glb", "-o", "out.npz"}, 2, {"2 characters", "--only"});
  const Json report =
      parsed(expect_runs(folder, {"bind", "two.glb", "-o", "out.glb", "--json", "--quiet"}).out);
  EXPECT_EQ(report["characters"].size(), 2U);
  EXPECT_EQ(read_gltf(folder / "out.glb").characters.size(), 2U);
  expect_runs(folder, {"bind", "two.glb", "--only", "other", "-o", "one.npz"});
  EXPECT_EQ(read_weights(folder / "one.npz").W.rows(), 4);
}

}  // namespace
}  // namespace skinfield_test
