// Geometric fields as a user asks for them: pause, paint, resume.
#include "cli/characters.h"
#include "skinfield/io/weights_file.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::read_weights;
using skinfield::RowMatrix;

std::vector<std::string> field_of_box(const std::vector<std::string>& more) {
  std::vector<std::string> all{"bind",    "box.obj",  "--skeleton",
                               "box.tgf", "--method", "geometric-fields",
                               "-o",      "w.npz",    "--quiet"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

RowMatrix weights(const BoxFolder& folder) {
  RowMatrix W(read_weights(folder / "w.npz").W);
  EXPECT_TRUE(W.allFinite());
  EXPECT_GE(W.minCoeff(), 0);
  EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-9);
  return W;
}

TEST(GeometricFieldsVerb, EveryOptimiserAndBoundaryGivesValidWeights) {
  const BoxFolder folder;
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {"--nodes", "1000"},
           {"--nodes", "1000", "--boundary", "neumann"},
           {"--nodes", "500", "--solver", "adam", "--iterations", "30"},
           {"--nodes", "500", "--solver", "adam-pool", "--iterations", "30"}}) {
    auto all = field_of_box(more);
    all.emplace_back("--json");
    const Json report = Json::parse(expect_runs(folder, all).out);
    EXPECT_EQ(report["domain"]["kind"], "field");
    EXPECT_EQ(report["method"], "geometric-fields");
    EXPECT_EQ(report["weights"]["field_vertices"]["seen"], 20);
    const RowMatrix W = weights(folder);
    EXPECT_GT(W(0, 0), 0.5) << "the end of the box belongs to the bone there";
    EXPECT_GT(W(19, 1), 0.5);
  }
}

TEST(GeometricFieldsVerb, APausedSolveGoesOnAsIfItHadNotBeen) {
  const BoxFolder folder;
  const std::vector<std::string> adam{"--solver", "adam", "--nodes", "500", "--iterations"};
  auto half = adam, whole = adam;
  half.insert(half.end(), {"20", "--save-field", "half.sfield"});
  whole.emplace_back("40");
  expect_runs(folder, field_of_box(half));
  expect_runs(folder, field_of_box({"--resume", "half.sfield", "--iterations", "40"}));
  const std::string resumed = read_file(folder / "w.npz");
  expect_runs(folder, field_of_box(whole));
  EXPECT_EQ(resumed, read_file(folder / "w.npz"));
}

TEST(GeometricFieldsVerb, PaintComesInWhenResumed) {
  const BoxFolder folder;
  expect_runs(folder, field_of_box({"--nodes", "1000", "--save-field", "a.sfield"}));
  const RowMatrix before = weights(folder);
  EXPECT_GT(before(0, 0), 0.5);
  write_file(folder / "paint.csv", "0,0,1\n1,0,1\n2,0,1\n3,0,1\n");
  expect_runs(folder, field_of_box({"--resume", "a.sfield", "--paint", "paint.csv"}));
  const RowMatrix after = weights(folder);
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(after(v, 1), 1, 1e-12) << v;
  EXPECT_GT(after(4, 1), before(4, 1)) << "the neighbours feel it";
}

TEST(GeometricFieldsVerb, WithoutAnInsideTheSurfaceStandsIn) {
  const BoxFolder folder;
  write_file(folder / "flat.obj",
             "v 0 0 0\nv 2 0 0\nv 4 0 0\nv 0 1 0\nv 2 1 0\nv 4 1 0\n"
             "f 1 2 5 4\nf 2 3 6 5\n");
  auto flat = field_of_box({"--json"});
  flat[1] = "flat.obj";
  const Json report = Json::parse(expect_runs(folder, flat).out);
  EXPECT_EQ(report["domain"]["rung"], "surface");
  EXPECT_EQ(report["domain"]["kind"], "tris");
  EXPECT_FALSE(report["warnings"].empty());
  EXPECT_GT(weights(folder)(0, 0), 0.5);
  flat = field_of_box({"--save-field", "a.sfield"});
  flat[1] = "flat.obj";
  flat[7] = "out.glb";
  expect_refused(folder, flat, 4, {"flat.obj", "no inside", "--save-field"});
}

TEST(GeometricFieldsVerb, SaysWhatDoesNotFit) {
  const BoxFolder folder;
  expect_runs(folder, field_of_box({"--nodes", "300", "--save-field", "a.sfield"}));
  write_file(folder / "other.tgf", "1 0.5 0.5 0.5\n2 3.5 0.5 0.5\n#\n1 2\n");
  auto other = field_of_box({"--resume", "a.sfield"});
  other[3] = "other.tgf";
  other[7] = "out.glb";
  expect_refused(folder, other, 3, {"other handles"});
  const auto refused = [&](const std::vector<std::string>& more, int code,
                           const std::vector<std::string>& words) {
    auto all = field_of_box(more);
    all[7] = "out.glb";
    expect_refused(folder, all, code, words);
  };
  refused({"--resume", "a.sfield", "--nodes", "100"}, 2, {"--nodes", "--resume"});
  refused({"--resume", "none.sfield"}, 3, {"none.sfield"});
  refused({"--save-field", "a.npz"}, 2, {"a.npz", ".sfield"});
  refused({"--domain", "points"}, 2, {"domain of its own"});
  refused({"--solver", "primal"}, 2, {"primal", "convex"});
  expect_refused(
      folder,
      {"bind", "box.obj", "--skeleton", "box.tgf", "--boundary", "natural", "-o", "out.glb"}, 2,
      {"--boundary", "bbw", "Neumann"});
}

}  // namespace
}  // namespace skinfield_test
