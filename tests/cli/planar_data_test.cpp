// Every flat shape of the shared data, from SVG, outline and mesh, through the program.
#include "cli/characters.h"
#include "skinfield/domain/planar_mesher.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"
#include "support/data.h"

#include <nlohmann/json.hpp>

namespace skinfield {
namespace {

using namespace skinfield_test;

SkinWeights bind_file(const TemporaryFolder& folder, const std::filesystem::path& mesh,
                      const std::filesystem::path& tgf, const std::string& name) {
  const std::string out = folder / (name + ".npz"), report = folder / (name + ".json");
  const RunResult result = run({"bind", mesh.string(), "--skeleton", tgf.string(), "--nodes",
                                "4000", "-o", out, "--report", report, "--quiet"});
  EXPECT_EQ(result.code, 0) << mesh << result.err;
  const auto c = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(c["domain"]["kind"], "tris") << mesh;
  EXPECT_LT(c["weights"]["row_sum_error"].get<double>(), 1e-9) << mesh;
  EXPECT_EQ(c["weights"]["negative"], 0) << mesh;
  EXPECT_EQ(c["input"]["handles_outside"].size(), 0u) << mesh;
  EXPECT_EQ(c["solve"]["status"], "converged") << mesh;
  return read_weights(out);
}

class PlanarData : public testing::TestWithParam<const char*> {};

TEST_P(PlanarData, SvgAndOutlineAgree) {
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  const std::string stem = std::string("planar/") + GetParam();
  SKINFIELD_NEEDS_DATA(svg, stem + ".svg");
  SKINFIELD_NEEDS_DATA(obj, stem + "-outline.obj");
  SKINFIELD_NEEDS_DATA(tgf, stem + ".tgf");
  const TemporaryFolder folder;
  const SkinWeights a = bind_file(folder, svg, tgf, "svg"), b = bind_file(folder, obj, tgf, "obj");
  ASSERT_EQ(a.W.rows(), b.W.rows());
  // The files round coordinates to six digits each.
  EXPECT_LT(compare(a, b).mean, 2e-3);
  if (const auto points = data(stem + "-points.tgf")) {
    bind_file(folder, svg, *points, "points");
  }
}
INSTANTIATE_TEST_SUITE_P(All, PlanarData,
                         testing::Values("alligator", "annulus", "comb", "snake", "star"));

TEST(PlanarMesh, TheAlligatorsMeshAgreesWithItsOutline) {
  SKINFIELD_NEEDS_DATA(mesh, "planar/alligator.obj");
  SKINFIELD_NEEDS_DATA(tgf, "planar/alligator.tgf");
  const TemporaryFolder folder;
  const SkinWeights own = bind_file(folder, mesh, tgf, "mesh");
  EXPECT_EQ(own.W.rows(), 3208);
  if (!can_mesh_outlines()) return;
  SKINFIELD_NEEDS_DATA(outline, "planar/alligator-outline.obj");
  // The mesh's weights on the outline's points, which are among its vertices.
  const RunResult transferred =
      run({"transfer", outline.string(), mesh.string(), "--skeleton", tgf.string(), "--nodes",
           "4000", "-o", folder / "t.npz", "--quiet"});
  ASSERT_EQ(transferred.code, 0) << transferred.err;
  EXPECT_LT(compare(own, read_weights(folder / "t.npz")).mean, 0.02);
}

TEST(PlanarOutput, GltfHasTheTrianglesAndCanBeDrawnAndPosed) {
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  const TemporaryFolder folder;
  write_file(folder / "a.svg", "<svg><path d='M0 0H4V1H0Z M1.8.4v.2h.4v-.2z'/></svg>");
  write_file(folder / "a.tgf", "1 0.5 -0.5\n2 1.5 -0.5\n3 3.5 -0.5\n#\n1 2\n2 3\n");
  const std::string svg = folder / "a.svg", tgf = folder / "a.tgf", glb = folder / "a.glb",
                    npz = folder / "a.npz";
  const RunResult result = run(
      {"bind", svg, "--skeleton", tgf, "--nodes", "500", "-o", glb, "--weights", npz, "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(read_weights(npz).W.rows(), 8);
  const RunResult inspected = run({"inspect", glb, "--json"});
  const auto json = nlohmann::json::parse(inspected.out)["characters"][0];
  EXPECT_NEAR(json["input_vertices"].get<double>(), 500, 60);
  EXPECT_GT(json["faces"], 500);
  EXPECT_EQ(json["planar"], true);
  const auto before = nlohmann::json::parse(run({"inspect", svg, "--json"}).out)["characters"][0];
  EXPECT_EQ(before["outline_segments"], 8);
  EXPECT_EQ(before["faces"], 0);
  const RunResult valid = validate_gltf(glb);
  EXPECT_TRUE(valid.code == 0 || valid.code == 3) << valid.out;
  EXPECT_EQ(run({"render", glb, "--pose", "demo", "-o", folder / "posed.png"}).code, 0);
  EXPECT_EQ(run({"render", svg, "--skeleton", tgf, "--weights", npz, "-o", folder / "w.png"}).code,
            0);
  const RunResult posed = run({"pose", svg, "--skeleton", tgf, "--weights", npz, "--pose", "bind",
                               "-o", folder / "posed.obj"});
  ASSERT_EQ(posed.code, 0) << posed.err;
  int vertices = 0, faces = 0;
  for (const std::string& line : lines(read_file(folder / "posed.obj"))) {
    vertices += line.starts_with("v ");
    faces += line.starts_with("f ");
  }
  EXPECT_EQ(vertices, 8);
  EXPECT_EQ(faces, 8);
}

TEST(PlanarOutput, ThePermissiveProfileSaysWhatToGive) {
  if (can_mesh_outlines()) GTEST_SKIP() << "this build has the mesher";
  const TemporaryFolder folder;
  write_file(folder / "a.svg", "<svg><rect width='4' height='1'/></svg>");
  write_file(folder / "a.tgf", "1 0.5 -0.5\n2 1.5 -0.5\n#\n1 2\n");
  expect_refused(folder, {"bind", "a.svg", "--skeleton", "a.tgf", "-o", "a.npz"}, 4,
                 {"CGAL", "triangulated OBJ"});
}

}  // namespace
}  // namespace skinfield
