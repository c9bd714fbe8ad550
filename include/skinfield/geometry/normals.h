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
/// manifold edges after welding), then turns each patch so that the winding number at the
/// `inside` points (k,3) is as near to >= 1 as possible; a soup of single faces is turned face by
/// face (each outward as seen by the inside points, weighted by solid angle and visibility).
/// Returns the faces, and how many were turned. Consistent closed meshes come back unchanged.
struct OrientationRepair {
  Triangles F;
  int flipped = 0;          ///< faces turned
  int inconsistent = 0;     ///< edges whose faces disagreed in the input
};
OrientationRepair repair_orientation(const Points& V, const Triangles& F, const Points& inside);

}  // namespace skinfield
