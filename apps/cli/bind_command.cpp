#include "bind_arguments.h"
#include "cli.h"
#include "tensor_output.h"

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

bool is_mass_file(const BindArguments& o) { return o.mass != "barycentric" && o.mass != "voronoi"; }

/// Do any of the files given hold rows of one character's vertices?
bool for_one_character(const BindArguments& o) {
  return !o.regions.empty() || !o.paint.empty() || !o.weights_in.empty() || is_mass_file(o) ||
         !o.resume.empty() || !o.save_field.empty() || !o.tensors.empty();
}

/// Weights, paint, masses and locks given as files; they are for a single character.
void read_conditions(const BindArguments& o, const Character& character, BindOptions& options) {
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

/// Options that this shape turned out to have no use for are named.
void warn_of_unused(const BindArguments& o, const BindReport& r) {
  const auto warn_if = [&](bool unused, const char* name, const char* why) {
    if (unused && o.given.contains(name)) warn(fmt::format("{} has no effect: {}", name, why));
  };
  const bool tets = !r.tet_route.empty();
  const bool given = r.tet_route == "given" || r.tet_route == "split";
  warn_if(tets || (r.rung == Rung::surface && r.domain_kind != "field"), "--seed",
          "nothing is random on tetrahedra or triangles");
  for (const char* name : {"--nodes", "--quality"})
    warn_if(given, name, "the input's own tetrahedra are the nodes");
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
                          const BindArguments& o, const std::string& path) {
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

void run(const BindArguments& o, const Common& common) {
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
  if (!o.tensors.empty()) check_tensor_output(o.tensors);
  check_outputs({o.output, o.weights_out, o.report, o.save_field, o.tensors});
  const Progress progress = make_progress(common);
  Asset asset = read_characters(o.input, o.skeleton, o.paint.empty() && o.regions.empty());
  for (const std::string& w : asset.warnings) warn(w);
  const bool matrix = !is_gltf(o.output) || !o.weights_out.empty();
  if (asset.characters.size() > 1 && (matrix || for_one_character(o)))
    throw UsageError(
        o.input + ": the file holds " + std::to_string(asset.characters.size()) +
        " characters, a matrix, regions, paint, masses, fields, tensors or given weights only one "
        "(use "
        "--only MESH)");

  std::vector<SkinWeights> weights, gltf_weights;
  std::vector<BindReport> reports;
  std::vector<std::string> notes;
  std::string field_file, tensor_file;
  for (Character& character : asset.characters) {
    BindOptions options = bind_options(o);
    if (!o.regions.empty()) read_regions(o.regions, character);
    // A field takes an outline as it is; a glTF holds triangles.
    if (!chosen_method(o).on_field || is_gltf(o.output))
      triangulate_outline(character, options.nodes, progress);
    read_conditions(o, character, options);
    if (!o.resume.empty())
      options.resume = std::make_shared<const FieldFile>(read_sfield(o.resume));
    BindResult result = bind_naming_file(o.input, character, options, progress);
    for (const std::string& w : result.report.warnings) warn(w);
    const BindReport& r = result.report;
    warn_of_unused(o, r);
    notes.push_back(summary(character.name.empty() ? o.input : character.name, r, options));
    if (common.verbose)
      for (const auto& [stage, seconds] : r.seconds)
        notes.push_back(fmt::format("  {:24} {:.3f} s", stage, seconds));
    gltf_weights.push_back(is_gltf(o.output) ? gltf_rows(character, result) : SkinWeights{});
    if (result.field) field_file = format_sfield(*result.field);
    if (result.tensors) tensor_file = format_tensors(*result.tensors, o.tensors);
    weights.push_back(std::move(result.weights));
    reports.push_back(std::move(result.report));
  }
  std::vector<OutputFile> files{
      {o.output, format_output(asset, is_gltf(o.output) ? gltf_weights : weights, o, o.output)}};
  if (!o.weights_out.empty())
    files.push_back({o.weights_out, format_output(asset, weights, o, o.weights_out)});
  if (!o.save_field.empty()) files.push_back({o.save_field, field_file});
  if (!o.tensors.empty()) files.push_back({o.tensors, tensor_file});
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
  auto o = std::make_shared<BindArguments>();
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
  add_regions_option(*verb, o->regions);
  verb->add_option("--paint", o->paint, "Prescribed rows: NPZ (index, weights) or CSV");
  verb->add_option("--weights-in", o->weights_in, "Start from these weights");
  verb->add_option("--lock", o->lock, "Keep these handles' weights from --weights-in: GLOB");
  verb->add_option("--boundary", o->boundary, "Of geometric-fields [natural]")
      ->check(CLI::IsMember({"natural", "neumann"}));
  verb->add_option("--visibility", o->visibility,
                   "Of geometric-fields, what blocks sight [counted]: leaving the shape; any "
                   "triangle; nothing")
      ->check(CLI::IsMember({"counted", "any-hit", "none"}));
  verb->add_option("--kernel-width", o->kernel_width, "Of geometric-fields: factor on sigma [1]")
      ->check(number(0.1, 10));
  verb->add_option("--difference-step", o->difference_step,
                   "Of geometric-fields: the difference step h in units of sigma [0.5]")
      ->check(number(0.01, 10));
  verb->add_option("--rows-per-point", o->rows_per_point,
                   "Of geometric-fields --solver convex: rows of the energy a point [12]")
      ->check(number(1, 1000));
  verb->add_option("--samples-per-step", o->samples_per_step,
                   "Of geometric-fields --solver adam and adam-pool: samples a step [2048]")
      ->check(number(1, 1 << 20));
  verb->add_option("--levels", o->levels,
                   "Of geometric-fields: levels from coarse to fine (1: none) [the solver's own]")
      ->check(number(1, 12));
  verb->add_option("--judge-step", o->judge_step,
                   "Also report a geometric field's energy by axis-aligned differences of this "
                   "step (share of the box's largest side), on samples of its own")
      ->check(number(1e-4, 0.1));
  verb->add_option("--save-field", o->save_field, "Save a geometric field: FILE.sfield");
  verb->add_option("--resume", o->resume, "Go on from a saved field; --paint may change");
  verb->add_option("--tensors", o->tensors,
                   "Also write quasi-harmonic's metric: FILE.npz (nodes, elements, direction, "
                   "condition), or FILE.png (condition numbers on a slice)");
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
