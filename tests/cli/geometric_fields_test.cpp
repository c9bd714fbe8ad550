// Geometric fields as a user asks for them: pause, paint, resume.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <sstream>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::compare;
using skinfield::read_gltf;
using skinfield::read_weights;
using skinfield::RowMatrix;
using skinfield::SkinWeights;

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

TEST(GeometricFieldsVerb, SavedFieldsAreTransferred) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "24000", "-o", "fine.glb"});
  expect_runs(folder, {"sample", "gecko", "--triangles", "8000", "-o", "coarse.glb"});
  const std::vector<std::string> method{"--method", "geometric-fields", "--quality", "draft"};
  const auto bind = [&](std::vector<std::string> all) {
    all.insert(all.end(), method.begin(), method.end());
    expect_runs(folder, all);
  };
  bind({"bind", "fine.glb", "--save-field", "gecko.sfield", "-o", "fine.npz"});
  bind({"bind", "coarse.glb", "-o", "coarse.npz"});
  // The shape itself has its own rows again.
  expect_runs(folder, {"transfer", "gecko.sfield", "fine.glb", "-o", "again.npz"});
  EXPECT_LT(compare(read_weights(folder / "again.npz"), read_weights(folder / "fine.npz")).mean,
            1e-9);
  const RunResult to_coarse = expect_runs(folder, {"transfer", "gecko.sfield", "coarse.glb", "-o",
                                                   "lod.npz", "--json", "--report", "lod.json"});
  const SkinWeights carried = read_weights(folder / "lod.npz"),
                    bound = read_weights(folder / "coarse.npz");
  EXPECT_LT(compare(carried, bound).mean, 0.05) << "the levels are of one shape";
  EXPECT_EQ(carried.names, bound.names);
  const Json report = Json::parse(to_coarse.out);
  EXPECT_EQ(Json::parse(read_file(folder / "lod.json")), report);
  EXPECT_EQ(report["weights"]["rows"], bound.W.rows());
  EXPECT_EQ(report["weights"]["negative"], 0);
  EXPECT_LT(report["weights"]["row_sum_error"], 1e-9);
  EXPECT_GT(report["peak_memory_bytes"], 0);
  const Json counts = report["field_vertices"];
  const auto all = counts["seen"].get<int>() + counts["flood_filled"].get<int>() +
                   counts["without_rays"].get<int>() + counts["passengers"].get<int>();
  EXPECT_GT(counts["seen"], 0);
  EXPECT_LE(all, bound.W.rows()) << "vertices in one place are one";
  // A rigged file, joints and all.
  expect_runs(folder, {"transfer", "gecko.sfield", "coarse.glb", "-o", "lod.glb"});
  const skinfield::Skeleton was = read_gltf(folder / "fine.glb").characters.front().skeleton,
                            is = read_gltf(folder / "lod.glb").characters.front().skeleton;
  ASSERT_EQ(is.joints.size(), was.joints.size());
  for (std::size_t j = 0; j < is.joints.size(); ++j) {
    EXPECT_EQ(is.joints[j].name, was.joints[j].name);
    EXPECT_LT((is.joints[j].position - was.joints[j].position).norm(), 1e-5);
  }
}

TEST(GeometricFieldsVerb, ATransferredFieldRigsAnObj) {
  const BoxFolder folder;
  expect_runs(folder, field_of_box({"--nodes", "500", "--save-field", "box.sfield"}));
  expect_runs(folder, {"transfer", "box.sfield", "box.obj", "-o", "rigged.glb"});
  const skinfield::Character rigged = read_gltf(folder / "rigged.glb").characters.front();
  EXPECT_EQ(rigged.skeleton.joints.size(), 3u) << "two bones and the end of the second";
  // As binding straight into a glTF gives it.
  auto straight = field_of_box({"--nodes", "500"});
  straight[7] = "bound.glb";
  expect_runs(folder, straight);
  EXPECT_LT(
      compare(*rigged.weights, *read_gltf(folder / "bound.glb").characters.front().weights).max,
      1e-6);
  expect_refused(folder, {"transfer", "box.sfield", "box.obj", "--nodes", "99", "-o", "out.glb"}, 2,
                 {"--nodes", "box.sfield"});
  expect_refused(folder,
                 {"transfer", "box.sfield", "box.obj", "-o", "out.glb", "--report", "out.glb"}, 2,
                 {"out.glb"});
  write_file(folder / "bad.sfield", "no field");
  expect_refused(folder, {"transfer", "bad.sfield", "box.obj", "-o", "out.glb"}, 3, {"bad.sfield"});
}

TEST(GeometricFieldsVerb, WithoutAnInsideTheSurfaceStandsIn) {
  const BoxFolder folder;
  write_file(folder / "sheet.obj",
             "v 0 0 0\nv 2 0 0.2\nv 4 0 0\nv 0 1 0\nv 2 1 0.2\nv 4 1 0\n"
             "f 1 2 5 4\nf 2 3 6 5\n");
  auto flat = field_of_box({"--json"});
  flat[1] = "sheet.obj";
  const Json report = Json::parse(expect_runs(folder, flat).out);
  EXPECT_EQ(report["domain"]["rung"], "surface");
  EXPECT_EQ(report["domain"]["kind"], "tris");
  EXPECT_FALSE(report["warnings"].empty());
  EXPECT_GT(weights(folder)(0, 0), 0.5);
  flat = field_of_box({"--save-field", "a.sfield"});
  flat[1] = "sheet.obj";
  flat[7] = "out.glb";
  expect_refused(folder, flat, 4, {"sheet.obj", "inside", "--save-field"});
}

TEST(GeometricFieldsVerb, FlatShapesHaveFieldsOfTheirArea) {
  const BoxFolder folder;
  // A comb of two prongs, as an outline, and the outline with two sides missing.
  write_file(folder / "comb.obj",
             "v 0 0 0\nv 1 0 0\nv 4 0 0\nv 4 .45 0\nv 1 .45 0\nv 1 .55 0\nv 4 .55 0\nv 4 1 0\n"
             "v 1 1 0\nv 0 1 0\nl 1 2 3 4 5 6 7 8 9 10 1\n");
  write_file(folder / "soup.obj",
             "v 0 0 0\nv 1 0 0\nv 4 0 0\nv 4 .45 0\nv 1 .45 0\nv 1 .55 0\nv 4 .55 0\nv 4 1 0\n"
             "v 1 1 0\nv 0 1 0\nl 2 3 4\nl 4 5 6 7\nl 8 9 10 1\n");
  write_file(folder / "comb.tgf", "1 1.2 .2 0\n2 3.8 .2 0\n3 1.2 .8 0\n4 3.8 .8 0\n#\n1 2\n3 4\n");
  for (const char* file : {"comb.obj", "soup.obj"}) {
    auto all =
        field_of_box({"--nodes", "1500", "--seed", "2", "--save-field", "comb.sfield", "--json"});
    all[1] = file;
    all[3] = "comb.tgf";
    std::erase(all, "--quiet");
    const RunResult result = expect_runs(folder, all);
    EXPECT_EQ(result.err.find("--seed"), std::string::npos) << result.err;
    const Json report = Json::parse(result.out);
    EXPECT_EQ(report["domain"]["kind"], "field");
    EXPECT_EQ(report["domain"]["rung"], "surface");
    const RowMatrix W = weights(folder);
    ASSERT_EQ(W.rows(), 10);
    EXPECT_GT(W(2, 0), 0.9);
    EXPECT_GT(W(7, 1), 0.9);
    expect_runs(folder, {"transfer", "comb.sfield", "comb.obj", "-o", "again.npz"});
    const RowMatrix again(read_weights(folder / "again.npz").W);
    EXPECT_LT((again - W).cwiseAbs().rowwise().sum().mean(), 0.1) << file;
  }
}

TEST(GeometricFieldsVerb, ParametersForComparisons) {
  const BoxFolder folder;
  const auto report = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--nodes", "600", "--json"});
    return Json::parse(expect_runs(folder, field_of_box(more)).out);
  };
  const Json own = report({});
  EXPECT_FALSE(own["solve"].contains("judged"));
  EXPECT_EQ(own["options"]["visibility"], "counted");
  const RowMatrix W = weights(folder);
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--kernel-width", "2"},
                                             {"--difference-step", "0.25"},
                                             {"--rows-per-point", "3"},
                                             {"--levels", "3"}}) {
    report(more);
    EXPECT_GT((weights(folder) - W).cwiseAbs().maxCoeff(), 1e-6) << more[0];
  }
  const std::vector<std::string> adam{"--solver", "adam", "--iterations", "5"};
  auto fewer = adam;
  fewer.insert(fewer.end(), {"--samples-per-step", "16"});
  report(adam);
  const RowMatrix by_adam = weights(folder);
  report(fewer);
  EXPECT_GT((weights(folder) - by_adam).cwiseAbs().maxCoeff(), 1e-6);
  report({"--visibility", "counted"});
  EXPECT_EQ(weights(folder), W);
  report({"--visibility", "none"});
  EXPECT_LT((weights(folder) - W).cwiseAbs().maxCoeff(), 1e-6) << "a box has nothing in its way";
  const Json judged = report({"--levels", "2", "--judge-step", "0.02"})["solve"]["judged"];
  ASSERT_EQ(judged["rows"].size(), 2u);
  EXPECT_LT(judged["rows"][0][1], judged["rows"][1][1]) << "points";
  EXPECT_EQ(judged["rows"][1][2], judged["energy"]);
  // Twice the size: an integral of squared second derivatives halves.
  std::istringstream box(box_obj());
  std::string large, line;
  double x, y, z;
  while (std::getline(box, line))
    large += (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3
                  ? "v " + std::to_string(2 * x) + " " + std::to_string(2 * y) + " " +
                        std::to_string(2 * z)
                  : line) +
             "\n";
  write_file(folder / "large.obj", large);
  write_file(folder / "large.tgf", "1 1 1 1\n2 4 1 1\n3 7 1 1\n#\n1 2\n2 3\n");
  const Json small = report({"--judge-step", "0.02"})["solve"];
  auto all = field_of_box({"--nodes", "600", "--judge-step", "0.02", "--json"});
  all[1] = "large.obj", all[3] = "large.tgf";
  const Json twice = Json::parse(expect_runs(folder, all).out)["solve"];
  const auto halves = [](const Json& from, const Json& to) {
    EXPECT_NEAR(2 * to.get<double>(), from.get<double>(), 1e-2 * from.get<double>());
  };
  halves(small["judged"]["energy"], twice["judged"]["energy"]);
  halves(small["energy"], twice["energy"]);
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
  refused({"--resume", "a.sfield", "--visibility", "none"}, 2, {"--visibility", "--resume"});
  refused({"--solver", "adam", "--rows-per-point", "6"}, 2, {"--rows-per-point", "convex"});
  refused({"--samples-per-step", "64"}, 2, {"--samples-per-step", "adam"});
  refused({"--levels", "0"}, 2, {"--levels"});
  expect_refused(
      folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--kernel-width", "2", "-o", "out.glb"},
      2, {"--kernel-width", "bbw", "geometric field"});
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
