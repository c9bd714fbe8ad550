// Sets of vertices as handles, for every method.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/io.h"
#include "skinfield/io/weights_file.h"
#include "support/data.h"
#include "support/tibiman.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::read_weights;
using skinfield::RowMatrix;

/// A column a list of vertices of the box.
std::string region_csv(const std::string& header, const std::vector<std::vector<int>>& regions) {
  std::string text = header + "\n";
  for (int v = 0; v < 20; ++v) {
    for (std::size_t r = 0; r < regions.size(); ++r)
      text += (r > 0 ? "," : "") +
              std::to_string(std::count(regions[r].begin(), regions[r].end(), v) > 0 ? 1 : 0);
    text += "\n";
  }
  return text;
}

struct RegionFolder : BoxFolder {
  RegionFolder() {
    write_file(*this / "ends.csv", region_csv("low,high", {{0, 1, 2, 3}, {16, 17, 18, 19}}));
  }
};

TEST(Regions, HoldTheirVerticesInEveryMethodAndDomain) {
  const RegionFolder folder;
  const std::vector<std::string> on_domain{"bbw",           "bbw-decoupled", "monotonic",
                                           "harmonic",      "biharmonic",    "triharmonic",
                                           "quasi-harmonic"};
  std::vector<std::vector<std::string>> cases{{"bone-heat"},
                                              {"geometric-fields", "--nodes", "300"}};
  for (const std::string& method : on_domain)
    for (const std::string domain : {"auto", "tets", "tris"})
      cases.push_back({method, "--domain", domain, "--nodes", "300"});
  for (const std::vector<std::string>& one : cases) {
    SCOPED_TRACE(one[0] + (one.size() > 3 ? " on " + one[2] : ""));
    std::vector<std::string> all{"bind",  "box.obj", "--regions", "ends.csv", "-o",
                                 "w.npz", "--json",  "--quiet",   "--method"};
    all.insert(all.end(), one.begin(), one.end());
    const Json report = Json::parse(expect_runs(folder, all).out);
    EXPECT_EQ(report["input"]["handles_inside"], Json({"low", "high"}));
    EXPECT_TRUE(report["weights"]["vertices_filled"].empty());
    const auto weights = read_weights(folder / "w.npz");
    EXPECT_EQ(weights.names, (std::vector<std::string>{"low", "high"}));
    const RowMatrix W(weights.W);
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(W(k, 0), 1, 1e-9);
      EXPECT_NEAR(W(16 + k, 1), 1, 1e-9);
    }
    for (int v = 4; v < 16; ++v) {
      EXPECT_NEAR(W.row(v).sum(), 1, 1e-9);
      EXPECT_NEAR(W(v, 0), 1 - 0.25 * (v / 4), 0.15) << v;
    }
  }
}

TEST(Regions, AVertexOfTwoIsShared) {
  const RegionFolder folder;
  write_file(folder / "shared.csv", region_csv("a,b", {{0, 1, 2, 3}, {3, 16}}));
  for (const std::string domain : {"points", "tets", "tris"}) {
    expect_runs(folder, {"bind", "box.obj", "--regions", "shared.csv", "--domain", domain,
                         "--nodes", "300", "-o", "w.npz"});
    const RowMatrix W(read_weights(folder / "w.npz").W);
    EXPECT_NEAR(W(3, 0), 0.5, 1e-12) << domain;
    EXPECT_NEAR(W(2, 0), 1, 1e-12) << domain;
  }
}

TEST(Regions, StandBehindBonesAndBecomeJoints) {
  const RegionFolder folder;
  expect_runs(folder,
              {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "300", "-o", "rig.glb"});
  for (const std::string skeleton : {"", "box.tgf", "rig.glb"}) {
    SCOPED_TRACE(skeleton);
    std::vector<std::string> all{"bind", "box.obj",   "--regions", "ends.csv", "--nodes", "300",
                                 "-o",   "bound.glb", "--weights", "w.npz",    "--quiet"};
    if (!skeleton.empty()) all.insert(all.end(), {"--skeleton", skeleton});
    expect_runs(folder, all);
    const std::vector<std::string> names = read_weights(folder / "w.npz").names;
    ASSERT_GE(names.size(), 2U);
    EXPECT_EQ(names[names.size() - 2], "low");
    EXPECT_EQ(names.back(), "high");
    const skinfield::Asset asset = skinfield::read_gltf(folder / "bound.glb");
    const auto& joints = asset.characters[0].skeleton.joints;
    const auto joint = [&](const std::string& name) {
      return std::find_if(joints.begin(), joints.end(),
                          [&](const auto& j) { return j.name == name; });
    };
    ASSERT_NE(joint("low"), joints.end());
    ASSERT_NE(joint("high"), joints.end());
    EXPECT_LT((joint("low")->position - skinfield::Vec3(0, 0.5, 0.5)).norm(), 1e-6);
    EXPECT_LT((joint("high")->position - skinfield::Vec3(4, 0.5, 0.5)).norm(), 1e-6);
    expect_runs(folder, {"render", "bound.glb", "--pose", "demo", "--width", "64", "--height", "48",
                         "-o", "posed.png"});
  }
}

TEST(Regions, ArePosedWithTheWeightsMadeForThem) {
  const RegionFolder folder;
  write_file(folder / "turn.json", R"({"high": {"translation": [0, 3, 0]}})");
  for (const std::string skeleton : {"", "box.tgf"}) {
    SCOPED_TRACE(skeleton);
    std::vector<std::string> shape{"box.obj", "--regions", "ends.csv"};
    if (!skeleton.empty()) shape.insert(shape.end(), {"--skeleton", skeleton});
    std::vector<std::string> bind{"bind"}, pose{"pose"}, render{"render"};
    for (auto* verb : {&bind, &pose, &render})
      verb->insert(verb->end(), shape.begin(), shape.end());
    bind.insert(bind.end(), {"--nodes", "300", "-o", "w.npz", "--quiet"});
    expect_runs(folder, bind);
    pose.insert(pose.end(), {"--weights", "w.npz", "--pose", "turn.json", "-o", "posed.obj"});
    expect_runs(folder, pose);
    const skinfield::Asset asset = skinfield::read_asset(folder / "posed.obj");
    const auto& V = asset.characters[0].mesh.V;
    for (int v = 0; v < 4; ++v) {
      EXPECT_NEAR(V(v, 1) - (v == 1 || v == 2 ? 1 : 0), 0, 1e-9) << "of the other region";
      EXPECT_NEAR(V(16 + v, 1) - (v == 1 || v == 2 ? 1 : 0), 3, 1e-9);
    }
    expect_runs(folder, [&] {
      auto demo = pose;
      std::replace(demo.begin(), demo.end(), std::string("turn.json"), std::string("demo"));
      return demo;
    }());
    EXPECT_GT((skinfield::read_asset(folder / "posed.obj").characters[0].mesh.V - V).norm(), 0.1);
    render.insert(render.end(), {"--weights", "w.npz", "--bone", "high", "--width", "64",
                                 "--height", "48", "-o", "heat.png"});
    expect_runs(folder, render);
  }
  // Without them the matrix does not fit, and nothing says what could be posed.
  expect_refused(folder, {"pose", "box.obj", "--weights", "w.npz", "-o", "p.obj"}, 3,
                 {"box.obj", "no bones", "--regions"});
}

TEST(Regions, OffTheDomainHaveTheirOwnVerticesAtMost) {
  const BoxFolder folder;
  // A loose vertex behind the tetrahedra of a corner.
  write_file(folder / "tet.mesh",
             "MeshVersionFormatted 1\nDimension 3\nVertices 5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 "
             "0\n2 2 2 0\nTetrahedra 1\n1 2 3 4 0\nEnd\n");
  write_file(folder / "regions.csv", "on,off\n1,0\n0,0\n0,0\n0,0\n0,1\n");
  RunOptions options;
  options.folder = folder.path().string();
  const RunResult result =
      run({"bind", "tet.mesh", "--regions", "regions.csv", "-o", "w.npz", "--json", "--quiet"},
          options);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(Json::parse(result.out)["input"]["handles_outside"], Json({"off"}));
  EXPECT_NE(result.err.find("no node stands for region off"), std::string::npos) << result.err;
}

TEST(Regions, ThatMeanNothingAreRefused) {
  const RegionFolder folder;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    write_file(folder / "bad.csv", text);
    expect_refused(folder, {"bind", "box.obj", "--regions", "bad.csv", "-o", "out.glb"}, 3, words);
  };
  refused("1,0\n0,1\n", {"bad.csv", "2 rows", "20 vertices"});
  refused(region_csv("a,b", {{0, 1}, {}}), {"bad.csv", "region 1", "no vertex"});
  std::string shares = "a\n0.5\n";
  for (int v = 1; v < 20; ++v) shares += "1\n";
  refused(shares, {"bad.csv", "vertex 0", "0 nor 1", "--paint"});
  expect_refused(folder, {"bind", "box.obj", "--regions", "none.npy", "-o", "out.glb"}, 3,
                 {"none.npy"});
}

TEST(Regions, TheRodsOfTibimanGiveThePublishedEnergies) {
  SKINFIELD_NEEDS_DATA(mesh, "fem/tibiman.mesh");
  SKINFIELD_NEEDS_DATA(vertices, "fem/tibiman-B.mtx");
  SKINFIELD_NEEDS_DATA(values, "fem/tibiman-BC.mtx");
  SKINFIELD_NEEDS_DATA(masses, "fem/tibiman-mv.mtx");
  const TemporaryFolder folder;
  const Tibiman rods = tibiman(mesh.parent_path());
  skinfield::SkinWeights regions;
  regions.W.resize(rods.mesh.V.rows(), rods.fixed.weights.cols());
  for (std::size_t k = 0; k < rods.fixed.node.size(); ++k)
    for (Eigen::Index c = 0; c < regions.W.cols(); ++c)
      if (rods.fixed.weights(static_cast<Eigen::Index>(k), c) != 0)
        regions.W.insert(rods.fixed.node[k], c) = 1;
  regions.W.makeCompressed();
  skinfield::write_weights(folder / "rods.npz", regions, skinfield::WeightsLayout::csr);
  const auto twice_the_energy = [&](const std::string& method) {
    const Json report =
        Json::parse(expect_runs(folder, {"bind", mesh.string(), "--regions", "rods.npz", "--mass",
                                         masses.string(), "--domain", "tets", "--method", method,
                                         "-o", "w.npz", "--json", "--quiet"})
                        .out);
    EXPECT_EQ(report["domain"]["handle_nodes"], 2282);
    return 2 * report["solve"]["energy"].get<double>();
  };
  // Stated without the 1/2: 35912.3 exact, 36136.4 by the program of quasi-harmonic weights.
  EXPECT_NEAR(twice_the_energy("bbw"), 35912.3, 1);
  EXPECT_NEAR(twice_the_energy("quasi-harmonic"), 36011.3, 1);
}

}  // namespace
}  // namespace skinfield_test
