#include "skinfield/rig/bone_tree.h"

#include "skinfield/base/error.h"

#include <algorithm>
#include <deque>
#include <string>

namespace skinfield {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The file's orientation; false if it is no forest.
bool as_in_file(const Skeleton& skeleton, BoneTree& tree) {
  const std::size_t bones = skeleton.bones.size();
  std::vector<int> incoming(skeleton.joints.size(), -1);
  for (std::size_t e = 0; e < bones; ++e) {
    const auto [head, tail] = skeleton.bones[e];
    if (head == tail) continue;
    if (incoming[at(tail)] >= 0) return false;
    incoming[at(tail)] = static_cast<int>(e);
  }
  tree = {};
  std::vector<std::vector<int>> children(bones);
  std::deque<int> ready;
  for (std::size_t e = 0; e < bones; ++e) {
    tree.head.push_back(skeleton.bones[e].first);
    tree.tail.push_back(skeleton.bones[e].second);
    const int parent = incoming[at(tree.head[e])];
    tree.parent.push_back(parent);
    if (parent >= 0) {
      children[at(parent)].push_back(static_cast<int>(e));
    } else {
      ready.push_back(static_cast<int>(e));
    }
  }
  while (!ready.empty()) {
    const int e = ready.front();
    ready.pop_front();
    tree.order.push_back(e);
    ready.insert(ready.end(), children[at(e)].begin(), children[at(e)].end());
  }
  return tree.order.size() == bones;  // bones of a cycle are never ready
}

BoneTree from_first_joints(const Skeleton& skeleton) {
  const std::size_t joints = skeleton.joints.size(), bones = skeleton.bones.size();
  std::vector<std::vector<int>> touching(joints);
  for (std::size_t e = 0; e < bones; ++e) {
    const auto [a, b] = skeleton.bones[e];
    touching[at(a)].push_back(static_cast<int>(e));
    if (b != a) touching[at(b)].push_back(static_cast<int>(e));
  }
  BoneTree tree;
  tree.head.assign(bones, -1);
  tree.tail.assign(bones, -1);
  tree.parent.assign(bones, -1);
  std::vector<bool> reached(joints, false);
  std::vector<int> incoming(joints, -1);
  for (std::size_t root = 0; root < joints; ++root) {
    if (reached[root]) continue;
    reached[root] = true;
    std::deque<int> ready{static_cast<int>(root)};
    while (!ready.empty()) {
      const int head = ready.front();
      ready.pop_front();
      for (const int e : touching[at(head)]) {
        if (tree.head[at(e)] >= 0) continue;
        const auto [a, b] = skeleton.bones[at(e)];
        const int tail = a == head ? b : a;
        tree.head[at(e)] = head;
        tree.tail[at(e)] = tail;
        tree.parent[at(e)] = incoming[at(head)];
        tree.order.push_back(e);
        if (reached[at(tail)]) continue;
        reached[at(tail)] = true;
        incoming[at(tail)] = e;
        ready.push_back(tail);
      }
    }
  }
  return tree;
}

}  // namespace

BoneTree bone_tree(const Skeleton& skeleton) {
  const int joints = static_cast<int>(skeleton.joints.size());
  for (std::size_t e = 0; e < skeleton.bones.size(); ++e) {
    const auto [a, b] = skeleton.bones[e];
    if (a < 0 || b < 0 || a >= joints || b >= joints) {
      throw InputError("bone " + std::to_string(e + 1) + " names a joint that does not exist",
                       "skeleton");
    }
  }
  BoneTree tree;
  return as_in_file(skeleton, tree) ? tree : from_first_joints(skeleton);
}

int first_bone_column(const Skeleton& skeleton) {
  const auto regions =
      std::count_if(skeleton.handles.begin(), skeleton.handles.end(),
                    [](const Handle& handle) { return handle.kind == Handle::Kind::region; });
  return skeleton.columns - static_cast<int>(regions) - static_cast<int>(skeleton.bones.size());
}

}  // namespace skinfield
