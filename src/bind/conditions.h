// Paint, locked columns, warm starts and symmetry: what the caller prescribes, in the unit box.
#pragma once

#include "bind/solved_domain.h"
#include "skinfield/domain/point_domain.h"
#include "skinfield/methods/bounded_biharmonic.h"

namespace skinfield {

struct Conditions {
  PaintedPoints paint;              ///< on merged vertices, handle columns
  std::vector<int> painted_vertex;  ///< merged vertices of paint's rows
  RowMatrix start;                  ///< (vertices, handles) given weights, or empty
  std::vector<int> locked;          ///< handles whose columns are kept from `start`
};

/// @throws InputError for sizes or columns that do not fit.
Conditions conditions_for(const Character& character, const BindOptions& options,
                          const SolvedDomain& solved);

/// (n, vertices) row-stochastic: brings weights that are given on the mesh's vertices to points, by
/// the closest triangle; rows are zero where there is none.
SparseRows closest_on_mesh(const Points& X, const Mesh& mesh);
/// The given weights on the domain's nodes (N, handles); empty without any.
RowMatrix start_on_nodes(const Conditions& conditions, const SolvedDomain& solved);

/// Paint alone: the vertices that a column is largest at are its handle, where no volume's nodes
/// can stand for them.
std::vector<Handle> handles_of_paint(const Conditions& conditions, const SolvedDomain& solved);

/// The painted rows on a surface's nodes.
FixedRows paint_on_nodes(const Conditions& conditions, const Domain& domain);

/// Vertices of regions belong to their handles exactly, those of k regions 1/k each.
void apply_regions(const std::vector<Handle>& handles, RowMatrix& rows);

/// Painted rows and locked columns hold exactly on the vertices they were given for.
void apply_exact_conditions(const Conditions& conditions, RowMatrix& rows);

/// Decides on symmetry in x and pairs the handles; a warning where it is asked for but not there.
void find_symmetry(const BindOptions& options, SolvedDomain& solved, BindReport& report);

/// @param P interpolates to the mesh's vertices. @param method the full solution's options.
RowMatrix resolve_on_kept_support(const SolvedDomain& solved, const SparseRows& P, int influences,
                                  const BoundedBiharmonicOptions& method, const Progress& progress);

/// Spurious local extrema of the handles' weights over the mesh's edges, by more than
/// extremum_tolerance.
std::int64_t mesh_extrema(const RowMatrix& rows, const Mesh& mesh);

}  // namespace skinfield
