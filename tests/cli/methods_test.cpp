// Every method of bind, as a user asks for it.
#include "cli/characters.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"

#include <nlohmann/json.hpp>

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
  EXPECT_EQ(report["options"]["solver"], "primal");
  const RowMatrix harmonic = folder.bound("harmonic", report, few);
  EXPECT_LT(report["weights"]["clamped_mass_max"], 1e-12) << "the maximum principle";
  EXPECT_FALSE(report["options"].contains("tolerance"));
  const RowMatrix biharmonic = folder.bound("biharmonic", report, few);
  EXPECT_EQ(report["solve"]["status"], "converged");
  EXPECT_GT(report["weights"]["clamped_mass_mean"], 1e-4);
  EXPECT_GE(report["weights"]["clamped_mass_max"], report["weights"]["clamped_mass_mean"]);
  const RowMatrix triharmonic = folder.bound("triharmonic", report, few);
  EXPECT_GT(tv(harmonic, bbw), 0.01);
  EXPECT_GT(tv(biharmonic, bbw), 1e-3);
  EXPECT_GT(tv(triharmonic, biharmonic), 0.01);
  EXPECT_LT(tv(biharmonic, bbw), tv(triharmonic, bbw)) << "the more it oscillates";
}

TEST(Methods, PaintAndLocksHoldInEach) {
  const BoxFolder folder;
  write_file(folder / "paint.csv", "0,0,1\n19,0.25,0.75\n");
  std::string given = "one,two\n";
  for (int v = 0; v < 20; ++v) given += v < 8 ? "0.7,0.3\n" : "0.2,0.8\n";
  write_file(folder / "given.csv", given);
  for (const std::string method : {"bbw", "harmonic", "biharmonic", "triharmonic"}) {
    SCOPED_TRACE(method);
    const std::vector<std::string> base{"bind", "box.obj", "--skeleton", "box.tgf", "--method",
                                        method, "-o",      "w.npz",      "--nodes", "200"};
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
  refused("harmonic", {"--tolerance", "1e-3"}, {"--tolerance", "harmonic", "directly"});
  refused("biharmonic", {"--iterations", "10"}, {"--iterations", "biharmonic"});
  refused("triharmonic", {"--time-limit", "1"}, {"--time-limit"});
  refused("harmonic", {"--solver", "primal"}, {"--solver", "harmonic"});
  refused("harmonic", {"--weights-in", "given.csv"}, {"box.obj", "cannot start from weights"});
  refused("nonsense", {}, {"--method"});
  refused("bbw", {"--solver", "nonsense"}, {"--solver"});
}

}  // namespace
}  // namespace skinfield_test
