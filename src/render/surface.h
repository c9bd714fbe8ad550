// What rays are cast at: triangles with corner normals, in the unit box.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <vector>

namespace skinfield::render_detail {

struct Surface {
  Points V;                        ///< (k,3)
  Triangles F;                     ///< (f,3)
  Points corner_normals;           ///< (3f,3) unit
  std::vector<int> vertex_source;  ///< (k) input vertex, or empty: the same
};

/// Angle-weighted normals, averaged only over neighbours within `crease` degrees of the face.
/// Equal positions count as one vertex, so that texture seams stay invisible.
Points corner_normals(const Points& V, const Triangles& F, double crease);

/// A disc (hexagon) per point, facing `normals` (n,3), or `toward_viewer` where that is empty.
Surface discs(const Points& V, const Points& normals, const Vec3& toward_viewer, double radius);

/// Octahedral bones and round dots. `part` gets the bone of every face, -1 for dots.
Surface skeleton_shape(const std::vector<std::pair<Vec3, Vec3>>& bones,
                       const std::vector<Vec3>& dots, double dot_radius, std::vector<int>& part);

}  // namespace skinfield::render_detail
