// Which kinds of weights there are, and what each can be asked for.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace skinfield {

enum class Method { bounded_biharmonic, harmonic, biharmonic, triharmonic, bone_heat };

/// A method's own choice of how it is solved; automatic is its first.
enum class Solver { automatic, primal };
std::string_view name_of(Solver solver);

struct MethodFacts {
  Method method = Method::bounded_biharmonic;
  std::string_view name;         ///< on the command line and in the report
  std::string_view description;  ///< a few words
  bool iterates = false;   ///< tolerance, iterations, time limit and a warm start mean something
  bool on_domain = false;  ///< solved on the nodes of a domain; else on the mesh's own vertices
  bool uses_mass = false;
  std::vector<Solver> solvers = {};  ///< its choices, the default first; empty: there is none
};

/// All methods, in the order in which they are listed.
std::span<const MethodFacts> methods();
const MethodFacts& facts_of(Method method);

}  // namespace skinfield
