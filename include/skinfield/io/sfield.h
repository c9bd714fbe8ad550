// Saved geometric fields, .sfield: all that is needed to go on solving (pause, paint, resume), or
// to evaluate them on another mesh of the same character. A zip of NumPy arrays.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/field_state.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skinfield {

struct FieldFile {
  FieldState state;
  Mesh shape;                   ///< that it was solved in, in the unit box
  UnitBox box;                  ///< from the file's units to the unit box
  std::vector<Handle> handles;  ///< in the unit box, with names; column i is handles[i]
  PaintFile paint;              ///< on the shape's vertices, or empty
  std::vector<std::pair<std::string, double>> settings;  ///< of the method, by name
  /// Joints, bones and columns for writing rigged files, in the file's units. Its handles are those
  /// above, regions as points at their middle; they have columns even where paint alone binds.
  Skeleton skeleton;
  /// Weights that were made symmetric: the partner of each handle, mirrored in x = mirror_plane
  /// (unit box); or empty.
  std::vector<int> mirror_partner;
  double mirror_plane = 0;
};

/// Throws InputError for damaged files, missing arrays, sizes that do not fit together, indices
/// that do not exist, values that are not finite, and versions other than format_sfield's.
FieldFile read_sfield(const std::filesystem::path& path);
FieldFile parse_sfield(std::string_view bytes, const std::string& name);
/// Written atomically. Throws IoError where it cannot be written.
void write_sfield(const std::filesystem::path& path, const FieldFile& file);
std::string format_sfield(const FieldFile& file);

}  // namespace skinfield
