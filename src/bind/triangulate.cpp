#include "skinfield/bind/triangulate.h"

#include "bind/ladder.h"
#include "skinfield/base/error.h"
#include "skinfield/domain/planar_mesher.h"

namespace skinfield {

void triangulate_outline(Character& character, int nodes, const Progress& progress) {
  if (!character.mesh.is_outline()) return;
  const ScaledCharacter scaled = scale_to_unit_box(character);
  const PlanarMesh planar = mesh_outline(scaled.mesh, scaled.handles, {.nodes = nodes}, progress);
  if (nodes == 0 && planar.crossings > 0) {
    throw DomainError("the outline crosses itself", character.name,
                      "bind it to .glb, which has vertices where it does, and use that");
  }
  Mesh& mesh = character.mesh;
  const Eigen::Index n = mesh.V.rows(), added = planar.V.rows() - n;
  mesh.V.conservativeResize(n + added, 3);
  mesh.V.bottomRows(added) = scaled.box.from(planar.V.bottomRows(added));
  mesh.F = planar.F;
  // The parts' share of triangles is not known: all belong to the first.
  for (Part& part : character.parts) part.face_begin = part.face_end = 0;
  if (!character.parts.empty()) {
    character.parts.front().face_end = static_cast<int>(mesh.F.rows());
  }
}

void count_inner_vertices(Character& character) {
  if (character.mesh.outline.empty()) return;
  std::vector<char> known(static_cast<std::size_t>(character.mesh.V.rows()), 0);
  for (const int v : character.vertex_of_input) known[static_cast<std::size_t>(v)] = 1;
  for (std::size_t v = 0; v < known.size(); ++v) {
    if (!known[v]) character.vertex_of_input.push_back(static_cast<int>(v));
  }
  character.input_normals.resize(0, 3);
  character.input_faces.resize(0, 3);
}

}  // namespace skinfield
