// A domain with the nodal weights found on it: evaluates the handles' weights anywhere.
#pragma once

#include "bind/ladder.h"
#include "skinfield/domain/point_domain.h"
#include "skinfield/domain/tet_domain.h"
#include "skinfield/domain/tri_domain.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/methods/geometric_fields.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace skinfield {

struct SolvedDomain {
  ScaledCharacter scaled;
  Rung rung = Rung::volume;
  std::unique_ptr<Domain> domain;       ///< null on the rungs of nearest handles
  const PointDomain* points = nullptr;  ///< the same domain, if it is one
  const TetDomain* tets = nullptr;      ///< likewise
  const TriDomain* tris = nullptr;      ///< likewise
  /// Instead of a domain: the nodes are the mesh's own vertices, and this finds triangles.
  std::unique_ptr<ClosestPointQuery> own_triangles;
  /// Or instead of nodes: a geometric field, with its rows at the mesh's own vertices.
  std::shared_ptr<const GeometricField> field;
  RowMatrix field_rows;
  std::vector<Fill> field_fill;
  RowMatrix nodal;          ///< (N, handles)
  std::vector<int> column;  ///< of each handle
  int columns = 0;
  std::vector<std::string> names;
  int max_influences = 0;
  double prune = 0;
  bool symmetric = false;
  std::vector<int> partner;  ///< of each handle, mirrored in x = mirror_plane
  double mirror_plane = 0;

  bool has_nodes() const { return domain || own_triangles; }
  /// From the nodes to points of the unit box. Needs nodes.
  Interpolation interpolation(const Points& X, const Points& normals) const;
  /// The same to the mesh's own vertices, whose parts and normals the domain knows.
  Interpolation at_mesh(const Points& normals) const;
  /// Handle weights (n, handles) at points of the unit box; `known`: their interpolation, or null.
  RowMatrix at(const Points& X, const Points& normals, const Interpolation* known,
               std::vector<Fill>& fill) const;
  /// The same of another surface's vertices: a field fills rows along its edges. `evaluated`
  /// (or null) takes how many of a field's rows came about how.
  RowMatrix at_surface(const Points& V, const Triangles& F, const Points& normals,
                       std::vector<Fill>& fill,
                       std::map<std::string, std::int64_t>* evaluated) const;

  /// Rows over handles to skin weights over columns and input vertices.
  SkinWeights to_columns(const RowMatrix& handle_rows,
                         const std::vector<int>& vertex_of_input) const;

 private:
  RowMatrix at_once(const Points& X, const Points& normals, const Interpolation* known,
                    std::vector<Fill>& fill) const;
  /// Rows on the simplex exactly; those that nothing reaches take the nearest handle.
  void complete(const Points& X, const Points& normals, RowMatrix& W,
                std::vector<Fill>& fill) const;
  /// The mean of rows at X and of those at its mirror image.
  RowMatrix mirrored_mean(const RowMatrix& W, const RowMatrix& mirrored) const;
  void mirror(Points& X, Points& normals) const;
};

std::map<std::string, std::int64_t> counts_by_name(const FieldEvaluationCounts& counts);
void count_fills(const std::vector<Fill>& fill, std::map<std::string, std::int64_t>& counts);

}  // namespace skinfield
