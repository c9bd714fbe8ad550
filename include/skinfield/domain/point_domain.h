// The mesh-free point domain: nodes inside the shape and at the handles, a ray-cast Voronoi
// finite-volume Laplacian between nodes that see each other (findings: "The mesh-free point
// domain"). An M-matrix on any input: symmetric, non-positive off the diagonal, K 1 = 0.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/domain/domain.h"
#include "skinfield/domain/solid.h"

#include <cstdint>
#include <map>
#include <memory>

namespace skinfield {

struct PointDomainOptions {
  int nodes = 16000;     ///< wanted; the result is within some per cent
  int directions = 256;  ///< rays a node for its Voronoi cell
  int neighbours = 28;   ///< visible neighbours a node
  int candidates = 40;   ///< nearest nodes tried for visibility
  int lloyd_steps = 2;
  double handle_spacing = 0.7;  ///< of handle samples, in local node distances
  bool adaptive = true;         ///< finer near handles and in thin parts
  std::uint64_t seed = 0;
};

/// Prescribed rows at points of the surface (Dirichlet conditions): each becomes a fixed node.
struct PaintedPoints {
  Points X;           ///< (k,3)
  Points N;           ///< (k,3) outward unit normals, or no rows
  RowMatrix weights;  ///< (k,m) rows on the simplex, the handles' columns
};

/// Wall and processor time and counts of each stage, for the report.
struct PointDomainFacts {
  std::int64_t rays = 0;
  int handle_nodes = 0;
  int components = 0;  ///< of the node graph
  int components_without_handle = 0;
  int nodes_without_handle = 0;
  double volume = 0;
  std::map<std::string, double> seconds;
};

/// Dense samples of handles regardless of the shape, for finding out where inside is: both ends
/// of every segment and at least `per_segment` points.
Points probe_handles(const std::vector<Handle>& handles, double spacing);
/// The same of regions, whose vertices are on the surface: a little way in from there, where the
/// triangles' (or a point cloud's) normals point outward.
Points probe_regions(const Mesh& mesh, const std::vector<Handle>& handles);

class PointDomain : public Domain {
 public:
  /// @param mesh in the unit box, equal positions merged. @param handles in the unit box, the
  /// same columns as `fixed().weights`. Parts of handles outside the shape are cut. `paint` may
  /// stand in for handles.
  /// @throws DomainError if no handle has a part inside, or the shape has no volume.
  PointDomain(const Mesh& mesh, const std::vector<Handle>& handles,
              const PointDomainOptions& options = {}, const PaintedPoints& paint = {},
              const Progress& progress = {});
  ~PointDomain() override;

  const Points& nodes() const override;
  const SparseRows& stiffness() const override;
  const Vector& mass() const override;
  const FixedRows& fixed() const override;
  Interpolation at(const Points& X, const Points& normals) const override;
  /// The vertices of the mesh itself, whose parts and normals are known.
  Interpolation at_mesh() const;
  /// (N,n) row-stochastic: each node from the vertices of the mesh near it that it sees. Brings
  /// weights that are given on vertices to the nodes (warm starts, locked columns).
  SparseRows from_mesh() const;

  const Solid& solid() const;
  const PointDomainFacts& facts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
