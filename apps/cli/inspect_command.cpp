#include "cli.h"

#include "skinfield/geometry/diagnosis.h"
#include "skinfield/io/gltf_animation.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace skinfield::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string input;
  SkeletonOptions skeleton;
};

Json character_json(const Character& c, const Progress& progress) {
  const Diagnosis d = diagnose(c.mesh, {}, progress);
  Json json{{"name", c.name},
            {"input_vertices", c.vertex_of_input.size()},
            {"merged_vertices", d.vertices},
            {"faces", d.faces},
            {"outline_segments", c.mesh.outline.E.rows()},
            {"tets", d.tets},
            {"components", d.components},
            {"boundary_edges", d.boundary_edges},
            {"nonmanifold_edges", d.nonmanifold_edges},
            {"inconsistent_edges", d.inconsistent_edges},
            {"degenerate_faces", d.degenerate_faces},
            {"duplicate_faces", d.duplicate_faces},
            {"self_intersections_sampled", d.intersecting_pairs_sampled},
            {"watertight", d.watertight},
            {"planar", d.planar},
            {"box_diagonal", diagonal(d.box)},
            {"weights", c.weights.has_value()},
            {"non_finite_weight_rows", c.non_finite_weight_rows}};
  json["parts"] = Json::array();
  for (const Part& part : c.parts)
    json["parts"].push_back({{"name", part.name}, {"vertices", part.end - part.begin}});
  json["joints"] = Json::array();
  const Skeleton& s = c.skeleton;
  for (int j = 0; j < static_cast<int>(s.joints.size()); ++j) {
    const Joint& joint = s.joints[static_cast<std::size_t>(j)];
    const bool left_out = std::find(s.left_out.begin(), s.left_out.end(), j) != s.left_out.end();
    json["joints"].push_back(
        {{"name", joint.name}, {"parent", joint.parent}, {"deforms", !left_out}});
  }
  json["handles"] = Json::array();
  for (std::size_t h = 0; h < s.handles.size(); ++h)
    json["handles"].push_back(
        {{"name", s.handles[h].name},
         {"column", s.column[h]},
         {"kind", s.handles[h].kind == Handle::Kind::bone ? "bone" : "point"}});
  return json;
}

void print_text(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_array()) {
      fmt::print("{:28} {}\n", key, value.size());
      for (const Json& entry : value) fmt::print("    {}\n", entry.dump());
    } else {
      fmt::print("{:28} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

void run(const Options& o, const Common& common) {
  const Progress progress = make_progress(common);
  const Asset asset = read_characters(o.input, o.skeleton, false);
  for (const std::string& w : asset.warnings) warn(w);
  Json json{{"file", o.input}, {"characters", Json::array()}, {"animations", Json::array()}};
  for (const Character& c : asset.characters)
    json["characters"].push_back(character_json(c, progress));
  for (const GltfAnimation& a : gltf_animations(asset))
    json["animations"].push_back({{"name", a.name}, {"begin_s", a.begin}, {"end_s", a.end}});
  if (common.json) {
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
    return;
  }
  for (const Json& c : json["characters"]) print_text(c);
  for (const Json& a : json["animations"]) fmt::print("animation {}\n", a.dump());
}

}  // namespace

void add_inspect(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "inspect", "Say what a file holds and how sound it is",
                            "skinfield inspect hero.glb");
  verb->add_option("input", o->input, "Character: glTF, GLB, OBJ, PLY, OFF, STL, SVG, .mesh, .msh")
      ->required();
  verb->add_flag("--json", common.json, "Print JSON");
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o, &common] { run(*o, common); });
}

}  // namespace skinfield::cli
