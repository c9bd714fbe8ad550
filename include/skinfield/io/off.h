// OFF and its variants with colours, normals and texture coordinates.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// [ST][C][N]OFF in ASCII: counts on the first line or the next, comments, trailing colours.
/// Throws InputError.
MeshFile parse_off(std::string_view bytes, const std::string& name);

}  // namespace skinfield
