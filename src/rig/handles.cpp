#include "skinfield/rig/handles.h"

#include "skinfield/base/error.h"
#include "skinfield/rig/bone_tree.h"
#include "skinfield/rig/glob.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace skinfield {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void check_joints(const Skeleton& skeleton) {
  if (skeleton.joints.empty()) throw InputError("there is no joint", "skeleton");
  for (std::size_t j = 0; j < skeleton.joints.size(); ++j) {
    if (!skeleton.joints[j].position.allFinite()) {
      throw InputError("joint " + std::to_string(j + 1) + " '" + skeleton.joints[j].name +
                           "' has a position that is not finite",
                       "skeleton");
    }
  }
}

/// Zero as far as positions computed from single-precision matrices can tell.
double zero_length(const Skeleton& skeleton) {
  double size = 0;
  for (const Joint& joint : skeleton.joints) {
    size = std::max(size, (joint.position - skeleton.joints[0].position).norm());
  }
  return 1e-6 * size;
}

/// Names must tell columns apart: empty and repeated ones get a number.
std::vector<std::string> distinct(std::vector<std::string> names, const std::string& empty) {
  std::set<std::string> taken(names.begin(), names.end());
  std::set<std::string> seen;
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (names[j].empty()) names[j] = empty + std::to_string(j);
    const std::string base = names[j];
    for (int k = 2; !seen.insert(names[j]).second; ++k) {
      do {
        names[j] = base + "#" + std::to_string(k++);
      } while (taken.count(names[j]) > 0);
    }
  }
  return names;
}

class JointRules {
 public:
  JointRules(const Skeleton& skeleton, const JointOptions& options, const std::vector<bool>& used,
             const InsideTest& inside)
      : joints_(skeleton.joints),
        options_(options),
        inside_(inside),
        zero_(zero_length(skeleton)),
        children_(joints_.size()) {
    const int count = static_cast<int>(joints_.size());
    for (int j = 0; j < count; ++j) {
      const int parent = joints_[at(j)].parent;
      if (parent >= count || parent == j) {
        throw InputError("joint '" + joints_[at(j)].name + "' has a parent that does not exist",
                         "skeleton");
      }
      if (parent >= 0) children_[at(parent)].push_back(j);
    }
    for (int j = 0; j < count; ++j) check_ancestry(j);
    choose(used);
  }

  bool deforms(int j) const { return deforms_[at(j)]; }

  Handle handle(int j) const {
    Handle handle;
    handle.joint = j;
    handle.name = joints_[at(j)].name;
    handle.point = position(j);
    bool leaf = true;
    for (const int child : children_[at(j)]) collect(j, child, handle, leaf);
    if (leaf && options_.leaf == JointOptions::Leaf::extend) {
      if (const auto tail = leaf_tail(j)) handle.segments.emplace_back(position(j), *tail);
    }
    handle.kind = handle.segments.empty() ? Handle::Kind::point : Handle::Kind::bone;
    return handle;
  }

 private:
  const Vec3& position(int j) const { return joints_[at(j)].position; }

  void check_ancestry(int j) const {
    std::size_t steps = 0;
    for (int a = j; a >= 0; a = joints_[at(a)].parent) {
      if (++steps > joints_.size()) {
        throw InputError("joint '" + joints_[at(j)].name + "' is its own ancestor", "skeleton");
      }
    }
  }

  void choose(const std::vector<bool>& used) {
    using Which = JointOptions::Which;
    const std::size_t count = joints_.size();
    if (!used.empty() && used.size() != count) {
      throw InputError("one flag a joint is needed", "used joints");
    }
    const bool weighted = std::find(used.begin(), used.end(), true) != used.end();
    if (options_.which == Which::used && !weighted) {
      throw InputError("no weights say which joints are used", "skeleton",
                       "choose joints by name, or all");
    }
    deforms_.assign(count, true);
    for (std::size_t j = 0; j < count; ++j) {
      const Joint& joint = joints_[j];
      if (options_.which == Which::match) {
        deforms_[j] = glob_match_any(options_.patterns, joint.name);
      } else if (options_.which != Which::all && weighted) {
        deforms_[j] = used[j];
      } else if (options_.which == Which::automatic) {
        const bool stray_root = joint.parent < 0 && inside_ && !inside_(joint.position);
        deforms_[j] = !stray_root && !is_helper_name(joint.name);
      }
    }
    // A character whose every joint looks like a helper still has to be bound to something.
    const auto some = [&] {
      return std::find(deforms_.begin(), deforms_.end(), true) != deforms_.end();
    };
    if (options_.which == Which::automatic && !some()) deforms_.assign(count, true);
    for (std::size_t j = 0; j < count; ++j) {
      if (glob_match_any(options_.exclude, joints_[j].name)) deforms_[j] = false;
    }
    if (!some()) {
      throw InputError("no joint is left to deform the mesh", "skeleton",
                       "choose other joints or exclude fewer");
    }
  }

  /// Segments from j to the next deforming joints below `child`, itself included.
  void collect(int j, int child, Handle& handle, bool& leaf) const {
    if (!deforms(child)) {
      for (const int below : children_[at(child)]) collect(j, below, handle, leaf);
      return;
    }
    leaf = false;
    if ((position(child) - position(j)).norm() > zero_) {
      handle.segments.emplace_back(position(j), position(child));
    }
  }

  std::optional<Vec3> leaf_tail(int j) const {
    const Vec3& head = position(j);
    for (const int child : children_[at(j)]) {
      if (is_tip_name(joints_[at(child)].name) && (position(child) - head).norm() > zero_) {
        return position(child);
      }
    }
    for (const JointTip& tip : joints_[at(j)].tips) {
      if (is_tip_name(tip.name) && tip.position.allFinite() &&
          (tip.position - head).norm() > zero_) {
        return tip.position;
      }
    }
    for (int above = joints_[at(j)].parent; above >= 0; above = joints_[at(above)].parent) {
      const Vec3 bone = head - position(above);
      if (deforms(above) && bone.norm() > zero_) return cut(head, head + 0.5 * bone);
    }
    return std::nullopt;
  }

  /// The part of a-b up to where it first leaves the shape; all of it where a is outside already.
  std::optional<Vec3> cut(const Vec3& a, const Vec3& b) const {
    if (!inside_ || !inside_(a)) return b;
    Handle whole;
    whole.segments.emplace_back(a, b);
    const HandleInside part = inside_part(whole, inside_);
    if (part.segments.empty() || (part.segments[0].second - a).norm() <= 1e-3 * (b - a).norm()) {
      return std::nullopt;
    }
    return part.segments[0].second;
  }

  const std::vector<Joint>& joints_;
  const JointOptions& options_;
  const InsideTest& inside_;
  double zero_;
  std::vector<std::vector<int>> children_;
  std::vector<bool> deforms_;
};

}  // namespace

void make_tgf_handles(Skeleton& skeleton) {
  check_joints(skeleton);
  const BoneTree tree = bone_tree(skeleton);
  std::vector<bool> on_bone(skeleton.joints.size(), false);
  for (Joint& joint : skeleton.joints) joint.parent = -1;
  for (const int e : tree.order) {
    const int head = tree.head[at(e)], tail = tree.tail[at(e)];
    on_bone[at(head)] = true;
    // The tail of a bone that closes a cycle has been met before.
    if (!on_bone[at(tail)]) skeleton.joints[at(tail)].parent = head;
    on_bone[at(tail)] = true;
  }

  std::vector<Handle> handles;
  for (std::size_t j = 0; j < skeleton.joints.size(); ++j) {
    if (on_bone[j]) continue;
    Handle handle;
    handle.kind = Handle::Kind::point;
    handle.name = skeleton.joints[j].name;
    handle.point = skeleton.joints[j].position;
    handles.push_back(std::move(handle));
  }
  const double zero = zero_length(skeleton);
  for (const auto& [a, b] : skeleton.bones) {
    const Joint& head = skeleton.joints[at(a)];
    const Joint& tail = skeleton.joints[at(b)];
    Handle handle;
    handle.point = head.position;
    if (!head.name.empty() && !tail.name.empty()) handle.name = head.name + "-" + tail.name;
    if ((tail.position - head.position).norm() > zero) {
      handle.segments.emplace_back(head.position, tail.position);
    } else {
      handle.kind = Handle::Kind::point;
    }
    handles.push_back(std::move(handle));
  }

  skeleton.source = Skeleton::Source::tgf;
  skeleton.handles = std::move(handles);
  skeleton.columns = static_cast<int>(skeleton.handles.size());
  skeleton.left_out.clear();
  skeleton.column.clear();
  std::vector<std::string> names;
  for (int i = 0; i < skeleton.columns; ++i) {
    skeleton.column.push_back(i);
    names.push_back(skeleton.handles[at(i)].name);
  }
  skeleton.column_names = distinct(std::move(names), "handle_");
  for (int i = 0; i < skeleton.columns; ++i) {
    skeleton.handles[at(i)].name = skeleton.column_names[at(i)];
  }
}

void make_joint_handles(Skeleton& skeleton, const JointOptions& options,
                        const std::vector<bool>& used, const InsideTest& inside) {
  check_joints(skeleton);
  const JointRules rules(skeleton, options, used, inside);
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints) names.push_back(joint.name);
  skeleton.column_names = distinct(std::move(names), "joint_");
  skeleton.source = Skeleton::Source::gltf;
  skeleton.columns = static_cast<int>(skeleton.joints.size());
  skeleton.handles.clear();
  skeleton.column.clear();
  skeleton.left_out.clear();
  for (int j = 0; j < skeleton.columns; ++j) {
    if (!rules.deforms(j)) {
      skeleton.left_out.push_back(j);
      continue;
    }
    Handle handle = rules.handle(j);
    handle.name = skeleton.column_names[at(j)];
    skeleton.handles.push_back(std::move(handle));
    skeleton.column.push_back(j);
  }
}

}  // namespace skinfield
