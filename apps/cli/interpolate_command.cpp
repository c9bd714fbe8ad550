#include "cli.h"
#include "picturing.h"
#include "posing.h"

#include "skinfield/bind/triangulate.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/matrix_file.h"
#include "skinfield/io/mesh_file.h"
#include "skinfield/io/npy.h"
#include "skinfield/render/colour.h"
#include "skinfield/weights/operations.h"

#include <fmt/core.h>

#include <array>
#include <cmath>

namespace skinfield::cli {
namespace {

struct Options {
  std::string input, data, output, weights;
  SkeletonOptions skeleton;
  RenderOptions render;
};

enum class Output { values, coloured_mesh, picture };

Output kind_of(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".png") return Output::picture;
  for (const char* mesh : {".glb", ".gltf", ".ply", ".obj"})
    if (extension == mesh) return Output::coloured_mesh;
  for (const char* values : {".npz", ".npy", ".dmat", ".csv"})
    if (extension == values) return Output::values;
  throw UsageError(path +
                   ": unknown output format (values .npz .npy .dmat .csv, vertex colours .glb "
                   ".gltf .ply .obj, or a picture .png)");
}

/// (m,k) a row a handle. Where colours are wanted, k is 1 or 3.
RowMatrix read_data(const Options& o, Eigen::Index handles, Output kind) {
  RowMatrix data = read_matrix(o.data);
  if (data.rows() != handles)
    throw InputError(fmt::format("holds {} rows for {} handles", data.rows(), handles), o.data,
                     "give a row a handle, in the order of the weights' columns");
  if (!data.allFinite()) throw InputError("holds numbers that are not finite", o.data);
  if (kind == Output::values) return data;
  if (data.cols() != 1 && data.cols() != 3)
    throw InputError(fmt::format("has {} columns, and {} shows colours", data.cols(), o.output),
                     o.data, "give 1 column (a scalar) or 3 (linear red, green, blue)");
  if (data.cols() == 3 && (data.minCoeff() < 0 || data.maxCoeff() > 1))
    throw InputError("has colours outside of 0 to 1", o.data, "scale them");
  return data;
}

/// Scalars from their range to that of the colour map.
Vector in_range(const RowMatrix& values, const RowMatrix& data) {
  const double low = data.minCoeff(), range = data.maxCoeff() - low;
  return (values.col(0).array() - low) / (range > 0 ? range : 1);
}

/// Linear RGB a row of `values`.
Points colours_of(const RowMatrix& values, const RowMatrix& data) {
  if (values.cols() == 3) return values.cwiseMax(0.0).cwiseMin(1.0);
  const Vector t = in_range(values, data);
  Points colours(t.size(), 3);
  for (Eigen::Index i = 0; i < t.size(); ++i) colours.row(i) = heat_colour(t[i]).transpose();
  return colours;
}

std::string format_values(const RowMatrix& values, const std::string& extension) {
  if (extension == ".npz") return format_npz({{"values", npy_from_matrix(values)}});
  if (extension == ".npy") return format_npy(npy_from_matrix(values));
  if (extension == ".dmat") return format_dmat(values);
  return format_csv({{}, values});
}

/// As mesh files have them.
Points srgb(const Points& linear) {
  Points colours(linear.rows(), 3);
  for (Eigen::Index i = 0; i < linear.rows(); ++i) {
    const Rgb8 bytes = to_srgb(linear.row(i).transpose());
    for (int k = 0; k < 3; ++k) colours(i, k) = bytes[static_cast<std::size_t>(k)] / 255.0;
  }
  return colours;
}

/// @param colours linear, of the mesh's vertices.
std::string format_coloured(const Asset& asset, const Points& colours,
                            const std::string& extension) {
  const Character& c = asset.characters.front();
  if (extension == ".ply") return format_ply(c.mesh.V, c.mesh.F, {}, srgb(colours));
  if (extension == ".obj") return format_obj(c.mesh.V, c.mesh.F, {}, srgb(colours));
  const std::array<Points, 1> of_input{Points(colours(c.vertex_of_input, Eigen::all))};
  return format_coloured_gltf(asset, of_input, extension == ".glb");
}

Image picture(const Asset& asset, const RowMatrix& values, const RowMatrix& data,
              const RenderOptions& options) {
  const Character& c = asset.characters.front();
  const Points V = c.mesh.V * turn_to_world(asset, 0).transpose();
  if (values.cols() == 1) return render_heat_map(V, c.mesh.F, in_range(values, data), options);
  return render_vertex_colours(V, c.mesh.F, colours_of(values, data), options);
}

void run(Options o, const CLI::App& verb, const Common& common) {
  const Output kind = kind_of(o.output);
  for (const std::string& name : picture_option_names())
    if (kind != Output::picture && verb.count(name) > 0)
      throw UsageError(name + ": " + o.output + " is no picture (leave it out, or write .png)");
  check_outputs({o.output});
  o.render.progress = make_progress(common);
  Asset asset = read_characters(o.input, o.skeleton, false);
  if (asset.characters.size() > 1)
    throw UsageError(o.input + ": the file holds several characters (use --only MESH)");
  Character& c = asset.characters.front();
  triangulate_outline(c, 0, o.render.progress);
  const SkinWeights weights = weights_of(asset, 0, o.weights);
  const RowMatrix data = read_data(o, weights.W.cols(), kind);
  RowMatrix values;
  try {
    values = interpolate(weights, data);
  } catch (const InputError& error) {
    throw InputError(error.message(), o.weights.empty() ? o.input : o.weights, error.remedy());
  }
  const std::string extension = lower_extension(o.output);
  if (kind == Output::values) {
    const RowMatrix of_input = values(c.vertex_of_input, Eigen::all);
    write_file_atomically(o.output, format_values(of_input, extension));
  } else if (kind == Output::coloured_mesh) {
    write_file_atomically(o.output, format_coloured(asset, colours_of(values, data), extension));
  } else {
    look_at_plane(verb, asset, o.render.camera);
    write_png(o.output, picture(asset, values, data, o.render));
  }
}

}  // namespace

void add_interpolate(CLI::App& app, Common& common,
                     std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "interpolate",
                            "Spread what is given for each handle over a mesh, by its weights",
                            "skinfield interpolate hero-bound.glb --data colours.csv -o hero.png");
  verb->add_option("input", o->input, "A character; with --weights any mesh")->required();
  verb->add_option("--data", o->data,
                   "A matrix (.csv .npy .npz .dmat .mtx), a row a handle in the order of the "
                   "weights' columns. For colours 3 columns (linear red, green, blue from 0 to 1) "
                   "or 1 (a scalar, through the heat map)")
      ->required();
  verb->add_option("-o,--output", o->output,
                   "Values a vertex .npz .npy .dmat .csv, vertex colours .glb .gltf .ply .obj, or "
                   "a picture .png")
      ->required();
  verb->add_option("--weights", o->weights, "Weight matrix, if the file has none");
  add_picture_options(*verb, o->render);
  o->skeleton.add_to(*verb);
  verbs.emplace_back(verb, [o, verb, &common] { run(*o, *verb, common); });
}

}  // namespace skinfield::cli
