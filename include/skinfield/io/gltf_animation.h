// A glTF file's own animations, played: joint and skinning matrices at a time.
#pragma once

#include "skinfield/io/asset.h"

#include <string>
#include <vector>

namespace skinfield {

/// One node's property over time.
struct GltfChannel {
  enum class Path { translation, rotation, scale };
  enum class Interpolation { linear, step, cubic_spline };
  int node = -1;
  Path path = Path::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;  ///< (k) seconds, ascending
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> values;
  ///< (k,4), cubic splines (3k,4) as in-tangent, value, out-tangent; quaternions xyzw, else xyz0
};

struct GltfAnimation {
  std::string name;
  double begin = 0, end = 0;  ///< seconds: first and last key of all its channels
  std::vector<GltfChannel> channels;
};

/// All animations of the source document, in file order; none for other formats. Channels of morph
/// weights and of extensions are left out. Throws InputError for damaged ones.
std::vector<GltfAnimation> gltf_animations(const Asset& asset);

/// World transforms of a character's joints, in column order, at `time` seconds (clamped to each
/// channel's keys); without an animation at rest. Rotations: spherical linear, step, or Hermite
/// splines (glTF 2.0, appendix C). Empty for a character without glTF joints.
/// Precondition: 0 <= character < asset.characters.size().
std::vector<Transform> joint_world_transforms(const Asset& asset, int character,
                                              const GltfAnimation* animation = nullptr,
                                              double time = 0);

/// World transform times inverse bind matrix: what moves a bind-space vertex. One a column.
std::vector<Transform> joint_skinning_transforms(const Asset& asset, int character,
                                                 const GltfAnimation* animation = nullptr,
                                                 double time = 0);

}  // namespace skinfield
