#include "skinfield/methods/bounded_biharmonic.h"

#include "methods/nodal_program.h"

namespace skinfield {

BoundedBiharmonicResult bounded_biharmonic(const BoundedBiharmonicProblem& problem,
                                           const BoundedBiharmonicOptions& options,
                                           const Progress& progress) {
  NodalProgram nodal(problem, {options.start, options.locked, options.paint, options.support},
                     "bounded biharmonic weights");
  BoundedBiharmonicResult result;
  result.unreached = nodal.unreached();
  SimplexSolution solution;
  if (nodal.open()) {
    if (!options.penalties_from_stiffness) nodal.program.K.resize(0, 0);
    SimplexOptions simplex;
    simplex.tolerance = options.tolerance;
    simplex.max_iterations = options.max_iterations;
    simplex.time_limit_s = options.time_limit_s;
    simplex.start = nodal.start;
    solution = solve_simplex_qp(nodal.program, simplex, progress);
    result.stats = solution.stats;
  }
  result.W = nodal.weights(solution.W);
  return result;
}

}  // namespace skinfield
