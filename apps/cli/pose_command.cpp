#include "cli.h"
#include "posing.h"

#include "skinfield/bind/triangulate.h"
#include "skinfield/geometry/plane.h"
#include "skinfield/io/file.h"
#include "skinfield/io/mesh_file.h"
#include "skinfield/render/image_warp.h"

namespace skinfield::cli {
namespace {

struct Options {
  std::string input, output, pose = "demo", weights, regions, skinning = "lbs", image;
  std::vector<double> image_box;  ///< left, bottom, right, top; empty: the mesh's own
  SkeletonOptions skeleton;
};

void check_output(const Options& o) {
  const std::string extension = lower_extension(o.output);
  const bool mesh = extension == ".obj" || extension == ".ply" || extension == ".off";
  if (!o.image.empty() && extension != ".png")
    throw UsageError(o.output + ": a warped --image is written as .png");
  if (o.image.empty() && extension == ".png")
    throw UsageError(o.output + ": a picture needs --image FILE.png to warp (or use render)");
  if (!mesh && extension != ".png")
    throw UsageError(o.output + ": posed meshes are written as .obj, .ply or .off");
  if (o.image.empty() && !o.image_box.empty())
    throw UsageError("--image-box says where an --image lies (give one)");
  if (!o.image_box.empty() && !(o.image_box[0] < o.image_box[2] && o.image_box[1] < o.image_box[3]))
    throw UsageError("--image-box: left and bottom have to be less than right and top");
  check_outputs({o.output});
}

/// The picture that lies on a flat mesh, moved with it.
Image warped(const Options& o, const Mesh& mesh, const Points& posed) {
  const Image image = decode_png(read_file(o.image), o.image);
  const auto plane = plane_of(mesh.V, 1e-6 * diagonal(bounding_box(mesh.V)));
  if (!plane)
    throw InputError("the mesh is not flat", o.input, "an image can be warped by flat meshes only");
  if (mesh.F.rows() == 0)
    throw InputError("the mesh has no triangles", o.input, "an image needs some to lie on");
  // In the file's own units, so that x and y stay what they are.
  Eigen::Matrix<double, 3, 2> axes;
  axes << plane->u, plane->v;
  const PlanarPoints rest = mesh.V * axes;
  ImageFrame frame = frame_around(rest);
  if (!o.image_box.empty())
    frame = {{o.image_box[0], o.image_box[1]}, {o.image_box[2], o.image_box[3]}};
  return warp_image(image, frame, rest, posed * axes, mesh.F);
}

void run(const Options& o) {
  check_output(o);
  Asset asset = read_characters(o.input, o.skeleton, false);
  if (asset.characters.size() > 1)
    throw UsageError(o.input + ": the file holds several characters (use --only MESH)");
  if (!o.regions.empty()) read_regions(o.regions, asset.characters.front());
  triangulate_outline(asset.characters.front(), 0);
  const Character& c = asset.characters.front();
  const SkinWeights weights = weights_of(asset, 0, o.weights);
  const Points V = deformed(c.mesh.V, weights, pose_transforms(asset, 0, o.pose), o.skinning);
  if (o.image.empty())
    write_mesh(o.output, V, c.mesh.F);
  else
    write_png(o.output, warped(o, c.mesh, V));
}

}  // namespace

void add_pose(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "pose", "Write the mesh, or an image on it, in a pose",
                            "skinfield pose hero-bound.glb --pose Walk@0.5 -o walk.obj");
  verb->add_option("input", o->input, "A rigged character, or a mesh with --skeleton and --weights")
      ->required();
  verb->add_option("-o,--output", o->output, "Posed mesh: .obj, .ply or .off; with --image .png")
      ->required();
  verb->add_option("--pose", o->pose,
                   "demo, bind, rest, FILE.json, FILE.dmat, or ANIMATION@SECONDS")
      ->capture_default_str();
  verb->add_option("--weights", o->weights, "Weight matrix, if the file has none");
  verb->add_option("--image", o->image,
                   "A PNG that lies on a flat mesh and moves with it, pixels keep their size");
  verb->add_option("--image-box", o->image_box,
                   "Where it lies: left bottom right top, in the mesh's units [the mesh's own box]")
      ->expected(4)
      ->check(number(-1e12, 1e12));
  add_regions_option(*verb, o->regions);
  verb->add_option("--skinning", o->skinning, "Linear blend or dual quaternions")
      ->check(CLI::IsMember({"lbs", "dqs"}))
      ->capture_default_str();
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o] { run(*o); });
}

}  // namespace skinfield::cli
