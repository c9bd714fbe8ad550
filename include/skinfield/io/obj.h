// Wavefront OBJ with its material colours.
#pragma once

#include "skinfield/io/mesh_file.h"

#include <functional>
#include <optional>

namespace skinfield {

struct ObjMaterial {
  std::string name;
  Eigen::Vector3d colour = Eigen::Vector3d(0.8, 0.8, 0.8);  ///< Kd
  double alpha = 1;                                         ///< d, or 1 - Tr
};

/// What an OBJ says beyond positions: for writing GLB with its UVs, normals and materials.
/// Rows of the corner tables match `Character::mesh.F`; -1 where a corner has none.
class ObjDocument : public Document {
 public:
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> texcoords;  ///< v up, as in the file
  Points normals;                                                       ///< in the library's axes
  Triangles texcoord_of_corner;  ///< (f,3) rows of texcoords, or -1
  Triangles normal_of_corner;    ///< (f,3) rows of normals, or -1
  std::vector<ObjMaterial> materials;
  std::vector<int> material_of_part;  ///< for each of Character::parts, or -1
};

/// Gives a material library named by `mtllib`, or nothing where it cannot be read.
using MaterialLoader = std::function<std::optional<std::string>(const std::string& file)>;

/// v, vt, vn, f, l in all forms (negative indices too), o, g, usemtl, mtllib; polygons become fans;
/// polylines are one shape of an outline; free-form surfaces are skipped with a warning. A new part
/// begins where object, group or material changes. Throws InputError.
MeshFile parse_obj(std::string_view bytes, const std::string& name,
                   const MaterialLoader& load_materials = {});

/// newmtl, Kd, d, Tr; everything else is skipped.
std::vector<ObjMaterial> parse_mtl(std::string_view bytes);

}  // namespace skinfield
