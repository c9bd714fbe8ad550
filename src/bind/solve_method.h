// The chosen method, on the domain that was built. A new method is one case here and a line in
// method.cpp.
#pragma once

#include "bind/conditions.h"
#include "skinfield/bind/bind.h"

namespace skinfield {

struct MethodSolution {
  RowMatrix nodal;  ///< (N, handles) rows on the simplex, or of zeros where no handle reaches
  /// The same before rows were brought onto the simplex, of methods that end with that; else empty.
  RowMatrix raw;
  SolveStats stats;
  /// The energy integrates squares of derivatives of this order: it scales with the unit of length
  /// to the power of dimension - 2 order.
  int derivative = 2;
  std::vector<BindReport::Step> history = {};  ///< energies in the unit box
  std::optional<TensorField> tensors = {};
  std::map<std::string, double> seconds = {};  ///< of its stages, wall
};

/// @throws OptionError if the method cannot do what the options ask for, or not for this character;
/// InputError for masses that do not fit.
void check_method(const BindOptions& options, const Character& character);

/// @param masses of merged vertices in the unit box, where BindOptions::masses are given.
/// Precondition: solved.has_nodes(). @throws SolveError
MethodSolution solve_method(const SolvedDomain& solved, const Conditions& conditions,
                            const BindOptions& options, const Vector& masses,
                            const Progress& progress);

/// Given masses on merged vertices, where they add up, and in the unit box; empty without any.
Vector masses_on_vertices(const BindOptions& options, const Character& character,
                          const SolvedDomain& solved);

/// Solves again on the influences that are kept; empty where the method has no such thing.
/// @param P interpolates to the mesh's vertices.
RowMatrix resolve_method(const SolvedDomain& solved, const SparseRows& P,
                         const Conditions& conditions, const BindOptions& options,
                         const Progress& progress);

}  // namespace skinfield
