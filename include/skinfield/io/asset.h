// What a file holds: characters (mesh, skeleton, weights) and the document they came from.
#pragma once

#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/skin_weights.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skinfield {

/// The source document, kept whole so that glTF survives a round trip; opaque outside io.
class Document {
 public:
  virtual ~Document() = default;
};

/// One drawable piece of a character: a glTF primitive under a node, or an OBJ file.
struct Part {
  std::string name;                  ///< mesh or object name, for --only and messages
  int begin = 0, end = 0;            ///< its vertices: rows [begin, end) of the input vertices
  int face_begin = 0, face_end = 0;  ///< its triangles: rows of mesh.F
  int node = -1, mesh = -1, primitive = -1;                 ///< glTF indices
  Eigen::Vector3d colour = Eigen::Vector3d(0.8, 0.8, 0.8);  ///< base colour, linear RGB
};

/// All primitives whose skins name the same joints; or everything in a file without skins.
struct Character {
  std::string name;
  Mesh mesh;                         ///< in bind space, equal positions merged
  std::vector<int> vertex_of_input;  ///< (n_input) -> mesh.V row, in file order
  Points input_normals;              ///< (n_input,3) as in the file, or empty
  Triangles input_faces;             ///< mesh.F before merging, in input vertices, or empty
  std::vector<Part> parts;
  Skeleton skeleton;                   ///< joints filled by the reader, handles by rig's rules
  std::optional<SkinWeights> weights;  ///< (n_input, columns) as in the file, NaN rows empty
  int non_finite_weight_rows = 0;
};

struct Asset {
  std::string path;
  std::vector<Character> characters;
  std::shared_ptr<const Document> document;  ///< null for formats that carry nothing else
  std::vector<std::string> warnings;
};

}  // namespace skinfield
