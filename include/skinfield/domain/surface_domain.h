// The surface itself as domain: the ladder's rung for shapes without an inside worth the name
// (ribbons, loose sheets, soups). Non-manifold and unoriented triangles are welcome. TriDomain is
// the exact counterpart, for flat shapes and sound meshes, and says how the two differ.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/domain/domain.h"
#include "skinfield/operators/mass.h"

#include <memory>

namespace skinfield {

struct SurfaceDomainOptions {
  /// Triangles are split until about so many nodes cover the surface, so that coarse meshes have
  /// nodes where handles need them. Meshes that have more vertices keep them.
  int nodes = 6000;
  /// Parts nearer to each other than this share of the node distance are joined.
  double touching = 0.75;
  MassKind mass = MassKind::barycentric;
};

class SurfaceDomain : public Domain {
 public:
  /// @param mesh in the unit box. Degenerate triangles are left out, equal positions become one.
  /// @param handles in the unit box; column i is handles[i]. A handle's fixed nodes are the ones
  /// nearest to it that it sees.
  /// @throws DomainError if there is no handle, or no triangle with an area.
  SurfaceDomain(const Mesh& mesh, const std::vector<Handle>& handles,
                const SurfaceDomainOptions& options = {}, const Progress& progress = {});
  ~SurfaceDomain() override;

  const Points& nodes() const override;
  /// Cotangent weights, those below a small positive floor raised to it (an M-matrix on any
  /// triangles), and weak links between parts that touch.
  const SparseRows& stiffness() const override;
  const Vector& mass() const override;
  const FixedRows& fixed() const override;
  /// Barycentric on the closest triangle; normals are not used.
  Interpolation at(const Points& X, const Points& normals) const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
