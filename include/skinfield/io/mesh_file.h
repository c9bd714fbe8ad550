// What a mesh file says, before vertices are merged; and posed meshes out again.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/io/asset.h"

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

/// The common result of all mesh parsers: everything in file order, faces fan-triangulated,
/// indices in range. Positions may still be non-finite (`asset_from` refuses them).
struct MeshFile {
  Points V;                 ///< (n,3); two-dimensional files get z = 0
  Triangles F;              ///< (f,3)
  Tetrahedra T;             ///< (t,4)
  Points N;                 ///< (n,3) vertex normals, or empty
  Outline outline;          ///< closed or open polylines; a shape's number is its part's
  std::vector<Part> parts;  ///< face ranges partition F; empty: one part
  std::shared_ptr<const Document> document;
  std::vector<std::string> warnings;
};

/// Which axis points up in the file. The library's axes are glTF's: y up.
enum class Up { y, z };

struct ReadOptions {
  Up up = Up::y;     ///< z: (x,y,z) becomes (x,z,-y)
  double scale = 1;  ///< positions are multiplied by this
};

/// One character without a skeleton: axes and scale applied, coincident vertices merged,
/// `vertex_of_input` filled; a tet mesh's F is its boundary; polylines of a file without faces
/// become the mesh's outline if they close and lie in a plane. `name` is the file for messages.
/// Throws InputError for no vertices, non-finite or immense positions, a useless scale.
Asset asset_from(MeshFile file, const std::string& name, const ReadOptions& options = {});

/// Writes (V,F) by extension: .obj, .ply (binary), .off. N (n,3) or empty. Written atomically.
/// Throws InputError for another extension, IoError where the file cannot be written.
void write_mesh(const std::filesystem::path& path, const Points& V, const Triangles& F,
                const Points& N = {});
/// colours: (n,3) sRGB from 0 to 1, or empty: behind the positions of an OBJ, as bytes in a PLY.
std::string format_obj(const Points& V, const Triangles& F, const Points& N = {},
                       const Points& colours = {});
std::string format_ply(const Points& V, const Triangles& F, const Points& N = {},
                       const Points& colours = {});
std::string format_off(const Points& V, const Triangles& F, const Points& N = {});

}  // namespace skinfield
