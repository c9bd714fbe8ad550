#include "cli/characters.h"
#include "domain/alpha_wrap.h"
#include "domain/tetgen_mesher.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/io/io.h"
#include "skinfield/io/mesh_file.h"

#include <nlohmann/json.hpp>

namespace skinfield_test {
namespace {

using Json = nlohmann::json;

#define SKINFIELD_NEEDS_MESHERS()                                 \
  if (!skinfield::have_tetgen() || !skinfield::have_alpha_wrap()) \
  GTEST_SKIP() << "this profile has no meshers"

/// A box of 2 x 0.5 x 0.5, open at one triangle if wanted, and a bone along it.
void write_box(const TemporaryFolder& folder, const std::string& name, bool open) {
  std::string obj;
  for (int i = 0; i < 8; ++i) {
    obj += "v " + std::to_string(i & 1 ? 2.0 : 0.0) + " " + std::to_string(i & 2 ? 0.5 : 0.0) +
           " " + std::to_string(i & 4 ? 0.5 : 0.0) + "\n";
  }
  obj +=
      "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\n"
      "f 2 4 8\n";
  if (!open) obj += "f 2 8 6\n";
  write_file(folder / name, obj);
  write_file(folder / "bones.tgf",
             "1 0.2 0.25 0.25\n2 1 0.25 0.25\n3 1.8 0.25 0.25\n#\n1 2\n2 3\n");
}

TEST(Tetrahedralise, WritesWhatBindSolvesOn) {
  SKINFIELD_NEEDS_MESHERS();
  const TemporaryFolder folder;
  write_box(folder, "box.obj", false);
  for (const std::string& out : {std::string("box.mesh"), std::string("box.msh")}) {
    const Json json =
        Json::parse(expect_runs(folder, {"tetrahedralise", "box.obj", "--skeleton", "bones.tgf",
                                         "--nodes", "500", "-o", out, "--json"})
                        .out);
    EXPECT_EQ(json["route"], "tetgen");
    EXPECT_NEAR(json["volume"].get<double>(), 0.5, 1e-9);
    EXPECT_GT(json["min_dihedral_degrees"].get<double>(), 1);
    EXPECT_EQ(json["inverted"], 0);
    const skinfield::Mesh mesh = skinfield::read_asset(folder / out).characters.front().mesh;
    EXPECT_EQ(mesh.V.rows(), json["vertices"].get<int>());
    EXPECT_EQ(mesh.T.rows(), json["tets"].get<int>());
    EXPECT_EQ(mesh.V(7, 0), 2.0);  // the input's vertices first
    // Read again it is a tet mesh with vertices on the bones: nothing is split.
    expect_runs(folder,
                {"bind", out, "--skeleton", "bones.tgf", "-o", "w.npz", "--report", "r.json"});
    const Json report = Json::parse(read_file(folder / "r.json"));
    EXPECT_EQ(report["domain"]["kind"], "tets");
    EXPECT_EQ(report["domain"]["route"], "given");
    EXPECT_EQ(report["domain"]["nodes"], json["vertices"]);
  }
}

TEST(Tetrahedralise, WrapsAnOpenBoxAndSaysSo) {
  SKINFIELD_NEEDS_MESHERS();
  const TemporaryFolder folder;
  write_box(folder, "open.obj", true);
  const RunResult ran = expect_runs(folder, {"tetrahedralise", "open.obj", "--skeleton",
                                             "bones.tgf", "--nodes", "500", "-o", "open.mesh"});
  EXPECT_NE(ran.err.find("wrap"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("open at 3 edges"), std::string::npos) << ran.err;
}

TEST(Tetrahedralise, RefusesWhatItCannotDo) {
  const TemporaryFolder folder;
  write_box(folder, "box.obj", false);
  const auto code = [&](const std::vector<std::string>& arguments) {
    RunOptions options;
    options.folder = folder.path().string();
    return run(arguments, options).code;
  };
  EXPECT_EQ(code({"tetrahedralise", "box.obj", "-o", "box.stl"}), 2);
  EXPECT_EQ(code({"tetrahedralise", "box.obj", "-o", "nowhere/box.mesh"}), 5);
  EXPECT_EQ(code({"tetrahedralise", "missing.obj", "-o", "box.mesh"}), 3);
  if (!skinfield::have_tetgen()) {
    EXPECT_EQ(code({"tetrahedralise", "box.obj", "-o", "box.mesh"}), 4);
    EXPECT_EQ(
        code({"bind", "box.obj", "--skeleton", "bones.tgf", "--domain", "tets", "-o", "w.npz"}), 4);
  }
}

}  // namespace
}  // namespace skinfield_test
