#include "skinfield/base/random.h"
#include "skinfield/rig/bone_tree.h"
#include "skinfield/rig/pose.h"

#include <algorithm>

namespace skinfield {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Where a column hangs: the depth below its root (points and roots have 0), and the share of all
/// handles that moves when it turns.
struct Place {
  int depth = 0;
  double carried = 0;
};

std::vector<Place> places(const Skeleton& skeleton) {
  const std::size_t columns = at(skeleton.columns);
  std::vector<int> parent(columns, -1), order;
  if (skeleton.source != Skeleton::Source::gltf) {
    const BoneTree tree = bone_tree(skeleton);
    const int points = first_bone_column(skeleton);
    for (const int e : tree.order) {
      order.push_back(points + e);
      if (tree.parent[at(e)] >= 0) parent[at(points + e)] = points + tree.parent[at(e)];
    }
  } else {
    order = parents_first(skeleton.joints);
    for (const int j : order) parent[at(j)] = skeleton.joints[at(j)].parent;
  }
  std::vector<Place> result(columns);
  for (const int column : order) {
    if (parent[at(column)] >= 0)
      result[at(column)].depth = result[at(parent[at(column)])].depth + 1;
  }
  const double share = 1.0 / static_cast<double>(skeleton.handles.size());
  for (const int column : skeleton.column) result[at(column)].carried += share;
  std::for_each(order.rbegin(), order.rend(), [&](int column) {
    const int above = parent[at(column)];
    if (above >= 0) result[at(above)].carried += result[at(column)].carried;
  });
  return result;
}

struct Frame {
  Vec3 thin = Vec3::UnitZ();  ///< along which the skeleton is least spread
  Vec3 broad = Vec3::UnitX();
  double size = 1;  ///< diagonal of the joints' box
};

/// Axes of the character's own box, so that turning the file's axes only renames them.
Frame frame_of(const Skeleton& skeleton) {
  const bool jointless = skeleton.joints.empty();  // regions alone
  const std::size_t count = jointless ? skeleton.handles.size() : skeleton.joints.size();
  Points X(static_cast<Eigen::Index>(count), 3);
  for (std::size_t j = 0; j < count; ++j) {
    X.row(static_cast<Eigen::Index>(j)) =
        (jointless ? skeleton.handles[j].point : skeleton.joints[j].position).transpose();
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
  const std::vector<Place> place = places(skeleton);
  const Frame frame = frame_of(skeleton);
  const bool roots_only = std::all_of(skeleton.column.begin(), skeleton.column.end(),
                                      [&](int column) { return place[at(column)].depth == 0; });
  for (std::size_t i = 0; i < skeleton.handles.size(); ++i) {
    const Handle& handle = skeleton.handles[i];
    const int column = skeleton.column[i];
    if (place[at(column)].depth == 0 && !roots_only) continue;
    Random random(seed, static_cast<std::uint64_t>(column));
    // Limbs swing, trunks only lean.
    const double share = std::min(1.0, 1.2 - place[at(column)].carried);
    const double size = amplitude * share * (0.7 + 0.3 * random.uniform());
    const int turn = roots_only ? column : place[at(column)].depth;
    const double angle = turn % 2 == 0 ? -size : size;
    Vec3 axis = axis_for(handle, frame);
    JointPose& joint = pose.joints[at(column)];
    if (handle.joint >= 0) {
      // From bind space into the joint's own frame.
      const Vec3 local =
          skeleton.joints[at(handle.joint)].inverse_bind.topLeftCorner<3, 3>() * axis;
      if (local.norm() > 0 && local.allFinite()) axis = local.normalized();
    } else if (handle.kind != Handle::Kind::bone && roots_only) {
      joint.translation = 0.15 * angle * frame.size * frame.broad;
    }
    joint.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
  }
  return pose;
}

}  // namespace skinfield
