#include "skinfield/rig/pose.h"

#include "skinfield/base/error.h"
#include "skinfield/rig/bone_tree.h"

#include <Eigen/LU>

#include <cmath>

namespace skinfield {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 apply(const Transform& T, const Vec3& x) {
  return T.topLeftCorner<3, 3>() * x + T.topRightCorner<3, 1>();
}

Transform change(const JointPose& pose) {
  Transform T = Transform::Identity();
  T.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix() * pose.scale.asDiagonal();
  T.topRightCorner<3, 1>() = pose.translation;
  return T;
}

/// The change about a place instead of the origin.
Transform change_about(const JointPose& pose, const Vec3& centre) {
  Transform T = change(pose);
  T.topRightCorner<3, 1>() += centre - T.topLeftCorner<3, 3>() * centre;
  return T;
}

void check(const Skeleton& skeleton, const Pose& pose) {
  if (pose.joints.size() != at(skeleton.columns)) {
    throw InputError("the pose has " + std::to_string(pose.joints.size()) + " entries for " +
                         std::to_string(skeleton.columns) + " columns",
                     "pose");
  }
  for (std::size_t j = 0; j < pose.joints.size(); ++j) {
    const JointPose& joint = pose.joints[j];
    if (!joint.rotation.coeffs().allFinite() || !joint.translation.allFinite() ||
        !joint.scale.allFinite() || std::abs(joint.rotation.norm() - 1) > 1e-6) {
      throw InputError("entry " + std::to_string(j) + " is not finite or no unit quaternion",
                       "pose");
    }
  }
}

std::vector<Transform> bind_transforms(const Skeleton& skeleton) {
  std::vector<Transform> bind;
  for (const Joint& joint : skeleton.joints) {
    const Eigen::FullPivLU<Transform> factors(joint.inverse_bind);
    const Transform inverse = factors.inverse();
    if (!factors.isInvertible() || !inverse.allFinite()) {
      throw InputError("the inverse bind matrix of joint '" + joint.name + "' has no inverse",
                       "skeleton");
    }
    bind.push_back(inverse);
  }
  return bind;
}

std::vector<Transform> handle_transforms(const Skeleton& skeleton, const Pose& pose) {
  std::vector<Transform> columns(at(skeleton.columns), Transform::Identity());
  const std::size_t points = at(first_bone_column(skeleton));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    columns[i] = change_about(pose.joints[i], skeleton.handles[i].point);
  }
  const BoneTree tree = bone_tree(skeleton);
  for (const int e : tree.order) {
    const std::size_t column = points + at(e);
    const Vec3 head = skeleton.joints[at(tree.head[at(e)])].position;
    columns[column] = change_about(pose.joints[column], head);
    if (tree.parent[at(e)] >= 0) {
      columns[column] = columns[points + at(tree.parent[at(e)])] * columns[column];
    }
  }
  return columns;
}

/// Column i is handles[i]: of TGF files, and of regions alone.
bool columns_are_handles(const Skeleton& skeleton) {
  if (skeleton.source == Skeleton::Source::gltf) return false;
  if (at(skeleton.columns) != skeleton.handles.size() ||
      skeleton.handles.size() < skeleton.bones.size()) {
    throw InputError("the handles are not made yet", "skeleton");
  }
  return true;
}

}  // namespace

Pose rest_pose(const Skeleton& skeleton) { return {std::vector<JointPose>(at(skeleton.columns))}; }

std::vector<int> parents_first(const std::vector<Joint>& joints) {
  const int count = static_cast<int>(joints.size());
  std::vector<std::vector<int>> children(joints.size());
  std::vector<int> order;
  for (int j = 0; j < count; ++j) {
    const int parent = joints[at(j)].parent;
    if (parent >= count || parent == j) {
      throw InputError("joint '" + joints[at(j)].name + "' has a parent that does not exist",
                       "skeleton");
    }
    if (parent < 0) {
      order.push_back(j);
    } else {
      children[at(parent)].push_back(j);
    }
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::vector<int>& below = children[at(order[k])];
    order.insert(order.end(), below.begin(), below.end());
  }
  if (order.size() != joints.size()) {
    throw InputError("joints are their own ancestors", "skeleton");
  }
  return order;
}

std::vector<Transform> joint_transforms(const Skeleton& skeleton, const Pose& pose, PoseBase base) {
  check(skeleton, pose);
  if (pose.joints.size() != skeleton.joints.size()) {
    throw InputError("only joints of a glTF skin have transforms of their own", "pose");
  }
  std::vector<Transform> bind;
  if (base == PoseBase::bind) bind = bind_transforms(skeleton);
  std::vector<Transform> world(skeleton.joints.size());
  for (const int j : parents_first(skeleton.joints)) {
    const Joint& joint = skeleton.joints[at(j)];
    Transform local = joint.local_rest;
    if (base == PoseBase::bind) {
      local = joint.parent < 0 ? bind[at(j)]
                               : skeleton.joints[at(joint.parent)].inverse_bind * bind[at(j)];
    }
    world[at(j)] = local * change(pose.joints[at(j)]);
    if (joint.parent >= 0) world[at(j)] = world[at(joint.parent)] * world[at(j)];
  }
  return world;
}

std::vector<Transform> column_transforms(const Skeleton& skeleton, const Pose& pose,
                                         PoseBase base) {
  check(skeleton, pose);
  if (columns_are_handles(skeleton)) return handle_transforms(skeleton, pose);
  std::vector<Transform> columns = joint_transforms(skeleton, pose, base);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    columns[j] = columns[j] * skeleton.joints[j].inverse_bind;
  }
  return columns;
}

Pose pose_from_quaternions(const Skeleton& skeleton, std::span<const double> xyzw) {
  Pose pose = rest_pose(skeleton);
  const std::size_t count = xyzw.size() / 4;
  const bool bones_only = columns_are_handles(skeleton) && count == skeleton.bones.size();
  if (xyzw.size() % 4 != 0 || (!bones_only && count != pose.joints.size())) {
    throw InputError(std::to_string(xyzw.size()) + " numbers are not a quaternion for each bone",
                     "pose",
                     "give 4 numbers (x y z w) for each of the " +
                         std::to_string(pose.joints.size()) + " handles");
  }
  const std::size_t first = bones_only ? at(first_bone_column(skeleton)) : 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Quaterniond q(xyzw[4 * k + 3], xyzw[4 * k], xyzw[4 * k + 1], xyzw[4 * k + 2]);
    const double norm = q.norm();
    if (!(norm > 1e-12) || !std::isfinite(norm)) {
      throw InputError("quaternion " + std::to_string(k) + " is zero or not finite", "pose");
    }
    pose.joints[first + k].rotation = q.normalized();
  }
  return pose;
}

Pose interpolate(const Pose& a, const Pose& b, double t) {
  if (a.joints.size() != b.joints.size()) {
    throw InputError("the poses belong to different skeletons", "pose");
  }
  Pose result = a;
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    JointPose& joint = result.joints[j];
    joint.rotation = a.joints[j].rotation.slerp(t, b.joints[j].rotation).normalized();
    joint.translation += t * (b.joints[j].translation - a.joints[j].translation);
    joint.scale += t * (b.joints[j].scale - a.joints[j].scale);
  }
  return result;
}

std::vector<Handle> posed_handles(const Skeleton& skeleton, const std::vector<Transform>& columns) {
  if (columns.size() != at(skeleton.columns)) {
    throw InputError("one transform a column is needed", "pose");
  }
  std::vector<Handle> posed = skeleton.handles;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const Transform& T = columns[at(skeleton.column[i])];
    posed[i].point = apply(T, posed[i].point);
    for (auto& [a, b] : posed[i].segments) {
      a = apply(T, a);
      b = apply(T, b);
    }
  }
  return posed;
}

}  // namespace skinfield
