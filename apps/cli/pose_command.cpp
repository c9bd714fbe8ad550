#include "cli.h"
#include "posing.h"

#include "skinfield/bind/triangulate.h"
#include "skinfield/io/file.h"
#include "skinfield/io/mesh_file.h"

namespace skinfield::cli {
namespace {

struct Options {
  std::string input, output, pose = "demo", weights, skinning = "lbs";
  SkeletonOptions skeleton;
};

void run(const Options& o) {
  const std::string extension = lower_extension(o.output);
  if (extension != ".obj" && extension != ".ply" && extension != ".off")
    throw UsageError(o.output + ": posed meshes are written as .obj, .ply or .off");
  check_outputs({o.output});
  Asset asset = read_characters(o.input, o.skeleton);
  if (asset.characters.size() > 1)
    throw UsageError(o.input + ": the file holds several characters (use --only MESH)");
  triangulate_outline(asset.characters.front(), 0);
  const Character& c = asset.characters.front();
  const SkinWeights weights = weights_of(asset, 0, o.weights);
  const Points V = deformed(c.mesh.V, weights, pose_transforms(asset, 0, o.pose), o.skinning);
  write_mesh(o.output, V, c.mesh.F);
}

}  // namespace

void add_pose(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "pose", "Write the mesh in a pose",
                            "skinfield pose hero-bound.glb --pose Walk@0.5 -o walk.obj");
  verb->add_option("input", o->input, "A rigged character, or a mesh with --skeleton and --weights")
      ->required();
  verb->add_option("-o,--output", o->output, "Posed mesh: .obj, .ply or .off")->required();
  verb->add_option("--pose", o->pose,
                   "demo, bind, rest, FILE.json, FILE.dmat, or ANIMATION@SECONDS")
      ->capture_default_str();
  verb->add_option("--weights", o->weights, "Weight matrix, if the file has none");
  verb->add_option("--skinning", o->skinning, "Linear blend or dual quaternions")
      ->check(CLI::IsMember({"lbs", "dqs"}))
      ->capture_default_str();
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o] { run(*o); });
}

}  // namespace skinfield::cli
