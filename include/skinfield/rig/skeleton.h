// Joints, skeletons, handles, and the rules that turn the one into the other.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <string>
#include <utility>
#include <vector>

namespace skinfield {

using Transform = Eigen::Matrix4d;  ///< column vectors: x' = T x

/// A child node of a joint that is no joint of the skin (`Head_end`, a hat): where a leaf may end.
struct JointTip {
  std::string name;
  Vec3 position = Vec3::Zero();  ///< in bind space: inverse_bind of its joint, inverted, times its
                                 ///< node translation
};

/// A glTF/Blender joint, or a TGF vertex.
struct Joint {
  std::string name;
  int parent = -1;               ///< index of the parent joint, -1 for roots
  Vec3 position = Vec3::Zero();  ///< in the character's bind space (from inverse bind matrices)
  Transform inverse_bind = Transform::Identity();  ///< bind space -> joint space
  Transform local_rest = Transform::Identity();    ///< node transform relative to the parent joint
  Transform world_rest = Transform::Identity();
  std::vector<JointTip> tips;  ///< child nodes outside the skin, in node order (glTF readers)
};

/// What a weight function belongs to.
struct Handle {
  enum class Kind { bone, point, region };
  Kind kind = Kind::bone;
  std::string name;
  int joint = -1;                               ///< skin joint it moves, -1 for TGF handles
  std::vector<std::pair<Vec3, Vec3>> segments;  ///< bone: at least one, none of zero length
  Vec3 point = Vec3::Zero();                    ///< point handles; a region's mean
  std::vector<int> vertices;                    ///< region handles: mesh vertices
};

/// One weight column = one handle. For glTF the columns are the skin's joints in skin order and
/// `handles` holds only the deforming ones; for TGF column i is handles[i].
struct Skeleton {
  enum class Source { none, tgf, gltf };
  Source source = Source::none;
  std::vector<Joint> joints;
  std::vector<std::pair<int, int>> bones;  ///< TGF edges, joint index pairs, in file order
  std::vector<Handle> handles;
  std::vector<int> column;  ///< column of handles[i]
  int columns = 0;
  std::vector<std::string> column_names;  ///< (columns)
  std::vector<int> left_out;              ///< joints that do not deform, for the report
};

}  // namespace skinfield
