#include "bind_arguments.h"

#include "skinfield/io/file.h"

#include <fmt/core.h>

namespace skinfield::cli {

bool is_gltf(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".glb" || extension == ".gltf";
}

void check_output(const std::string& path) {
  static const std::set<std::string> known{".glb", ".gltf", ".npz", ".npy", ".dmat", ".csv"};
  if (!known.contains(lower_extension(path)))
    throw UsageError(path + ": unknown output format (use .glb, .gltf, .npz, .npy, .dmat or .csv)");
}

const MethodFacts& chosen_method(const BindArguments& o) {
  for (const MethodFacts& facts : methods())
    if (facts.name == o.method) return facts;
  return methods().front();  // auto
}

/// "auto" and the names, for CLI11's check.
std::vector<std::string> method_names() {
  std::vector<std::string> names{"auto"};
  for (const MethodFacts& facts : methods()) names.emplace_back(facts.name);
  return names;
}

std::set<std::string> solver_names() {
  std::set<std::string> names{"auto"};
  for (const MethodFacts& facts : methods())
    for (const SolverFacts& solver : facts.solvers) names.emplace(name_of(solver.solver));
  return names;
}

std::string method_help() {
  std::string text = "Kind of weights";
  for (const MethodFacts& facts : methods())
    text += fmt::format("{} {}: {}", text.ends_with("weights") ? "." : ";", facts.name,
                        facts.description);
  return text + ". auto = bbw";
}

std::string solver_help() {
  std::string text = "How it is solved, the first by default";
  for (const MethodFacts& facts : methods()) {
    if (facts.solvers.size() < 2) continue;
    text += fmt::format("; {}:", facts.name);
    for (const SolverFacts& solver : facts.solvers)
      text += fmt::format(" {}", name_of(solver.solver));
  }
  return text;
}

std::string tolerance_help() {
  return "When to stop: primal, coupled, decoupled [1e-3]: no weight changes by more; dual, "
         "dual-unboxed [1e-4] and active-set [1e-9]: the certified gap; quasi-harmonic "
         "[1e-4]: four steps save less";
}

void check_method_options(const BindArguments& o) {
  const MethodFacts& facts = chosen_method(o);
  const auto refuse = [&](bool useful, const std::vector<std::string>& names, const char* why) {
    for (const std::string& name : names)
      if (!useful && o.given.contains(name))
        throw UsageError(fmt::format("{}: --method {} {} (leave it out)", name, facts.name, why));
  };
  refuse(facts.iterates(), {"--tolerance", "--iterations", "--time-limit"}, "is solved directly");
  refuse(facts.on_field, {"--boundary"},
         facts.on_domain ? "has zero Neumann boundaries built in" : "knows no boundary conditions");
  refuse(facts.on_field, {"--save-field", "--resume"}, "is no field that could be saved");
  refuse(facts.on_field,
         {"--visibility", "--kernel-width", "--difference-step", "--rows-per-point",
          "--samples-per-step", "--levels", "--judge-step"},
         "is no geometric field");
  refuse(o.solver == "auto" || o.solver == "convex", {"--rows-per-point"},
         "has them with --solver convex only");
  refuse(o.solver == "adam" || o.solver == "adam-pool", {"--samples-per-step"},
         "has them with --solver adam and adam-pool only");
  refuse(facts.tensors, {"--tensors"}, "has no tensors");
  refuse(o.resume.empty(),
         {"--nodes", "--quality", "--seed", "--visibility", "--kernel-width", "--difference-step",
          "--rows-per-point", "--samples-per-step", "--levels"},
         "takes them from --resume");
  refuse(facts.on_domain || facts.on_field, {"--nodes", "--quality", "--seed"},
         "has no nodes but the vertices");
  refuse(facts.uses_mass, {"--mass"}, "has no masses in it");
  refuse(facts.solvers.size() > 1, {"--solver"}, "has only one solver");
  if (o.solver == "auto") return;
  std::string choices;
  for (const SolverFacts& solver : facts.solvers) {
    if (name_of(solver.solver) == o.solver) {
      if (solver.tolerance_is.empty() && o.given.contains("--tolerance"))
        throw UsageError(
            fmt::format("--tolerance: --method {} --solver {} runs its iterations (use "
                        "--iterations)",
                        facts.name, o.solver));
      return;
    }
    choices += (choices.empty() ? "" : ", ") + std::string(name_of(solver.solver));
  }
  throw UsageError(fmt::format("--solver {}: --method {} has {}", o.solver, facts.name, choices));
}

BindOptions bind_options(const BindArguments& o) {
  BindOptions options;
  const MethodFacts& facts = chosen_method(o);
  options.method = facts.method;
  for (const SolverFacts& solver : facts.solvers)
    if (name_of(solver.solver) == o.solver) options.solver = solver.solver;
  options.domain = o.domain == "points" ? BindOptions::DomainKind::points
                   : o.domain == "tris" ? BindOptions::DomainKind::surface
                   : o.domain == "tets" ? BindOptions::DomainKind::tets
                                        : BindOptions::DomainKind::automatic;
  options.nodes = o.nodes > 0            ? o.nodes
                  : o.quality == "draft" ? 2000
                  : o.quality == "high"  ? 64000
                                         : 16000;
  // Kernel points; each optimiser has its own normal number.
  options.field_points = o.nodes > 0            ? o.nodes
                         : o.quality == "draft" ? 1 << 12
                         : o.quality == "high"  ? 1 << 16
                                                : 0;
  if (!o.boundary.empty())
    options.boundary = o.boundary == "neumann" ? Boundary::neumann : Boundary::natural;
  if (o.visibility == "any-hit") options.field.visibility = FieldVisibility::any_hit;
  if (o.visibility == "none") options.field.visibility = FieldVisibility::none;
  if (o.visibility == "counted") options.field.visibility = FieldVisibility::counted;
  options.field.kernel_width = o.kernel_width;
  options.field.difference_step = o.difference_step;
  options.field.rows_per_point = o.rows_per_point;
  options.field.samples_per_step = o.samples_per_step;
  options.field.levels = o.levels;
  options.field.judged_step = o.judge_step;
  options.keep_field = !o.save_field.empty();
  options.keep_tensors = !o.tensors.empty();
  options.tolerance = o.tolerance;
  options.iterations = o.iterations;
  options.time_limit_s = o.time_limit;
  options.keep_history = !o.report.empty();
  options.seed = o.seed;
  if (o.mass == "voronoi") options.mass = MassKind::voronoi;
  const bool gltf = is_gltf(o.output);
  options.max_influences = o.max_influences >= 0 ? o.max_influences : gltf ? 4 : 0;
  options.prune = o.prune >= 0 ? o.prune : gltf ? 1e-4 : 0;
  options.symmetry = o.symmetry == "x"      ? BindOptions::Symmetry::x
                     : o.symmetry == "auto" ? BindOptions::Symmetry::automatic
                                            : BindOptions::Symmetry::off;
  return options;
}

std::map<std::string, std::string> described(const BindArguments& o, const BindOptions& b) {
  std::map<std::string, std::string> all{{"domain", o.domain},
                                         {"max_influences", std::to_string(b.max_influences)},
                                         {"prune", fmt::format("{:g}", b.prune)},
                                         {"symmetry", o.symmetry},
                                         {"joints", o.skeleton.joints},
                                         {"exclude", o.skeleton.exclude},
                                         {"leaf", o.skeleton.leaf},
                                         {"up", o.skeleton.up},
                                         {"scale", fmt::format("{:g}", o.skeleton.scale)},
                                         {"skeleton", o.skeleton.skeleton},
                                         {"only", o.skeleton.only},
                                         {"regions", o.regions},
                                         {"paint", o.paint},
                                         {"weights_in", o.weights_in},
                                         {"lock", o.lock}};
  const MethodFacts& facts = facts_of(b.method);
  if (facts.on_field) {
    all["boundary"] = !o.boundary.empty() ? o.boundary : o.resume.empty() ? "natural" : "as saved";
    all["resume"] = o.resume;
    all["points"] = std::to_string(b.field_points);
    const auto own = [](bool given, const std::string& value) { return given ? value : "own"; };
    all["visibility"] = !o.visibility.empty() ? o.visibility : o.resume.empty() ? "counted" : "own";
    all["kernel_width"] = own(o.kernel_width > 0, fmt::format("{:g}", o.kernel_width));
    all["difference_step"] = own(o.difference_step > 0, fmt::format("{:g}", o.difference_step));
    all["rows_per_point"] = own(o.rows_per_point > 0, fmt::format("{:g}", o.rows_per_point));
    all["samples_per_step"] = own(o.samples_per_step > 0, std::to_string(o.samples_per_step));
    all["levels"] = own(o.levels > 0, std::to_string(o.levels));
    all["judge_step"] = own(o.judge_step > 0, fmt::format("{:g}", o.judge_step));
  }
  if (facts.on_domain) {
    all["quality"] = o.quality;
    all["nodes"] = std::to_string(b.nodes);
  }
  if (const SolverFacts* solver = facts_of(b.method, b.solver)) {
    const double tolerance = b.tolerance > 0 ? b.tolerance : solver->tolerance;
    all["tolerance"] = fmt::format("{:g}", tolerance);
    all["tolerance_is"] = solver->tolerance_is;
    all["iterations"] = std::to_string(b.iterations > 0 ? b.iterations : solver->iterations);
    all["time_limit_s"] = fmt::format("{:g}", b.time_limit_s);
    if (facts.solvers.size() > 1)
      all["solver"] =
          b.solver == Solver::automatic && !o.resume.empty() ? "as saved" : name_of(solver->solver);
  }
  if (facts.uses_mass) all["mass"] = o.mass;
  return all;
}

}  // namespace skinfield::cli
