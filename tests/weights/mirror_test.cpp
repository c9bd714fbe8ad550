#include "skinfield/weights/mirror.h"

#include "skinfield/base/error.h"
#include "skinfield/weights/statistics.h"
#include "weights/fixtures.h"
#include "weights/point_grid.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

using skinfield_test::grid_mesh;
using skinfield_test::largest_row_error;
using skinfield_test::random_weights;

TEST(OtherSide, KnowsTheConventions) {
  const std::pair<const char*, const char*> pairs[] = {{"Arm.L", "Arm.R"},
                                                       {"arm_l", "arm_r"},
                                                       {"L_Hand", "R_Hand"},
                                                       {"LeftFoot", "RightFoot"},
                                                       {"mixamorig:LeftArm", "mixamorig:RightArm"},
                                                       {"FootL", "FootR"},
                                                       {"arm-left", "arm-right"},
                                                       {"LEFT_LEG", "RIGHT_LEG"},
                                                       {"leftarm2", "rightarm2"},
                                                       {"b_LeftUpperArm_09", "b_RightUpperArm_09"},
                                                       {"Bip01 L Thigh", "Bip01 R Thigh"},
                                                       {"Index2.L_end", "Index2.R_end"}};
  for (const auto& [left, right] : pairs) {
    EXPECT_EQ(other_side(left), right);
    EXPECT_EQ(other_side(right), left);
  }
  for (const char* middle : {"Leg", "Head", "Root", "tail_1", "Spine", "", "7"}) {
    EXPECT_EQ(other_side(middle), middle);
  }
}

TEST(PairColumns, PairsByNameThenByPosition) {
  Points P(5, 3);
  P << 0, 0, 0, 1, 1, 0, -1, 1, 0, 0.5, 2, 0, -0.5, 2, 0;
  const std::vector<int> partner =
      pair_columns({"Root", "Arm.L", "Arm.R", "FrontLeg", "FrontLeg.001"}, P, {}, 0.01);
  EXPECT_EQ(partner, (std::vector<int>{0, 2, 1, 4, 3}));
  EXPECT_EQ(pair_columns({}, P, {}, 0.01), (std::vector<int>{0, 2, 1, 4, 3}));
  P(4, 1) = 2.5;
  EXPECT_EQ(pair_columns({}, P, {}, 0.01), (std::vector<int>{0, 2, 1, 3, 4}));
  EXPECT_THROW(pair_columns({"a"}, P, {}, 0.01), InputError);
  EXPECT_THROW(pair_columns({}, P, {.normal = Vec3(2, 0, 0)}, 0.01), InputError);
}

TEST(PointGrid, FindsTheNearestPointFromAnywhere) {
  Points P(500, 3);
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 3; ++k) {
      P(i, k) =
          skinfield_test::hash_unit(static_cast<std::uint64_t>(3 * i + k)) * (k == 2 ? 0.01 : 1);
    }
  }
  const PointGrid grid(P);
  for (int q = 0; q < 200; ++q) {
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      x[k] = 3 * skinfield_test::hash_unit(static_cast<std::uint64_t>(9000 + 3 * q + k)) - 1;
    }
    Eigen::Index expected = 0;
    (P.rowwise() - x.transpose()).rowwise().squaredNorm().minCoeff(&expected);
    EXPECT_EQ(grid.nearest(x), expected);
  }
}

TEST(Mirror, TwiceIsTheIdentityOnASymmetricMesh) {
  const Mesh mesh = grid_mesh(9);
  const SkinWeights weights = random_weights(81, 5, 1);
  const std::vector<int> partner{1, 0, 2, 4, 3};
  const Mirrored once = mirror(weights, mesh, {}, partner, 1e-6);
  const Mirrored twice = mirror(once.weights, mesh, {}, partner, 1e-6);
  EXPECT_EQ(once.matched, 81);
  EXPECT_GT(compare(once.weights, weights).mean, 0.1);
  EXPECT_EQ(dense_weights(twice.weights), dense_weights(weights));
}

TEST(Mirror, InterpolatesWhereNoVertexMatches) {
  Mesh mesh = grid_mesh(9);
  mesh.V.col(0).array() *= 0.5;
  mesh.V.col(0).array() += 0.013;
  const Mirrored result = mirror(random_weights(81, 3, 2), mesh, {}, {0, 1, 2}, 1e-6);
  EXPECT_EQ(result.matched, 0);
  EXPECT_LT(largest_row_error(result.weights), 1e-12);
}

TEST(Symmetrise, GivesItsOwnMirrorImage) {
  const Mesh mesh = grid_mesh(7);
  const std::vector<int> partner{1, 0, 2};
  const Mirrored half = symmetrise(random_weights(49, 3, 3), mesh, {}, partner, 1e-6);
  const Mirrored image = mirror(half.weights, mesh, {}, partner, 1e-6);
  EXPECT_LT(compare(half.weights, image.weights).max, 1e-15);
  EXPECT_LT(largest_row_error(half.weights), 1e-14);
  EXPECT_THROW(mirror(half.weights, mesh, {}, {1, 2, 0}, 1e-6), InputError);
}

}  // namespace
}  // namespace skinfield
