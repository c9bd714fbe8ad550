// Which kinds of weights there are, and what each can be asked for.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace skinfield {

enum class Method {
  bounded_biharmonic,
  decoupled_biharmonic,
  monotonic,
  quasi_harmonic,
  geometric_fields,
  harmonic,
  biharmonic,
  triharmonic,
  bone_heat
};

/// A method's own choices of how it is solved; automatic is its first. dual_unboxed leaves W <= 1
/// out of decoupled weights, for the comparison of the dual's paper. coupled and decoupled are
/// those of monotonic weights: partition of unity inside the problem, or columns one by one;
/// convex, adam and adam_pool those of geometric fields; adam_lbfgs, restarted_adam, adam and
/// lbfgs those of quasi-harmonic weights.
enum class Solver {
  automatic,
  primal,
  dual,
  dual_unboxed,
  active_set,
  coupled,
  decoupled,
  convex,
  adam,
  adam_pool,
  adam_lbfgs,
  restarted_adam,
  lbfgs
};
std::string_view name_of(Solver solver);

struct SolverFacts {
  Solver solver = Solver::automatic;
  /// What BindOptions::tolerance means for it, and the value that 0 stands for.
  std::string_view tolerance_is;
  double tolerance = 0;
  int iterations = 0;  ///< what 0 stands for
};

struct MethodFacts {
  Method method = Method::bounded_biharmonic;
  std::string_view name;         ///< on the command line and in the report
  std::string_view description;  ///< a few words
  bool on_domain = false;  ///< solved on the nodes of a domain; else on the mesh's own vertices
  bool on_field = false;   ///< or as a field of its own inside the shape
  bool needs_elements = false;  ///< of the domain: tetrahedra or triangles
  bool uses_mass = false;
  bool starts = false;   ///< a warm start from given weights means something
  bool locks = true;     ///< can keep given columns
  bool tensors = false;  ///< solves for a tensor an element, which can be had
  /// Its choices, the default first; empty: solved directly, without tolerance or iterations.
  std::vector<SolverFacts> solvers = {};

  bool iterates() const { return !solvers.empty(); }
};

/// All methods, in the order in which they are listed.
std::span<const MethodFacts> methods();
const MethodFacts& facts_of(Method method);
/// The facts of a solver (automatic: the first), or null if the method has no such solver.
const SolverFacts* facts_of(Method method, Solver solver);

}  // namespace skinfield
