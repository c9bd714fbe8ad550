// --only: one mesh of a file is bound, and the rest travels along untouched.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/weights_file.h"
#include "support/gltf_builder.h"

namespace skinfield_test {
namespace {

/// The square, and another one above it that hangs on the same skin.
std::string two_squares() {
  GltfBuilder b = skinned_square();
  b.json["meshes"].push_back(b.json["meshes"][0]);
  b.json["meshes"][1]["name"] = "hat";
  const int position = b.add<float>({0, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0}, 5126, 4, "VEC3",
                                    {{"min", {0.0, 1.0, 0.0}}, {"max", {1.0, 2.0, 0.0}}});
  b.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = position;
  b.push("nodes", {{"name", "hat"}, {"mesh", 1}, {"skin", 0}});
  b.json["scenes"][0]["nodes"] = {0, 1, 4};
  return b.glb();
}

TEST(Only, LeavesOtherMeshesOfAGltfAsTheyAre) {
  const BoxFolder folder;
  write_file(folder / "two.glb", two_squares());
  expect_runs(folder, {"bind", "two.glb", "--only", "hat", "--joints", "b", "--quiet", "-o",
                       "hat.glb", "--weights", "hat.npz"});
  EXPECT_EQ(skinfield::read_weights(folder / "hat.npz").W.rows(), 4);
  const auto before = skinfield::read_gltf(folder / "two.glb").characters.front();
  const auto after = skinfield::read_gltf(folder / "hat.glb").characters.front();
  ASSERT_EQ(after.parts.size(), 2U);
  for (std::size_t p = 0; p < 2; ++p)
    for (int i = after.parts[p].begin; i < after.parts[p].end; ++i) {
      if (after.parts[p].name == "hat")
        EXPECT_EQ(after.weights->W.coeff(i, 1), 1) << "the hat hangs on joint b alone";
      else
        EXPECT_NEAR(after.weights->W.coeff(i, 1), before.weights->W.coeff(i, 1), 1e-6);
    }
  const RunResult validated = validate_gltf(folder / "hat.glb", folder / "two.glb");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out;
}

TEST(Only, NeedsWeightsOnTheOtherMeshes) {
  const BoxFolder folder;
  write_file(folder / "two.glb", two_squares());
  write_file(folder / "hat.tgf", "1 0.2 1.5 0\n2 0.8 1.5 0\n#\n1 2\n#\n");
  // Under another skeleton the first square would have none.
  expect_refused(folder,
                 {"bind", "two.glb", "--only", "hat", "--skeleton", "hat.tgf", "--quiet",
                  "--domain", "tris", "-o", "out.glb"},
                 3, {"two.glb", "other meshes have no weights"});
}

TEST(Only, KeepsTheMaterialOfAnObject) {
  const BoxFolder folder;
  write_file(folder / "two.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
  const std::string box = box_obj();
  const std::size_t faces = box.find('f');
  write_file(folder / "two.obj",
             "mtllib two.mtl\nv 0 0 9\nv 1 0 9\nv 0 1 9\n" + box.substr(0, faces) +
                 "o flat\nusemtl red\nf 1 2 3\no box\nusemtl blue\n" +
                 "f 4 5 6 7\nf 20 21 22 23\nf 4 8 9 5\nf 5 9 10 6\nf 6 10 11 7\n");
  expect_runs(folder, {"bind", "two.obj", "--only", "box", "--skeleton", "box.tgf", "--nodes",
                       "100", "--quiet", "-o", "box.glb"});
  const auto bound = skinfield::read_gltf(folder / "box.glb").characters.front();
  ASSERT_EQ(bound.parts.size(), 1U);
  EXPECT_EQ(bound.parts[0].colour, skinfield::Vec3(0, 0, 1));
  expect_refused(folder,
                 {"bind", "two.obj", "--only", "hat", "--skeleton", "box.tgf", "-o", "out.glb"}, 3,
                 {"no mesh or object is called hat", "box, flat"});
}

}  // namespace
}  // namespace skinfield_test
