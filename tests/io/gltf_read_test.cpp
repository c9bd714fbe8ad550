// Reading glTF: every form an accessor takes, characters, bind spaces.
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "support/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace skinfield;
using skinfield_test::bytes_of;
using skinfield_test::GltfBuilder;
using skinfield_test::Json;
using skinfield_test::read;
using skinfield_test::skinned_square;

Json& attributes(GltfBuilder& b) { return b.json["meshes"][0]["primitives"][0]["attributes"]; }

/// A mesh without a skin whose only primitive has these positions.
GltfBuilder plain(int position_accessor_of(GltfBuilder&)) {
  GltfBuilder b;
  const int position = position_accessor_of(b);
  b.push("meshes", {{"primitives", Json::array({Json{{"attributes", {{"POSITION", position}}}}})}});
  b.push("nodes", {{"mesh", 0}});
  return b;
}

int float_triangle(GltfBuilder& b) {
  return b.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, 3, "VEC3");
}

TEST(GltfRead, GlbAndTextWithDataUriSayTheSame) {
  const GltfBuilder b = skinned_square();
  const Asset glb = read(b.glb()), text = read(b.text());
  for (const Asset* asset : {&glb, &text}) {
    ASSERT_EQ(asset->characters.size(), 1u);
    const Character& c = asset->characters[0];
    EXPECT_EQ(c.mesh.V.rows(), 4);
    EXPECT_EQ(c.mesh.F.rows(), 2);
    EXPECT_EQ(c.parts.at(0).name, "square");
    EXPECT_EQ(c.skeleton.source, Skeleton::Source::gltf);
    ASSERT_EQ(c.skeleton.joints.size(), 2u);
    EXPECT_EQ(c.skeleton.joints[1].parent, 0);
    EXPECT_EQ(c.skeleton.joints[1].position, Vec3(0, 1, 0));
    ASSERT_EQ(c.skeleton.joints[1].tips.size(), 1u);
    EXPECT_EQ(c.skeleton.joints[1].tips[0].name, "b_end");
    EXPECT_EQ(c.skeleton.joints[1].tips[0].position, Vec3(0, 2, 0));
    EXPECT_EQ(c.weights->W.coeff(2, 1), 0.75);
    EXPECT_EQ(c.weights->W.coeff(2, 0), 0.25);
  }
}

TEST(GltfRead, BufferInAFileOfItsOwn) {
  const GltfBuilder b = skinned_square();
  const auto folder = std::filesystem::path(testing::TempDir()) / "skinfield_gltf_read";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "the data.bin", b.binary);
  write_file_atomically(folder / "square.gltf", b.text("the%20data.bin"));
  EXPECT_EQ(read_gltf(folder / "square.gltf").characters.at(0).mesh.V.rows(), 4);
  EXPECT_EQ(read_gltf_skeleton(folder / "square.gltf").joints.size(), 2u);
  EXPECT_THROW(read(b.text("the%20data.bin")), InputError);
  std::filesystem::remove_all(folder);
}

TEST(GltfRead, SparseInterleavedQuantisedAndUnindexedPositions) {
  const Points expected = read(plain(float_triangle).glb()).characters.at(0).mesh.V;
  const auto sparse = [](GltfBuilder& b) {
    const int where = b.view(bytes_of<std::uint8_t>({1, 2}));
    const int what = b.view(bytes_of<float>({1, 0, 0, 0, 1, 0}));
    return b.accessor(-1, 5126, 3, "VEC3",
                      {{"sparse",
                        {{"count", 2},
                         {"indices", {{"bufferView", where}, {"componentType", 5121}}},
                         {"values", {{"bufferView", what}}}}}});
  };
  const auto interleaved = [](GltfBuilder& b) {
    const float x = 9;
    const int view = b.view(bytes_of<float>({x, 0, 0, 0, x, 1, 0, 0, x, 0, 1, 0}), 16);
    return b.accessor(view, 5126, 3, "VEC3", {{"byteOffset", 4}});
  };
  const auto normalised = [](GltfBuilder& b) {
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    const int view =
        b.view(bytes_of<std::int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0}), 8);
    return b.accessor(view, 5122, 3, "VEC3", {{"normalized", true}});
  };
  const auto integers = [](GltfBuilder& b) {
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    const int view = b.view(bytes_of<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}), 4);
    return b.accessor(view, 5121, 3, "VEC3");
  };
  using Make = int (*)(GltfBuilder&);
  for (const Make make : {Make(sparse), Make(interleaved), Make(normalised), Make(integers)}) {
    const Asset asset = read(plain(make).glb());
    EXPECT_EQ(asset.characters.at(0).mesh.V, expected);
    EXPECT_EQ(asset.characters.at(0).mesh.F.rows(), 1);
    EXPECT_TRUE(asset.characters.at(0).skeleton.joints.empty());
  }
}

TEST(GltfRead, IndicesOfAnyWidthAndAnyMode) {
  const auto faces = [](int mode, int type, const std::string& bytes, int count) {
    GltfBuilder b = skinned_square();
    const int index = b.accessor(b.view(bytes), type, count, "SCALAR");
    Json& primitive = b.json["meshes"][0]["primitives"][0];
    primitive["indices"] = index;
    primitive["mode"] = mode;
    return read(b.glb()).characters.at(0).mesh.F;
  };
  const Triangles square = (Triangles(2, 3) << 0, 1, 2, 0, 2, 3).finished();
  EXPECT_EQ(faces(4, 5121, bytes_of<std::uint8_t>({0, 1, 2, 0, 2, 3}), 6), square);
  EXPECT_EQ(faces(4, 5123, bytes_of<std::uint16_t>({0, 1, 2, 0, 2, 3}), 6), square);
  EXPECT_EQ(faces(4, 5125, bytes_of<std::uint32_t>({0, 1, 2, 0, 2, 3}), 6), square);
  const Triangles strip = faces(5, 5121, bytes_of<std::uint8_t>({0, 1, 3, 2}), 4);
  EXPECT_EQ(strip, (Triangles(2, 3) << 0, 1, 3, 1, 2, 3).finished());
  const Triangles fan = faces(6, 5121, bytes_of<std::uint8_t>({0, 1, 2, 3}), 4);
  EXPECT_EQ(fan, (Triangles(2, 3) << 1, 2, 0, 2, 3, 0).finished());
  EXPECT_EQ(faces(1, 5121, bytes_of<std::uint8_t>({0, 1, 2, 3}), 4).rows(), 0);
}

TEST(GltfRead, WeightsOfIntegersOfSeveralSetsAndNotFinite) {
  GltfBuilder b = skinned_square();
  attributes(b)["WEIGHTS_0"] =
      b.add<std::uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0, 0, 255, 0, 0}, 5121, 4,
                          "VEC4", {{"normalized", true}});
  EXPECT_NEAR(read(b.glb()).characters[0].weights->W.coeff(2, 0), 0.8, 1e-12);

  GltfBuilder two = skinned_square();
  attributes(two)["JOINTS_1"] =
      two.add<std::uint16_t>({1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5123, 4, "VEC4");
  attributes(two)["WEIGHTS_1"] =
      two.add<float>({1, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, 4, "VEC4");
  const SparseRows W = read(two.glb()).characters[0].weights->W;
  EXPECT_EQ(W.coeff(0, 1), 0.5);
  EXPECT_EQ(W.coeff(1, 1), 0.75);

  GltfBuilder bad = skinned_square();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  attributes(bad)["WEIGHTS_0"] =
      bad.add<float>({nan, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, 5126, 4, "VEC4");
  const Asset asset = read(bad.glb());
  EXPECT_EQ(asset.characters[0].non_finite_weight_rows, 1);
  EXPECT_EQ(asset.warnings.size(), 2u);
  EXPECT_EQ(asset.characters[0].weights->W.row(0).nonZeros(), 0);
  EXPECT_EQ(asset.characters[0].weights->W.coeff(1, 0), 1);
  EXPECT_EQ(asset.characters[0].weights->W.row(2).nonZeros(), 0);
}

TEST(GltfRead, SplitVerticesAreMergedAcrossPrimitives) {
  GltfBuilder b = skinned_square();
  Json second = b.json["meshes"][0]["primitives"][0];
  b.json["meshes"][0]["primitives"].push_back(second);
  const Character c = read(b.glb()).characters.at(0);
  EXPECT_EQ(c.vertex_of_input.size(), 8u);
  EXPECT_EQ(c.mesh.V.rows(), 4);
  EXPECT_EQ(c.mesh.F.rows(), 4);
  EXPECT_EQ(c.mesh.F.row(0), c.mesh.F.row(2));
  EXPECT_EQ(c.input_faces(2, 0), 4);
  EXPECT_EQ(c.parts.size(), 2u);
}

TEST(GltfRead, SkinsOfTheSameJointsAreOneCharacterInTheFirstOnesSpace) {
  GltfBuilder b = skinned_square();
  // The same square, stored a hundred times smaller, moved by one, its joints in another order.
  const int position =
      b.add<float>({0.01f, 0, 0, 0.02f, 0, 0, 0.02f, 0.01f, 0, 0.01f, 0.01f, 0}, 5126, 4, "VEC3");
  const int binds = b.add<float>({100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0, 0, -1, 0, 1,
                                  100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0, 0, 0,  0, 1},
                                 5126, 2, "MAT4");
  Json mesh = b.json["meshes"][0];
  mesh["primitives"][0]["attributes"]["POSITION"] = position;
  b.push("meshes", mesh);
  b.push("skins", {{"inverseBindMatrices", binds}, {"joints", Json::array({2, 1})}});
  b.push("nodes", {{"mesh", 1}, {"skin", 1}});
  const Asset asset = read(b.glb());
  ASSERT_EQ(asset.characters.size(), 1u);
  const Character& c = asset.characters[0];
  EXPECT_EQ(c.mesh.V.rows(), 6);  // they share an edge
  EXPECT_NEAR(c.mesh.V.col(0).maxCoeff(), 2, 1e-6);
  EXPECT_NEAR(c.mesh.V.col(1).maxCoeff(), 1, 1e-6);
  EXPECT_EQ(c.weights->W.coeff(4, 1), 1);  // its joint 0 is the character's column 1
  EXPECT_TRUE(asset.warnings.empty());
}

TEST(GltfRead, SkinsOfOtherJointsAreOtherCharacters) {
  GltfBuilder b = skinned_square();
  b.push("skins", {{"joints", Json::array({1, 2, 3})}});
  b.push("nodes", {{"mesh", 0}, {"skin", 1}});
  const Asset asset = read(b.glb());
  ASSERT_EQ(asset.characters.size(), 2u);
  // Without inverse bind matrices joints are where their nodes are.
  EXPECT_EQ(asset.characters[1].skeleton.joints[2].position, Vec3(0, 2, 0));
  EXPECT_FALSE(asset.warnings.empty());
}

TEST(GltfRead, BindPoseComesFromInverseBindMatricesNotFromTheRestPose) {
  GltfBuilder b = skinned_square();
  b.json["nodes"][2]["translation"] = {5.0, 5.0, 5.0};
  const Skeleton s = read(b.glb()).characters.at(0).skeleton;
  EXPECT_EQ(s.joints[1].position, Vec3(0, 1, 0));
  EXPECT_EQ(Vec3(s.joints[1].world_rest.topRightCorner<3, 1>()), Vec3(5, 5, 5));
}

TEST(GltfRead, StaticMeshesStandInTheWorld) {
  GltfBuilder b = plain(float_triangle);
  b.push("nodes", {{"translation", {0.0, 0.0, 3.0}},
                   {"scale", {2.0, 2.0, 2.0}},
                   {"children", Json::array({0})}});
  b.push("nodes", {{"mesh", 0}, {"translation", {100.0, 0.0, 0.0}}});  // in no scene
  b.json["scenes"][0]["nodes"] = {1};
  const Character c = read(b.glb()).characters.at(0);
  EXPECT_EQ(c.mesh.V, (Points(3, 3) << 0, 0, 3, 2, 0, 3, 0, 2, 3).finished());
  EXPECT_EQ(c.parts.size(), 1u);
}

}  // namespace
