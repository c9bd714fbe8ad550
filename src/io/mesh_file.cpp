#include "skinfield/io/mesh_file.h"

#include "io/outline.h"
#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/obj.h"

#include <fmt/format.h>
#include <cmath>

namespace skinfield {
namespace {

// Squares and products of such coordinates still fit a double.
constexpr double kLargestPosition = 1e100;

void check_positions(const Points& V, const std::string& name) {
  if (V.rows() == 0) {
    throw InputError("the mesh has no vertices", name, "export it again with its geometry");
  }
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(V(i, c)) <= kLargestPosition)) {
        throw InputError(
            fmt::format("vertex {} has the position {} {} {}", i + 1, V(i, 0), V(i, 1), V(i, 2)),
            name, "positions must be finite; repair or remove the vertex");
      }
    }
  }
}

template <class Indices>
void check_indices(const Indices& F, Eigen::Index vertices, const char* what,
                   const std::string& name) {
  for (Eigen::Index i = 0; i < F.rows(); ++i) {
    for (Eigen::Index c = 0; c < F.cols(); ++c) {
      if (F(i, c) < 0 || F(i, c) >= vertices) {
        throw InputError(
            fmt::format("{} {} names vertex {} of {}", what, i + 1, F(i, c) + 1, vertices), name,
            "the file is damaged; export it again");
      }
    }
  }
}

void turn_to_y_up(Points& X) {
  if (X.rows() == 0) return;
  const Vector y = X.col(1);
  X.col(1) = X.col(2);
  X.col(2) = -y;
}

}  // namespace

Asset asset_from(MeshFile file, const std::string& name, const ReadOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw InputError(fmt::format("the scale is {}", options.scale), name, "give a positive number");
  }
  check_positions(file.V, name);
  check_indices(file.F, file.V.rows(), "face", name);
  check_indices(file.T, file.V.rows(), "tetrahedron", name);
  check_indices(file.outline.E, file.V.rows(), "polyline segment", name);
  if (options.up == Up::z) {
    turn_to_y_up(file.V);
    turn_to_y_up(file.N);
    if (const auto* obj = dynamic_cast<const ObjDocument*>(file.document.get())) {
      auto turned = std::make_shared<ObjDocument>(*obj);
      turn_to_y_up(turned->normals);
      file.document = std::move(turned);
    }
  }
  if (options.scale != 1) {
    file.V *= options.scale;
    check_positions(file.V, name);
  }

  Character character;
  character.name = std::filesystem::path(name).stem().string();
  Welded welded = weld(file.V);
  Mesh& mesh = character.mesh;
  mesh.V = std::move(welded.V);
  character.vertex_of_input = std::move(welded.vertex);
  const std::vector<int>& to = character.vertex_of_input;
  const auto merged = [&to](std::int32_t v) {
    return static_cast<std::int32_t>(to[static_cast<std::size_t>(v)]);
  };
  mesh.T = file.T.unaryExpr(merged);
  if (mesh.T.rows() > 0) {
    mesh.F = boundary_faces(mesh.V, mesh.T);
    file.parts.clear();
  } else {
    mesh.F = file.F.unaryExpr(merged);
    character.input_faces = std::move(file.F);
  }
  if (mesh.is_point_cloud()) {
    mesh.outline = sound_outline(file.outline, to, mesh.V, file.warnings);
  } else if (!file.outline.empty()) {
    file.warnings.emplace_back("polylines beside faces are ignored");
  }
  if (mesh.is_point_cloud() && file.N.rows() == file.V.rows()) {
    mesh.N.resize(mesh.V.rows(), 3);
    for (Eigen::Index i = file.N.rows(); i-- > 0;) {
      mesh.N.row(to[static_cast<std::size_t>(i)]) = file.N.row(i);
    }
  }
  character.input_normals = std::move(file.N);
  character.parts = std::move(file.parts);
  if (character.parts.empty()) {
    Part whole;
    whole.name = character.name;
    whole.end = static_cast<int>(to.size());
    whole.face_end = static_cast<int>(mesh.F.rows());
    character.parts.push_back(std::move(whole));
  }

  Asset asset;
  asset.path = name;
  asset.characters.push_back(std::move(character));
  asset.document = std::move(file.document);
  asset.warnings = std::move(file.warnings);
  return asset;
}

std::string format_obj(const Points& V, const Triangles& F, const Points& N,
                       const Points& colours) {
  fmt::memory_buffer out;
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    fmt::format_to(std::back_inserter(out), "v {} {} {}", V(i, 0), V(i, 1), V(i, 2));
    if (colours.rows() > 0) {
      fmt::format_to(std::back_inserter(out), " {:.6g} {:.6g} {:.6g}", colours(i, 0), colours(i, 1),
                     colours(i, 2));
    }
    out.push_back('\n');
  }
  const bool normals = N.rows() == V.rows() && N.rows() > 0;
  for (Eigen::Index i = 0; normals && i < N.rows(); ++i) {
    fmt::format_to(std::back_inserter(out), "vn {} {} {}\n", N(i, 0), N(i, 1), N(i, 2));
  }
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const int a = F(f, 0) + 1, b = F(f, 1) + 1, c = F(f, 2) + 1;
    if (normals) {
      fmt::format_to(std::back_inserter(out), "f {0}//{0} {1}//{1} {2}//{2}\n", a, b, c);
    } else {
      fmt::format_to(std::back_inserter(out), "f {} {} {}\n", a, b, c);
    }
  }
  return fmt::to_string(out);
}

std::string format_off(const Points& V, const Triangles& F, const Points& N) {
  fmt::memory_buffer out;
  const bool normals = N.rows() == V.rows() && N.rows() > 0;
  fmt::format_to(std::back_inserter(out), "{}OFF\n{} {} 0\n", normals ? "N" : "", V.rows(),
                 F.rows());
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    fmt::format_to(std::back_inserter(out), "{} {} {}", V(i, 0), V(i, 1), V(i, 2));
    if (normals) {
      fmt::format_to(std::back_inserter(out), " {} {} {}", N(i, 0), N(i, 1), N(i, 2));
    }
    out.push_back('\n');
  }
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    fmt::format_to(std::back_inserter(out), "3 {} {} {}\n", F(f, 0), F(f, 1), F(f, 2));
  }
  return fmt::to_string(out);
}

void write_mesh(const std::filesystem::path& path, const Points& V, const Triangles& F,
                const Points& N) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") {
    write_file_atomically(path, format_obj(V, F, N));
  } else if (extension == ".ply") {
    write_file_atomically(path, format_ply(V, F, N));
  } else if (extension == ".off") {
    write_file_atomically(path, format_off(V, F, N));
  } else {
    throw InputError("meshes are written as .obj, .ply or .off", path.string(),
                     "name the output so");
  }
}

}  // namespace skinfield
