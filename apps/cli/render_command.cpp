#include "cli.h"
#include "picturing.h"
#include "posing.h"

#include "skinfield/bind/triangulate.h"
#include "skinfield/render/render.h"
#include "skinfield/weights/statistics.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

namespace skinfield::cli {
namespace {

struct Options {
  std::string input, output, kind = "auto", pose, weights, regions, skinning = "lbs", bone;
  SkeletonOptions skeleton;
  bool bones = false, extrema = false;
  RenderOptions render;
};

/// Linear RGB a face, from the parts' base colours.
Points face_colours(const Character& c) {
  Points colours(c.mesh.F.rows(), 3);
  colours.setConstant(0.6);
  for (const Part& part : c.parts)
    for (int f = part.face_begin; f < part.face_end && f < colours.rows(); ++f)
      colours.row(f) = part.colour.transpose();
  return colours;
}

int find_bone(const Skeleton& skeleton, const std::string& which) {
  const auto& names = skeleton.column_names;
  const auto found = std::find(names.begin(), names.end(), which);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  char* end = nullptr;
  const long index = std::strtol(which.c_str(), &end, 10);
  if (!which.empty() && *end == 0 && index >= 0 && index < skeleton.columns)
    return static_cast<int>(index);
  throw UsageError("--bone " + which +
                   ": the skeleton has no such joint (skinfield inspect lists them)");
}

/// Several characters in one picture: their meshes side by side in one, columns one after another.
struct Scene {
  Points V, colours;
  Triangles F;
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  std::vector<std::string> names;
  SkeletonOverlay overlay;
  std::vector<ExtremumMark> extrema;
};

/// As the report counts them; positions are the scene's vertices, columns the scene's.
void mark_extrema(const SkinWeights& weights, const Mesh& mesh, const Points& V, int first_column,
                  std::vector<ExtremumMark>& marks) {
  for (const Extremum& e : local_extrema(weights, mesh, extremum_tolerance).places)
    marks.push_back({V.row(e.vertex).transpose(), first_column + e.column, e.maximum});
}

void append(const Asset& asset, int index, const Options& o, bool weights_needed, Scene& scene) {
  const Character& c = asset.characters[static_cast<std::size_t>(index)];
  const auto first_vertex = static_cast<std::int32_t>(scene.V.rows());
  const auto first_column = static_cast<std::int32_t>(scene.names.size());
  Points V = c.mesh.V;
  std::vector<Transform> columns;
  SkinWeights weights;
  if (weights_needed) {
    weights = weights_of(asset, index, o.weights);
    if (!o.pose.empty()) {
      columns = pose_transforms(asset, index, o.pose);
      V = deformed(V, weights, columns, o.skinning);
    }
    for (Eigen::Index i = 0; i < weights.W.rows(); ++i)
      for (SparseRows::InnerIterator it(weights.W, i); it; ++it)
        scene.entries.emplace_back(first_vertex + static_cast<std::int32_t>(i),
                                   first_column + it.col(), it.value());
    for (Eigen::Index j = 0; j < weights.W.cols(); ++j)
      scene.names.push_back(static_cast<std::size_t>(j) < weights.names.size()
                                ? weights.names[static_cast<std::size_t>(j)]
                                : std::to_string(j));
  }
  SkeletonOverlay overlay = skeleton_overlay(c.skeleton, columns);
  if (o.pose.empty() || o.pose == "demo" || o.pose == "bind") {
    // These live in bind space; the other poses already stand as the file's world has them.
    const Eigen::Matrix3d R = turn_to_world(asset, index);
    V = (V * R.transpose()).eval();
    for (auto& [head, tail] : overlay.bones) head = R * head, tail = R * tail;
    for (Vec3& dot : overlay.dots) dot = R * dot;
  }
  if (o.extrema) mark_extrema(weights, c.mesh, V, first_column, scene.extrema);
  scene.overlay.bones.insert(scene.overlay.bones.end(), overlay.bones.begin(), overlay.bones.end());
  scene.overlay.dots.insert(scene.overlay.dots.end(), overlay.dots.begin(), overlay.dots.end());
  const Points colours = face_colours(c);
  const Eigen::Index n = scene.V.rows(), f = scene.F.rows();
  scene.V.conservativeResize(n + V.rows(), 3);
  scene.V.bottomRows(V.rows()) = V;
  scene.F.conservativeResize(f + c.mesh.F.rows(), 3);
  scene.F.bottomRows(c.mesh.F.rows()) = (c.mesh.F.array() + first_vertex).matrix();
  scene.colours.conservativeResize(f + c.mesh.F.rows(), 3);
  scene.colours.bottomRows(c.mesh.F.rows()) = colours;
}

void run(Options o, const CLI::App& verb, const Common& common) {
  o.render.progress = make_progress(common);
  Asset asset = read_characters(o.input, o.skeleton, false);
  if (asset.characters.size() > 1 && !o.weights.empty())
    throw UsageError(o.input + ": the file holds several characters (use --only MESH)");
  if (!o.regions.empty()) {
    if (asset.characters.size() > 1)
      throw UsageError(o.input + ": the file holds several characters (use --only MESH)");
    read_regions(o.regions, asset.characters.front());
  }
  for (Character& c : asset.characters) triangulate_outline(c, 0, o.render.progress);
  look_at_plane(verb, asset, o.render.camera);
  std::string kind = o.kind;
  const bool has_weights = !o.weights.empty() || asset.characters.front().weights.has_value();
  if (kind == "auto")
    kind = !o.bone.empty() ? "heat" : !o.pose.empty() ? "posed" : has_weights ? "sheet" : "posed";
  if (o.extrema && kind == "posed")
    throw UsageError(
        "--extrema: a posed picture shows no weights (use --kind heat, dominant or sheet)");
  const bool weights_needed = kind != "posed" || !o.pose.empty();
  Scene scene;
  for (int i = 0; i < static_cast<int>(asset.characters.size()); ++i)
    append(asset, i, o, weights_needed, scene);
  SparseRows W(scene.V.rows(), static_cast<Eigen::Index>(scene.names.size()));
  W.setFromTriplets(scene.entries.begin(), scene.entries.end());
  if (o.bones || kind == "sheet") o.render.skeleton = scene.overlay;
  if (o.extrema) note(common, fmt::format("{} local extrema", scene.extrema.size()));
  o.render.extrema = std::move(scene.extrema);

  Image image;
  if (kind == "heat") {
    const int bone = find_bone(asset.characters.front().skeleton, o.bone.empty() ? "0" : o.bone);
    if (o.render.caption.empty()) o.render.caption = scene.names[static_cast<std::size_t>(bone)];
    const Vector weight = W.col(bone);
    std::erase_if(o.render.extrema, [bone](const ExtremumMark& m) { return m.column != bone; });
    image = render_heat_map(scene.V, scene.F, weight, o.render);
  } else if (kind == "dominant") {
    image = render_dominant(scene.V, scene.F, W, o.render);
  } else if (kind == "sheet") {
    image = render_contact_sheet(scene.V, scene.F, W, scene.names, o.render);
  } else {
    image = render_posed(scene.V, scene.F, scene.colours, o.render);
  }
  write_png(o.output, image);
}

}  // namespace

void add_render(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "render", "Draw weights or a pose as a PNG",
                            "skinfield render hero-bound.glb --pose demo -o hero.png");
  verb->add_option("input", o->input, "A character; with --weights any mesh")->required();
  verb->add_option("-o,--output", o->output, "Picture: .png")->required();
  verb->add_option("--kind", o->kind,
                   "heat: one bone; dominant: colours by bone; sheet: all bones; posed: shaded")
      ->check(CLI::IsMember({"auto", "heat", "dominant", "sheet", "posed"}))
      ->capture_default_str();
  verb->add_option("--bone", o->bone, "Joint name or column of the heat map");
  verb->add_option("--pose", o->pose,
                   "demo, bind, rest, FILE.json, FILE.dmat, or ANIMATION@SECONDS");
  verb->add_option("--skinning", o->skinning, "Linear blend or dual quaternions")
      ->check(CLI::IsMember({"lbs", "dqs"}))
      ->capture_default_str();
  verb->add_option("--weights", o->weights, "Weight matrix, if the file has none");
  add_regions_option(*verb, o->regions);
  verb->add_flag("--bones", o->bones, "Draw the skeleton");
  verb->add_flag(
      "--extrema", o->extrema,
      "Mark spurious local extrema of the weights: maxima light, minima dark, rings where "
      "the body hides them");
  add_picture_options(*verb, o->render);
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o, verb, &common] {
    if (!std::string_view(o->output).ends_with(".png"))
      throw UsageError(o->output + ": pictures are written as .png");
    check_outputs({o->output});
    run(*o, *verb, common);
  });
}

}  // namespace skinfield::cli
