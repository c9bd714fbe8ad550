// Poses and forward kinematics: from rotations at joints to one transform a weight column.
#pragma once

#include "skinfield/rig/skeleton.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skinfield {

/// A change relative to the rest: scale first, then rotation, then translation.
struct JointPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit; coefficients x y z w
  Vec3 translation = Vec3::Zero();
  Vec3 scale = Vec3::Ones();
};

/// One entry a weight column.
/// glTF: in the joint's own rest frame (its axes and its units): world = parent's world * local
/// rest * change. TGF bones: about the head, in the file's axes, on top of the bones above; TGF
/// points: about the point.
struct Pose {
  std::vector<JointPose> joints;
};

/// What a glTF pose is relative to. rest: the document's node transforms, as glTF players pose
/// it. bind: the inverse bind matrices, so that the unchanged pose is exactly the mesh as it was
/// bound, whatever the nodes say. TGF skeletons have only one.
enum class PoseBase { rest, bind };

Pose rest_pose(const Skeleton& skeleton);

/// Joint indices, parents before children, in file order otherwise. Throws InputError for parents
/// that do not exist and for cycles.
std::vector<int> parents_first(const std::vector<Joint>& joints);

/// glTF: the world transform of every joint. Throws InputError if the pose has not one entry a
/// column, numbers are not finite, or (bind) an inverse bind matrix has no inverse.
std::vector<Transform> joint_transforms(const Skeleton& skeleton, const Pose& pose,
                                        PoseBase base = PoseBase::rest);

/// From bind space to the pose, one a column (skinning matrices): glTF world * inverse_bind; TGF
/// as `Pose` says. Precondition: the skeleton's handles are made. Throws as joint_transforms.
std::vector<Transform> column_transforms(const Skeleton& skeleton, const Pose& pose,
                                         PoseBase base = PoseBase::rest);

/// libigl's poses of a TGF: quaternions x y z w, one after the other, one a bone in file order
/// (point handles rest) or one a column. They need not be normalised.
/// Throws InputError if their number fits neither or one is zero.
Pose pose_from_quaternions(const Skeleton& skeleton, std::span<const double> xyzw);

/// The pose t of the way from a to b: rotations along the shorter arc, the rest linear.
Pose interpolate(const Pose& a, const Pose& b, double t);

/// A bend of everything that deforms and is no root (of everything, where there are only roots),
/// to look at weights: each bone by 0.7 to 1 of `amplitude` (radians) to alternating sides in the
/// plane in which the skeleton is widest, less (down to a fifth) where it carries more than a
/// fifth of the handles; point handles also move a little. Deterministic; the seed varies the
/// angles. Meant for PoseBase::bind.
Pose demo_pose(const Skeleton& skeleton, double amplitude = 0.6, std::uint64_t seed = 0);

/// The handles with their segments and points moved along with their columns.
std::vector<Handle> posed_handles(const Skeleton& skeleton, const std::vector<Transform>& columns);

}  // namespace skinfield
