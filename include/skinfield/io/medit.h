// MEDIT's ASCII .mesh: tetrahedra and triangles.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Vertices, Triangles, Quadrilaterals and Tetrahedra in 2 or 3 dimensions; other sections are
/// skipped; hexahedra are refused. Throws InputError.
MeshFile parse_medit(std::string_view bytes, const std::string& name);

/// V (n,3), F (f,3) or empty, T (t,4), positions with all their digits.
std::string format_medit(const Points& V, const Triangles& F, const Tetrahedra& T);

}  // namespace skinfield
