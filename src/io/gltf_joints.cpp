// Skeletons that a document does not have yet, as glTF nodes and skins.
#include "io/bytes.h"
#include "io/gltf_writing.h"

#include <Eigen/Dense>

#include <algorithm>

namespace skinfield::gltf {
namespace {

Transform translation(const Vec3& at) {
  Transform T = Transform::Identity();
  T.topRightCorner<3, 1>() = at;
  return T;
}

/// A joint's place and turn, without the scales that rigs carry: the new skin needs none.
Transform rigid_bind(const Joint& joint) {
  Transform T = translation(joint.position);
  const Eigen::Matrix3d L = joint.inverse_bind.topLeftCorner<3, 3>();
  if (!(std::abs(L.determinant()) > 0)) return T;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(L, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0) R = -R;
  T.topLeftCorner<3, 3>() = R.transpose();
  return T;
}

/// Cuts parents that lead back to their child; the skeleton is then a forest.
void break_cycles(std::vector<NewJoint>& joints) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    int at = joints[j].parent;
    std::size_t steps = 0;
    while (at >= 0 && static_cast<std::size_t>(at) != j && steps++ <= joints.size()) {
      at = joints[static_cast<std::size_t>(at)].parent;
    }
    if (at >= 0) joints[j].parent = -1;
  }
}

JointTree tree_of_bones(const Skeleton& skeleton, int columns) {
  JointTree out;
  const std::size_t n = skeleton.joints.size();
  std::vector<int> ends_here(n, -1);  // first bone whose tail this vertex is
  std::vector<char> starts_here(n, 0), on_bone(n, 0);
  for (std::size_t b = 0; b < skeleton.bones.size(); ++b) {
    const auto head = static_cast<std::size_t>(skeleton.bones[b].first);
    const auto tail = static_cast<std::size_t>(skeleton.bones[b].second);
    on_bone[head] = on_bone[tail] = starts_here[head] = 1;
    if (ends_here[tail] < 0) ends_here[tail] = static_cast<int>(b);
  }
  // Columns: points in file order, then bones in file order; joints in the same order.
  const auto name_of = [&skeleton](std::size_t column, const std::string& otherwise) {
    return column < skeleton.column_names.size() ? skeleton.column_names[column] : otherwise;
  };
  for (std::size_t v = 0; v < n; ++v) {
    if (on_bone[v]) continue;
    const std::string name = name_of(out.joints.size(), "point_" + skeleton.joints[v].name);
    out.joints.push_back({name, -1, translation(skeleton.joints[v].position)});
  }
  const int points = static_cast<int>(out.joints.size());
  for (std::size_t b = 0; b < skeleton.bones.size(); ++b) {
    const auto head = static_cast<std::size_t>(skeleton.bones[b].first);
    const int parent = ends_here[head] < 0 ? -1 : points + ends_here[head];
    const std::string name = name_of(out.joints.size(), "bone_" + std::to_string(b));
    out.joints.push_back({name, parent, translation(skeleton.joints[head].position)});
  }
  for (const Handle& handle : skeleton.handles) {
    if (handle.kind != Handle::Kind::region) continue;
    out.joints.push_back({name_of(out.joints.size(), handle.name), -1, translation(handle.point)});
  }
  if (static_cast<int>(out.joints.size()) != columns) {
    throw InputError("the weights have " + std::to_string(columns) + " columns, the skeleton " +
                     std::to_string(out.joints.size()) + " bones, points and regions");
  }
  for (int c = 0; c < columns; ++c) out.joint_of_column.push_back(c);
  break_cycles(out.joints);
  for (std::size_t b = 0; b < skeleton.bones.size(); ++b) {
    const auto tail = static_cast<std::size_t>(skeleton.bones[b].second);
    if (starts_here[tail]) continue;
    const int bone = points + static_cast<int>(b);
    out.joints.push_back({out.joints[static_cast<std::size_t>(bone)].name + "_end", bone,
                          translation(skeleton.joints[tail].position)});
  }
  return out;
}

JointTree tree_of_handles(const Skeleton& skeleton, int columns) {
  JointTree out;
  for (int c = 0; c < columns; ++c) {
    const auto k = static_cast<std::size_t>(c);
    NewJoint joint;
    joint.name =
        k < skeleton.column_names.size() ? skeleton.column_names[k] : "handle_" + std::to_string(c);
    for (std::size_t h = 0; h < skeleton.handles.size(); ++h) {
      const int column = h < skeleton.column.size() ? skeleton.column[h] : static_cast<int>(h);
      if (column != c) continue;
      const Handle& handle = skeleton.handles[h];
      Vec3 at = handle.point;
      if (handle.kind == Handle::Kind::bone && !handle.segments.empty()) {
        at = handle.segments.front().first;
      }
      joint.bind = translation(at);
    }
    out.joints.push_back(std::move(joint));
    out.joint_of_column.push_back(c);
  }
  return out;
}

std::string float_bytes(const Transform& T) {
  std::string bytes;
  for (Eigen::Index i = 0; i < 16; ++i) put_little(bytes, static_cast<float>(T.data()[i]));
  return bytes;
}

}  // namespace

JointTree make_joint_tree(const Skeleton& skeleton, int columns) {
  if (skeleton.source == Skeleton::Source::tgf) return tree_of_bones(skeleton, columns);
  if (skeleton.source == Skeleton::Source::none || skeleton.joints.empty()) {
    return tree_of_handles(skeleton, columns);
  }
  if (static_cast<int>(skeleton.joints.size()) != columns) {
    throw InputError("the weights have " + std::to_string(columns) + " columns, the skeleton " +
                     std::to_string(skeleton.joints.size()) + " joints");
  }
  JointTree out;
  for (int j = 0; j < columns; ++j) {
    const Joint& joint = skeleton.joints[static_cast<std::size_t>(j)];
    out.joints.push_back({joint.name, joint.parent, rigid_bind(joint)});
    out.joint_of_column.push_back(j);
  }
  break_cycles(out.joints);
  return out;
}

PlacedTree place_tree(Extension& out, JointTree tree) {
  PlacedTree placed;
  const int first = out.append_node({{"name", "Skeleton"}}) + 1;
  placed.root = first - 1;
  std::vector<Json> children(tree.joints.size());
  Json roots = Json::array();
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    const int parent = tree.joints[j].parent;
    Json& list = parent < 0 ? roots : children[static_cast<std::size_t>(parent)];
    list.push_back(first + static_cast<int>(j));
  }
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    const NewJoint& joint = tree.joints[j];
    Transform local = joint.bind;
    if (joint.parent >= 0) {
      local = tree.joints[static_cast<std::size_t>(joint.parent)].bind.inverse() * joint.bind;
    }
    Json node = {{"name", joint.name}};
    const Vec3 t = local.topRightCorner<3, 1>();
    if (!t.isZero(0)) node["translation"] = {t.x(), t.y(), t.z()};
    const Eigen::Quaterniond q(Eigen::Matrix3d(local.topLeftCorner<3, 3>()));
    if (q.vec().norm() > 1e-12) node["rotation"] = {q.x(), q.y(), q.z(), q.w()};
    if (!children[j].empty()) node["children"] = std::move(children[j]);
    placed.nodes.push_back(out.append_node(std::move(node)));
  }
  out.json["nodes"][static_cast<std::size_t>(placed.root)]["children"] = std::move(roots);
  placed.tree = std::move(tree);
  return placed;
}

int append_skin(Extension& out, const PlacedTree& placed, const Transform& to_character,
                const std::string& name) {
  std::string bytes;
  for (const NewJoint& joint : placed.tree.joints) {
    Transform T = joint.bind.inverse() * to_character;
    T.row(3) << 0, 0, 0, 1;
    bytes += float_bytes(T);
  }
  const int accessor = out.put(
      bytes, {{"componentType", 5126}, {"count", placed.tree.joints.size()}, {"type", "MAT4"}}, 0);
  Json skin = {
      {"inverseBindMatrices", accessor}, {"skeleton", placed.root}, {"joints", placed.nodes}};
  if (!name.empty()) skin["name"] = name;
  if (!out.json.contains("skins")) out.json["skins"] = Json::array();
  out.json["skins"].push_back(std::move(skin));
  return static_cast<int>(out.json["skins"].size()) - 1;
}

}  // namespace skinfield::gltf
