// Normals for bare point clouds and repair of randomly flipped faces.
#pragma once

#include "skinfield/geometry/mesh.h"

namespace skinfield {

/// Unit normals of a point cloud: local plane fits over the `neighbours` nearest points, made
/// consistent along a minimum spanning tree (Hoppe et al. 1992), and flipped component by
/// component so that the `inside` points (k,3) get a positive winding number; with none, so that
/// each component's normals point away from its centroid.
Points estimate_point_normals(const Points& P, const Points& inside, int neighbours = 16);

/// Areas for oriented-point winding numbers: the local Voronoi area in each tangent plane.
Vector point_areas(const Points& P, const Points& N, int neighbours = 16);

/// Makes the orientation of neighbouring faces agree where it can be made to (breadth first over
/// manifold edges after welding, each such patch keeping the orientation of most of its area).
/// Then turns patches so that as many `inside` points (k,3) as can be have a winding number of at
/// least 1/2. Patches too small to matter to it (a soup's single faces) are turned one by one, each
/// outward as the nearest inside points see it (weighted by solid angle and visibility), but only
/// where they largely disagree: a soup whose winding number at the inside points is at least 0.45
/// of what turning would reach stays as it is. Consistent closed meshes come back unchanged; with
/// no inside points only neighbours are made to agree.
struct OrientationRepair {
  Triangles F;
  int flipped = 0;       ///< faces turned
  int inconsistent = 0;  ///< edges whose faces disagreed in the input
};
OrientationRepair repair_orientation(const Points& V, const Triangles& F, const Points& inside);

}  // namespace skinfield
