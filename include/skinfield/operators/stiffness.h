// Linear finite elements on tetrahedra and triangles in space.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// Cotangent stiffness K (n,n): x' K x is the Dirichlet energy of the linear interpolant. Symmetric
/// positive semidefinite with K 1 = 0, both triangles and every diagonal entry stored. Inverted
/// elements count like their mirror images. Elements whose volume is lost to rounding (below
/// 1e-16 of the cube of their longest edge), repeat a vertex or are not finite add nothing.
/// (Jacobson 2013, "Algorithms and interfaces for real-time deformation of 2D and 3D shapes",
/// section 2.1.3; the gradient form here needs no angles.)
SparseRows stiffness(const Points& V, const Tetrahedra& T);
/// The same on triangles (area below 1e-12 of the square of the longest edge adds nothing).
SparseRows stiffness(const Points& V, const Triangles& F);

/// Gradient of the linear interpolant: (3t,n), rows 3e..3e+2 are the gradient in element e.
/// Degenerate elements have zero rows. Triangles: the tangential gradient.
SparseRows gradient(const Points& V, const Tetrahedra& T);
SparseRows gradient(const Points& V, const Triangles& F);

/// (t) volumes, never negative; (f) areas.
Vector element_volumes(const Points& V, const Tetrahedra& T);
Vector element_volumes(const Points& V, const Triangles& F);

}  // namespace skinfield
