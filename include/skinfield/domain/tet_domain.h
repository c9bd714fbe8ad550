// Linear finite elements on a tet mesh: the domain that exact bounded biharmonic weights were made
// for (Jacobson, Baran, Popovic, Sorkine 2011, section 3), and the referee of the others.
#pragma once

#include "skinfield/domain/domain.h"
#include "skinfield/operators/mass.h"

#include <memory>

namespace skinfield {

struct TetDomainOptions {
  MassKind mass_kind = MassKind::barycentric;
  /// (n) > 0, masses of V's vertices, or empty for those of `mass_kind`. Where the mesh is split,
  /// the given density (mass over barycentric mass) stays and new vertices take it from what they
  /// were made of.
  Vector mass;
};

struct TetDomainFacts {
  int handle_nodes = 0;
  int components = 0;  ///< of nodes that tets couple
  int components_without_handle = 0;
  int nodes_without_handle = 0;
  int uncoupled_nodes = 0;   ///< duplicates, unreferenced, corners of empty tets only
  int split_handles = 0;     ///< handles that had no vertex
  int new_nodes = 0;         ///< made for them
  std::vector<int> outside;  ///< handles without a fixed row
  std::int64_t inverted_tets = 0, degenerate_tets = 0;
  double volume = 0;
};

class TetDomain : public Domain {
 public:
  /// Nodes 0..n-1 are V's rows in order, nodes made for handles come after. Equal positions count
  /// as the first of them; the others, and vertices of no tet, stay as nodes that nothing couples
  /// (`at` gives their weights like those of any other point). Inverted tets count like their
  /// mirror images, tets without volume not at all.
  ///
  /// A vertex within 1e-6 of the box diagonal of a handle is fixed, shared by k handles 1/k each
  /// (design.md 4). A bone or point without such a vertex has the mesh split at its samples (about
  /// two a mean edge, at least two a bone); samples very near to a vertex, edge or face go onto
  /// it. A mesh with vertices on every handle is never changed. Parts of handles outside are cut.
  ///
  /// @param V (n,3) in the unit box. @param handles in the unit box; column i is handles[i];
  /// regions name rows of V.
  /// @throws DomainError if no tet has a volume, or handles are given but none reaches the mesh;
  /// InputError for masses that do not fit.
  TetDomain(const Points& V, const Tetrahedra& T, const std::vector<Handle>& handles,
            const TetDomainOptions& options = {});
  ~TetDomain() override;

  const Points& nodes() const override;
  /// Cotangent stiffness (operators/stiffness.h): entries of both signs on obtuse tets.
  const SparseRows& stiffness() const override;
  const Vector& mass() const override;
  const FixedRows& fixed() const override;
  /// Barycentric in the tet that holds the point; outside points take the closest point of the
  /// boundary. Normals are not used.
  Interpolation at(const Points& X, const Points& normals) const override;

  const Tetrahedra& elements() const;
  bool contains(const Vec3& x) const;
  const TetDomainFacts& facts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
