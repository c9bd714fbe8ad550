// Gmsh 2.2 .msh, ASCII and binary.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Triangles, quadrangles and tetrahedra (of second order: their corners); points and lines are
/// skipped; other solids are refused. Throws InputError.
MeshFile parse_gmsh(std::string_view bytes, const std::string& name);

/// ASCII, positions with all their digits: V (n,3), F (f,3) or empty, T (t,4).
std::string format_gmsh(const Points& V, const Triangles& F, const Tetrahedra& T);

}  // namespace skinfield
