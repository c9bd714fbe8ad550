#include "cli.h"

#include "skinfield/bind/bind.h"
#include "skinfield/bind/handles.h"
#include "skinfield/bind/triangulate.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/weights_file.h"

#include <fmt/core.h>

namespace skinfield::cli {
namespace {

struct Options {
  std::string source, target, output, quality = "normal";
  SkeletonOptions skeleton;
  int nodes = 0, max_influences = -1;
  std::uint64_t seed = 0;
};

void run(const Options& o, const Common& common) {
  const std::string extension = lower_extension(o.output);
  const bool gltf = extension == ".glb" || extension == ".gltf";
  if (!gltf && !is_weights_extension(extension))
    throw UsageError(o.output +
                     ": unknown output format (use .glb, .gltf, .npz, .npy, .dmat or .csv)");
  check_outputs({o.output});
  const Progress progress = make_progress(common);
  const Asset source = read_characters(o.source, o.skeleton);
  SkeletonOptions bare = o.skeleton;
  bare.skeleton.clear();
  bare.only.clear();
  Asset target = read_characters(o.target, bare, false);
  if (source.characters.size() != 1 || target.characters.size() != 1)
    throw UsageError("transfer takes files of one character each (use --only MESH for the source)");
  BindOptions options;
  options.nodes = o.nodes > 0            ? o.nodes
                  : o.quality == "draft" ? 2000
                  : o.quality == "high"  ? 64000
                                         : 16000;
  options.seed = o.seed;
  options.max_influences = o.max_influences >= 0 ? o.max_influences : gltf ? 4 : 0;
  options.prune = gltf ? 1e-4 : 0;
  const BindResult bound = bind(source.characters.front(), options, progress);
  for (const std::string& w : bound.report.warnings) warn(w);
  Character& character = target.characters.front();
  give_skeleton(character, source.characters.front().skeleton);
  if (gltf) {
    triangulate_outline(character, options.nodes, progress);
    count_inner_vertices(character);
  }
  std::map<std::string, std::int64_t> filled;
  const std::vector<SkinWeights> weights{transfer(*bound.solved, character, &filled)};
  progress.check();
  if (gltf)
    write_gltf(target, weights, o.output);
  else
    write_weights(o.output, weights.front());
  for (const auto& [cause, count] : filled)
    note(common, fmt::format("{} vertices filled: {}", count, cause));
}

}  // namespace

void add_transfer(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "transfer",
                            "Bind one mesh, and give its weights to another of the same character",
                            "skinfield transfer hero.glb hero-lod2.obj -o hero-lod2.glb");
  verb->add_option("source", o->source, "The character that is bound")->required();
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
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o, &common] { run(*o, common); });
}

}  // namespace skinfield::cli
