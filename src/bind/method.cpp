#include "skinfield/bind/method.h"

#include <algorithm>

namespace skinfield {

std::string_view name_of(Solver solver) {
  switch (solver) {
    case Solver::automatic:
      return "auto";
    case Solver::primal:
      return "primal";
  }
  return "";
}

std::span<const MethodFacts> methods() {
  static const std::vector<MethodFacts> all{
      {.method = Method::bounded_biharmonic,
       .name = "bbw",
       .description = "bounded biharmonic, smooth and valid by construction",
       .iterates = true,
       .on_domain = true,
       .uses_mass = true,
       .solvers = {Solver::primal}},
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

}  // namespace skinfield
