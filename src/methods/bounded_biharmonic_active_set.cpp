#include "skinfield/methods/bounded_biharmonic_active_set.h"

#include "methods/nodal_program.h"

#include <utility>

namespace skinfield {

BoundedBiharmonicResult bounded_biharmonic_active_set(
    const BoundedBiharmonicProblem& problem, const BoundedBiharmonicActiveSetOptions& options,
    const Progress& progress) {
  NodalProgram nodal(problem, {options.start, options.locked, options.paint, {}},
                     "bounded biharmonic weights by active sets");
  BoundedBiharmonicResult result;
  result.unreached = nodal.unreached();
  SimplexSolution solution;
  if (nodal.open()) {
    ActiveSetOptions active_set = options.active_set;
    active_set.start = std::move(nodal.start);
    solution = solve_simplex_active_set(nodal.program, active_set, progress);
    result.stats = solution.stats;
  }
  result.W = nodal.weights(solution.W);
  return result;
}

}  // namespace skinfield
