#include "skinfield/rig/handles.h"

#include "rig/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/rig/bone_tree.h"
#include "skinfield/rig/glob.h"

#include <gtest/gtest.h>

#include <limits>

namespace skinfield {
namespace {

using skinfield_test::joint_skeleton;
using skinfield_test::tgf_skeleton;
using Which = JointOptions::Which;

const Handle* find(const Skeleton& skeleton, const std::string& name) {
  for (const Handle& handle : skeleton.handles) {
    if (handle.name == name) return &handle;
  }
  return nullptr;
}

TEST(TgfHandles, PointsComeFirstThenBonesInFileOrder) {
  Skeleton s =
      tgf_skeleton({{0, 0, 0}, {5, 5, 5}, {1, 0, 0}, {2, 0, 0}, {7, 7, 7}}, {{2, 3}, {0, 2}});
  make_tgf_handles(s);
  ASSERT_EQ(s.columns, 4);
  EXPECT_EQ(s.column, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(s.handles[0].kind, Handle::Kind::point);
  EXPECT_EQ(s.handles[0].point, Vec3(5, 5, 5));
  EXPECT_EQ(s.handles[1].point, Vec3(7, 7, 7));
  EXPECT_EQ(s.handles[2].segments, (std::vector<std::pair<Vec3, Vec3>>{{{1, 0, 0}, {2, 0, 0}}}));
  EXPECT_EQ(s.handles[3].segments[0].second, Vec3(1, 0, 0));
  EXPECT_EQ(s.handles[3].joint, -1);
  EXPECT_EQ(s.joints[3].parent, 2);
  EXPECT_EQ(s.joints[2].parent, 0);
  EXPECT_EQ(s.column_names, (std::vector<std::string>{"2", "5", "3-4", "1-3"}));
}

TEST(TgfHandles, ZeroLengthBonesArePointsInTheirColumn) {
  Skeleton s =
      tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {3, 0, 0}}, {{0, 1}, {1, 2}, {3, 3}, {0, 1}});
  make_tgf_handles(s);
  ASSERT_EQ(s.columns, 4);
  EXPECT_EQ(s.handles[1].kind, Handle::Kind::point);
  EXPECT_EQ(s.handles[1].point, Vec3(1, 0, 0));
  EXPECT_EQ(s.handles[2].kind, Handle::Kind::point);
  EXPECT_EQ(s.handles[3].kind, Handle::Kind::bone);
  EXPECT_NE(s.column_names[0], s.column_names[3]);
}

TEST(TgfHandles, RefusesNothingWrongNumbersAndNonFinitePositions) {
  Skeleton none;
  EXPECT_THROW(make_tgf_handles(none), InputError);
  Skeleton wrong = tgf_skeleton({{0, 0, 0}}, {{0, 1}});
  EXPECT_THROW(make_tgf_handles(wrong), InputError);
  Skeleton nan = tgf_skeleton({{0, std::numeric_limits<double>::quiet_NaN(), 0}}, {});
  EXPECT_THROW(make_tgf_handles(nan), InputError);
}

TEST(BoneTree, FollowsTheFileWhereItIsAForest) {
  const Skeleton s =
      tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, {{2, 3}, {1, 2}, {1, 0}});
  const BoneTree tree = bone_tree(s);
  EXPECT_EQ(tree.head, (std::vector<int>{2, 1, 1}));
  EXPECT_EQ(tree.parent, (std::vector<int>{1, -1, -1}));
  EXPECT_EQ(tree.order, (std::vector<int>{1, 2, 0}));
}

TEST(BoneTree, OrientsFromTheFirstJointOtherwise) {
  const Skeleton s =
      tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, {{0, 1}, {2, 1}, {3, 2}, {3, 0}});
  const BoneTree tree = bone_tree(s);
  EXPECT_EQ(tree.head, (std::vector<int>{0, 1, 3, 0}));
  EXPECT_EQ(tree.tail, (std::vector<int>{1, 2, 2, 3}));
  EXPECT_EQ(tree.parent, (std::vector<int>{-1, 0, 3, -1}));
  ASSERT_EQ(tree.order.size(), 4u);
}

TEST(JointHandles, OwnTheSegmentsToTheirDeformingChildren) {
  Skeleton s = joint_skeleton({{"hip", -1, {0, 0, 0}},
                               {"legL", 0, {1, -1, 0}},
                               {"legR", 0, {-1, -1, 0}},
                               {"spine", 0, {0, 1, 0}},
                               {"head", 3, {0, 3, 0}}});
  make_joint_handles(s);
  ASSERT_EQ(s.columns, 5);
  EXPECT_EQ(find(s, "hip")->segments.size(), 3u);
  EXPECT_EQ(find(s, "spine")->segments[0].second, Vec3(0, 3, 0));
  // A leaf goes on in its bone's direction by half the bone's length.
  EXPECT_EQ(find(s, "head")->segments[0].second, Vec3(0, 4, 0));
  EXPECT_EQ(find(s, "legL")->segments[0].second, Vec3(1.5, -1.5, 0));
  EXPECT_EQ(find(s, "legL")->joint, 1);

  make_joint_handles(s, {.which = Which::all, .leaf = JointOptions::Leaf::point});
  EXPECT_EQ(find(s, "head")->kind, Handle::Kind::point);
  EXPECT_EQ(find(s, "head")->point, Vec3(0, 3, 0));
}

TEST(JointHandles, LeavesEndAtTheirTips) {
  Skeleton s = joint_skeleton({{"neck", -1, {0, 0, 0}},
                               {"Head", 0, {0, 1, 0}},
                               {"HeadTop_End", 1, {0, 1, 5}},
                               {"Tail", 0, {0, -1, 0}}});
  s.joints[3].tips = {{"Hat", {9, 9, 9}}, {"Tail_end", {0, -1, -2}}};
  make_joint_handles(s);
  EXPECT_EQ(s.left_out, std::vector<int>{2});
  EXPECT_EQ(find(s, "HeadTop_End"), nullptr);
  EXPECT_EQ(find(s, "Head")->segments[0].second, Vec3(0, 1, 5));
  EXPECT_EQ(find(s, "Tail")->segments[0].second, Vec3(0, -1, -2));
  EXPECT_EQ(s.column, (std::vector<int>{0, 1, 3}));
  EXPECT_EQ(s.columns, 4);
}

TEST(JointHandles, HelpersNeitherEndABoneNorLendADirection) {
  Skeleton s = joint_skeleton({{"hip", -1, {0, 0, 0}},
                               {"control_spine", 0, {4, 1, 0}},
                               {"chest", 1, {0, 2, 0}},
                               {"hand_IK", 2, {3, 3, 3}}});
  make_joint_handles(s);
  EXPECT_EQ(s.left_out, (std::vector<int>{1, 3}));
  EXPECT_EQ(find(s, "hip")->segments, (std::vector<std::pair<Vec3, Vec3>>{{{0, 0, 0}, {0, 2, 0}}}));
  EXPECT_EQ(find(s, "chest")->segments[0].second, Vec3(0, 3, 0));
}

TEST(JointHandles, ZeroLengthBonesArePoints) {
  Skeleton s = joint_skeleton({{"a", -1, {0, 0, 0}},
                               {"b", 0, {0, 1, 0}},
                               {"twist", 1, {0, 1, 0}},
                               {"lonely", -1, {5, 0, 0}}});
  make_joint_handles(s);
  EXPECT_EQ(find(s, "b")->kind, Handle::Kind::point);
  EXPECT_EQ(find(s, "b")->point, Vec3(0, 1, 0));
  // The leaf at the same place continues the bone above both.
  EXPECT_EQ(find(s, "twist")->segments[0].second, Vec3(0, 1.5, 0));
  EXPECT_EQ(find(s, "lonely")->kind, Handle::Kind::point);
}

TEST(JointHandles, LeavesAreCutWhereTheyLeaveTheShape) {
  Skeleton s = joint_skeleton({{"a", -1, {0, 0, 0}}, {"b", 0, {0, 0.8, 0}}});
  const InsideTest ball = [](const Vec3& x) { return x.norm() < 1; };
  make_joint_handles(s, {}, {}, ball);
  EXPECT_NEAR(find(s, "b")->segments[0].second[1], 1, 1e-6);
  const InsideTest elsewhere = [](const Vec3& x) { return (x - Vec3(0, 0, 0)).norm() < 0.5; };
  make_joint_handles(s, {}, {}, elsewhere);
  EXPECT_NEAR(find(s, "b")->segments[0].second[1], 1.2, 1e-12);
}

TEST(JointHandles, AutoFollowsWeightsAndElseNamesAndRoots) {
  Skeleton s = joint_skeleton({{"Root", -1, {0, -9, 0}},
                               {"hip", 0, {0, 0, 0}},
                               {"PoleTarget.L", 0, {0, 0.1, 0}},
                               {"handslot.l", 1, {0, 0.2, 0}}});
  const InsideTest ball = [](const Vec3& x) { return x.norm() < 1; };
  make_joint_handles(s, {}, {}, ball);
  EXPECT_EQ(s.column, std::vector<int>{1});
  make_joint_handles(s, {}, {true, false, true, false}, ball);
  EXPECT_EQ(s.column, (std::vector<int>{0, 2}));
  make_joint_handles(s, {}, {false, false, false, false}, ball);
  EXPECT_EQ(s.column, std::vector<int>{1});
  make_joint_handles(s, {.which = Which::all}, {true, false, true, false}, ball);
  EXPECT_EQ(s.column.size(), 4u);
  make_joint_handles(s, {.which = Which::match, .patterns = {"h*"}, .exclude = {"*slot*"}});
  EXPECT_EQ(s.column, std::vector<int>{1});
  EXPECT_EQ(s.left_out, (std::vector<int>{0, 2, 3}));
}

TEST(JointHandles, RefuseWhatCannotBe) {
  Skeleton s = joint_skeleton({{"a", -1, {0, 0, 0}}, {"b", 0, {0, 1, 0}}});
  EXPECT_THROW(make_joint_handles(s, {.which = Which::used}), InputError);
  EXPECT_THROW(make_joint_handles(s, {.which = Which::match, .patterns = {"z"}}), InputError);
  EXPECT_THROW(make_joint_handles(s, {}, {true}), InputError);
  s.joints[0].parent = 1;
  EXPECT_THROW(make_joint_handles(s), InputError);
}

TEST(JointHandles, AreBoundEvenIfAllNamesLookLikeHelpers) {
  Skeleton s = joint_skeleton({{"target_1", -1, {0, 0, 0}}, {"target_2", 0, {0, 1, 0}}});
  make_joint_handles(s);
  EXPECT_EQ(s.column.size(), 2u);
}

TEST(JointNames, TellHelpersAndTips) {
  for (const char* name :
       {"IKBackLeg.L", "kneeIK.l", "PoleTargetL", "control-toe-roll.l", "Hat_Socket", "handslot.r",
        "Head_end", "Head_end_01", "Bip01 HeadNub", "ik_foot_l"}) {
    EXPECT_TRUE(is_helper_name(name)) << name;
  }
  for (const char* name : {"Spike", "Tadpole", "Spine", "Legend", "bend", "Kiki", "tail_1", "",
                           "b_LeftFoot01_017", "leg_joint_L_1", "Hips"}) {
    EXPECT_FALSE(is_helper_name(name)) << name;
  }
  for (const char* name : {"Head_end", "LeftToe_End", "pinky-finger-tip", "HeadNub", "Toe0nub"}) {
    EXPECT_TRUE(is_tip_name(name)) << name;
  }
  for (const char* name : {"Hat", "1H_Axe", "Torso_2", "Pistol", "Stag_Horns", "Bender"}) {
    EXPECT_FALSE(is_tip_name(name)) << name;
  }
}

TEST(Glob, MatchesStarsAndQuestionMarks) {
  EXPECT_TRUE(glob_match("*", ""));
  EXPECT_TRUE(glob_match("", ""));
  EXPECT_TRUE(glob_match("arm*", "arm"));
  EXPECT_TRUE(glob_match("*.L", "Arm.L.L"));
  EXPECT_TRUE(glob_match("a*b*c", "axbxbxc"));
  EXPECT_TRUE(glob_match("Finger?", "Finger3"));
  EXPECT_FALSE(glob_match("Finger?", "Finger"));
  EXPECT_FALSE(glob_match("a*b", "acbc"));
  EXPECT_FALSE(glob_match("", "a"));
  EXPECT_FALSE(glob_match("ARM", "arm"));
  EXPECT_TRUE(glob_match_any({"x", "a*"}, "arm"));
  EXPECT_FALSE(glob_match_any({}, "arm"));
}

}  // namespace
}  // namespace skinfield
