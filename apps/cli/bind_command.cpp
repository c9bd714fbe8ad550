#include "cli.h"

#include "skinfield/base/parallel.h"
#include "skinfield/bind/bind.h"
#include "skinfield/bind/handles.h"
#include "skinfield/bind/report.h"
#include "skinfield/bind/triangulate.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/matrix_file.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/rig/glob.h"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <set>

namespace skinfield::cli {
namespace {

struct Options {
  std::string input, output, method = "auto", solver = "auto", domain = "auto";
  std::string mass = "barycentric";
  std::string quality = "normal", symmetry = "off";
  std::string paint, weights_in, lock, report, weights_out, boundary, save_field, resume;
  SkeletonOptions skeleton;
  int nodes = 0, iterations = 0, max_influences = -1;
  double tolerance = 0, time_limit = 0, prune = -1;
  std::uint64_t seed = 0;
  std::set<std::string> given;  ///< names of the options on the command line
};

bool is_gltf(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".glb" || extension == ".gltf";
}

void check_output(const std::string& path) {
  static const std::set<std::string> known{".glb", ".gltf", ".npz", ".npy", ".dmat", ".csv"};
  if (!known.contains(lower_extension(path)))
    throw UsageError(path + ": unknown output format (use .glb, .gltf, .npz, .npy, .dmat or .csv)");
}

const MethodFacts& chosen_method(const Options& o) {
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
  return "When to stop: primal, coupled, decoupled [1e-3]: no weight changes by more; dual [1e-4] "
         "and "
         "active-set [1e-9]: the certified gap; quasi-harmonic [1e-4]: a round saves less; convex "
         "[1e-2]: no weight changes by more in five passes";
}

/// Options that the method has no use for are refused, not ignored.
void check_method_options(const Options& o) {
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
  refuse(o.resume.empty(), {"--nodes", "--quality", "--seed"}, "takes them from --resume");
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

BindOptions bind_options(const Options& o) {
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
  options.keep_field = !o.save_field.empty();
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

std::map<std::string, std::string> described(const Options& o, const BindOptions& b) {
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
                                         {"paint", o.paint},
                                         {"weights_in", o.weights_in},
                                         {"lock", o.lock}};
  const MethodFacts& facts = facts_of(b.method);
  if (facts.on_field) {
    all["boundary"] = !o.boundary.empty() ? o.boundary : o.resume.empty() ? "natural" : "as saved";
    all["resume"] = o.resume;
    all["points"] = std::to_string(b.field_points);
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

bool is_mass_file(const Options& o) { return o.mass != "barycentric" && o.mass != "voronoi"; }

/// Do any of the files given hold rows of one character's vertices?
bool for_one_character(const Options& o) {
  return !o.paint.empty() || !o.weights_in.empty() || is_mass_file(o) || !o.resume.empty() ||
         !o.save_field.empty();
}

/// Weights, paint, masses and locks given as files; they are for a single character.
void read_conditions(const Options& o, const Character& character, BindOptions& options) {
  const auto vertices = static_cast<Eigen::Index>(character.vertex_of_input.size());
  const Eigen::Index columns = character.skeleton.columns;
  if (!o.paint.empty()) {
    const PaintFile file = read_paint(o.paint, vertices);
    if (columns > 0 && file.weights.cols() != columns)
      throw InputError(fmt::format("has {} columns of weights, the skeleton {} handles",
                                   file.weights.cols(), columns),
                       o.paint, "give one column a handle, in the skeleton's order");
    options.paint = Paint{file.index, file.weights};
  }
  if (!o.weights_in.empty()) {
    options.start = read_weights(o.weights_in);
    const SparseRows& W = options.start->W;
    if (W.rows() != vertices || (columns > 0 && W.cols() != columns))
      throw InputError(fmt::format("holds {} x {} weights, the character has {} vertices and {} "
                                   "handles",
                                   W.rows(), W.cols(), vertices, columns),
                       o.weights_in, "give the weights of this very file");
  }
  if (is_mass_file(o)) options.masses = read_vector(o.mass);
  if (o.lock.empty()) return;
  const auto& names = character.skeleton.column_names;
  for (std::size_t c = 0; c < names.size(); ++c)
    if (glob_match(o.lock, names[c])) options.locked_columns.push_back(static_cast<int>(c));
  if (options.locked_columns.empty())
    throw UsageError("--lock " + o.lock + ": no handle has such a name");
}

/// Errors of the library name the character; the user knows it by its file.
BindResult bind_naming_file(const std::string& path, const Character& character,
                            const BindOptions& options, const Progress& progress) {
  try {
    return bind(character, options, progress);
  } catch (const OptionError& error) {
    throw UsageError(fmt::format("{}: {} ({})", path, error.message(), error.remedy()));
  } catch (const InputError& error) {
    throw InputError(error.message(), error.where().empty() ? path : path + ": " + error.where(),
                     error.remedy());
  } catch (const DomainError& error) {
    throw DomainError(error.message(), error.where().empty() ? path : path + ": " + error.where(),
                      error.remedy());
  }
}

/// One line about a character that was bound.
std::string summary(const std::string& name, const BindReport& r, const BindOptions& options) {
  const MethodFacts& facts = facts_of(options.method);
  std::string quality = std::string(facts.name);
  // Where nothing is certified the gap is all of the energy.
  if (facts.iterates() && std::isfinite(r.solve.kkt_residual) && r.solve.relative_gap < 1)
    quality = fmt::format("largest change {:.1e}, certified gap {:.1e}", r.solve.largest_change,
                          r.solve.relative_gap);
  else if (!facts.iterates())
    quality += fmt::format(", clamped mass {:.1e} on average, {:.1e} at most", r.clamped_mass_mean,
                           r.clamped_mass_max);
  return fmt::format("{}: {} vertices, {} handles, {} on {} nodes; {}", name, r.rows, r.handles,
                     name_of(r.rung), r.nodes, quality);
}

/// Weights for a glTF, whose triangles need those of an outline's inner vertices too.
SkinWeights gltf_rows(Character& character, const BindResult& result) {
  if (character.mesh.outline.empty()) return result.weights;
  count_inner_vertices(character);
  return transfer(*result.solved, character);
}

std::string format_output(const Asset& asset, const std::vector<SkinWeights>& weights,
                          const Options& o, const std::string& path) {
  if (!is_gltf(path)) return format_weights(weights.front(), lower_extension(path));
  const bool binary = lower_extension(path) == ".glb";
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  if (o.skeleton.only.empty() || !is_gltf(o.input))
    return format_gltf(asset, weights, binary, {}, folder);
  // A glTF travels whole; what --only leaves out stays as it is.
  SkeletonOptions everything = o.skeleton;
  everything.only.clear();
  const Asset whole = read_characters(o.input, everything, false);
  return format_gltf(whole, weights_among_others(whole, o.skeleton.only, weights), binary, {},
                     folder);
}

void run(const Options& o, const Common& common) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = process_cpu_seconds();
  check_method_options(o);
  check_output(o.output);
  if (!o.weights_out.empty()) {
    check_output(o.weights_out);
    if (is_gltf(o.weights_out))
      throw UsageError(o.weights_out + ": --weights writes .npz, .npy, .dmat or .csv");
  }
  if (!o.lock.empty() && o.weights_in.empty())
    throw UsageError("--lock needs --weights-in FILE, whose columns it keeps");
  if (!o.save_field.empty() && lower_extension(o.save_field) != ".sfield")
    throw UsageError(o.save_field + ": --save-field writes .sfield");
  check_outputs({o.output, o.weights_out, o.report, o.save_field});
  const Progress progress = make_progress(common);
  Asset asset = read_characters(o.input, o.skeleton, o.paint.empty());
  for (const std::string& w : asset.warnings) warn(w);
  const bool matrix = !is_gltf(o.output) || !o.weights_out.empty();
  if (asset.characters.size() > 1 && (matrix || for_one_character(o)))
    throw UsageError(
        o.input + ": the file holds " + std::to_string(asset.characters.size()) +
        " characters, a matrix, paint, masses, fields or given weights only one (use --only "
        "MESH)");

  std::vector<SkinWeights> weights, gltf_weights;
  std::vector<BindReport> reports;
  std::vector<std::string> notes;
  std::string field_file;
  for (Character& character : asset.characters) {
    BindOptions options = bind_options(o);
    triangulate_outline(character, options.nodes, progress);
    read_conditions(o, character, options);
    if (!o.resume.empty())
      options.resume = std::make_shared<const FieldFile>(read_sfield(o.resume));
    BindResult result = bind_naming_file(o.input, character, options, progress);
    for (const std::string& w : result.report.warnings) warn(w);
    const BindReport& r = result.report;
    notes.push_back(summary(character.name.empty() ? o.input : character.name, r, options));
    if (common.verbose)
      for (const auto& [stage, seconds] : r.seconds)
        notes.push_back(fmt::format("  {:24} {:.3f} s", stage, seconds));
    gltf_weights.push_back(is_gltf(o.output) ? gltf_rows(character, result) : SkinWeights{});
    if (result.field) field_file = format_sfield(*result.field);
    weights.push_back(std::move(result.weights));
    reports.push_back(std::move(result.report));
  }
  std::vector<OutputFile> files{
      {o.output, format_output(asset, is_gltf(o.output) ? gltf_weights : weights, o, o.output)}};
  if (!o.weights_out.empty())
    files.push_back({o.weights_out, format_output(asset, weights, o, o.weights_out)});
  if (!o.save_field.empty()) files.push_back({o.save_field, field_file});
  ReportContext context;
  context.input_path = o.input;
  context.output_path = o.output;
  context.method = chosen_method(o).method;
  context.profile = link_profile();
  context.threads = thread_count();
  context.options = described(o, bind_options(o));
  context.seed = o.seed;
  context.peak_memory_bytes = peak_memory_bytes();
  context.total_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  context.total_cpu_s = process_cpu_seconds() - cpu;
  const std::string json = report_json(reports, context);
  if (!o.report.empty()) files.push_back({o.report, json});
  progress.check();
  write_files_atomically(files);
  for (const std::string& line : notes) note(common, line);
  if (common.json) fmt::print("{}", json);
}

}  // namespace

void add_bind(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "bind", "Compute skinning weights for a character",
                            "skinfield bind hero.glb -o hero-bound.glb");
  verb->add_option("input", o->input, "Character: glTF, GLB, OBJ, PLY, OFF, STL, SVG, .mesh, .msh")
      ->required();
  verb->add_option("-o,--output", o->output, "Rigged .glb/.gltf, or weights .npz .npy .dmat .csv")
      ->required();
  o->skeleton.add_to(*verb);
  verb->add_option("--method", o->method, method_help())
      ->check(CLI::IsMember(method_names()))
      ->capture_default_str();
  verb->add_option("--solver", o->solver, solver_help())
      ->check(CLI::IsMember(solver_names()))
      ->capture_default_str();
  verb->add_option("--domain", o->domain,
                   "points: inside the shape; tets: tetrahedra in it; tris: on its triangles "
                   "(flat shapes always)")
      ->check(CLI::IsMember({"auto", "points", "tets", "tris"}))
      ->capture_default_str();
  verb->add_option("--quality", o->quality, "2000, 16000 or 64000 nodes")
      ->check(CLI::IsMember({"draft", "normal", "high"}))
      ->capture_default_str();
  verb->add_option("--nodes", o->nodes, "Nodes, instead of --quality")->check(number(50, 4000000));
  verb->add_option("--tolerance", o->tolerance, tolerance_help())->check(number(1e-12, 1));
  verb->add_option("--iterations", o->iterations, "At most so many iterations [the solver's own]")
      ->check(number(1, 1000000));
  verb->add_option("--time-limit", o->time_limit, "Seconds for the solve (0: no limit)")
      ->check(number(0, 1e9))
      ->capture_default_str();
  verb->add_option("--mass", o->mass,
                   "Masses on surfaces: barycentric, voronoi, or FILE (.npy .mtx .dmat) with one a "
                   "vertex")
      ->capture_default_str();
  verb->add_option("--seed", o->seed, "Seed of the random numbers")
      ->check(number(0, 1e18))
      ->capture_default_str();
  verb->add_option("--paint", o->paint, "Prescribed rows: NPZ (index, weights) or CSV");
  verb->add_option("--weights-in", o->weights_in, "Start from these weights");
  verb->add_option("--lock", o->lock, "Keep these handles' weights from --weights-in: GLOB");
  verb->add_option("--boundary", o->boundary, "Of geometric-fields [natural]")
      ->check(CLI::IsMember({"natural", "neumann"}));
  verb->add_option("--save-field", o->save_field, "Save a geometric field: FILE.sfield");
  verb->add_option("--resume", o->resume, "Go on from a saved field; --paint may change");
  verb->add_option("--max-influences", o->max_influences,
                   "Influences a vertex (0: all) [4 for glTF, 0 for matrices]")
      ->check(number(0, 100000));
  verb->add_option("--prune", o->prune, "Drop smaller weights [1e-4 for glTF, 0 for matrices]")
      ->check(number(0, 1));
  verb->add_option("--symmetry", o->symmetry, "Make the weights mirror-symmetric in x")
      ->check(CLI::IsMember({"off", "x", "auto"}))
      ->capture_default_str();
  verb->add_option("--report", o->report, "Write the report: FILE.json");
  verb->add_flag("--json", common.json, "Print the report to stdout");
  verb->add_option("--weights", o->weights_out, "Also write the weight matrix");
  verbs.emplace_back(verb, [o, verb, &common] {
    for (const CLI::Option* option : verb->get_options())
      if (option->count() > 0) o->given.insert(option->get_name());
    run(*o, common);
  });
}

}  // namespace skinfield::cli
