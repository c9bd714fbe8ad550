// Exact linear finite elements on triangles: flat shapes, and weights on surfaces in space
// (Jacobson, Baran, Popovic, Sorkine 2011, section 3, in two dimensions).
//
// Two domains live on triangles. This one takes the mesh as it is: pure cotangent stiffness, so
// that its energies are those of the papers and agree with any other finite-element code; it is
// for flat input and where `--domain tris` is asked for. SurfaceDomain bends the mesh to its
// needs: it refines, lifts weights to an M-matrix and links loose parts, and so ends in smooth
// weights on ribbons, soups and sheets; it is the ladder's rung for shapes that have no inside.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/domain/domain.h"
#include "skinfield/operators/mass.h"

#include <memory>

namespace skinfield {

struct TriDomainOptions {
  /// A mesh that must be changed, because a handle has no vertex, and that is coarser than this is
  /// refined to about so many nodes first. 0: never.
  int nodes = 2000;
  MassKind mass_kind = MassKind::barycentric;
  /// (n) > 0 masses of the mesh's vertices in unit-box units, or empty: those of `mass_kind`.
  Vector mass;
};

struct TriDomainFacts {
  bool planar = false;   ///< all vertices in one plane (1e-6 of the box's diagonal)
  int added_nodes = 0;   ///< behind the mesh's own vertices
  int handle_nodes = 0;  ///< fixed by handles
  int components = 0;    ///< of the triangles over shared vertices
  int components_without_handle = 0;
  double area = 0, area_without_handle = 0;  ///< unit box
};

/// Nodes 0..n-1 are the mesh's vertices in order, others follow.
///
/// Fixed rows (design.md 4): a vertex within 1e-6 of the box's diagonal of a handle is fixed,
/// shared by k handles 1/k each. A mesh that has such vertices on every handle is never changed.
/// Where a handle has none: in the plane, the mesh is split at the handle's samples (about two a
/// mean edge length, at least two a bone), which lie where the handle, dropped onto the plane, is
/// in the shape, and edges around them are flipped until they are Delaunay; in space, the handle
/// holds the vertices nearest to its samples that it sees.
class TriDomain : public Domain {
 public:
  /// @param mesh in the unit box, equal positions merged; non-manifold and unoriented triangles
  /// are welcome, degenerate ones and loose vertices take no part.
  /// @param handles in the unit box; column i is handles[i]. A handle beside a flat shape has no
  /// rows.
  /// @throws DomainError if there is no handle, no triangle with an area, or no handle in the
  /// shape. InputError if masses are given that do not fit, or that the mesh must be split.
  TriDomain(const Mesh& mesh, const std::vector<Handle>& handles,
            const TriDomainOptions& options = {}, const Progress& progress = {});
  ~TriDomain() override;

  const Points& nodes() const override;
  /// Cotangent weights (operators/stiffness.h), negative ones as they are.
  const SparseRows& stiffness() const override;
  const Vector& mass() const override;
  const FixedRows& fixed() const override;
  /// A point exactly at a vertex of the mesh takes that vertex, so that overlapping parts do not
  /// mix; others are barycentric on the closest triangle. Normals are not used.
  Interpolation at(const Points& X, const Points& normals) const override;

  /// (N,n) row-stochastic: each node from the mesh's vertices.
  SparseRows from_mesh() const;
  /// Is x, dropped onto the plane, in the flat shape? False in space.
  bool covers(const Vec3& x) const;
  const Triangles& triangles() const;
  const TriDomainFacts& facts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
