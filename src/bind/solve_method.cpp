#include "bind/solve_method.h"

#include "skinfield/methods/polyharmonic.h"

#include <algorithm>

namespace skinfield {
namespace {

BoundedBiharmonicProblem problem_on(const SolvedDomain& solved) {
  return {solved.domain->stiffness(), solved.domain->mass(), solved.domain->fixed()};
}

/// A point domain has the painted points among its fixed nodes.
FixedRows paint_for(const SolvedDomain& solved, const Conditions& conditions) {
  return solved.points ? FixedRows() : paint_on_nodes(conditions, *solved.domain);
}

BoundedBiharmonicOptions bounded_options(const SolvedDomain& solved, const Conditions& conditions,
                                         const BindOptions& options) {
  BoundedBiharmonicOptions method;
  method.tolerance = options.tolerance;
  method.max_iterations = options.iterations;
  method.time_limit_s = options.time_limit_s;
  method.start = start_on_nodes(conditions, solved);
  if (method.start.rows() > 0) method.locked = conditions.locked;
  // A given start may be far from the optimum, where only the local penalties converge.
  method.penalties_from_stiffness = !solved.points || method.start.rows() > 0;
  method.paint = paint_for(solved, conditions);
  return method;
}

MethodSolution solve_bounded(const SolvedDomain& solved, const Conditions& conditions,
                             const BindOptions& options, const Progress& progress) {
  BoundedBiharmonicResult result = bounded_biharmonic(
      problem_on(solved), bounded_options(solved, conditions, options), progress);
  return {.nodal = std::move(result.W), .raw = {}, .stats = result.stats, .derivative = 2};
}

MethodSolution solve_polyharmonic(int order, const SolvedDomain& solved,
                                  const Conditions& conditions, const Progress& progress) {
  PolyharmonicOptions method;
  method.order = order;
  method.paint = paint_for(solved, conditions);
  if (!conditions.locked.empty()) method.start = start_on_nodes(conditions, solved);
  if (method.start.rows() > 0) method.locked = conditions.locked;
  PolyharmonicResult result = polyharmonic(problem_on(solved), method, progress);
  RowMatrix valid = valid_weights(result.W, method.locked);
  return {.nodal = std::move(valid),
          .raw = std::move(result.W),
          .stats = result.stats,
          .derivative = order};
}

}  // namespace

void check_method(const BindOptions& options, const std::string& character) {
  const MethodFacts& facts = facts_of(options.method);
  const std::string name(facts.name);
  if (options.solver != Solver::automatic &&
      std::find(facts.solvers.begin(), facts.solvers.end(), options.solver) == facts.solvers.end())
    throw OptionError("method " + name + " has no solver " + std::string(name_of(options.solver)),
                      character, "leave the choice out");
  if (options.start && options.locked_columns.empty() && !facts.iterates)
    throw OptionError("method " + name + " is solved directly and cannot start from weights",
                      character, "lock some of their columns, or leave them out");
}

MethodSolution solve_method(const SolvedDomain& solved, const Conditions& conditions,
                            const BindOptions& options, const Progress& progress) {
  switch (options.method) {
    case Method::bounded_biharmonic:
      break;
    case Method::harmonic:
      return solve_polyharmonic(1, solved, conditions, progress);
    case Method::biharmonic:
      return solve_polyharmonic(2, solved, conditions, progress);
    case Method::triharmonic:
      return solve_polyharmonic(3, solved, conditions, progress);
  }
  return solve_bounded(solved, conditions, options, progress);
}

RowMatrix resolve_method(const SolvedDomain& solved, const SparseRows& P,
                         const Conditions& conditions, const BindOptions& options,
                         const Progress& progress) {
  if (options.method != Method::bounded_biharmonic) return {};
  return resolve_on_kept_support(solved, P, options.max_influences,
                                 bounded_options(solved, conditions, options), progress);
}

}  // namespace skinfield
