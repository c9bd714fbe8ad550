#include "skinfield/rig/pose.h"

#include "rig/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/base/random.h"
#include "skinfield/rig/handles.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>

namespace skinfield {
namespace {

using skinfield_test::joint_skeleton;
using skinfield_test::tgf_skeleton;

Eigen::Quaterniond turn(double angle, const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

Vec3 apply(const Transform& T, const Vec3& x) { return (T * x.homogeneous()).head<3>(); }

/// Five joints in random frames; the rest pose is the bind pose; parents may come after children.
Skeleton random_skeleton() {
  const int parents[] = {2, -1, 1, 0, 1};
  Skeleton s;
  s.source = Skeleton::Source::gltf;
  s.joints.resize(5);
  for (int j = 0; j < 5; ++j) {
    Random random(7, static_cast<std::uint64_t>(j));
    Joint& joint = s.joints[static_cast<std::size_t>(j)];
    joint.name = std::string("j") + std::to_string(j);
    joint.parent = parents[j];
    joint.position = random.direction() * 2;
    joint.world_rest.topLeftCorner<3, 3>() =
        1.7 * turn(3 * random.uniform(), random.direction()).toRotationMatrix();
    joint.world_rest.topRightCorner<3, 1>() = joint.position;
    joint.inverse_bind = joint.world_rest.inverse();
  }
  for (Joint& joint : s.joints) {
    joint.local_rest =
        joint.parent < 0 ? joint.world_rest
                         : Transform(s.joints[static_cast<std::size_t>(joint.parent)].inverse_bind *
                                     joint.world_rest);
  }
  make_joint_handles(s, {.which = JointOptions::Which::all});
  return s;
}

double deviation(const std::vector<Transform>& transforms) {
  double worst = 0;
  for (const Transform& T : transforms) {
    worst = std::max(worst, (T - Transform::Identity()).cwiseAbs().maxCoeff());
  }
  return worst;
}

TEST(ForwardKinematics, OfTheRestPoseIsTheRest) {
  const Skeleton s = random_skeleton();
  const std::vector<Transform> world = joint_transforms(s, rest_pose(s));
  for (std::size_t j = 0; j < world.size(); ++j) {
    EXPECT_LT((world[j] - s.joints[j].world_rest).cwiseAbs().maxCoeff(), 1e-12);
  }
  EXPECT_LT(deviation(column_transforms(s, rest_pose(s))), 1e-12);
  EXPECT_LT(deviation(column_transforms(s, rest_pose(s), PoseBase::bind)), 1e-12);
}

TEST(ForwardKinematics, BindBaseIgnoresTheNodes) {
  Skeleton s = random_skeleton();
  for (Joint& joint : s.joints) joint.local_rest *= 100;
  EXPECT_GT(deviation(column_transforms(s, rest_pose(s))), 1);
  EXPECT_LT(deviation(column_transforms(s, rest_pose(s), PoseBase::bind)), 1e-12);
}

TEST(ForwardKinematics, TurningAJointKeepsItAndCarriesItsChildren) {
  Skeleton s = joint_skeleton({{"a", -1, {0, 0, 0}}, {"b", 0, {1, 0, 0}}, {"c", 1, {2, 0, 0}}});
  make_joint_handles(s);
  Pose pose = rest_pose(s);
  pose.joints[1].rotation = turn(std::acos(-1.0) / 2, Vec3::UnitZ());
  const std::vector<Transform> T = column_transforms(s, pose);
  EXPECT_LT(deviation({T[0]}), 1e-15);
  EXPECT_LT((apply(T[1], {1, 0, 0}) - Vec3(1, 0, 0)).norm(), 1e-14);
  EXPECT_LT((apply(T[1], {2, 0, 0}) - Vec3(1, 1, 0)).norm(), 1e-14);
  EXPECT_LT((T[2] - T[1]).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(ForwardKinematics, TurningTheRootMovesEverythingRigidly) {
  const Skeleton s = random_skeleton();
  Pose pose = rest_pose(s);
  pose.joints[1].rotation = turn(0.8, {1, 2, 3});
  pose.joints[1].translation = Vec3(0.1, 0.2, 0.3);
  const std::vector<Transform> T = column_transforms(s, pose);
  for (const Transform& t : T) EXPECT_LT((t - T[1]).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((T[1].topLeftCorner<3, 3>() * T[1].topLeftCorner<3, 3>().transpose() -
             Eigen::Matrix3d::Identity())
                .norm(),
            1e-12);
}

TEST(TgfKinematics, BonesTurnAboutTheirHeadsAndStayConnected) {
  Skeleton s = tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 1, 0}, {9, 9, 9}},
                            {{0, 1}, {1, 2}, {2, 3}});
  make_tgf_handles(s);
  EXPECT_LT(deviation(column_transforms(s, rest_pose(s))), 1e-15);
  const Eigen::Quaterniond q[] = {turn(0.4, {0, 0, 1}), turn(-0.9, {1, 1, 0}),
                                  turn(1.3, {0, 1, 2})};
  std::vector<double> numbers;
  for (const auto& each : q) {
    for (int k = 0; k < 4; ++k) numbers.push_back(3 * each.coeffs()[k]);
  }
  const Pose pose = pose_from_quaternions(s, numbers);
  const std::vector<Transform> T = column_transforms(s, pose);
  EXPECT_LT(deviation({T[0]}), 1e-15);  // the point handle
  EXPECT_LT((T[1].topLeftCorner<3, 3>() - q[0].toRotationMatrix()).norm(), 1e-12);
  EXPECT_LT((T[3].topLeftCorner<3, 3>() - (q[0] * q[1] * q[2]).toRotationMatrix()).norm(), 1e-12);
  EXPECT_LT((apply(T[1], {0, 0, 0})).norm(), 1e-15);
  for (const int k : {1, 2}) {
    const Vec3 joint = s.joints[static_cast<std::size_t>(k)].position;
    const std::size_t column = static_cast<std::size_t>(k);
    EXPECT_LT((apply(T[column], joint) - apply(T[column + 1], joint)).norm(), 1e-14);
  }
  EXPECT_THROW(pose_from_quaternions(s, std::vector<double>(11, 1.0)), InputError);
  EXPECT_THROW(pose_from_quaternions(s, std::vector<double>(12, 0.0)), InputError);
  EXPECT_EQ(pose_from_quaternions(s, std::vector<double>(16, 1.0)).joints.size(), 4u);
}

TEST(TgfKinematics, PointsTurnAboutThemselves) {
  Skeleton s = tgf_skeleton({{1, 2, 3}}, {});
  make_tgf_handles(s);
  Pose pose = rest_pose(s);
  pose.joints[0] = {turn(1, {1, 0, 0}), {0, 0, 5}, {2, 2, 2}};
  const Transform T = column_transforms(s, pose)[0];
  EXPECT_LT((apply(T, {1, 2, 3}) - Vec3(1, 2, 8)).norm(), 1e-14);
  EXPECT_LT((apply(T, {2, 2, 3}) - Vec3(3, 2, 8)).norm(), 1e-14);
}

TEST(Pose, RefusesWhatDoesNotFit) {
  const Skeleton s = random_skeleton();
  EXPECT_THROW(column_transforms(s, Pose{}), InputError);
  Pose pose = rest_pose(s);
  pose.joints[2].rotation.coeffs() *= 2;
  EXPECT_THROW(column_transforms(s, pose), InputError);
  Skeleton flat = s;
  flat.joints[0].inverse_bind.setZero();
  EXPECT_THROW(column_transforms(flat, rest_pose(s), PoseBase::bind), InputError);
  flat = s;
  flat.joints[1].parent = 3;
  EXPECT_THROW(column_transforms(flat, rest_pose(s)), InputError);
}

TEST(Pose, InterpolatesBetweenItsEnds) {
  const Skeleton s = random_skeleton();
  const Pose bent = demo_pose(s, 0.8);
  const auto same = [](const Pose& a, const Pose& b) {
    double worst = 0;
    for (std::size_t j = 0; j < a.joints.size(); ++j) {
      worst = std::max(worst, a.joints[j].rotation.angularDistance(b.joints[j].rotation));
    }
    return worst;
  };
  EXPECT_LT(same(interpolate(rest_pose(s), bent, 0), rest_pose(s)), 1e-12);
  EXPECT_LT(same(interpolate(rest_pose(s), bent, 1), bent), 1e-12);
  EXPECT_NEAR(same(interpolate(rest_pose(s), bent, 0.25), rest_pose(s)),
              0.25 * same(bent, rest_pose(s)), 1e-12);
}

TEST(DemoPose, BendsLimbsMoreThanTrunksAndRootsNotAtAll) {
  const Skeleton s = random_skeleton();
  const Pose pose = demo_pose(s, 0.5, 3), again = demo_pose(s, 0.5, 3);
  const Pose other = demo_pose(s, 0.5, 4);
  double difference = 0;
  for (std::size_t j = 0; j < 5; ++j) {
    const double angle = pose.joints[j].rotation.angularDistance(Eigen::Quaterniond::Identity());
    EXPECT_EQ(pose.joints[j].rotation.coeffs(), again.joints[j].rotation.coeffs());
    difference += pose.joints[j].rotation.angularDistance(other.joints[j].rotation);
    if (j == 1) {
      EXPECT_EQ(angle, 0);
    } else {
      const double share = j == 2 ? 1.2 - 3.0 / 5 : j == 0 ? 1.2 - 2.0 / 5 : 1;
      EXPECT_GE(angle, 0.35 * share - 1e-12);
      EXPECT_LE(angle, 0.5 * share + 1e-12);
    }
  }
  EXPECT_GT(difference, 0);
}

TEST(DemoPose, TurnsBonesAcrossThemselvesAndMovesLonePoints) {
  Skeleton bones = tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {2, 0.5, 0}}, {{0, 1}, {1, 2}});
  make_tgf_handles(bones);
  const Pose pose = demo_pose(bones);
  EXPECT_EQ(pose.joints[0].rotation.vec().norm(), 0);
  EXPECT_NEAR(pose.joints[1].rotation.vec().dot(Vec3(1, 0.5, 0)), 0, 1e-15);
  EXPECT_GT(pose.joints[1].rotation.vec().norm(), 0.1);
  Skeleton points = tgf_skeleton({{0, 0, 0}, {1, 0, 0}}, {});
  make_tgf_handles(points);
  EXPECT_GT(demo_pose(points).joints[1].translation.norm(), 0.01);
}

TEST(PosedHandles, FollowTheirColumns) {
  Skeleton s = tgf_skeleton({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1}, {1, 2}});
  make_tgf_handles(s);
  const std::vector<Handle> posed = posed_handles(s, column_transforms(s, demo_pose(s)));
  EXPECT_LT((posed[0].segments[0].second - posed[1].segments[0].first).norm(), 1e-15);
  EXPECT_NEAR((posed[1].segments[0].second - posed[1].segments[0].first).norm(), 1, 1e-14);
  EXPECT_GT((posed[1].segments[0].second - Vec3(2, 0, 0)).norm(), 0.1);
}

}  // namespace
}  // namespace skinfield
