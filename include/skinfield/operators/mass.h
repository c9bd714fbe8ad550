// Lumped masses: how much volume (or area) a vertex stands for.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// Barycentric masses (n): a quarter of each tetrahedron's volume goes to each corner, a third of
/// each triangle's area. A vertex of no element, or of empty ones only, gets 1e-12 of the mean
/// mass so that M^-1 exists.
Vector barycentric_mass(const Points& V, const Tetrahedra& T);
Vector barycentric_mass(const Points& V, const Triangles& F);

}  // namespace skinfield
