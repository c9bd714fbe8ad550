#include "cli.h"

#include "skinfield/base/parallel.h"
#include "skinfield/bind/bind.h"
#include "skinfield/bind/handles.h"
#include "skinfield/bind/report.h"
#include "skinfield/bind/triangulate.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/sfield.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/weights/statistics.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <set>

namespace skinfield::cli {
namespace {

struct Options {
  std::string source, target, output, report, quality = "normal";
  SkeletonOptions skeleton;
  int nodes = 0, max_influences = -1;
  std::uint64_t seed = 0;
  std::set<std::string> given;  ///< names of the options on the command line
};

BindOptions bind_options(const Options& o, bool gltf) {
  BindOptions options;
  options.nodes = o.nodes > 0            ? o.nodes
                  : o.quality == "draft" ? 2000
                  : o.quality == "high"  ? 64000
                                         : 16000;
  options.seed = o.seed;
  options.max_influences = o.max_influences >= 0 ? o.max_influences : gltf ? 4 : 0;
  options.prune = gltf ? 1e-4 : 0;
  return options;
}

/// What gives the weights away, and the skeleton that goes with them.
struct Source {
  std::shared_ptr<const SolvedDomain> solved;
  Skeleton skeleton;
};

Source read_field(const Options& o, const BindOptions& options, const Progress& progress) {
  for (const char* name : {"--skeleton", "--joints", "--exclude", "--leaf", "--only", "--quality",
                           "--nodes", "--seed"})
    if (o.given.contains(name))
      throw UsageError(fmt::format("{}: {} brings its own (leave it out)", name, o.source));
  const FieldFile file = read_sfield(o.source);
  try {
    return {solved_field(file, options, progress), file.skeleton};
  } catch (const InputError& error) {
    throw InputError(error.message(), o.source, "save the field again");
  }
}

Source bind_source(const Options& o, const BindOptions& options, const Progress& progress) {
  const Asset asset = read_characters(o.source, o.skeleton);
  if (asset.characters.size() != 1)
    throw UsageError("transfer takes files of one character each (use --only MESH for the source)");
  const BindResult bound = bind(asset.characters.front(), options, progress);
  for (const std::string& w : bound.report.warnings) warn(w);
  return {bound.solved, asset.characters.front().skeleton};
}

/// How the rows came about and what they are, with the names of the bind report.
std::string transfer_report(const Options& o, const SkinWeights& weights,
                            const std::map<std::string, std::int64_t>& filled,
                            const std::map<std::string, std::int64_t>& evaluated, double seconds,
                            double cpu_seconds) {
  using Json = nlohmann::ordered_json;
  const WeightStatistics s = weight_statistics(weights);
  Json histogram = Json::object();
  for (std::size_t k = 0; k < s.influences.size(); ++k)
    if (s.influences[k] > 0) histogram[std::to_string(k)] = s.influences[k];
  const Json json{{"schema", 1},
                  {"source", o.source},
                  {"target", o.target},
                  {"output", o.output},
                  {"vertices", weights.W.rows()},
                  {"handles", weights.W.cols()},
                  {"vertices_filled", filled},
                  {"field_vertices", evaluated},
                  {"weights",
                   {{"rows", weights.W.rows()},
                    {"row_sum_error", s.row_sum_error},
                    {"negative", s.negative},
                    {"non_finite", s.non_finite},
                    {"empty_rows", s.empty_rows},
                    {"influences", histogram}}},
                  {"threads", thread_count()},
                  {"total_s", seconds},
                  {"total_cpu_s", cpu_seconds},
                  {"peak_memory_bytes", peak_memory_bytes()}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void run(const Options& o, const Common& common) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = process_cpu_seconds();
  const std::string extension = lower_extension(o.output);
  const bool gltf = extension == ".glb" || extension == ".gltf";
  if (!gltf && !is_weights_extension(extension))
    throw UsageError(o.output +
                     ": unknown output format (use .glb, .gltf, .npz, .npy, .dmat or .csv)");
  check_outputs({o.output, o.report});
  const Progress progress = make_progress(common);
  SkeletonOptions bare = o.skeleton;
  bare.skeleton.clear();
  bare.only.clear();
  Asset target = read_characters(o.target, bare, false);
  if (target.characters.size() != 1)
    throw UsageError(o.target + ": transfer takes files of one character each");
  const BindOptions options = bind_options(o, gltf);
  const Source source = lower_extension(o.source) == ".sfield" ? read_field(o, options, progress)
                                                               : bind_source(o, options, progress);
  Character& character = target.characters.front();
  give_skeleton(character, source.skeleton);
  if (gltf) {
    triangulate_outline(character, options.nodes, progress);
    count_inner_vertices(character);
  }
  std::map<std::string, std::int64_t> filled, evaluated;
  const std::vector<SkinWeights> weights{transfer(*source.solved, character, &filled, &evaluated)};
  std::filesystem::path folder = std::filesystem::path(o.output).parent_path();
  if (folder.empty()) folder = ".";
  std::vector<OutputFile> files{
      {o.output, gltf ? format_gltf(target, weights, extension == ".glb", {}, folder)
                      : format_weights(weights.front(), extension)}};
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const std::string json = transfer_report(o, weights.front(), filled, evaluated, taken.count(),
                                           process_cpu_seconds() - cpu);
  if (!o.report.empty()) files.push_back({o.report, json});
  progress.check();
  write_files_atomically(files);
  for (const auto& [cause, count] : filled)
    note(common, fmt::format("{} vertices filled: {}", count, cause));
  for (const auto& [way, count] : evaluated)
    note(common, fmt::format("{} vertices evaluated: {}", count, way));
  if (common.json) fmt::print("{}", json);
}

}  // namespace

void add_transfer(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(
      app, common, "transfer",
      "Give weights to another mesh of a character that is bound here, or saved as a field",
      "skinfield transfer hero.glb hero-lod2.obj -o hero-lod2.glb");
  verb->add_option("source", o->source,
                   "The character that is bound, or its geometric field as bind --save-field "
                   "writes it (.sfield)")
      ->required();
  verb->add_option("target", o->target, "Level of detail, or clothes, in the same place and units")
      ->required();
  verb->add_option("-o,--output", o->output, "Rigged .glb/.gltf, or weights .npz .npy .dmat .csv")
      ->required();
  verb->add_option("--quality", o->quality, "2000, 16000 or 64000 nodes")
      ->check(CLI::IsMember({"draft", "normal", "high"}))
      ->capture_default_str();
  verb->add_option("--nodes", o->nodes, "Nodes, instead of --quality")
      ->check(CLI::Range(50, 4000000));
  verb->add_option("--max-influences", o->max_influences,
                   "Influences a vertex (0: all) [4 for glTF, 0 for matrices]")
      ->check(number(0, 100000));
  verb->add_option("--seed", o->seed, "Seed of the random numbers")
      ->check(number(0, 1e18))
      ->capture_default_str();
  verb->add_option("--report", o->report, "Write the report, how the rows came about: FILE.json");
  verb->add_flag("--json", common.json, "Print the report to stdout");
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o, verb, &common] {
    for (const CLI::Option* option : verb->get_options())
      if (option->count() > 0) o->given.insert(option->get_name());
    run(*o, common);
  });
}

}  // namespace skinfield::cli
