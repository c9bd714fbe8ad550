#include "cli.h"

#include "skinfield/domain/tet_domain.h"
#include "skinfield/domain/tetrahedraliser.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gmsh.h"
#include "skinfield/io/medit.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <chrono>

namespace skinfield::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string input, output, quality = "normal";
  SkeletonOptions skeleton;
  int nodes = 0;
};

struct Tets {
  Points V;  ///< file units
  Tetrahedra T;
  TetRoute route = TetRoute::given;
  int handle_vertices = 0;
  std::vector<int> handles_outside;
  double alpha = 0, surface_volume = 0;  ///< file units
  std::string why_not_direct;
};

/// The mesh that `bind --domain tets` solves on.
Tets make_tets(const Character& character, int nodes, const Progress& progress) {
  const UnitBox box = unit_box(character.mesh.V);
  Mesh mesh = character.mesh;
  mesh.V = box.to(mesh.V);
  std::vector<Handle> handles = character.skeleton.handles;
  for (Handle& handle : handles) {
    handle.point = box.to(handle.point);
    for (auto& [a, b] : handle.segments) {
      a = box.to(a);
      b = box.to(b);
    }
  }
  Tets tets;
  Tetrahedralisation made;
  if (mesh.T.rows() > 0) {
    made.V = mesh.V;
    made.T = mesh.T;
    made.route = TetRoute::given;
  } else {
    TetrahedraliserOptions options;
    options.nodes = nodes;
    made = tetrahedralise(mesh, handles, options, progress);
  }
  tets.route = made.route;
  tets.why_not_direct = made.why_not_direct;
  tets.alpha = made.alpha / box.scale;
  tets.surface_volume = made.surface_volume / (box.scale * box.scale * box.scale);
  tets.T = made.T;
  if (!handles.empty()) {
    const TetDomain domain(made.V, made.T, handles);
    if (domain.facts().new_nodes > 0) {
      made.V = domain.nodes();
      tets.T = domain.elements();
      if (made.route == TetRoute::given) tets.route = TetRoute::split;
    }
    tets.handle_vertices = domain.facts().handle_nodes;
    tets.handles_outside = domain.facts().outside;
  }
  tets.V = box.from(made.V);
  // The input's own vertices keep every digit.
  if (made.route != TetRoute::wrap) {
    tets.V.topRows(character.mesh.V.rows()) = character.mesh.V;
  }
  return tets;
}

void run(const Options& o, const Common& common) {
  const auto start = std::chrono::steady_clock::now();
  const std::string extension = lower_extension(o.output);
  if (extension != ".mesh" && extension != ".msh")
    throw UsageError(o.output + ": tetrahedra are written as .mesh (MEDIT) or .msh (Gmsh)");
  check_outputs({o.output});
  const Progress progress = make_progress(common);
  const Asset asset = read_characters(o.input, o.skeleton, false);
  for (const std::string& w : asset.warnings) warn(w);
  if (asset.characters.size() != 1)
    throw UsageError(o.input + ": the file holds " + std::to_string(asset.characters.size()) +
                     " characters (use --only MESH)");
  const Character& character = asset.characters.front();
  const int nodes = o.nodes > 0            ? o.nodes
                    : o.quality == "draft" ? 2000
                    : o.quality == "high"  ? 64000
                                           : 16000;
  const Tets tets = make_tets(character, nodes, progress);
  const TetStatistics s = tet_statistics(tets.V, tets.T);
  const Triangles F = boundary_faces(tets.V, tets.T);
  progress.check();
  write_file_atomically(o.output, extension == ".mesh" ? format_medit(tets.V, F, tets.T)
                                                       : format_gmsh(tets.V, F, tets.T));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Json outside = Json::array();
  for (const int h : tets.handles_outside) {
    const std::string& name = character.skeleton.handles[static_cast<std::size_t>(h)].name;
    outside.push_back(name);
    warn("handle " + name + " lies outside the shape and has no vertex");
  }
  if (!tets.why_not_direct.empty())
    warn(
        fmt::format("the surface could not be filled as it is ({}): the tetrahedra fill a wrap "
                    "around it, which closes gaps under {:.3g}",
                    tets.why_not_direct, tets.alpha));
  note(common, fmt::format("{}: route {}, {} vertices, {} tetrahedra, volume {:.6g}, smallest "
                           "dihedral angle {:.2f} degrees (median {:.1f}), {} vertices on handles",
                           o.output, name_of(tets.route), tets.V.rows(), tets.T.rows(), s.volume,
                           s.min_dihedral, s.median_dihedral, tets.handle_vertices));
  if (!common.json) return;
  const Json json{{"file", o.input},
                  {"output", o.output},
                  {"route", name_of(tets.route)},
                  {"why_not_direct", tets.why_not_direct},
                  {"vertices", tets.V.rows()},
                  {"tets", tets.T.rows()},
                  {"boundary_faces", F.rows()},
                  {"volume", s.volume},
                  {"surface_volume", tets.surface_volume},
                  {"wrap_alpha", tets.alpha},
                  {"min_dihedral_degrees", s.min_dihedral},
                  {"median_dihedral_degrees", s.median_dihedral},
                  {"inverted", s.inverted},
                  {"degenerate", s.degenerate},
                  {"handle_vertices", tets.handle_vertices},
                  {"handles_outside", outside},
                  {"seconds", seconds}};
  fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

void add_tetrahedralise(CLI::App& app, Common& common,
                        std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb =
      new_verb(app, common, "tetrahedralise", "Fill a shape with tetrahedra, vertices on its bones",
               "skinfield tetrahedralise hand.obj --skeleton hand.tgf -o hand.mesh");
  verb->add_option("input", o->input, "Character: glTF, GLB, OBJ, PLY, OFF, STL, .mesh, .msh")
      ->required();
  verb->add_option("-o,--output", o->output, "The .mesh (MEDIT) or .msh (Gmsh) to write")
      ->required();
  o->skeleton.add_to(*verb);
  verb->add_option("--quality", o->quality, "About 2000, 16000 or 64000 vertices")
      ->check(CLI::IsMember({"draft", "normal", "high"}))
      ->capture_default_str();
  verb->add_option("--nodes", o->nodes, "Vertices, instead of --quality")
      ->check(number(50, 4000000));
  verb->add_flag("--json", common.json, "Print what came out as JSON");
  verbs.emplace_back(verb, [o, &common] { run(*o, common); });
}

}  // namespace skinfield::cli
