// From outlines to triangles: constrained Delaunay triangulation with quality refinement, through
// CGAL (GPL, so in the `full` profile only; this is the one file that knows it).
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/rig/skeleton.h"

#include <vector>

namespace skinfield {

struct PlanarMesherOptions {
  /// Vertices wanted; the result is within a tenth where the outline allows it. 0: the outline's
  /// own points alone, and no handles.
  int nodes = 16000;
};

/// V's first rows are the outline's mesh.V; F is counterclockwise in the plane.
struct PlanarMesh {
  Points V;
  Triangles F;
  int crossings = 0;  ///< points where segments of the outline cross, new vertices
};

/// Is there a mesher in this build?
bool can_mesh_outlines();

/// Triangulates what lies inside mesh.outline. Handles, dropped onto the plane, become vertices and
/// edges where they are inside. Angles are at least 20.7 degrees but for those that the outline and
/// handles themselves make (Ruppert's and Shewchuk's refinement). Deterministic.
/// @throws DomainError in the `permissive` profile, if the outline is not flat, or if it has no
/// inside. Cancelled.
PlanarMesh mesh_outline(const Mesh& mesh, const std::vector<Handle>& handles,
                        const PlanarMesherOptions& options = {}, const Progress& progress = {});

}  // namespace skinfield
