#include "bind/solve_method.h"

#include "bind/tet_stage.h"
#include "skinfield/base/error.h"
#include "skinfield/methods/bone_heat.h"
#include "skinfield/methods/bounded_biharmonic_active_set.h"
#include "skinfield/methods/bounded_biharmonic_dual.h"
#include "skinfield/methods/decoupled_biharmonic.h"
#include "skinfield/methods/monotonic.h"
#include "skinfield/methods/polyharmonic.h"
#include "skinfield/methods/quasi_harmonic.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

BoundedBiharmonicProblem problem_on(const SolvedDomain& solved) {
  return {solved.domain->stiffness(), solved.domain->mass(), solved.domain->fixed()};
}

struct Stop {
  double tolerance = 0;
  int iterations = 0;
};

/// When the solver stops: as asked for, or its own choice.
Stop stop_of(const BindOptions& options) {
  const SolverFacts* facts = facts_of(options.method, options.solver);
  return {options.tolerance > 0 ? options.tolerance : facts->tolerance,
          options.iterations > 0 ? options.iterations : facts->iterations};
}

std::vector<BindReport::Step> steps(const std::vector<DualRecord>& history) {
  std::vector<BindReport::Step> result;
  for (const DualRecord& r : history)
    result.push_back({r.iteration, r.primal_objective, r.dual_objective, r.constraint_violation});
  return result;
}

/// A point domain has the painted points among its fixed nodes.
FixedRows paint_for(const SolvedDomain& solved, const Conditions& conditions) {
  if (solved.points) return {};
  return solved.tets ? paint_on_tets(conditions, *solved.tets)
                     : paint_on_nodes(conditions, *solved.domain);
}

BoundedBiharmonicOptions bounded_options(const SolvedDomain& solved, const Conditions& conditions,
                                         const BindOptions& options) {
  const Stop stop = stop_of(options);
  BoundedBiharmonicOptions method;
  method.tolerance = stop.tolerance;
  method.max_iterations = stop.iterations;
  method.time_limit_s = options.time_limit_s;
  method.start = start_on_nodes(conditions, solved);
  if (method.start.rows() > 0) method.locked = conditions.locked;
  // A given start may be far from the optimum, where only the local penalties converge.
  method.penalties_from_stiffness = !solved.points || method.start.rows() > 0;
  method.paint = paint_for(solved, conditions);
  return method;
}

/// The paper's dual, which stops on the certified gap.
DualOptions dual_options(const BindOptions& options) {
  const Stop stop = stop_of(options);
  DualOptions dual;
  dual.relative_gap = stop.tolerance;
  dual.max_iterations = stop.iterations;
  dual.time_limit_s = options.time_limit_s;
  dual.keep_history = options.keep_history;
  return dual;
}

MethodSolution solve_bounded(const SolvedDomain& solved, const Conditions& conditions,
                             const BindOptions& options, const Progress& progress) {
  BoundedBiharmonicOptions common = bounded_options(solved, conditions, options);
  if (options.solver == Solver::dual) {
    BoundedBiharmonicDualOptions method;
    method.dual = dual_options(options);
    method.start = std::move(common.start);
    method.locked = std::move(common.locked);
    method.paint = std::move(common.paint);
    BoundedBiharmonicDualResult result =
        bounded_biharmonic_dual(problem_on(solved), method, progress);
    return {.nodal = std::move(result.W),
            .raw = {},
            .stats = result.stats,
            .derivative = 2,
            .history = steps(result.history)};
  }
  BoundedBiharmonicResult result;
  if (options.solver == Solver::active_set) {
    BoundedBiharmonicActiveSetOptions method;
    method.active_set.relative_gap = common.tolerance;
    method.active_set.max_iterations = common.max_iterations;
    method.active_set.time_limit_s = options.time_limit_s;
    method.start = std::move(common.start);
    method.locked = std::move(common.locked);
    method.paint = std::move(common.paint);
    result = bounded_biharmonic_active_set(problem_on(solved), method, progress);
  } else {
    result = bounded_biharmonic(problem_on(solved), common, progress);
  }
  return {.nodal = std::move(result.W), .raw = {}, .stats = result.stats, .derivative = 2};
}

MethodSolution solve_decoupled(const SolvedDomain& solved, const Conditions& conditions,
                               const BindOptions& options, const Progress& progress) {
  BoundedBiharmonicOptions common = bounded_options(solved, conditions, options);
  DecoupledBiharmonicOptions method;
  const bool boxed = options.solver != Solver::dual_unboxed;
  method.solver = options.solver == Solver::dual || !boxed ? DecoupledSolver::dual
                  : options.solver == Solver::active_set   ? DecoupledSolver::active_set
                                                           : DecoupledSolver::primal;
  method.tolerance = common.tolerance;
  method.max_iterations = common.max_iterations;
  method.active_iterations = common.max_iterations;
  method.time_limit_s = options.time_limit_s;
  method.dual = dual_options(options);
  method.dual.upper_bound = boxed;
  method.start = std::move(common.start);
  method.locked = std::move(common.locked);
  method.paint = std::move(common.paint);
  method.penalties_from_stiffness = common.penalties_from_stiffness;
  DecoupledBiharmonicResult result = decoupled_biharmonic(problem_on(solved), method, progress);
  return {.nodal = std::move(result.W),
          .raw = {},
          .stats = result.stats,
          .derivative = 2,
          .history = steps(result.history)};
}

MethodSolution solve_monotonic(const SolvedDomain& solved, const Conditions& conditions,
                               const BindOptions& options, const Progress& progress) {
  const Stop stop = stop_of(options);
  MonotonicOptions method;
  method.coupled = options.solver != Solver::decoupled;
  method.tolerance = stop.tolerance;
  method.max_iterations = stop.iterations;
  method.time_limit_s = options.time_limit_s;
  method.paint = paint_for(solved, conditions);
  MonotonicResult result =
      monotonic({solved.domain->stiffness(), solved.domain->mass(), solved.domain->fixed()}, method,
                progress);
  return {.nodal = std::move(result.W), .raw = {}, .stats = result.stats, .derivative = 2};
}

MethodSolution solve_quasi_harmonic(const SolvedDomain& solved, const Conditions& conditions,
                                    const BindOptions& options, const Progress& progress) {
  const Stop stop = stop_of(options);
  if (!solved.tets && !solved.tris)
    throw SolveError("there are no elements for the metric", "quasi-harmonic weights",
                     "use --method bbw");
  QuasiHarmonicOptions method;
  method.optimiser = options.solver == Solver::restarted_adam ? TensorOptimiser::restarted_adam
                     : options.solver == Solver::adam         ? TensorOptimiser::adam
                     : options.solver == Solver::lbfgs        ? TensorOptimiser::lbfgs
                                                              : TensorOptimiser::adam_lbfgs;
  method.tolerance = stop.tolerance;
  method.max_iterations = stop.iterations;
  method.time_limit_s = options.time_limit_s;
  method.paint = paint_for(solved, conditions);
  if (!conditions.locked.empty()) method.start = start_on_nodes(conditions, solved);
  if (method.start.rows() > 0) method.locked = conditions.locked;
  const Tetrahedra no_tets;
  const Triangles no_triangles;
  QuasiHarmonicResult result =
      quasi_harmonic({.V = solved.domain->nodes(),
                      .T = solved.tets ? solved.tets->elements() : no_tets,
                      .F = solved.tris ? solved.tris->triangles() : no_triangles,
                      .M = solved.domain->mass(),
                      .fixed = solved.domain->fixed()},
                     method, progress);
  std::vector<BindReport::Step> history;
  for (std::size_t k = 0; options.keep_history && k < result.history.size(); ++k)
    history.push_back({static_cast<int>(k), result.history[k], 0, 0});
  MethodSolution solution{.nodal = std::move(result.W),
                          .raw = std::move(result.unprojected),
                          .stats = result.stats,
                          .derivative = 2,
                          .history = std::move(history),
                          .seconds = std::move(result.seconds)};
  if (options.keep_tensors) {
    solution.tensors.emplace();
    solution.tensors->nodes = solved.scaled.box.from(solved.domain->nodes());
    if (solved.tets)
      solution.tensors->elements = solved.tets->elements();
    else
      solution.tensors->elements = solved.tris->triangles();
    solution.tensors->direction = std::move(result.direction);
    solution.tensors->condition = std::move(result.condition);
  }
  return solution;
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

MethodSolution solve_bone_heat(const SolvedDomain& solved, const Conditions& conditions,
                               const BindOptions& options, const Vector& masses,
                               const Progress& progress) {
  BoneHeatOptions method;
  method.mass = options.mass;
  method.masses = masses;
  std::map<int, Eigen::Index> row_of_vertex;  // ascending
  for (std::size_t k = 0; k < conditions.painted_vertex.size(); ++k)
    row_of_vertex.emplace(conditions.painted_vertex[k], static_cast<Eigen::Index>(k));
  method.paint.weights.resize(static_cast<Eigen::Index>(row_of_vertex.size()),
                              conditions.paint.weights.cols());
  for (const auto& [vertex, row] : row_of_vertex) {
    method.paint.weights.row(static_cast<Eigen::Index>(method.paint.node.size())) =
        conditions.paint.weights.row(row);
    method.paint.node.push_back(vertex);
  }
  if (!conditions.locked.empty()) {
    method.start = conditions.start;
    method.locked = conditions.locked;
  }
  BoneHeatResult result = bone_heat(solved.scaled.mesh, solved.scaled.handles, method, progress);
  RowMatrix valid = valid_weights(result.W, method.locked);
  return {.nodal = std::move(valid),
          .raw = std::move(result.W),
          .stats = result.stats,
          .derivative = 1};
}

}  // namespace

void check_method(const BindOptions& options, const Character& character) {
  const std::string& where = character.name;
  const MethodFacts& facts = facts_of(options.method);
  const std::string name(facts.name);
  if (options.solver != Solver::automatic && !facts_of(options.method, options.solver))
    throw OptionError("method " + name + " has no solver " + std::string(name_of(options.solver)),
                      where, "leave the choice out");
  if (options.keep_tensors && !facts.tensors)
    throw OptionError("method " + name + " has no tensors", where, "use --method quasi-harmonic");
  if (!facts.locks && !options.locked_columns.empty())
    throw OptionError("method " + name + " cannot keep columns of given weights", where,
                      "use --method bbw");
  if (options.start && options.locked_columns.empty() && !facts.starts)
    throw OptionError(
        "method " + name + " cannot start from weights", where,
        facts.locks ? "lock some of their columns, or leave them out" : "leave them out");
  if (facts.needs_elements && options.domain == BindOptions::DomainKind::points)
    throw OptionError("method " + name + " needs tetrahedra or triangles", where,
                      "use --domain tets or leave the domain out");
  if (facts.on_field && options.domain != BindOptions::DomainKind::automatic)
    throw OptionError("method " + name + " has a domain of its own", where, "leave the domain out");
  if (!facts.on_domain && !facts.on_field && character.mesh.F.rows() == 0)
    throw OptionError("method " + name + " needs a surface, and this is a point cloud", where,
                      "use --method bbw");
  if (!facts.on_domain && !facts.on_field && options.domain == BindOptions::DomainKind::points)
    throw OptionError("method " + name + " lives on the surface, not on points inside", where,
                      "leave the domain out");
  if (!options.masses) return;
  const Vector& M = *options.masses;
  const auto inputs = static_cast<Eigen::Index>(character.vertex_of_input.size());
  if (M.size() != inputs)
    throw InputError("there are " + std::to_string(M.size()) + " masses for " +
                         std::to_string(inputs) + " vertices",
                     where, "give one a vertex, in the file's order");
  for (Eigen::Index i = 0; i < M.size(); ++i)
    if (!(M[i] > 0) || !std::isfinite(M[i]))
      throw InputError("the mass of vertex " + std::to_string(i) + " is not positive", where,
                       "every vertex needs a mass above 0");
}

Vector masses_on_vertices(const BindOptions& options, const Character& character,
                          const SolvedDomain& solved) {
  if (!options.masses) return {};
  Vector M = Vector::Zero(character.mesh.V.rows());
  for (std::size_t i = 0; i < character.vertex_of_input.size(); ++i)
    M[character.vertex_of_input[i]] += (*options.masses)[static_cast<Eigen::Index>(i)];
  const int dimension = solved.rung == Rung::volume ? 3 : 2;
  return M * std::pow(solved.scaled.box.scale, dimension);
}

MethodSolution solve_method(const SolvedDomain& solved, const Conditions& conditions,
                            const BindOptions& options, const Vector& masses,
                            const Progress& progress) {
  switch (options.method) {
    case Method::bounded_biharmonic:
      break;
    case Method::decoupled_biharmonic:
      return solve_decoupled(solved, conditions, options, progress);
    case Method::monotonic:
      return solve_monotonic(solved, conditions, options, progress);
    case Method::quasi_harmonic:
      return solve_quasi_harmonic(solved, conditions, options, progress);
    case Method::geometric_fields:  // has no nodes: see field_stage.h
      break;
    case Method::harmonic:
      return solve_polyharmonic(1, solved, conditions, progress);
    case Method::biharmonic:
      return solve_polyharmonic(2, solved, conditions, progress);
    case Method::triharmonic:
      return solve_polyharmonic(3, solved, conditions, progress);
    case Method::bone_heat:
      return solve_bone_heat(solved, conditions, options, masses, progress);
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
