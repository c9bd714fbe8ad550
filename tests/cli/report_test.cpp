// What the program says: the report, --help, --version, and which stream is for what.
#include "cli/characters.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;

std::vector<std::string> bind_box(const std::vector<std::string>& more) {
  std::vector<std::string> all{"bind",    "box.obj", "--skeleton", "box.tgf",
                               "--nodes", "200",     "-o",         "out.npz"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(Report, HasEveryKey) {
  const BoxFolder folder;
  expect_runs(folder, bind_box({"--report", "r.json"}));
  const Json r = Json::parse(read_file(folder / "r.json"));
  EXPECT_EQ(r["schema"], 1);
  const std::map<std::string, std::vector<std::string>> wanted{
      {"",
       {"input", "method", "options", "seed", "threads", "profile", "domain", "solve", "weights",
        "timings_s", "cpu_s", "peak_memory_bytes", "warnings"}},
      {"input",
       {"vertices", "faces", "components", "boundary_edges", "nonmanifold_edges",
        "self_intersections_sampled", "degenerate_faces", "unit_scale", "handles_inside",
        "handles_partly_inside", "handles_outside", "joints_left_out"}},
      {"domain", {"kind", "rung", "nodes", "neighbours", "rays"}},
      {"solve", {"status", "iterations", "energy", "lower_bound", "relative_gap", "kkt_residual"}},
      {"weights",
       {"rows", "row_sum_error", "negative", "non_finite", "influences", "pruned_mass_mean",
        "pruned_mass_max", "handles_without_vertices", "vertices_filled", "extrema"}}};
  for (const auto& [place, keys] : wanted)
    for (const std::string& key : keys)
      EXPECT_TRUE((place.empty() ? r : r[place]).contains(key)) << place << "." << key;

  EXPECT_EQ(r["input"]["vertices"], 20);
  EXPECT_EQ(r["input"]["faces"], 36);
  EXPECT_EQ(r["input"]["unit_scale"], 0.25) << "the box is 4 long";
  EXPECT_EQ(r["input"]["handles_inside"].size(), 2U);
  EXPECT_EQ(r["domain"]["rung"], "volume");
  EXPECT_GT(r["domain"]["neighbours"], r["domain"]["nodes"]);
  EXPECT_GT(r["domain"]["rays"], 0);
  EXPECT_EQ(r["solve"]["status"], "converged");
  EXPECT_LE(r["solve"]["lower_bound"], r["solve"]["energy"]);
  EXPECT_LE(r["solve"]["relative_gap"], 1e-3);
  EXPECT_GE(r["solve"]["factor_entries"], r["domain"]["nodes"]);
  EXPECT_EQ(r["weights"]["rows"], 20);
  EXPECT_LE(r["weights"]["row_sum_error"], 1e-6);
  EXPECT_EQ(r["options"]["nodes"], "200");
  std::int64_t counted = 0;
  for (const auto& [influences, rows] : r["weights"]["influences"].items())
    counted += rows.get<std::int64_t>();
  EXPECT_EQ(counted, 20);
}

TEST(Report, JsonGoesToStandardOutputAlone) {
  const BoxFolder folder;
  const RunResult loud = expect_runs(folder, bind_box({"--json", "--verbose"}));
  EXPECT_EQ(Json::parse(loud.out)["schema"], 1);
  EXPECT_GT(lines(loud.err).size(), 3U) << "--verbose tells the stages' times";
  const RunResult plain = expect_runs(folder, bind_box({}));
  EXPECT_EQ(plain.out, "");
  EXPECT_EQ(lines(plain.err).size(), 1U);
  EXPECT_EQ(plain.err.find('\r'), std::string::npos) << "progress is for terminals";
  const RunResult quiet = expect_runs(folder, bind_box({"--quiet", "--report", "r.json"}));
  EXPECT_EQ(quiet.out + quiet.err, "");
  for (const char* verb : {"inspect", "compare"}) {
    const std::string file = std::string(verb) == "inspect" ? "box.obj" : "out.npz";
    std::vector<std::string> all{verb, file, "--json"};
    if (std::string(verb) == "compare") all.insert(all.begin() + 1, file);
    const RunResult result = expect_runs(folder, all);
    EXPECT_FALSE(Json::parse(result.out, nullptr, false).is_discarded()) << verb;
    EXPECT_EQ(result.err, "");
  }
}

TEST(Report, StoppedByALimitIsNoFailure) {
  const BoxFolder folder;
  const RunResult result = expect_runs(
      folder, bind_box({"--iterations", "1", "--tolerance", "1e-9", "--json", "--quiet"}));
  const Json r = Json::parse(result.out);
  EXPECT_EQ(r["solve"]["status"], "limit");
  EXPECT_LE(r["weights"]["row_sum_error"], 1e-6) << "the best weights so far are valid";
  EXPECT_EQ(r["weights"]["negative"], 0);
}

TEST(Help, ListsVerbsWithExamplesThatExist) {
  const TemporaryFolder folder;
  const std::string all = expect_runs(folder, {"--help"}).out;
  const std::vector<std::string> verbs{"bind",        "inspect", "pose",
                                       "render",      "compare", "transfer",
                                       "interpolate", "sample",  "tetrahedralise"};
  for (const std::string& verb : verbs) {
    EXPECT_NE(all.find("\n  " + verb + " "), std::string::npos) << verb;
    const std::string help = expect_runs(folder, {verb, "--help"}).out;
    EXPECT_NE(help.find("Example: skinfield " + verb + " "), std::string::npos) << verb;
    EXPECT_NE(help.find("--quiet"), std::string::npos) << verb;
  }
  for (const char* later : {"batch", "view"}) {
    EXPECT_EQ(all.find(later), std::string::npos) << later;
    EXPECT_EQ(expect_runs(folder, {"bind", "--help"}).out.find(later), std::string::npos) << later;
  }
}

TEST(Help, VersionTellsProfileAndLicences) {
  const TemporaryFolder folder;
  const std::string text = expect_runs(folder, {"--version"}).out;
  EXPECT_TRUE(text.starts_with("skinfield ")) << text;
  EXPECT_NE(text.find("profile: "), std::string::npos);
  for (const char* licence : {"MIT", "MPL-2.0", "Apache-2.0", "LICENSES.md"})
    EXPECT_NE(text.find(licence), std::string::npos) << licence;
}

}  // namespace
}  // namespace skinfield_test
