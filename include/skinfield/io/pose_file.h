// Poses in files: rotations and translations a handle, one frame or many.
#pragma once

#include "skinfield/rig/pose.h"

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

/// One handle's motion relative to the rest pose, in the frame that rig's `Pose` says.
struct PoseEntry {
  std::string name;  ///< joint or handle name; empty where `index` is given
  int index = -1;    ///< handle index, 0-based
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit length
  Vec3 translation = Vec3::Zero();
};

struct PoseFile {
  std::vector<std::vector<PoseEntry>> frames;  ///< at least one
  bool quaternions = false;  ///< libigl's: entries count bones (or columns) and only rotate
};

/// One frame for a skeleton, in rig's terms. Entries of JSON name a column, a joint or a handle;
/// columns without an entry rest. Throws InputError for a frame, name or index that is not there.
Pose pose_for(const PoseFile& file, std::size_t frame, const Skeleton& skeleton);

/// By extension: .json or .dmat. Throws InputError.
PoseFile read_pose(const std::filesystem::path& path);

/// `{"Arm": {"rotation": [x,y,z,w], "translation": [x,y,z]}, "3": {...}}`: names, or handle
/// indices in digits; both members optional. A list of such objects, or `{"frames": [...]}`, is an
/// animation.
PoseFile parse_pose_json(std::string_view bytes, const std::string& name);

/// libigl's: unit quaternions x y z w one below the other, a frame a column; or one a row of
/// four columns.
PoseFile parse_pose_dmat(std::string_view bytes, const std::string& name);

}  // namespace skinfield
