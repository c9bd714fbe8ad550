// From a document to characters: which primitives belong together, and in which space.
#include "skinfield/io/gltf.h"

#include "io/gltf_document.h"
#include "skinfield/io/file.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

using namespace gltf;

/// What is collected of one character before its vertices are merged.
struct Gathering {
  int first_skin = -1;
  std::vector<Skin> skins;            // of the bindings, first one first
  std::vector<PrimitiveData> pieces;  // one a part, already in character space
};

class Reader {
 public:
  explicit Reader(std::shared_ptr<GltfDocument> document) : document_(std::move(document)) {}

  Asset read();

 private:
  void gather_skinned();
  void gather_static();
  std::vector<char> nodes_of_scene() const;
  void add_binding(std::size_t character, int node, int skin, const Transform& to_character);
  void add_parts(std::size_t character, Binding& binding, const Skin* skin);
  void finish(std::size_t character);
  Eigen::Vector3d colour(const Json& primitive, const std::string& who) const;

  std::shared_ptr<GltfDocument> document_;
  Asset asset_;
  std::vector<Gathering> gatherings_;
  std::int64_t vertices_ = 0;
};

Asset Reader::read() {
  asset_.path = document_->name;
  gather_skinned();
  if (gatherings_.empty()) gather_static();
  for (std::size_t c = 0; c < gatherings_.size(); ++c) finish(c);
  asset_.document = document_;
  return std::move(asset_);
}

void Reader::gather_skinned() {
  std::map<std::vector<int>, std::size_t> character_of;
  std::map<int, Skin> skins;
  std::map<std::tuple<std::size_t, int, std::string>, std::size_t> seen;
  for (std::size_t n = 0; n < document_->nodes.size(); ++n) {
    const std::string who = "node " + std::to_string(n);
    const Json& node = document_->item("nodes", static_cast<std::int64_t>(n), who);
    const int skin_index = document_->index(node, "skin", "skins", who);
    const int mesh = document_->index(node, "mesh", "meshes", who);
    if (skin_index < 0 || mesh < 0) continue;
    auto found = skins.find(skin_index);
    if (found == skins.end()) {
      found = skins.emplace(skin_index, read_skin(*document_, skin_index)).first;
    }
    const Skin& skin = found->second;
    std::vector<int> joints = skin.joints;
    std::sort(joints.begin(), joints.end());
    const auto [entry, is_new] = character_of.emplace(joints, gatherings_.size());
    const std::size_t c = entry->second;
    if (is_new) {
      gatherings_.emplace_back();
      gatherings_.back().first_skin = skin_index;
      gatherings_.back().skins.push_back(skin);
      document_->characters.emplace_back();
      document_->characters.back().joint_nodes = skin.joints;
      asset_.characters.emplace_back();
      Character& character = asset_.characters.back();
      character.skeleton = make_skeleton(*document_, skin);
      character.name = skin.name.empty() ? document_->text(node, "name") : skin.name;
      document_->characters.back().joints = character.skeleton.joints;
      if (!skin.useful_binds && skin.joints.size() > 1) {
        asset_.warnings.push_back("skin " + std::to_string(skin_index) +
                                  " has no inverse bind matrices: joints are taken where their "
                                  "nodes stand");
      }
    }
    auto& bindings = document_->characters[c].bindings;
    const auto [twin, unseen] = seen.emplace(std::tuple(c, mesh, skin_key(skin)), bindings.size());
    if (!unseen) {
      bindings[twin->second].twins.push_back(static_cast<int>(n));
      continue;
    }
    Binding binding;
    binding.node = static_cast<int>(n);
    binding.mesh = mesh;
    binding.skin = skin_index;
    for (const int joint : gatherings_[c].skins.front().joints) {
      const auto at = std::find(skin.joints.begin(), skin.joints.end(), joint);
      binding.slot_of_column.push_back(static_cast<int>(at - skin.joints.begin()));
    }
    add_parts(c, binding, &skin);
    bindings.push_back(std::move(binding));
  }
}

std::vector<char> Reader::nodes_of_scene() const {
  const Json& scenes = document_->list("scenes");
  std::vector<char> in(document_->nodes.size(), scenes.empty());
  if (scenes.empty()) return in;
  const std::int64_t scene = document_->integer(document_->json, "scene", 0, "the document");
  const Json& json = document_->item("scenes", scene, "scene");
  for (const int root : document_->indices(json, "nodes", "nodes", "scene")) {
    in[static_cast<std::size_t>(root)] = 1;
  }
  for (const int n : document_->node_order) {
    const int parent = document_->nodes[static_cast<std::size_t>(n)].parent;
    if (parent >= 0 && in[static_cast<std::size_t>(parent)]) in[static_cast<std::size_t>(n)] = 1;
  }
  return in;
}

void Reader::gather_static() {
  const std::vector<char> in_scene = nodes_of_scene();
  const std::vector<Transform> world = document_->world_transforms();
  gatherings_.emplace_back();
  document_->characters.emplace_back();
  asset_.characters.emplace_back();
  asset_.characters.back().name = std::filesystem::path(document_->name).stem().string();
  for (std::size_t n = 0; n < document_->nodes.size(); ++n) {
    if (!in_scene[n]) continue;
    const std::string who = "node " + std::to_string(n);
    const Json& node = document_->item("nodes", static_cast<std::int64_t>(n), who);
    Binding binding;
    binding.node = static_cast<int>(n);
    binding.mesh = document_->index(node, "mesh", "meshes", who);
    if (binding.mesh < 0) continue;
    binding.to_character = world[n];
    add_parts(0, binding, nullptr);
    document_->characters[0].bindings.push_back(std::move(binding));
  }
}

Eigen::Vector3d Reader::colour(const Json& primitive, const std::string& who) const {
  Part standard;
  const int material = document_->index(primitive, "material", "materials", who);
  if (material < 0) return standard.colour;
  const Json& json = document_->item("materials", material, who);
  const auto pbr = json.find("pbrMetallicRoughness");
  if (pbr == json.end() || !pbr->is_object()) return standard.colour;
  const auto factor = pbr->find("baseColorFactor");
  if (factor == pbr->end() || !factor->is_array() || factor->size() < 3) return standard.colour;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(*factor)[k].is_number()) return Part().colour;
    standard.colour[static_cast<Eigen::Index>(k)] = (*factor)[k].get<double>();
  }
  return standard.colour;
}

void Reader::add_parts(std::size_t c, Binding& binding, const Skin* skin) {
  const std::string mesh_who = "mesh " + std::to_string(binding.mesh);
  const Json& mesh = document_->item("meshes", binding.mesh, mesh_who);
  const auto primitives = mesh.find("primitives");
  if (primitives == mesh.end() || !primitives->is_array()) {
    document_->fail(mesh_who + " has no primitives", "export it again");
  }
  Character& character = asset_.characters[c];
  Gathering& gathering = gatherings_[c];
  std::string name = document_->text(mesh, "name");
  if (name.empty()) {
    name =
        document_->text(document_->json["nodes"][static_cast<std::size_t>(binding.node)], "name");
  }
  if (name.empty()) name = "mesh_" + std::to_string(binding.mesh);
  binding.part_begin = static_cast<int>(character.parts.size());
  std::vector<PrimitiveData> pieces;
  for (std::size_t p = 0; p < primitives->size(); ++p) {
    const std::string who =
        document_->name + ": mesh '" + name + "', primitive " + std::to_string(p);
    const Json& primitive = (*primitives)[p];
    if (!primitive.is_object()) document_->fail(who + " is no object", "export it again");
    PrimitiveData piece =
        read_primitive(*document_, primitive, skin ? static_cast<int>(skin->joints.size()) : 0,
                       who.substr(document_->name.size() + 2));
    if (piece.V.rows() == 0) continue;
    vertices_ += piece.V.rows();
    // A mesh shown by many nodes multiplies: bound what a small file can make us allocate.
    if (vertices_ >
        std::max<std::int64_t>(1 << 22, 4 * static_cast<std::int64_t>(document_->source_bytes))) {
      document_->fail("its nodes show " + std::to_string(vertices_) + " vertices or more",
                      "merge or remove the copies");
    }
    Part part;
    part.name = name;
    part.node = binding.node;
    part.mesh = binding.mesh;
    part.primitive = static_cast<int>(p);
    part.colour = colour(primitive, who);
    character.parts.push_back(std::move(part));
    pieces.push_back(std::move(piece));
  }
  binding.part_end = static_cast<int>(character.parts.size());
  if (skin) {
    bool posed = false;
    binding.to_character =
        place_in_bind_space(gathering.skins.front(), *skin, binding.slot_of_column, pieces, posed);
    if (posed) {
      asset_.warnings.push_back(
          "skin " + std::to_string(binding.skin) + " was bound in another pose than skin " +
          std::to_string(gathering.first_skin) + ": its parts are posed by their weights");
    }
    // From here on weights name the character's columns.
    std::vector<int> column(skin->joints.size(), -1);
    for (std::size_t j = 0; j < binding.slot_of_column.size(); ++j) {
      column[static_cast<std::size_t>(binding.slot_of_column[j])] = static_cast<int>(j);
    }
    for (PrimitiveData& piece : pieces) {
      for (auto& entry : piece.weights) {
        entry = {entry.row(), column[static_cast<std::size_t>(entry.col())], entry.value()};
      }
    }
  } else {
    for (PrimitiveData& piece : pieces) move_piece(binding.to_character, piece);
  }
  for (PrimitiveData& piece : pieces) gathering.pieces.push_back(std::move(piece));
}

void Reader::finish(std::size_t c) {
  Character& character = asset_.characters[c];
  std::vector<PrimitiveData>& pieces = gatherings_[c].pieces;
  Eigen::Index n = 0, f = 0;
  bool normals = true, weighted = false;
  std::size_t entries = 0;
  for (const PrimitiveData& piece : pieces) {
    n += piece.V.rows();
    f += piece.F.rows();
    normals = normals && piece.N.rows() > 0;
    weighted = weighted || piece.weighted;
    entries += piece.weights.size();
  }
  if (n == 0) document_->fail("has no mesh with vertices", "export it with its meshes");
  Points V(n, 3);
  character.input_faces.resize(f, 3);
  if (normals) character.input_normals.resize(n, 3);
  std::vector<Eigen::Triplet<double, std::int32_t>> triplets;
  triplets.reserve(entries);
  int negative = 0;
  n = f = 0;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    PrimitiveData& piece = pieces[p];
    Part& part = character.parts[p];
    part.begin = static_cast<int>(n);
    part.face_begin = static_cast<int>(f);
    V.middleRows(n, piece.V.rows()) = piece.V;
    character.input_faces.middleRows(f, piece.F.rows()) =
        piece.F.array() + static_cast<std::int32_t>(n);
    for (Eigen::Index v = 0; normals && v < piece.V.rows(); ++v) {
      const double length = piece.N.row(v).norm();
      const bool good = std::isfinite(length) && length > 0;
      character.input_normals.row(n + v) =
          good ? Eigen::RowVector3d(piece.N.row(v) / length) : Eigen::RowVector3d::Zero();
    }
    for (const auto& entry : piece.weights) {
      triplets.emplace_back(static_cast<std::int32_t>(n + entry.row()), entry.col(), entry.value());
    }
    character.non_finite_weight_rows += piece.non_finite_rows;
    negative += piece.negative_rows;
    n += piece.V.rows();
    f += piece.F.rows();
    part.end = static_cast<int>(n);
    part.face_end = static_cast<int>(f);
    piece = {};
  }
  if (!V.allFinite())
    document_->fail("its transforms take vertices to infinity", "export it again");
  if (character.name.empty()) character.name = character.parts.front().name;
  const std::string who = "character '" + character.name + "': ";
  if (character.non_finite_weight_rows > 0) {
    asset_.warnings.push_back(who + std::to_string(character.non_finite_weight_rows) +
                              " vertices have weights that are not finite; they are ignored");
  }
  if (negative > 0) {
    asset_.warnings.push_back(who + std::to_string(negative) +
                              " vertices have negative weights; these are ignored");
  }
  Welded welded = weld(V, 1e-6 * diagonal(bounding_box(V)));
  character.mesh.V = std::move(welded.V);
  character.vertex_of_input = std::move(welded.vertex);
  character.mesh.F = character.input_faces.unaryExpr([&character](std::int32_t i) {
    return static_cast<std::int32_t>(character.vertex_of_input[static_cast<std::size_t>(i)]);
  });
  if (weighted) {
    SkinWeights weights;
    weights.W.resize(n, character.skeleton.columns);
    weights.W.setFromTriplets(triplets.begin(), triplets.end());
    weights.names = character.skeleton.column_names;
    character.weights = std::move(weights);
  }
}

/// Damaged documents are met by checks with better words; this is the net below them.
template <class Read>
auto guarded(const std::string& name, const Read& read) {
  try {
    return read();
  } catch (const Json::exception&) {
    throw InputError("the glTF document is malformed", name, "export it again");
  }
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

Asset read_gltf(const std::filesystem::path& path) {
  return guarded(path.string(), [&path] {
    return Reader(load_document(read_file(path), path.string(), folder_of(path))).read();
  });
}

Asset read_gltf_bytes(std::span<const std::byte> bytes, std::string name,
                      const std::filesystem::path& folder) {
  return guarded(name, [&] {
    const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return Reader(load_document(view, name, folder)).read();
  });
}

Skeleton read_gltf_skeleton(const std::filesystem::path& path) {
  return guarded(path.string(), [&path] {
    const auto document = load_document(read_file(path), path.string(), folder_of(path));
    std::optional<Skin> chosen;
    std::vector<int> joints;
    for (std::size_t s = 0; s < document->list("skins").size(); ++s) {
      Skin skin = read_skin(*document, static_cast<int>(s));
      std::vector<int> sorted = skin.joints;
      std::sort(sorted.begin(), sorted.end());
      if (chosen && sorted != joints) {
        document->fail("holds more than one skeleton", "keep only the one to use");
      }
      if (!chosen) chosen = std::move(skin);
      joints = std::move(sorted);
    }
    if (!chosen) document->fail("has no skin, so no joints", "give a .tgf or a skinned glTF");
    return make_skeleton(*document, *chosen);
  });
}

}  // namespace skinfield
