#include "skinfield/base/random.h"
#include "skinfield/rig/bone_tree.h"
#include "skinfield/rig/pose.h"

#include <algorithm>

namespace skinfield {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Depth of every column below its root; points and roots have 0.
std::vector<int> depths(const Skeleton& skeleton) {
  std::vector<int> depth(at(skeleton.columns), 0);
  if (skeleton.source == Skeleton::Source::tgf) {
    const BoneTree tree = bone_tree(skeleton);
    const std::size_t points = depth.size() - skeleton.bones.size();
    for (const int e : tree.order) {
      const int parent = tree.parent[at(e)];
      if (parent >= 0) depth[points + at(e)] = depth[points + at(parent)] + 1;
    }
  } else {
    for (const int j : parents_first(skeleton.joints)) {
      const int parent = skeleton.joints[at(j)].parent;
      if (parent >= 0) depth[at(j)] = depth[at(parent)] + 1;
    }
  }
  return depth;
}

struct Frame {
  Vec3 thin = Vec3::UnitZ();  ///< along which the skeleton is least spread
  Vec3 broad = Vec3::UnitX();
  double size = 1;  ///< diagonal of the joints' box
};

/// Axes of the character's own box, so that turning the file's axes only renames them.
Frame frame_of(const Skeleton& skeleton) {
  Points X(static_cast<Eigen::Index>(skeleton.joints.size()), 3);
  for (std::size_t j = 0; j < skeleton.joints.size(); ++j) {
    X.row(static_cast<Eigen::Index>(j)) = skeleton.joints[j].position.transpose();
  }
  Frame frame;
  if (X.rows() < 2) return frame;
  const Eigen::RowVector3d extent = X.colwise().maxCoeff() - X.colwise().minCoeff();
  Eigen::Index thin = 2, broad = 0;
  for (Eigen::Index k = 2; k >= 0; --k) {
    if (extent[k] < extent[thin]) thin = k;
  }
  broad = thin == 0 ? 1 : 0;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (k != thin && extent[k] > extent[broad]) broad = k;
  }
  frame.thin = Vec3::Unit(thin);
  frame.broad = Vec3::Unit(broad);
  if (extent.norm() > 0) frame.size = extent.norm();
  return frame;
}

/// Perpendicular to the bone, near the thin axis: the bone then swings in the broad plane.
Vec3 axis_for(const Handle& handle, const Frame& frame) {
  Vec3 direction = Vec3::Zero();
  for (const auto& [a, b] : handle.segments) direction += b - a;
  if (!(direction.norm() > 0)) return frame.thin;
  direction.normalize();
  const Vec3 across = frame.thin - frame.thin.dot(direction) * direction;
  if (across.norm() > 0.3) return across.normalized();
  return (frame.broad - frame.broad.dot(direction) * direction).normalized();
}

}  // namespace

Pose demo_pose(const Skeleton& skeleton, double amplitude, std::uint64_t seed) {
  Pose pose = rest_pose(skeleton);
  if (skeleton.handles.empty()) return pose;
  const std::vector<int> depth = depths(skeleton);
  const Frame frame = frame_of(skeleton);
  const bool roots_only = std::all_of(skeleton.column.begin(), skeleton.column.end(),
                                      [&](int column) { return depth[at(column)] == 0; });
  for (std::size_t i = 0; i < skeleton.handles.size(); ++i) {
    const Handle& handle = skeleton.handles[i];
    const int column = skeleton.column[i];
    if (depth[at(column)] == 0 && !roots_only) continue;
    Random random(seed, static_cast<std::uint64_t>(column));
    const double size = amplitude * (0.7 + 0.3 * random.uniform());
    const int turn = roots_only ? column : depth[at(column)];
    const double angle = turn % 2 == 0 ? -size : size;
    Vec3 axis = axis_for(handle, frame);
    JointPose& joint = pose.joints[at(column)];
    if (handle.joint >= 0) {
      // From bind space into the joint's own frame.
      const Vec3 local =
          skeleton.joints[at(handle.joint)].inverse_bind.topLeftCorner<3, 3>() * axis;
      if (local.norm() > 0 && local.allFinite()) axis = local.normalized();
    } else if (handle.kind == Handle::Kind::point && roots_only) {
      joint.translation = 0.15 * angle * frame.size * frame.broad;
    }
    joint.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
  }
  return pose;
}

}  // namespace skinfield
