// From an implicit shape to a closed, manifold, evenly triangulated surface.
#pragma once

#include "sample/implicit.h"
#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

namespace skinfield::sample_detail {

/// Marching tetrahedra on a body-centred cubic lattice of step `step` (between nodes of a kind),
/// oriented outward; then short edges are collapsed, edges flipped toward Delaunay triangles, and
/// vertices spread evenly over the surface. Features thinner than about a step are lost.
Mesh polygonise(const ImplicitShape& shape, double step, const Progress& progress);

/// The second half: improves triangles of a closed manifold mesh in place; stays manifold.
void even_out(Mesh& mesh, double short_edge, double long_edge);

}  // namespace skinfield::sample_detail
