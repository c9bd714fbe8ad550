// Binding on tetrahedra: the mesh's own, or made from its surface.
#pragma once

#include "bind/conditions.h"
#include "bind/solved_domain.h"
#include "skinfield/domain/tetrahedraliser.h"

namespace skinfield {

/// The tet domain of `solved.scaled`; notes in the report how it came about.
/// @throws DomainError where there are no tets and none can be made.
std::unique_ptr<TetDomain> make_tet_domain(const BindOptions& options, const Character& character,
                                           const SolvedDomain& solved, BindReport& report,
                                           const Progress& progress);

/// (N,n) row-stochastic: brings weights that are given on the mesh's vertices to the nodes.
SparseRows nodes_from_mesh(const TetDomain& domain, const Mesh& mesh);

/// The painted rows on the nodes: on the vertex itself where it is a node, else on the node that
/// stands for most of it.
FixedRows paint_on_tets(const Conditions& conditions, const TetDomain& domain);

}  // namespace skinfield
