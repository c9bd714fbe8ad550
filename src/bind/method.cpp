#include "skinfield/bind/method.h"

#include <algorithm>

namespace skinfield {

std::string_view name_of(Solver solver) {
  switch (solver) {
    case Solver::automatic:
      return "auto";
    case Solver::primal:
      return "primal";
    case Solver::dual:
      return "dual";
    case Solver::dual_unboxed:
      return "dual-unboxed";
    case Solver::active_set:
      return "active-set";
    case Solver::coupled:
      return "coupled";
    case Solver::decoupled:
      return "decoupled";
    case Solver::convex:
      return "convex";
    case Solver::adam:
      return "adam";
    case Solver::adam_pool:
      return "adam-pool";
    case Solver::adam_lbfgs:
      return "adam-lbfgs";
    case Solver::restarted_adam:
      return "restarted-adam";
    case Solver::lbfgs:
      return "lbfgs";
  }
  return "";
}

std::span<const MethodFacts> methods() {
  constexpr std::string_view change = "largest change of a weight";
  constexpr std::string_view gap = "certified gap";
  constexpr std::string_view saved = "share of the energy that four steps must save";
  static const std::vector<MethodFacts> all{
      {.method = Method::bounded_biharmonic,
       .name = "bbw",
       .description = "bounded biharmonic, smooth and valid by construction",
       .on_domain = true,
       .uses_mass = true,
       .starts = true,
       .solvers = {{Solver::primal, change, 1e-3, 500},
                   {Solver::dual, gap, 1e-4, 20000},
                   {Solver::active_set, gap, 1e-9, 500}}},
      {.method = Method::decoupled_biharmonic,
       .name = "bbw-decoupled",
       .description = "each bone by itself between 0 and 1, then normalised",
       .on_domain = true,
       .uses_mass = true,
       .starts = true,
       .solvers = {{Solver::primal, change, 1e-3, 500},
                   {Solver::dual, gap, 1e-4, 20000},
                   {Solver::dual_unboxed, gap, 1e-4, 20000},
                   {Solver::active_set, "", 0, 8}}},
      {.method = Method::monotonic,
       .name = "monotonic",
       .description = "bounded biharmonic without local extrema",
       .on_domain = true,
       .uses_mass = true,
       .locks = false,
       .solvers = {{Solver::coupled, change, 1e-3, 1500}, {Solver::decoupled, change, 1e-3, 1500}}},
      {.method = Method::quasi_harmonic,
       .name = "quasi-harmonic",
       .description = "harmonic in an optimised metric, hardly any extrema, on elements",
       .on_domain = true,
       .needs_elements = true,
       .uses_mass = true,
       .tensors = true,
       .solvers = {{Solver::adam_lbfgs, saved, 1e-4, 80},
                   {Solver::restarted_adam, saved, 1e-4, 24},
                   {Solver::adam, saved, 1e-4, 100},
                   {Solver::lbfgs, saved, 1e-4, 400}}},
      {.method = Method::geometric_fields,
       .name = "geometric-fields",
       .description = "kernel fields inside the shape, conditions hard, boundaries by choice",
       .on_field = true,
       .locks = false,
       .solvers = {{Solver::convex, "largest change of a weight in five passes", 1e-2, 0},
                   {Solver::adam, "", 0, 6000},
                   {Solver::adam_pool, "", 0, 2400}}},
      {.method = Method::harmonic,
       .name = "harmonic",
       .description = "valid, but with a kink at every bone",
       .on_domain = true},
      {.method = Method::biharmonic,
       .name = "biharmonic",
       .description = "no bounds, then clamped",
       .on_domain = true,
       .uses_mass = true},
      {.method = Method::triharmonic,
       .name = "triharmonic",
       .description = "no bounds, then clamped",
       .on_domain = true,
       .uses_mass = true},
      {.method = Method::bone_heat,
       .name = "bone-heat",
       .description = "surface heat of the bones each vertex sees, as in Blender and Maya",
       .uses_mass = true},
  };
  return all;
}

const MethodFacts& facts_of(Method method) {
  const std::span<const MethodFacts> all = methods();
  return *std::find_if(all.begin(), all.end(),
                       [method](const MethodFacts& facts) { return facts.method == method; });
}

const SolverFacts* facts_of(Method method, Solver solver) {
  for (const SolverFacts& facts : facts_of(method).solvers)
    if (solver == Solver::automatic || facts.solver == solver) return &facts;
  return nullptr;
}

}  // namespace skinfield
