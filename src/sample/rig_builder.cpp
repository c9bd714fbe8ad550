#include "sample/rig_builder.h"

#include "skinfield/base/error.h"

#include <numbers>

namespace skinfield::sample_detail {

void RigBuilder::joint(const std::string& name, const std::string& parent, const Vec3& position) {
  Joint joint;
  joint.name = name;
  joint.parent = parent.empty() ? -1 : index_.at(parent);
  joint.position = position;
  joint.world_rest.topRightCorner<3, 1>() = position;
  joint.inverse_bind.topRightCorner<3, 1>() = -position;
  Vec3 local = position;
  if (joint.parent >= 0) {
    local -= skeleton_.joints[static_cast<std::size_t>(joint.parent)].position;
  }
  joint.local_rest.topRightCorner<3, 1>() = local;
  index_[name] = static_cast<int>(skeleton_.joints.size());
  skeleton_.joints.push_back(joint);
}

void RigBuilder::tail(const std::string& joint, const Vec3& position) {
  Joint& owner = skeleton_.joints[static_cast<std::size_t>(index_.at(joint))];
  owner.tips.push_back({joint + "_end", position});
}

Skeleton RigBuilder::finish() const {
  Skeleton skeleton = skeleton_;
  skeleton.source = Skeleton::Source::gltf;
  skeleton.columns = static_cast<int>(skeleton.joints.size());
  for (std::size_t j = 0; j < skeleton.joints.size(); ++j) {
    const Joint& joint = skeleton.joints[j];
    Handle handle;
    handle.name = joint.name;
    handle.joint = static_cast<int>(j);
    for (const Joint& child : skeleton.joints) {
      if (child.parent == handle.joint) {
        handle.segments.emplace_back(joint.position, child.position);
      }
    }
    if (handle.segments.empty()) {
      for (const JointTip& tip : joint.tips) {
        handle.segments.emplace_back(joint.position, tip.position);
      }
    }
    skeleton.handles.push_back(handle);
    skeleton.column.push_back(handle.joint);
    skeleton.column_names.push_back(joint.name);
  }
  return skeleton;
}

PoseBuilder::PoseBuilder(const Skeleton& skeleton) {
  for (std::size_t j = 0; j < skeleton.joints.size(); ++j) index_[skeleton.joints[j].name] = j;
  pose_.rotation.assign(skeleton.joints.size(), Eigen::Quaterniond::Identity());
}

PoseBuilder& PoseBuilder::turn(const std::string& joint, const Vec3& axis, double degrees) {
  const auto found = index_.find(joint);
  if (found == index_.end()) throw InputError("the sample has no joint named " + joint, "sample");
  Eigen::Quaterniond& rotation = pose_.rotation[found->second];
  const Eigen::Quaterniond by(
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
  rotation = (by * rotation).normalized();
  return *this;
}

PoseBuilder& PoseBuilder::move_root(const Vec3& by) {
  pose_.root_movement += by;
  return *this;
}

}  // namespace skinfield::sample_detail
