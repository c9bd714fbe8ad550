// A character's shape: triangles in space, a tetrahedral mesh, a flat outline, or a bare point
// cloud.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// Closed polylines in one plane, cut into segments: every vertex ends an even number of the
/// segments of a shape. A place belongs to a shape if a ray from it crosses that shape's segments
/// an odd number of times (so that a loop within a loop is a hole), and to the outline if it
/// belongs to any of its shapes.
struct Outline {
  Segments E;              ///< (e,2)
  std::vector<int> shape;  ///< (e) the shape that each segment bounds
  /// (k,2) Segments in the plane that close no polyline: a soup, the inside to their left.
  /// Geometric fields alone take them.
  Segments loose;

  bool empty() const { return E.rows() == 0; }
};

/// Plain data; nothing is assumed about it (soups, non-manifold, open, empty are all meshes).
struct Mesh {
  Points V;         ///< (n,3) positions, in the units of whoever made the mesh
  Triangles F;      ///< (f,3) triangles; for a tet mesh its boundary, oriented outward
  Tetrahedra T;     ///< (t,4) tetrahedra, or empty
  Points N;         ///< (n,3) normals of a point cloud, or empty
  Outline outline;  ///< of a flat shape, or empty; F is empty until the outline is triangulated

  bool is_outline() const { return F.rows() == 0 && T.rows() == 0 && !outline.empty(); }
  bool is_point_cloud() const { return F.rows() == 0 && T.rows() == 0 && outline.empty(); }
};

/// Row i of (n,3) normals, or zero where there are none.
inline Vec3 normal_or_zero(const Points& N, Eigen::Index i) {
  return N.rows() > 0 ? Vec3(N.row(i).transpose()) : Vec3(Vec3::Zero());
}

/// Lower and upper corner. Precondition: at least one row; all finite.
Box3 bounding_box(const Points& V);
double diagonal(const Box3& box);

/// The map to the unit box: x -> (x - origin) * scale, largest side of the box = 1.
struct UnitBox {
  Vec3 origin = Vec3::Zero();
  double scale = 1;
  Points to(const Points& X) const;
  Vec3 to(const Vec3& x) const { return (x - origin) * scale; }
  Points from(const Points& X) const;
};
/// A box of zero size (a single point) gets scale 1.
UnitBox unit_box(const Points& V);

/// Vertices closer than `tolerance` become one (0: equal positions only): each joins the earliest
/// new vertex within the tolerance, so that chains do not creep. `vertex` maps old to new; new
/// vertices keep the order of their first appearance. Triangles that lose a corner stay (callers
/// that mind test for them). Linear time (hash grid). Position of a merged vertex: its first
/// member's.
struct Welded {
  Points V;
  std::vector<int> vertex;
};
Welded weld(const Points& V, double tolerance = 0);

/// Connected components over shared vertices: component of every face, numbered by first face.
struct Components {
  std::vector<int> of_face;
  int count = 0;
};
Components connected_components(const Triangles& F, Eigen::Index vertices);

/// (f,3) twice-area-weighted (not normalised) face normals.
Points face_normals(const Points& V, const Triangles& F);
Vector face_areas(const Points& V, const Triangles& F);
/// Angle-weighted unit vertex normals; zero where a vertex has no non-degenerate face.
/// (Area-weighted ones point outward of thin parts: findings.md A.)
Points vertex_normals(const Points& V, const Triangles& F);

/// Boundary triangles of a tet mesh (sides of one tet, or of an odd number), oriented outward of
/// the first tet that has them, whichever way round its corners are listed.
Triangles boundary_faces(const Points& V, const Tetrahedra& T);

}  // namespace skinfield
