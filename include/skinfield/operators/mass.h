// Lumped masses: how much volume (or area) a vertex stands for.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

enum class MassKind {
  /// A quarter of each tetrahedron's volume goes to each corner, a third of each triangle's area.
  barycentric,
  /// What lies nearer to the corner than to the element's other corners. Tetrahedra: exactly that
  /// part, cut out by the bisector planes; it is the circumcentric cell where the circumcentres
  /// of the element and its faces lie inside, and stays positive where they do not. Triangles: the
  /// mixed areas of Meyer,
  /// Desbrun, Schroeder, Barr 2003 ("Discrete differential-geometry operators for triangulated
  /// 2-manifolds", section 3.3): circumcentric, and in obtuse triangles half of the area to the
  /// obtuse corner, a quarter to the others.
  voronoi,
};

/// (n) masses. Their sum is the volume (area). A vertex of no element, or of empty ones only, gets
/// 1e-12 of the mean mass so that M^-1 exists. Parallel, deterministic.
Vector lumped_mass(const Points& V, const Tetrahedra& T, MassKind kind);
Vector lumped_mass(const Points& V, const Triangles& F, MassKind kind);

Vector barycentric_mass(const Points& V, const Tetrahedra& T);
Vector barycentric_mass(const Points& V, const Triangles& F);

}  // namespace skinfield
