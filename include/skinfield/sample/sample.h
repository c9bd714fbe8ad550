// Three characters made by code, so that there is always something to bind: `gecko` (one clean,
// closed surface with thin toes), `robot` (overlapping and floating closed parts) and `scan` (the
// gecko as a jittered triangle soup with a third of its faces missing).
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/io/asset.h"
#include "skinfield/rig/pose.h"
#include "skinfield/rig/skeleton.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

struct SampleOptions {
  int resolution = 0;      ///< about so many triangles, 500 to 2 million; 0: 16,000. The
                           ///< gecko's toes need 8,000, so that it never has fewer
  std::uint64_t seed = 0;  ///< which faces the scan lost and how the rest trembles
  Progress progress;
};

/// A named run of faces; every part of the robot is a closed surface by itself.
struct SamplePart {
  std::string name;
  int face_begin = 0, face_end = 0;
  Vec3 colour = Vec3::Ones();  ///< linear RGB
};

/// A rotation per joint relative to the rest pose, in the joint's own axes, and a movement of the
/// root joint. The joints' rest rotations are all the identity.
struct SamplePose {
  std::vector<Eigen::Quaterniond> rotation;  ///< (joints)
  Vec3 root_movement = Vec3::Zero();
};

/// A loop: the last key equals the first.
struct SampleAnimation {
  std::string name;
  std::vector<double> time;     ///< seconds, ascending from 0
  std::vector<SamplePose> key;  ///< as many
};

struct SampleCharacter {
  std::string name;
  Mesh mesh;
  Points colours;                 ///< (n,3) linear RGB of the vertices
  std::vector<SamplePart> parts;  ///< they cover all faces in order
  /// Joints without `_end` nodes, which are the leaf joints' tails; one bone handle a joint (to
  /// every child, leaves to their tail), column i = joint i.
  Skeleton skeleton;
  SamplePose demo_pose;
  SampleAnimation animation;
};

/// "gecko", "robot", "scan".
std::span<const std::string_view> sample_names();

/// Metres, y up, looking along +z. Same bytes at any thread count. Throws InputError for an
/// unknown name or a resolution out of range.
SampleCharacter make_sample(std::string_view name, const SampleOptions& options = {});

/// Per column, bind pose -> posed: world * inverse bind. Throws InputError if sizes disagree.
std::vector<Transform> sample_transforms(const Skeleton& skeleton, const SamplePose& pose);

/// The same pose in rig's words.
Pose to_pose(const SamplePose& pose);

/// A binary glTF 2.0 file: mesh, joint nodes with `_end` nodes, skin, animation. glTF does not
/// allow a skinned mesh without weights, so every vertex follows the nearest bone rigidly: a
/// placeholder that names every joint as deforming and waits to be replaced by `bind`.
std::vector<std::uint8_t> sample_glb(const SampleCharacter& character);

/// What reading sample_glb() gives: the document is the one in memory, handles are not made yet.
Asset sample_asset(const SampleCharacter& character);

/// Writes sample_glb() beside the target and renames. Throws IoError where that fails.
void write_sample(const std::filesystem::path& path, const SampleCharacter& character);

/// The placeholder: for every vertex the handle whose segments are nearest; every handle gets at
/// least one vertex (n >= handles).
std::vector<int> nearest_handle(const Points& V, const Skeleton& skeleton);

}  // namespace skinfield
