// STL, ASCII and binary.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Three input vertices a facet, in file order; facet normals are ignored (many are wrong). A
/// binary file is known by its size, since some begin with "solid" too. Throws InputError.
MeshFile parse_stl(std::string_view bytes, const std::string& name);

/// True if the size fits a binary STL's facet count exactly.
bool is_binary_stl(std::string_view bytes);

}  // namespace skinfield
