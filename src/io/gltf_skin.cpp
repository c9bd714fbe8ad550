// Skins: joints where the inverse bind matrices put them.
#include "io/gltf_document.h"

#include <Eigen/Dense>

#include <algorithm>

namespace skinfield::gltf {

Skin read_skin(const GltfDocument& document, int skin) {
  const std::string who = "skin " + std::to_string(skin);
  const Json& json = document.item("skins", skin, who);
  Skin out;
  out.name = document.text(json, "name");
  out.joints = document.indices(json, "joints", "nodes", who + ": joints");
  if (out.joints.empty()) document.fail(who + " has no joints", "export it again");
  std::vector<int> sorted = out.joints;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    document.fail(who + " names node " + std::to_string(*twice) + " twice", "export it again");
  }
  out.inverse_bind.assign(out.joints.size(), Transform::Identity());
  const int accessor = document.index(json, "inverseBindMatrices", "accessors", who);
  if (accessor >= 0) {
    const AccessorValues values =
        read_accessor(document, accessor, {"MAT4"}, who + ": inverseBindMatrices");
    if (values.count < out.joints.size()) {
      document.fail(who + " has fewer inverse bind matrices than joints", "export it again");
    }
    for (std::size_t j = 0; j < out.joints.size(); ++j) {
      Transform& T = out.inverse_bind[j];
      T = Eigen::Map<const Transform>(values.values.data() + 16 * j);
      if (!T.allFinite()) {
        document.fail(
            who + ": the inverse bind matrix of joint " + std::to_string(j) + " is not finite",
            "export it again");
      }
      T.row(3) << 0, 0, 0, 1;
    }
  }
  out.useful_binds = std::any_of(out.inverse_bind.begin(), out.inverse_bind.end(),
                                 [](const Transform& T) { return !T.isIdentity(1e-12); });
  return out;
}

namespace {

/// What the inverse bind matrix undoes. A singular one (a joint scaled to nothing) still has an
/// origin: the point of least norm that it takes there.
Transform bind_transform(const Transform& inverse_bind) {
  const Eigen::Matrix3d L = inverse_bind.topLeftCorner<3, 3>();
  const Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix3d> solver(L);
  Transform T = Transform::Identity();
  T.topLeftCorner<3, 3>() = solver.pseudoInverse();
  T.topRightCorner<3, 1>() = -solver.solve(Vec3(inverse_bind.topRightCorner<3, 1>()));
  return T;
}

}  // namespace

Skeleton make_skeleton(const GltfDocument& document, const Skin& skin) {
  Skeleton skeleton;
  skeleton.source = Skeleton::Source::gltf;
  const std::vector<Transform> world = document.world_transforms();
  std::vector<int> slot(document.nodes.size(), -1);
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    slot[static_cast<std::size_t>(skin.joints[j])] = static_cast<int>(j);
  }
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    const auto index = static_cast<std::size_t>(skin.joints[j]);
    const Node& node = document.nodes[index];
    Joint joint;
    joint.name = document.text(document.json["nodes"][index], "name");
    if (joint.name.empty()) joint.name = "joint_" + std::to_string(j);
    joint.inverse_bind = skin.inverse_bind[j];
    joint.world_rest = world[index];
    joint.local_rest = local_transform(node);
    int ancestor = node.parent;
    while (ancestor >= 0 && slot[static_cast<std::size_t>(ancestor)] < 0) {
      const Node& between = document.nodes[static_cast<std::size_t>(ancestor)];
      joint.local_rest = local_transform(between) * joint.local_rest;
      ancestor = between.parent;
    }
    joint.parent = ancestor < 0 ? -1 : slot[static_cast<std::size_t>(ancestor)];
    // Identity matrices everywhere place nothing: such files mean the nodes' own rest pose.
    const Transform bind = skin.useful_binds ? bind_transform(joint.inverse_bind) : world[index];
    joint.position = bind.topRightCorner<3, 1>();
    for (const int child : node.children) {
      if (slot[static_cast<std::size_t>(child)] >= 0) continue;
      const Transform local = local_transform(document.nodes[static_cast<std::size_t>(child)]);
      joint.tips.push_back(
          {document.text(document.json["nodes"][static_cast<std::size_t>(child)], "name"),
           (bind * local).topRightCorner<3, 1>()});
    }
    skeleton.column_names.push_back(joint.name);
    skeleton.joints.push_back(std::move(joint));
  }
  skeleton.columns = static_cast<int>(skeleton.joints.size());
  return skeleton;
}

}  // namespace skinfield::gltf
