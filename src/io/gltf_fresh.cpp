// A document for meshes that came without one: OBJ, PLY, OFF, STL, tets, samples.
#include "io/bytes.h"
#include "io/gltf_writing.h"
#include "skinfield/io/obj.h"

#include <array>
#include <cmath>

namespace skinfield::gltf {
namespace {

constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;

/// Vertices as glTF wants them: one for each combination of position, texture coordinate, normal.
struct Vertices {
  std::vector<int> input;             ///< row of the input vertices
  std::vector<int> texcoord, normal;  ///< rows of the OBJ's tables, or -1
  Triangles faces;                    ///< indices into the above
};

/// Faces over input vertices, also for makers that gave merged ones only.
Triangles faces_of_input(const Character& character) {
  const Triangles& F = character.mesh.F;
  if (character.input_faces.rows() == F.rows()) return character.input_faces;
  std::vector<std::int32_t> member(static_cast<std::size_t>(character.mesh.V.rows()), 0);
  for (std::size_t i = character.vertex_of_input.size(); i-- > 0;) {
    member[static_cast<std::size_t>(character.vertex_of_input[i])] = static_cast<std::int32_t>(i);
  }
  return F.unaryExpr([&member](std::int32_t v) { return member[static_cast<std::size_t>(v)]; });
}

Vertices split(const Character& character, const ObjDocument* obj) {
  Vertices out;
  const Triangles F = faces_of_input(character);
  if (F.rows() == 0) {
    for (std::size_t i = 0; i < character.vertex_of_input.size(); ++i) {
      out.input.push_back(static_cast<int>(i));
      out.texcoord.push_back(-1);
      out.normal.push_back(-1);
    }
    return out;
  }
  const bool texcoords = obj && obj->texcoord_of_corner.rows() == F.rows();
  const bool normals = obj && obj->normal_of_corner.rows() == F.rows();
  std::map<std::array<int, 3>, std::int32_t> known;
  out.faces.resize(F.rows(), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const std::array<int, 3> key{F(f, k), texcoords ? obj->texcoord_of_corner(f, k) : -1,
                                   normals ? obj->normal_of_corner(f, k) : -1};
      const auto [found, is_new] = known.emplace(key, static_cast<std::int32_t>(out.input.size()));
      if (is_new) {
        out.input.push_back(key[0]);
        out.texcoord.push_back(key[1]);
        out.normal.push_back(key[2]);
      }
      out.faces(f, k) = found->second;
    }
  }
  return out;
}

std::string float3(const Points& rows) {
  std::string bytes;
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    put_little(bytes, static_cast<float>(rows.data()[i]));
  }
  return bytes;
}

Json vec3(Eigen::Index count) {
  return {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}};
}

Json put_positions(Extension& out, const Character& character, const Vertices& vertices) {
  Points P(static_cast<Eigen::Index>(vertices.input.size()), 3);
  for (std::size_t i = 0; i < vertices.input.size(); ++i) {
    const auto input = static_cast<std::size_t>(vertices.input[i]);
    P.row(static_cast<Eigen::Index>(i)) = character.mesh.V.row(character.vertex_of_input[input]);
  }
  Json accessor = vec3(P.rows());
  const Eigen::Matrix<float, Eigen::Dynamic, 3> floats = P.cast<float>();
  for (const bool upper : {false, true}) {
    const Eigen::RowVector3f corner =
        upper ? floats.colwise().maxCoeff().eval() : floats.colwise().minCoeff().eval();
    accessor[upper ? "max" : "min"] = {static_cast<double>(corner[0]),
                                       static_cast<double>(corner[1]),
                                       static_cast<double>(corner[2])};
  }
  return out.put(float3(P), std::move(accessor), kArrayBuffer);
}

/// Normals if every vertex has a usable one.
void put_normals(Extension& out, const Character& character, const ObjDocument* obj,
                 const Vertices& vertices, Json& attributes) {
  Points N(static_cast<Eigen::Index>(vertices.input.size()), 3);
  for (std::size_t i = 0; i < vertices.input.size(); ++i) {
    Eigen::RowVector3d normal = Eigen::RowVector3d::Zero();
    if (vertices.normal[i] >= 0) {
      normal = obj->normals.row(vertices.normal[i]);
    } else if (character.input_normals.rows() > vertices.input[i]) {
      normal = character.input_normals.row(vertices.input[i]);
    }
    const double length = normal.norm();
    if (!std::isfinite(length) || length < 1e-12) return;
    N.row(static_cast<Eigen::Index>(i)) = normal / length;
  }
  attributes["NORMAL"] = out.put(float3(N), vec3(N.rows()), kArrayBuffer);
}

void put_texcoords(Extension& out, const ObjDocument* obj, const Vertices& vertices,
                   Json& attributes) {
  std::string bytes;
  bool any = false;
  for (const int t : vertices.texcoord) {
    any = any || t >= 0;
    // glTF's v points down (glTF 2.0, 3.8.3).
    put_little(bytes, t < 0 ? 0.0f : static_cast<float>(obj->texcoords(t, 0)));
    put_little(bytes, t < 0 ? 0.0f : static_cast<float>(1 - obj->texcoords(t, 1)));
  }
  if (!any) return;
  attributes["TEXCOORD_0"] = out.put(
      bytes, {{"componentType", 5126}, {"count", vertices.texcoord.size()}, {"type", "VEC2"}},
      kArrayBuffer);
}

/// The colours' rows on the split vertices.
void put_colours(Extension& out, const Points& colours, const Vertices& vertices,
                 Json& attributes) {
  const Points split = colours(vertices.input, Eigen::all);
  attributes["COLOR_0"] = out.put(float3(split), vec3(split.rows()), kArrayBuffer);
}

int put_material(Extension& out, std::map<std::string, int>& known, const std::string& name,
                 const Eigen::Vector3d& colour, double alpha) {
  const Eigen::Vector3d c = colour.cwiseMax(0).cwiseMin(1);
  Json material = Json::object();
  if (!name.empty()) material["name"] = name;
  material["pbrMetallicRoughness"] = {{"baseColorFactor", {c[0], c[1], c[2], alpha}},
                                      {"metallicFactor", 0.0}};
  if (alpha < 1) material["alphaMode"] = "BLEND";
  material["doubleSided"] = true;
  const auto [found, is_new] = known.emplace(material.dump(), static_cast<int>(known.size()));
  if (is_new) out.json["materials"].push_back(std::move(material));
  return found->second;
}

int put_indices(Extension& out, const Triangles& F, Eigen::Index begin, Eigen::Index end,
                std::size_t vertices) {
  std::string bytes;
  const bool wide = vertices > 65535;
  for (Eigen::Index i = 3 * begin; i < 3 * end; ++i) {
    const std::int32_t v = F.data()[i];
    if (wide) {
      put_little(bytes, static_cast<std::uint32_t>(v));
    } else {
      put_little(bytes, static_cast<std::uint16_t>(v));
    }
  }
  return out.put(
      bytes,
      {{"componentType", wide ? 5125 : 5123}, {"count", 3 * (end - begin)}, {"type", "SCALAR"}},
      kElementBuffer);
}

/// The weights' rows on the split vertices.
SparseRows spread(const SparseRows& W, const std::vector<int>& input) {
  SparseRows out(static_cast<Eigen::Index>(input.size()), W.cols());
  std::vector<Eigen::Triplet<double, std::int32_t>> triplets;
  for (std::size_t i = 0; i < input.size(); ++i) {
    for (SparseRows::InnerIterator it(W, input[i]); it; ++it) {
      triplets.emplace_back(static_cast<std::int32_t>(i), it.col(), it.value());
    }
  }
  out.setFromTriplets(triplets.begin(), triplets.end());
  return out;
}

}  // namespace

Extension fresh_document(const Asset& source, std::span<const SkinWeights> weights,
                         const GltfWriteOptions& options, std::span<const Points> colours) {
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "Skinfield"}}},
               {"scene", 0},
               {"scenes", Json::array({{{"nodes", Json::array()}}})},
               {"nodes", Json::array()}};
  Extension out(std::move(json), {});
  const auto* obj = source.characters.size() == 1
                        ? dynamic_cast<const ObjDocument*>(source.document.get())
                        : nullptr;
  std::map<std::string, int> materials;
  for (std::size_t c = 0; c < source.characters.size(); ++c) {
    const Character& character = source.characters[c];
    const SparseRows& W = weights[c].W;
    if (W.rows() > 0 && W.rows() != static_cast<Eigen::Index>(character.vertex_of_input.size())) {
      throw InputError("the weights have " + std::to_string(W.rows()) + " rows, the mesh has " +
                           std::to_string(character.vertex_of_input.size()) + " vertices",
                       source.path);
    }
    const Vertices vertices = split(character, obj);
    Json attributes = Json::object();
    attributes["POSITION"] = put_positions(out, character, vertices);
    put_normals(out, character, obj, vertices, attributes);
    put_texcoords(out, obj, vertices, attributes);
    if (!colours.empty()) put_colours(out, colours[c], vertices, attributes);
    Json node = Json::object();
    if (!character.name.empty()) node["name"] = character.name;
    node["mesh"] = c;
    const int mesh_node = out.append_node(std::move(node));
    Json roots = Json::array({mesh_node});
    if (W.rows() > 0) {
      const PlacedTree placed =
          place_tree(out, make_joint_tree(character.skeleton, static_cast<int>(W.cols())));
      Json carrier = {{"attributes", std::move(attributes)}};
      set_weights(
          out, carrier,
          pack_weights(spread(W, vertices.input), 0, static_cast<int>(vertices.input.size()),
                       placed.tree.joint_of_column, options.format, 1));
      attributes = std::move(carrier["attributes"]);
      out.json["nodes"][static_cast<std::size_t>(mesh_node)]["skin"] =
          append_skin(out, placed, Transform::Identity(), character.name);
      roots.push_back(placed.root);
    }
    for (Json& root : roots) out.json["scenes"][0]["nodes"].push_back(std::move(root));
    std::vector<Part> parts = character.parts;
    if (parts.empty()) {
      parts.emplace_back();
      parts.back().face_end = static_cast<int>(vertices.faces.rows());
    }
    Json primitives = Json::array();
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const Part& part = parts[p];
      Json primitive = {{"attributes", attributes}};
      if (vertices.faces.rows() == 0) {
        primitive["mode"] = 0;
        if (p > 0) break;  // all points are in the first
      } else if (part.face_begin >= part.face_end) {
        continue;
      } else {
        primitive["indices"] =
            put_indices(out, vertices.faces, part.face_begin, part.face_end, vertices.input.size());
      }
      const int m = obj && p < obj->material_of_part.size() ? obj->material_of_part[p] : -1;
      const ObjMaterial* material = m >= 0 ? &obj->materials[static_cast<std::size_t>(m)] : nullptr;
      // A material's colour would tint those of the vertices.
      primitive["material"] = !colours.empty()
                                  ? put_material(out, materials, "", Eigen::Vector3d::Ones(), 1)
                                  : put_material(out, materials, material ? material->name : "",
                                                 part.colour, material ? material->alpha : 1.0);
      primitives.push_back(std::move(primitive));
    }
    Json mesh = Json::object();
    if (!character.name.empty()) mesh["name"] = character.name;
    mesh["primitives"] = std::move(primitives);
    out.json["meshes"].push_back(std::move(mesh));
  }
  return out;
}

}  // namespace skinfield::gltf
