// The oriented segments that bound a flat shape: of its triangles, its outline, or a soup of edges.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <vector>

namespace skinfield {

/// In the plane z = 0. The inside is to the left of each segment.
struct PlanarBoundary {
  Points V;         ///< the mesh's vertices, and behind them places where loops cross
  Segments closed;  ///< of closed loops: their winding number is whole
  Segments open;    ///< of chains that don't close, as they were given or all turned
};

/// @param mesh flat, in z = 0. Its triangles' rim, whichever way round their corners are listed; or
/// its closed outline, cut where it crosses itself, each shape's inside by the even-odd rule, with
/// the loose segments. @param handle_samples (k,3) say which side of loose segments is inside.
PlanarBoundary planar_boundary(const Mesh& mesh, const Points& handle_samples);

/// Loose segments as a smoothed winding number has them: in pieces that its width does not see.
struct DirtySegments {
  Points X;         ///< (k,3) their middles
  Points L;         ///< (k,3) outward normals times length
  double edge = 0;  ///< median length of the segments
  /// 1/2pi sum L.(c-x) / (|c-x|^2 + epsilon^2): findings.md E, rule 4, in the plane.
  double smoothed(const Vec3& x, double epsilon) const;
};
DirtySegments dirty_segments(const Points& V, const Segments& E);

/// (n,3) unit normals of vertices, away from the inside; zero where no segment ends.
Points boundary_normals(const Points& V, const Segments& closed, const Segments& open);

}  // namespace skinfield
