// Every rigged file of the shared data: read, rewritten with the artist's own weights, read again.
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/gltf_animation.h"
#include "support/data.h"
#include "support/gltf_builder.h"
#include "support/gltf_diff.h"

#include <gtest/gtest.h>

namespace {

using namespace skinfield;
namespace fs = std::filesystem;

std::vector<fs::path> rigged_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".glb") || name.ends_with(".gltf")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_compressed(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with("draco") || name.starts_with("meshopt");
}

std::vector<SkinWeights> own_weights(const Asset& asset) {
  std::vector<SkinWeights> weights;
  for (const Character& character : asset.characters) {
    weights.push_back(character.weights.value_or(SkinWeights{}));
  }
  return weights;
}

TEST(GltfData, CharactersAreWholeAndConsistent) {
  SKINFIELD_NEEDS_DATA(folder, "rigged");
  for (const fs::path& path : rigged_files(folder)) {
    if (is_compressed(path)) continue;
    SCOPED_TRACE(path.filename().string());
    const Asset asset = read_gltf(path);
    ASSERT_EQ(asset.characters.size(), 1u);
    const Character& c = asset.characters[0];
    const auto n = static_cast<Eigen::Index>(c.vertex_of_input.size());
    EXPECT_GT(c.mesh.F.rows(), 0);
    EXPECT_LT(c.mesh.F.maxCoeff(), c.mesh.V.rows());
    EXPECT_EQ(c.parts.front().begin, 0);
    EXPECT_EQ(c.parts.back().end, n);
    EXPECT_EQ(c.parts.back().face_end, c.mesh.F.rows());
    if (c.skeleton.joints.empty()) continue;
    EXPECT_EQ(c.skeleton.columns, static_cast<int>(c.skeleton.joints.size()));
    ASSERT_TRUE(c.weights.has_value());
    EXPECT_EQ(c.weights->W.rows(), n);
    int empty = 0;
    for (Eigen::Index v = 0; v < n; ++v) {
      const double sum = c.weights->W.row(v).sum();
      empty += sum == 0;
      EXPECT_TRUE(sum == 0 || std::abs(sum - 1) < 1e-12);
    }
    EXPECT_EQ(empty, c.non_finite_weight_rows);
    // A joint that places itself by its inverse bind matrix is that matrix's origin.
    for (const Joint& joint : c.skeleton.joints) {
      const Eigen::Vector4d origin = joint.inverse_bind * joint.position.homogeneous();
      EXPECT_LT(origin.head<3>().norm(),
                1e-4 * joint.inverse_bind.norm() * (1 + joint.position.norm()));
    }
  }
}

TEST(GltfData, FiguresOfTheCatalogueAreFound) {
  SKINFIELD_NEEDS_DATA(folder, "rigged");
  struct Row {
    const char* file;
    int split, merged, faces, joints, weighted;
  };
  for (const Row& row :
       {Row{"fox.glb", 1728, 290, 576, 24, 22}, Row{"cesium_man.glb", 3273, 2338, 4672, 19, 19},
        Row{"robot_expressive.glb", 1108, 276, 544, 43, 24},
        Row{"kaykit_mage.glb", 3348, 2086, 4029, 41, 20},
        Row{"farmer.glb", 11006, 2786, 5476, 49, 48}, Row{"quad_skin_joints1.glb", 4, 4, 2, 10, 10},
        Row{"simple_skin.gltf", 10, 10, 8, 2, 2}}) {
    SCOPED_TRACE(row.file);
    const Asset asset = read_gltf(folder / row.file);
    const Character& c = asset.characters.at(0);
    EXPECT_EQ(static_cast<int>(c.vertex_of_input.size()), row.split);
    EXPECT_EQ(c.mesh.V.rows(), row.merged);
    EXPECT_EQ(c.mesh.F.rows(), row.faces);
    EXPECT_EQ(static_cast<int>(c.skeleton.joints.size()), row.joints);
    Eigen::VectorXd sums = Eigen::VectorXd::Ones(c.weights->W.rows()).transpose() * c.weights->W;
    EXPECT_EQ((sums.array() > 0).count(), row.weighted);
  }
  EXPECT_EQ(read_gltf(folder / "wasp_nan_weights.glb").characters[0].non_finite_weight_rows, 6);
}

TEST(GltfData, RewrittenWithItsOwnWeightsNothingElseChanges) {
  SKINFIELD_NEEDS_DATA(folder, "rigged");
  for (const fs::path& path : rigged_files(folder)) {
    if (is_compressed(path)) continue;
    SCOPED_TRACE(path.filename().string());
    const std::string source = read_file(path);
    const Asset asset = read_gltf(path);
    const auto weights = own_weights(asset);
    for (const auto& [format, tolerance] : {std::pair{GltfWeightFormat::float32, 1e-7},
                                            std::pair{GltfWeightFormat::unorm16, 1.1 / 65535},
                                            std::pair{GltfWeightFormat::unorm8, 1.1 / 255}}) {
      for (const bool binary : {true, false}) {
        const std::string written = format_gltf(asset, weights, binary, {format});
        EXPECT_EQ(skinfield_test::unexpected_changes(source, written), std::vector<std::string>{});
        const Asset again = skinfield_test::read(written);
        ASSERT_EQ(again.characters.size(), asset.characters.size());
        const Character &a = asset.characters[0], &b = again.characters[0];
        EXPECT_TRUE(a.mesh.V == b.mesh.V);
        EXPECT_TRUE(a.mesh.F == b.mesh.F);
        EXPECT_EQ(a.vertex_of_input, b.vertex_of_input);
        if (!a.weights) continue;
        double worst = 0;
        for (Eigen::Index v = 0; v < a.weights->W.rows(); ++v) {
          if (a.weights->W.row(v).sum() == 0) continue;  // not finite in the file
          const Eigen::RowVectorXd difference = a.weights->W.row(v) - b.weights->W.row(v);
          worst = std::max(worst, difference.cwiseAbs().maxCoeff());
        }
        EXPECT_LT(worst, tolerance);
      }
    }
  }
}

TEST(GltfData, WritingTwiceGivesTheSameBytesAndDoesNotGrow) {
  SKINFIELD_NEEDS_DATA(path, "rigged/alpaca.glb");
  const Asset asset = read_gltf(path);
  const std::string once = format_gltf(asset, own_weights(asset), true);
  const Asset again = skinfield_test::read(once);
  const std::string twice = format_gltf(again, own_weights(again), true);
  EXPECT_EQ(once.size(), twice.size());
  EXPECT_EQ(format_gltf(asset, own_weights(asset), true), once);
}

TEST(GltfData, AnimationsPlay) {
  SKINFIELD_NEEDS_DATA(folder, "rigged");
  const Asset fox = read_gltf(folder / "fox.glb");
  const auto animations = gltf_animations(fox);
  ASSERT_EQ(animations.size(), 3u);
  const auto rest = joint_skinning_transforms(fox, 0);
  ASSERT_EQ(rest.size(), 24u);
  double moved = 0;
  for (int k = 0; k <= 8; ++k) {
    const auto& run = animations.back();
    const auto posed =
        joint_skinning_transforms(fox, 0, &run, run.begin + (run.end - run.begin) * k / 8);
    for (std::size_t j = 0; j < posed.size(); ++j) {
      ASSERT_TRUE(posed[j].allFinite());
      moved = std::max(moved, (posed[j] - rest[j]).norm());
    }
  }
  EXPECT_GT(moved, 1.0);
  // Where the rest pose is the bind pose, skinning at rest moves nothing.
  for (const Transform& T : rest) EXPECT_TRUE(T.isIdentity(1e-3)) << T;
}

TEST(GltfData, CompressedGeometryIsRefusedByName) {
  SKINFIELD_NEEDS_DATA(folder, "rigged");
  for (const auto& [file, extension] :
       {std::pair{"draco_astronaut.glb", "KHR_draco_mesh_compression"},
        std::pair{"meshopt_no_skin.glb", "EXT_meshopt_compression"}}) {
    try {
      read_gltf(folder / file);
      ADD_FAILURE() << file << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(extension), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(file), std::string::npos);
      EXPECT_FALSE(error.remedy().empty());
    }
  }
}

}  // namespace
