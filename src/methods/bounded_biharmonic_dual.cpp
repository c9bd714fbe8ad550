#include "skinfield/methods/bounded_biharmonic_dual.h"

#include "methods/nodal_program.h"

#include <utility>

namespace skinfield {

BoundedBiharmonicDualResult bounded_biharmonic_dual(const BoundedBiharmonicProblem& problem,
                                                    const BoundedBiharmonicDualOptions& options,
                                                    const Progress& progress) {
  NodalProgram nodal(problem, {options.start, options.locked, options.paint, {}},
                     "bounded biharmonic weights by the dual");
  BoundedBiharmonicDualResult result;
  result.unreached = nodal.unreached();
  DualSolution solution;
  if (nodal.open()) {
    DualOptions dual = options.dual;
    dual.start = std::move(nodal.start);
    solution = solve_simplex_dual(nodal.program, dual, progress);
    result.stats = solution.stats;
    result.recovered_energy = solution.recovered_energy;
    result.constraint_violation = solution.constraint_violation;
    result.evaluations = solution.evaluations;
    result.history = std::move(solution.history);
  }
  result.W = nodal.weights(solution.W);
  return result;
}

}  // namespace skinfield
