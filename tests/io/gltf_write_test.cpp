// Writing glTF: exact sums, shared meshes, new skins, fresh documents; and playing animations.
#include "skinfield/io/gltf.h"
#include "skinfield/io/gltf_animation.h"
#include "support/gltf_builder.h"
#include "support/gltf_diff.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace skinfield;
using skinfield_test::GltfBuilder;
using skinfield_test::Json;
using skinfield_test::read;
using skinfield_test::skinned_square;

SkinWeights dense(const Eigen::MatrixXd& W) {
  SkinWeights weights;
  weights.W = W.sparseView();
  return weights;
}

std::string rewrite(const Asset& asset, const Eigen::MatrixXd& W,
                    const GltfWriteOptions& options = {}) {
  const std::vector<SkinWeights> weights(asset.characters.size(), dense(W));
  return format_gltf(asset, weights, true, options);
}

Json json_of(const std::string& bytes) { return gltf::load_document(bytes, "out", {})->json; }

gltf::AccessorValues attribute(const std::string& bytes, const std::string& name, int mesh = 0) {
  const auto document = gltf::load_document(bytes, "out", {});
  const Json& primitive = document->json["meshes"][static_cast<std::size_t>(mesh)]["primitives"][0];
  return gltf::read_accessor(*document, primitive["attributes"][name].get<int>(), {"VEC4"}, name);
}

TEST(GltfWrite, RowsDescendAndSumToOneExactlyInEveryFormat) {
  const Asset asset = read(skinned_square().glb());
  Eigen::MatrixXd W(4, 2);
  W << 1.0 / 3, 2.0 / 3, 0.1, 0.9, 1, 0, 0.123456789, 0.876543211;
  for (const auto format :
       {GltfWeightFormat::float32, GltfWeightFormat::unorm16, GltfWeightFormat::unorm8}) {
    const std::string bytes = rewrite(asset, W, {format});
    const auto joints = attribute(bytes, "JOINTS_0"), weights = attribute(bytes, "WEIGHTS_0");
    const double unit = format == GltfWeightFormat::float32   ? 1 << 24
                        : format == GltfWeightFormat::unorm16 ? 65535
                                                              : 255;
    for (std::size_t v = 0; v < 4; ++v) {
      double sum = 0;
      for (int k = 0; k < 4; ++k) {
        sum += std::round(weights(v, k) * unit);
        EXPECT_LE(weights(v, k), weights(v, std::max(k - 1, 0)));
        EXPECT_TRUE(weights(v, k) > 0 || joints(v, k) == 0);
      }
      EXPECT_EQ(sum, unit);
    }
    const SparseRows back = read(bytes).characters[0].weights->W;
    EXPECT_LE((Eigen::MatrixXd(back) - W).cwiseAbs().maxCoeff(), 1.0 / unit);
  }
}

TEST(GltfWrite, MoreThanFourInfluencesTakeMoreSets) {
  GltfBuilder b = skinned_square();
  b.json["skins"][0].erase("inverseBindMatrices");
  b.json["skins"][0]["joints"] = Json::array();
  for (int j = 0; j < 300; ++j) {
    b.json["skins"][0]["joints"].push_back(
        b.push("nodes", {{"name", std::string("j").append(std::to_string(j))}}));
  }
  const Asset asset = read(b.glb());
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(4, 300);
  W.col(0).setConstant(0.3);
  for (int k = 0; k < 5; ++k) W.col(299 - k).setConstant(0.14);
  const std::string bytes = rewrite(asset, W);
  EXPECT_EQ(attribute(bytes, "JOINTS_1").component_type, 5123);
  EXPECT_EQ(attribute(bytes, "JOINTS_0")(0, 1), 295);
  EXPECT_LE((Eigen::MatrixXd(read(bytes).characters[0].weights->W) - W).cwiseAbs().maxCoeff(),
            1e-7);
}

TEST(GltfWrite, DocumentKeepsWhatItDoesNotKnow) {
  GltfBuilder b = skinned_square();
  b.json["extensionsUsed"] = {"VENDOR_smell"};
  b.json["extensions"] = {{"VENDOR_smell", {{"zebra", 1}, {"apple", {1.5, "x"}}}}};
  b.json["nodes"][1]["extras"] = {{"rig", "left"}};
  const int target = b.add<float>(std::vector<float>(12, 0.5f), 5126, 4, "VEC3");
  b.json["meshes"][0]["primitives"][0]["targets"] = Json::array({Json{{"POSITION", target}}});
  const std::string source = b.glb();
  Eigen::MatrixXd W(4, 2);
  W << 0, 1, 0, 1, 0.5, 0.5, 1, 0;
  const std::string written = rewrite(read(source), W);
  EXPECT_EQ(skinfield_test::unexpected_changes(source, written), std::vector<std::string>{});
  EXPECT_EQ(Eigen::MatrixXd(read(written).characters[0].weights->W), W);
  // The helper itself sees changes.
  b.json["nodes"][1]["extras"]["rig"] = "right";
  EXPECT_EQ(skinfield_test::unexpected_changes(source, b.glb()).size(), 1u);
}

TEST(GltfWrite, MeshUnderTwoSkeletonsIsDuplicated) {
  GltfBuilder b = skinned_square();
  const int skin = b.push("skins", {{"joints", Json::array({2, 1, 3})}});
  b.push("nodes", {{"mesh", 0}, {"skin", skin}});
  const Asset asset = read(b.glb());
  ASSERT_EQ(asset.characters.size(), 2u);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(4, 2), B = Eigen::MatrixXd::Zero(4, 3);
  A.col(1).setOnes();
  B.col(2).setOnes();
  const std::vector<SkinWeights> both = {dense(A), dense(B)};
  const std::string bytes = format_gltf(asset, both, true);
  EXPECT_EQ(json_of(bytes)["meshes"].size(), 2u);
  const Asset again = read(bytes);
  EXPECT_EQ(Eigen::MatrixXd(again.characters[0].weights->W), A);
  EXPECT_EQ(Eigen::MatrixXd(again.characters[1].weights->W), B);
  // A character without new weights keeps its mesh; the other one gets a copy.
  const std::vector<SkinWeights> one = {dense(A), SkinWeights{}};
  const Asset half = read(format_gltf(asset, one, true));
  EXPECT_EQ(Eigen::MatrixXd(half.characters[0].weights->W), A);
  EXPECT_EQ(Eigen::MatrixXd(half.characters[1].weights->W),
            Eigen::MatrixXd(asset.characters[1].weights->W));
}

Skeleton tgf_chain() {
  Skeleton s;
  s.source = Skeleton::Source::tgf;
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(0, 2, 0), Vec3(5, 5, 5)}) {
    Joint joint;
    joint.name = std::to_string(s.joints.size() + 1);
    joint.position = at;
    s.joints.push_back(joint);
  }
  s.bones = {{0, 1}, {1, 2}};
  s.columns = 3;  // the point, then the bones
  return s;
}

TEST(GltfWrite, NewSkinUnderMovedNodesShowsTheSamePlace) {
  GltfBuilder b = skinned_square();
  for (const char* key : {"JOINTS_0", "WEIGHTS_0"}) {
    b.json["meshes"][0]["primitives"][0]["attributes"].erase(key);
  }
  b.json.erase("skins");
  b.json["nodes"][0] = {{"name", "square"}, {"mesh", 0}, {"scale", {2.0, 2.0, 2.0}}};
  b.push("nodes", {{"translation", {0.0, 3.0, 0.0}}, {"children", Json::array({0})}});
  b.json["scenes"][0]["nodes"] = {4};
  Asset asset = read(b.glb());
  asset.characters[0].skeleton = tgf_chain();
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(4, 3);
  W.col(1).setConstant(0.75);
  W.col(2).setConstant(0.25);
  const std::string bytes = rewrite(asset, W);
  const Json json = json_of(bytes);
  EXPECT_FALSE(json["nodes"][0].contains("mesh"));
  EXPECT_EQ(json["nodes"][0]["scale"], b.json["nodes"][0]["scale"]);
  const Asset again = read(bytes);
  const Character& c = again.characters.at(0);
  ASSERT_EQ(c.skeleton.joints.size(), 4u);  // point, two bones, the end of the chain
  EXPECT_EQ(c.skeleton.joints[2].parent, 1);
  EXPECT_EQ(c.skeleton.joints[3].parent, 2);
  EXPECT_EQ(c.weights->W.coeff(0, 1), 0.75);
  const auto moved = joint_skinning_transforms(again, 0);
  for (Eigen::Index v = 0; v < 4; ++v) {
    const Eigen::Vector4d at = moved[1] * c.mesh.V.row(v).transpose().homogeneous();
    EXPECT_LT((at.head<3>() - asset.characters[0].mesh.V.row(v).transpose()).norm(), 1e-6);
  }
}

TEST(GltfWrite, FreshDocumentForOtherFormats) {
  Asset asset;
  asset.characters.emplace_back();
  Character& c = asset.characters[0];
  c.mesh.V = (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished();
  c.mesh.F = (Triangles(1, 3) << 0, 1, 2).finished();
  c.vertex_of_input = {0, 1, 2, 0};
  c.input_normals = Points::Zero(4, 3);
  c.input_normals.col(2).setOnes();
  c.skeleton = tgf_chain();
  c.skeleton.bones = {{0, 1}, {1, 2}, {2, 0}};  // a ring of bones is cut open
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(4, 4);
  W.col(3).setOnes();
  for (const bool binary : {true, false}) {
    const std::vector<SkinWeights> weights = {dense(W)};
    const Asset again = read(format_gltf(asset, weights, binary));
    const Character& d = again.characters.at(0);
    EXPECT_EQ(d.mesh.V, c.mesh.V);
    EXPECT_EQ(d.mesh.F, c.mesh.F);
    EXPECT_EQ(d.input_normals.rows(), 3);
    EXPECT_EQ(d.weights->W.coeff(2, 3), 1);
    EXPECT_EQ(d.skeleton.joints[3].position, Vec3(0, 2, 0));
  }
  EXPECT_THROW(rewrite(asset, W.topRows(2)), InputError);
  EXPECT_THROW(rewrite(asset, W.leftCols(2)), InputError);
  EXPECT_THROW(write_gltf(asset, {}, "x.glb"), InputError);
}

TEST(GltfAnimation, LinearStepAndCubicSpline) {
  GltfBuilder b = skinned_square();
  const int times = b.add<float>({1, 3}, 5126, 2, "SCALAR");
  const int moves = b.add<float>({0, 0, 0, 4, 0, 0}, 5126, 2, "VEC3");
  const float h = std::sqrt(0.5f);
  const int turns = b.add<float>({0, 0, 0, 1, 0, 0, h, h}, 5126, 2, "VEC4");
  const int spline =
      b.add<float>({0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 0}, 5126, 6, "VEC3");
  const auto animate = [&](const char* path, int output, const char* interpolation) {
    b.push("animations",
           {{"samplers",
             Json::array(
                 {Json{{"input", times}, {"output", output}, {"interpolation", interpolation}}})},
            {"channels",
             Json::array({Json{{"sampler", 0}, {"target", {{"node", 1}, {"path", path}}}}})}});
  };
  animate("translation", moves, "LINEAR");
  animate("translation", moves, "STEP");
  animate("translation", spline, "CUBICSPLINE");
  animate("rotation", turns, "LINEAR");
  const Asset asset = read(b.glb());
  const auto animations = gltf_animations(asset);
  ASSERT_EQ(animations.size(), 4u);
  EXPECT_EQ(animations[0].begin, 1);
  EXPECT_EQ(animations[0].end, 3);
  const auto x = [&](std::size_t a, double t) {
    return joint_world_transforms(asset, 0, &animations[a], t)[0](0, 3);
  };
  EXPECT_EQ(x(0, 0), 0);
  EXPECT_NEAR(x(0, 1.5), 1, 1e-12);
  EXPECT_EQ(x(0, 9), 4);
  EXPECT_EQ(x(1, 2.9), 0);
  EXPECT_EQ(x(1, 3), 4);
  // Ends 0 and 2 with slope 1 at both over two seconds: the straight line.
  EXPECT_NEAR(x(2, 1.7), 0.7, 1e-12);
  const auto turned = joint_world_transforms(asset, 0, &animations[3], 2);
  EXPECT_NEAR(turned[1](0, 3), -std::sqrt(0.5), 1e-6);  // child at (0,1,0), turned by 45 degrees
  const auto rest = joint_skinning_transforms(asset, 0);
  for (const Transform& T : rest) EXPECT_TRUE(T.isIdentity(1e-12));
}

}  // namespace
