#include "skinfield/io/pose_file.h"

#include "skinfield/base/error.h"
#include "support/data.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

TEST(PoseFile, JsonByNameAndIndex) {
  const PoseFile pose = parse_pose_json(
      R"({"Arm": {"rotation": [0, 0, 2, 0], "translation": [1, 2, 3]}, "12": {}})", "a");
  ASSERT_EQ(pose.frames.size(), 1u);
  ASSERT_EQ(pose.frames[0].size(), 2u);
  EXPECT_EQ(pose.frames[0][0].name, "Arm");
  EXPECT_EQ(pose.frames[0][0].index, -1);
  EXPECT_TRUE(pose.frames[0][0].rotation.isApprox(Eigen::Quaterniond(0, 0, 0, 1)));
  EXPECT_EQ(pose.frames[0][0].translation, Vec3(1, 2, 3));
  EXPECT_EQ(pose.frames[0][1].index, 12);
  EXPECT_TRUE(pose.frames[0][1].rotation.isApprox(Eigen::Quaterniond::Identity()));
  EXPECT_EQ(parse_pose_json(R"([{"1": {}}, {"1": {}}])", "a").frames.size(), 2u);
  EXPECT_EQ(parse_pose_json(R"({"frames": [{}]})", "a").frames.size(), 1u);
}

TEST(PoseFile, JsonRefusals) {
  for (const char* bad :
       {"", "{", "3", "[]", "[3]", R"({"a": 3})", R"({"a": {"rotation": [0, 0, 0]}})",
        R"({"a": {"rotation": [0, 0, 0, 0]}})", R"({"a": {"rotation": [0, 0, 0, "1"]}})",
        R"({"a": {"translation": [0, 0, 1e999]}})", R"({"a": {"scale": [1, 1, 1]}})",
        "[[[[[[[[[[[[[[[[[[[[[[[]"}) {
    EXPECT_THROW(parse_pose_json(bad, "a"), InputError) << bad;
  }
}

TEST(PoseFile, DmatBothWays) {
  const PoseFile column = parse_pose_dmat("1 8\n0\n0\n0\n1\n1\n0\n0\n0\n", "a");
  const PoseFile rows = parse_pose_dmat("4 2\n0\n1\n0\n0\n0\n0\n1\n0\n", "a");
  for (const PoseFile& pose : {column, rows}) {
    ASSERT_EQ(pose.frames.size(), 1u);
    ASSERT_EQ(pose.frames[0].size(), 2u);
    EXPECT_TRUE(pose.frames[0][0].rotation.isApprox(Eigen::Quaterniond::Identity()));
    EXPECT_TRUE(pose.frames[0][1].rotation.isApprox(Eigen::Quaterniond(0, 1, 0, 0)));
    EXPECT_EQ(pose.frames[0][1].index, 1);
  }
  EXPECT_THROW(parse_pose_dmat("1 3\n0\n0\n1\n", "a"), InputError);
  EXPECT_THROW(parse_pose_dmat("1 4\n0\n0\n0\n0\n", "a"), InputError);
}

TEST(PoseFile, FramesBecomePosesOfASkeleton) {
  Skeleton skeleton;
  skeleton.source = Skeleton::Source::gltf;
  skeleton.joints.resize(3);
  skeleton.columns = 3;
  skeleton.column_names = {"Hip", "Arm", "Leg"};
  const PoseFile file = parse_pose_json(
      R"({"Arm": {"rotation": [1, 0, 0, 0]}, "2": {"translation": [1, 2, 3]}})", "a");
  const Pose pose = pose_for(file, 0, skeleton);
  ASSERT_EQ(pose.joints.size(), 3u);
  EXPECT_TRUE(pose.joints[0].rotation.isApprox(Eigen::Quaterniond::Identity()));
  EXPECT_TRUE(pose.joints[1].rotation.isApprox(Eigen::Quaterniond(0, 1, 0, 0)));
  EXPECT_EQ(pose.joints[2].translation, Vec3(1, 2, 3));
  EXPECT_THROW(pose_for(file, 1, skeleton), InputError);
  for (const char* bad : {R"({"Tail": {}})", R"({"3": {}})"}) {
    EXPECT_THROW(pose_for(parse_pose_json(bad, "a"), 0, skeleton), InputError) << bad;
  }
}

TEST(PoseFile, HandPoseHasAUnitQuaternionABone) {
  SKINFIELD_NEEDS_DATA(path, "fem/hand-pose.dmat");
  const PoseFile pose = read_pose(path);
  ASSERT_EQ(pose.frames.size(), 1u);
  EXPECT_EQ(pose.frames[0].size(), 20u);
  EXPECT_NEAR(pose.frames[0][0].rotation.w(), 0.75297704283434619, 1e-9);
}

}  // namespace
}  // namespace skinfield
