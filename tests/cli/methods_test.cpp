// Every method of bind, as a user asks for it.
#include "cli/characters.h"
#include "domain/tetgen_mesher.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <map>
#include <set>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;
using skinfield::read_weights;
using skinfield::RowMatrix;

/// The sample gecko, coarse enough for tests.
struct GeckoFolder : TemporaryFolder {
  GeckoFolder() {
    expect_runs(*this, {"sample", "gecko", "--triangles", "6000", "-o", "gecko.glb"});
  }
  /// Weights and report of one method; rows are checked to lie on the simplex.
  RowMatrix bound(const std::string& method, Json& report,
                  const std::vector<std::string>& more = {}) const {
    const std::string file = method + ".npz";
    std::vector<std::string> all{"bind", "gecko.glb", "--method", method,
                                 "-o",   file,        "--json",   "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    report = Json::parse(expect_runs(*this, all).out);
    EXPECT_EQ(report["method"], method);
    RowMatrix W(read_weights(*this / file).W);
    EXPECT_TRUE(W.allFinite());
    EXPECT_GE(W.minCoeff(), 0);
    EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-9);
    return W;
  }
};

double tv(const RowMatrix& a, const RowMatrix& b) {
  return 0.5 * (a - b).cwiseAbs().rowwise().sum().mean();
}

TEST(Methods, EachGivesValidWeightsOfItsOwn) {
  const GeckoFolder folder;
  const std::vector<std::string> few{"--nodes", "800"};
  Json report;
  const RowMatrix bbw = folder.bound("bbw", report, few);
  EXPECT_EQ(report["weights"]["clamped_mass_max"], 0);
  EXPECT_FALSE(report["weights"].contains("extrema_before_projection"));
  EXPECT_EQ(report["options"]["solver"], "primal");
  const RowMatrix harmonic = folder.bound("harmonic", report, few);
  EXPECT_LT(report["weights"]["clamped_mass_max"], 1e-12) << "the maximum principle";
  EXPECT_FALSE(report["options"].contains("tolerance"));
  EXPECT_EQ(report["weights"]["extrema_before_projection"], report["weights"]["extrema"])
      << "nothing had to be projected";
  const RowMatrix biharmonic = folder.bound("biharmonic", report, few);
  EXPECT_EQ(report["solve"]["status"], "converged");
  EXPECT_GT(report["weights"]["clamped_mass_mean"], 1e-4);
  EXPECT_GE(report["weights"]["clamped_mass_max"], report["weights"]["clamped_mass_mean"]);
  const RowMatrix triharmonic = folder.bound("triharmonic", report, few);
  const RowMatrix heat = folder.bound("bone-heat", report);
  EXPECT_EQ(report["domain"]["kind"], "surface");
  EXPECT_EQ(report["domain"]["nodes"], report["input"]["merged_vertices"]);
  EXPECT_GT(report["input"]["handles_inside"].size(), 30U);
  EXPECT_FALSE(report["options"].contains("nodes"));
  EXPECT_GT(tv(heat, bbw), 0.01);
  EXPECT_LT(tv(heat, bbw), 0.4);
  EXPECT_GT(tv(harmonic, bbw), 0.01);
  EXPECT_GT(tv(biharmonic, bbw), 1e-3);
  EXPECT_GT(tv(triharmonic, biharmonic), 0.01);
  EXPECT_LT(tv(biharmonic, bbw), tv(triharmonic, bbw)) << "the more it oscillates";
}

TEST(Methods, SolversAgreeAndTheOthersHaveMoreEnergy) {
  if (!skinfield::have_tetgen()) GTEST_SKIP() << "the permissive profile has no TetGen";
  const BoxFolder folder;
  expect_runs(folder, {"tetrahedralise", "box.obj", "--skeleton", "box.tgf", "--nodes", "600", "-o",
                       "box.mesh"});
  const auto bound = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"bind", "box.mesh", "--skeleton", "box.tgf",
                                 "-o",   "w.npz",    "--json",     "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    const Json report = Json::parse(expect_runs(folder, all).out);
    EXPECT_EQ(report["domain"]["kind"], "tets");
    const RowMatrix W(read_weights(folder / "w.npz").W);
    EXPECT_GE(W.minCoeff(), 0);
    EXPECT_LT((W.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-9);
    return std::pair(W, report["solve"]["biharmonic_energy"].get<double>());
  };
  const auto [W, energy] = bound({"--tolerance", "1e-6"});
  for (const std::string solver : {"dual", "active-set"}) {
    const auto [other, its_energy] = bound({"--solver", solver, "--tolerance", "1e-8"});
    EXPECT_NEAR(its_energy, energy, 1e-6 * energy) << solver;
    EXPECT_LT((W - other).cwiseAbs().maxCoeff(), 1e-2) << solver;
  }
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {"--method", "bbw-decoupled"},
           {"--method", "bbw-decoupled", "--solver", "dual"},
           {"--method", "bbw-decoupled", "--solver", "dual-unboxed"},
           {"--method", "bbw-decoupled", "--solver", "active-set"},
           {"--method", "monotonic"},
           {"--method", "monotonic", "--solver", "decoupled"},
           {"--method", "quasi-harmonic"}})
    EXPECT_GE(bound(more).second, energy * (1 - 1e-6)) << more.back();
}

TEST(Methods, OptionsWithoutUseOnThisShapeAreNamed) {
  if (!skinfield::have_tetgen()) GTEST_SKIP() << "the permissive profile has no TetGen";
  const BoxFolder folder;
  expect_runs(folder, {"tetrahedralise", "box.obj", "--skeleton", "box.tgf", "--nodes", "200", "-o",
                       "box.mesh", "--quiet"});
  const auto bound = expect_runs(folder, {"bind", "box.mesh", "--skeleton", "box.tgf", "--nodes",
                                          "300", "--seed", "2", "-o", "w.npz", "--quiet"});
  EXPECT_NE(bound.err.find("--nodes has no effect"), std::string::npos) << bound.err;
  EXPECT_NE(bound.err.find("--seed has no effect"), std::string::npos) << bound.err;
}

TEST(Methods, HistoryOfTheDualIsInTheReport) {
  const BoxFolder folder;
  expect_runs(folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "300", "--solver",
                       "dual", "-o", "w.npz", "--report", "r.json", "--quiet"});
  const Json report = Json::parse(read_file(folder / "r.json"));
  const Json& history = report["solve"]["history"];
  ASSERT_EQ(history["columns"].size(), 4U);
  ASSERT_GT(history["rows"].size(), 2U);
  const double energy = report["solve"]["energy"];
  for (const Json& row : history["rows"])
    EXPECT_LE(row[2].get<double>(), energy * (1 + 1e-9)) << "weak duality";
}

TEST(Methods, QuasiHarmonicMakesItsOwnElements) {
  if (!skinfield::have_tetgen()) GTEST_SKIP() << "the permissive profile has no TetGen";
  const BoxFolder folder;
  const Json report = Json::parse(
      expect_runs(folder, {"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "600", "--method",
                           "quasi-harmonic", "-o", "w.npz", "--json", "--quiet"})
          .out);
  EXPECT_EQ(report["domain"]["kind"], "tets");
  EXPECT_TRUE(report["solve"]["kkt_residual"].is_null()) << "not measured";
  EXPECT_TRUE(report["weights"].contains("extrema_before_projection"));
  const Json& seconds = report["timings_s"];
  EXPECT_GT(seconds["solve_linear"], 0);
  EXPECT_LT(seconds["solve_linear"], seconds["solve_steps"]);
  EXPECT_LE(seconds["solve_start"].get<double>() + seconds["solve_steps"].get<double>(),
            seconds["solve"]);
}

TEST(Methods, OptimisersOfQuasiHarmonicAreChosenByName) {
  if (!skinfield::have_tetgen()) GTEST_SKIP() << "the permissive profile has no TetGen";
  const BoxFolder folder;
  expect_runs(folder, {"tetrahedralise", "box.obj", "--skeleton", "box.tgf", "--nodes", "600", "-o",
                       "box.mesh"});
  std::map<std::string, std::vector<double>> energies;
  for (const std::string solver : {"adam-lbfgs", "restarted-adam", "adam", "lbfgs"}) {
    expect_runs(folder, {"bind", "box.mesh", "--skeleton", "box.tgf", "--method", "quasi-harmonic",
                         "--solver", solver, "--iterations", "30", "--tolerance", "1e-9", "-o",
                         "w.npz", "--report", "r.json", "--quiet"});
    const Json report = Json::parse(read_file(folder / "r.json"));
    EXPECT_EQ(report["options"]["solver"], solver);
    for (const Json& row : report["solve"]["history"]["rows"])
      energies[solver].push_back(row[1].get<double>());
    ASSERT_GE(energies[solver].size(), solver == "adam-lbfgs" ? 25U : 31U);
    EXPECT_EQ(energies[solver][0], energies["adam-lbfgs"][0]) << "the same objective and start";
  }
  EXPECT_EQ(energies["restarted-adam"][24], energies["adam-lbfgs"][24]);
  std::set<double> second_round;
  for (const auto& [solver, history] : energies) second_round.insert(history[8]);
  EXPECT_EQ(second_round.size(), 3U) << "but for the first two, which part after 24 steps";
}

TEST(Methods, PaintAndLocksHoldInEach) {
  if (!skinfield::have_tetgen()) GTEST_SKIP() << "the permissive profile has no TetGen";
  const BoxFolder folder;
  write_file(folder / "paint.csv", "0,0,1\n19,0.25,0.75\n");
  std::string given = "one,two\n";
  for (int v = 0; v < 20; ++v) given += v < 8 ? "0.7,0.3\n" : "0.2,0.8\n";
  write_file(folder / "given.csv", given);
  for (const std::string method : {"bbw", "bbw-decoupled", "quasi-harmonic", "harmonic",
                                   "biharmonic", "triharmonic", "bone-heat"}) {
    SCOPED_TRACE(method);
    std::vector<std::string> base{"bind",     "box.obj", "--skeleton", "box.tgf",
                                  "--method", method,    "-o",         "w.npz"};
    if (method != "bone-heat") base.insert(base.end(), {"--nodes", "200"});
    auto painting = base, locking = base;
    painting.insert(painting.end(), {"--paint", "paint.csv"});
    expect_runs(folder, painting);
    const RowMatrix painted(read_weights(folder / "w.npz").W);
    EXPECT_NEAR(painted(0, 1), 1, 1e-12);
    EXPECT_NEAR(painted(19, 0), 0.25, 1e-12);
    const auto names = read_weights(folder / "w.npz").names;
    ASSERT_EQ(names.size(), 2U);
    locking.insert(locking.end(), {"--weights-in", "given.csv", "--lock", names[0]});
    expect_runs(folder, locking);
    const RowMatrix locked(read_weights(folder / "w.npz").W);
    for (int v = 0; v < 20; ++v) {
      EXPECT_NEAR(locked(v, 0), v < 8 ? 0.7 : 0.2, 1e-9) << v;
      EXPECT_NEAR(locked.row(v).sum(), 1, 1e-9) << v;
    }
  }
}

TEST(Methods, OptionsWithoutUseAreRefused) {
  const BoxFolder folder;
  write_file(
      folder / "given.csv", std::string("a,b\n") + [] {
        std::string rows;
        for (int v = 0; v < 20; ++v) rows += "0.5,0.5\n";
        return rows;
      }());
  const auto refused = [&](const std::string& method, const std::vector<std::string>& more,
                           const std::vector<std::string>& words) {
    std::vector<std::string> all{"bind",     "box.obj", "--skeleton", "box.tgf",
                                 "--method", method,    "-o",         "out.glb"};
    all.insert(all.end(), more.begin(), more.end());
    expect_refused(folder, all, 2, words);
  };
  refused("monotonic", {"--weights-in", "given.csv", "--lock", "*"}, {"monotonic", "keep columns"});
  refused("quasi-harmonic", {"--domain", "points"}, {"quasi-harmonic", "tetrahedra"});
  refused("bbw-decoupled", {"--solver", "active-set", "--tolerance", "1e-3"},
          {"--tolerance", "active-set", "--iterations"});
  refused("geometric-fields", {"--solver", "adam", "--tolerance", "1e-3"}, {"--tolerance", "adam"});
  refused("monotonic", {"--solver", "dual"}, {"dual", "monotonic", "coupled"});
  refused("harmonic", {"--tolerance", "1e-3"}, {"--tolerance", "harmonic", "directly"});
  refused("biharmonic", {"--iterations", "10"}, {"--iterations", "biharmonic"});
  refused("triharmonic", {"--time-limit", "1"}, {"--time-limit"});
  refused("harmonic", {"--solver", "primal"}, {"--solver", "harmonic"});
  refused("harmonic", {"--weights-in", "given.csv"}, {"box.obj", "cannot start from weights"});
  refused("harmonic", {"--mass", "voronoi"}, {"--mass", "no masses"});
  refused("bone-heat", {"--nodes", "100"}, {"--nodes", "bone-heat", "vertices"});
  refused("bone-heat", {"--domain", "points"}, {"box.obj", "surface", "leave the domain out"});
  refused("bone-heat", {"--weights-in", "given.csv"}, {"cannot start from weights"});
  refused("bbw", {"--mass", "voronoi"}, {"box.obj", "masses of their own", "--domain tets"});
  refused("nonsense", {}, {"--method"});
  refused("bbw", {"--solver", "nonsense"}, {"--solver"});
}

TEST(Methods, BoneHeatNeedsASurface) {
  const BoxFolder folder;
  std::string cloud = box_obj();
  cloud.resize(cloud.find("f "));
  write_file(folder / "cloud.obj", cloud);
  expect_refused(
      folder,
      {"bind", "cloud.obj", "--skeleton", "box.tgf", "--method", "bone-heat", "-o", "out.glb"}, 2,
      {"cloud.obj", "point cloud", "--method bbw"});
}

TEST(Methods, MassesByNameAndFromAFile) {
  const BoxFolder folder;
  const auto bound = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"bind", "box.obj", "--skeleton", "box.tgf", "-o", "w.npz"};
    all.insert(all.end(), more.begin(), more.end());
    expect_runs(folder, all);
    return RowMatrix(read_weights(folder / "w.npz").W);
  };
  const RowMatrix plain = bound({"--method", "bone-heat"});
  EXPECT_GT(tv(bound({"--method", "bone-heat", "--mass", "voronoi"}), plain), 1e-6);
  EXPECT_GT(tv(bound({"--domain", "tris", "--mass", "voronoi"}), bound({"--domain", "tris"})), 0);
  // Barycentric masses of the box as a file: a third of each triangle's area (1/2, at the ends
  // too) a corner; the corners of the ends meet two or three of them more.
  std::string dmat = "1 20\n", mtx = "%%MatrixMarket matrix array real general\n20 1\n";
  const std::string obj = box_obj();
  std::vector<double> mass(20, 0);
  std::vector<std::array<int, 4>> quads;
  for (const std::string& line : lines(obj)) {
    std::array<int, 4> q{};
    if (std::sscanf(line.c_str(), "f %d %d %d %d", &q[0], &q[1], &q[2], &q[3]) == 4)
      quads.push_back(q);
  }
  ASSERT_EQ(quads.size(), 18U);
  for (const auto& q : quads) {  // split along the diagonal from the first corner
    for (const int k : {0, 1, 2, 0, 2, 3})
      mass[static_cast<std::size_t>(q[static_cast<std::size_t>(k)] - 1)] += 1.0 / 6;
  }
  for (const double m : mass) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g\n", m);
    dmat += text;
    mtx += text;
  }
  write_file(folder / "m.dmat", dmat);
  write_file(folder / "m.mtx", mtx);
  for (const char* file : {"m.dmat", "m.mtx"})
    EXPECT_LT((bound({"--method", "bone-heat", "--mass", file}) - plain).cwiseAbs().maxCoeff(),
              1e-12);

  write_file(folder / "short.dmat", "1 3\n1\n1\n1\n");
  std::string zero = dmat;
  zero.replace(5, zero.find('\n', 5) - 5, "0");
  write_file(folder / "zero.dmat", zero);
  const auto refused = [&](const char* file, int code, const std::vector<std::string>& words,
                           const std::vector<std::string>& more) {
    std::vector<std::string> all{"bind",   "box.obj", "--skeleton", "box.tgf",
                                 "--mass", file,      "-o",         "out.glb"};
    all.insert(all.end(), more.begin(), more.end());
    expect_refused(folder, all, code, words);
  };
  const std::vector<std::string> heat{"--method", "bone-heat"};
  refused("short.dmat", 3, {"3 masses for 20 vertices"}, heat);
  refused("zero.dmat", 3, {"mass of vertex 0", "not positive"}, heat);
  refused("nonsense", 3, {"nonsense"}, heat);
  refused("m.dmat", 3, {"must be split", "no vertex"}, {"--domain", "tris"});
}

}  // namespace
}  // namespace skinfield_test
