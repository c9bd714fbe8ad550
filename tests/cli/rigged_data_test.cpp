// Every rigged character of the shared data through the program: bound, valid, nothing new for the
// Khronos validator, seams closed.
#include "cli/characters.h"
#include "skinfield/io/gltf.h"
#include "skinfield/weights/statistics.h"
#include "support/data.h"
#include "support/gltf_diff.h"

namespace skinfield_test {
namespace {

class Rigged : public testing::TestWithParam<const char*> {};

/// Largest difference between rows of input vertices at one place.
double seam(const skinfield::Character& character) {
  const skinfield::SparseRows& W = character.weights->W;
  std::vector<int> first(static_cast<std::size_t>(character.mesh.V.rows()), -1);
  double largest = 0;
  for (std::size_t i = 0; i < character.vertex_of_input.size(); ++i) {
    int& f = first[static_cast<std::size_t>(character.vertex_of_input[i])];
    if (f < 0) f = static_cast<int>(i);
    const skinfield::SparseRows difference = W.row(f) - W.row(static_cast<Eigen::Index>(i));
    for (Eigen::Index k = 0; k < difference.nonZeros(); ++k)
      largest = std::max(largest, std::abs(difference.valuePtr()[k]));
  }
  return largest;
}

TEST_P(Rigged, BindsValidly) {
  SKINFIELD_NEEDS_DATA(source, std::string("rigged/") + GetParam());
  const TemporaryFolder folder;
  const std::string output = std::string("out") + source.extension().string();
  expect_runs(folder, {"bind", source.string(), "--quality", "draft", "--quiet", "-o", output});
  const skinfield::Asset bound = skinfield::read_gltf(folder / output);
  ASSERT_FALSE(bound.characters.empty());
  for (const skinfield::Character& character : bound.characters) {
    ASSERT_TRUE(character.weights.has_value());
    EXPECT_EQ(character.non_finite_weight_rows, 0);
    const skinfield::WeightStatistics s = skinfield::weight_statistics(*character.weights);
    EXPECT_LE(s.row_sum_error, 1e-6);
    EXPECT_EQ(s.negative, 0);
    EXPECT_EQ(s.non_finite, 0);
    EXPECT_LE(seam(character), 1e-3);
  }
  EXPECT_EQ(unexpected_changes(read_file(source), read_file(folder / output)),
            std::vector<std::string>{});
  const RunResult validated = validate_gltf(folder / output, source.string());
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out << validated.err;
}

INSTANTIATE_TEST_SUITE_P(Data, Rigged,
                         testing::Values("alpaca.glb", "cesium_man.glb", "farmer.glb", "fox.glb",
                                         "frog.glb", "greenman.glb", "kaykit_barbarian.glb",
                                         "kaykit_mage.glb", "koi.glb", "manta_ray.glb", "mech.glb",
                                         "quad_skin_joints1.glb", "robot_expressive.glb",
                                         "simple_skin.gltf", "snake.glb", "spider.glb", "stag.glb",
                                         "trex.glb", "wasp_nan_weights.glb", "webxr_hand_left.glb",
                                         "witch.glb"),
                         [](const testing::TestParamInfo<const char*>& file) {
                           return std::filesystem::path(file.param).stem().string();
                         });

}  // namespace
}  // namespace skinfield_test
