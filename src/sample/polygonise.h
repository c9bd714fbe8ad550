// From an implicit shape to a closed, manifold, evenly triangulated surface.
#pragma once

#include "sample/implicit.h"
#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

namespace skinfield::sample_detail {

/// Marching tetrahedra on a body-centred cubic lattice of step `step` (between nodes of a kind),
/// oriented outward; then short edges are collapsed, edges flipped toward Delaunay triangles, and
/// vertices spread evenly over the surface. Where the shape is thicker than `fine_radius`, edges
/// are up to `coarsest` times longer. Features thinner than about a step are lost.
Mesh polygonise(const ImplicitShape& shape, double step, double fine_radius, double coarsest,
                const Progress& progress);

/// The second half: improves triangles of a closed manifold mesh in place; stays manifold.
/// size (n): the edge length wanted at each vertex; it is kept in step with the vertices.
void even_out(Mesh& mesh, Vector& size);

}  // namespace skinfield::sample_detail
