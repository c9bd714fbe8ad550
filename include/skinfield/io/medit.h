// MEDIT's ASCII .mesh: tetrahedra and triangles.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Vertices, Triangles, Quadrilaterals and Tetrahedra in 2 or 3 dimensions; other sections are
/// skipped; hexahedra are refused. Throws InputError.
MeshFile parse_medit(std::string_view bytes, const std::string& name);

}  // namespace skinfield
