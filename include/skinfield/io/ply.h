// PLY: ASCII, binary little and big endian; elements and properties in any order.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Vertices with x y [z] and optional nx ny nz, faces with vertex_indices or vertex_index;
/// anything else is skipped. A file without faces is a point cloud. Throws InputError.
MeshFile parse_ply(std::string_view bytes, const std::string& name);

}  // namespace skinfield
