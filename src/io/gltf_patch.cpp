// The source's own document with new weights, and new joints where it had none.
#include "io/gltf_writing.h"

#include <algorithm>
#include <tuple>

namespace skinfield::gltf {
namespace {

bool is_own_skeleton(const Skeleton& skeleton, const CharacterSource& source) {
  return skeleton.source == Skeleton::Source::gltf && !source.joints.empty() &&
         std::equal(skeleton.joints.begin(), skeleton.joints.end(), source.joints.begin(),
                    source.joints.end(), [](const Joint& a, const Joint& b) {
                      return a.name == b.name && a.parent == b.parent && a.position == b.position &&
                             a.inverse_bind == b.inverse_bind;
                    });
}

std::vector<int> nodes_of(const Binding& binding) {
  std::vector<int> nodes = binding.twins;
  nodes.insert(nodes.begin(), binding.node);
  return nodes;
}

class Patcher {
 public:
  Patcher(const Asset& source, const GltfDocument& document, std::span<const SkinWeights> weights,
          const GltfWriteOptions& options)
      : source_(source),
        document_(document),
        weights_(weights),
        options_(options),
        out_(document.json, document.buffers) {}

  Extension patch();

 private:
  bool patched(std::size_t c) const { return weights_[c].W.rows() > 0; }
  void find_kept_meshes();
  void release_replaced();
  void patch_character(std::size_t c);
  void put_weights(std::size_t c, const Binding& binding, const std::vector<int>& slots);
  void put_skin(const Binding& binding, const PlacedTree& placed, std::map<std::string, int>& skins,
                const std::string& name);
  bool shows_skin_as_it_is(int node) const;
  std::vector<std::size_t> scenes_of(int node) const;
  void add_to_scenes(int node, const std::vector<std::size_t>& scenes);
  Json& node(int index) { return out_.json["nodes"][static_cast<std::size_t>(index)]; }

  const Asset& source_;
  const GltfDocument& document_;
  std::span<const SkinWeights> weights_;
  const GltfWriteOptions& options_;
  Extension out_;
  std::set<int> kept_;     ///< meshes that an unpatched character needs as they are
  std::set<int> claimed_;  ///< meshes patched in place
};

Extension Patcher::patch() {
  find_kept_meshes();
  release_replaced();
  for (std::size_t c = 0; c < source_.characters.size(); ++c) {
    if (patched(c)) patch_character(c);
  }
  return std::move(out_);
}

void Patcher::find_kept_meshes() {
  for (std::size_t c = 0; c < document_.characters.size(); ++c) {
    if (patched(c)) continue;
    for (const Binding& binding : document_.characters[c].bindings) kept_.insert(binding.mesh);
  }
}

/// Accessors that nothing but the weights to be replaced refers to give their places.
void Patcher::release_replaced() {
  std::set<std::pair<int, int>> replaced;  // mesh, primitive
  for (std::size_t c = 0; c < document_.characters.size(); ++c) {
    if (!patched(c)) continue;
    for (const Binding& binding : document_.characters[c].bindings) {
      if (kept_.contains(binding.mesh)) continue;
      for (int p = binding.part_begin; p < binding.part_end; ++p) {
        const Part& part = source_.characters[c].parts[static_cast<std::size_t>(p)];
        replaced.emplace(part.mesh, part.primitive);
      }
    }
  }
  std::set<int> free, needed;
  const Json& meshes = document_.list("meshes");
  const auto refer = [](std::set<int>& set, const Json& value) {
    if (value.is_number()) set.insert(value.get<int>());
  };
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const auto primitives = meshes[m].find("primitives");
    if (primitives == meshes[m].end()) continue;
    for (std::size_t p = 0; p < primitives->size(); ++p) {
      const Json& primitive = (*primitives)[p];
      const bool is_replaced = replaced.contains({static_cast<int>(m), static_cast<int>(p)});
      const int sets = is_replaced ? count_weight_sets(primitive) : 0;
      std::set<std::string> names;
      for (int s = 0; s < sets; ++s) {
        names.insert("JOINTS_" + std::to_string(s));
        names.insert("WEIGHTS_" + std::to_string(s));
      }
      for (const auto& [key, value] : primitive.items()) {
        if (key == "indices") refer(needed, value);
        if (key == "attributes") {
          for (const auto& [name, index] : value.items()) {
            refer(names.contains(name) ? free : needed, index);
          }
        }
        if (key == "targets") {
          for (const Json& target : value) {
            for (const Json& index : target) refer(needed, index);
          }
        }
      }
    }
  }
  for (const Json& skin : document_.list("skins")) {
    if (skin.contains("inverseBindMatrices")) refer(needed, skin["inverseBindMatrices"]);
  }
  for (const Json& animation : document_.list("animations")) {
    if (!animation.contains("samplers")) continue;
    for (const Json& sampler : animation["samplers"]) {
      for (const char* key : {"input", "output"}) {
        if (sampler.contains(key)) refer(needed, sampler[key]);
      }
    }
  }
  for (const int index : needed) free.erase(index);
  out_.release(free);
}

void Patcher::patch_character(std::size_t c) {
  const Character& character = source_.characters[c];
  const CharacterSource& origin = document_.characters[c];
  const int columns = static_cast<int>(weights_[c].W.cols());
  if (weights_[c].W.rows() != static_cast<Eigen::Index>(character.vertex_of_input.size())) {
    throw InputError("the weights have " + std::to_string(weights_[c].W.rows()) +
                         " rows, character '" + character.name + "' has " +
                         std::to_string(character.vertex_of_input.size()) + " vertices",
                     document_.name);
  }
  if (is_own_skeleton(character.skeleton, origin)) {
    if (columns != static_cast<int>(origin.joints.size())) {
      throw InputError("the weights have " + std::to_string(columns) + " columns, the skin " +
                           std::to_string(origin.joints.size()) + " joints",
                       document_.name);
    }
    for (const Binding& binding : origin.bindings) put_weights(c, binding, binding.slot_of_column);
    return;
  }
  const PlacedTree placed = place_tree(out_, make_joint_tree(character.skeleton, columns));
  std::set<std::size_t> scenes;
  for (const Binding& binding : origin.bindings) {
    for (const std::size_t s : scenes_of(binding.node)) scenes.insert(s);
  }
  add_to_scenes(placed.root, {scenes.begin(), scenes.end()});
  std::map<std::string, int> skins;
  for (const Binding& binding : origin.bindings) {
    put_weights(c, binding, placed.tree.joint_of_column);
    put_skin(binding, placed, skins, character.name);
  }
}

void Patcher::put_weights(std::size_t c, const Binding& binding, const std::vector<int>& slots) {
  int mesh = binding.mesh;
  Json& meshes = out_.json["meshes"];
  if (kept_.contains(mesh) || !claimed_.insert(mesh).second) {
    meshes.push_back(document_.json["meshes"][static_cast<std::size_t>(mesh)]);
    mesh = static_cast<int>(meshes.size()) - 1;
    for (const int n : nodes_of(binding)) node(n)["mesh"] = mesh;
  }
  Json& primitives = meshes[static_cast<std::size_t>(mesh)]["primitives"];
  for (int p = binding.part_begin; p < binding.part_end; ++p) {
    const Part& part = source_.characters[c].parts[static_cast<std::size_t>(p)];
    Json& primitive = primitives[static_cast<std::size_t>(part.primitive)];
    // Sets that fall empty stay: without them the document would hold unused accessors.
    set_weights(out_, primitive,
                pack_weights(weights_[c].W, part.begin, part.end, slots, options_.format,
                             count_weight_sets(primitive)));
  }
}

/// A skinned mesh belongs to a root node without a transform, or to one that had a skin before.
/// Nodes whose morph weights are animated, or that extensions concern, stay as they are, too.
bool Patcher::shows_skin_as_it_is(int index) const {
  const Node& place = document_.nodes[static_cast<std::size_t>(index)];
  const Json& json = document_.json["nodes"][static_cast<std::size_t>(index)];
  if (json.contains("skin") || json.contains("extensions")) return true;
  if (place.parent < 0 && local_transform(place).isIdentity(0)) return true;
  for (const Json& animation : document_.list("animations")) {
    if (!animation.contains("channels")) continue;
    for (const Json& channel : animation["channels"]) {
      const auto target = channel.find("target");
      if (target == channel.end() || !target->is_object()) continue;
      if (document_.text(*target, "path") == "weights" && target->contains("node") &&
          (*target)["node"] == index) {
        return true;
      }
    }
  }
  return false;
}

void Patcher::put_skin(const Binding& binding, const PlacedTree& placed,
                       std::map<std::string, int>& skins, const std::string& name) {
  const Transform& T = binding.to_character;
  const std::string key(reinterpret_cast<const char*>(T.data()), sizeof(double) * 16);
  auto found = skins.find(key);
  if (found == skins.end()) {
    found = skins.emplace(key, append_skin(out_, placed, T, name)).first;
  }
  for (const int n : nodes_of(binding)) {
    if (shows_skin_as_it_is(n)) {
      node(n)["skin"] = found->second;
      continue;
    }
    Json shown = Json::object();
    for (const char* moved : {"name", "mesh", "weights"}) {
      if (node(n).contains(moved)) shown[moved] = node(n)[moved];
    }
    shown["skin"] = found->second;
    node(n).erase("mesh");
    node(n).erase("weights");
    const int root = out_.append_node(std::move(shown));
    // Says where its mesh went; the validator takes a node without anything for a mistake.
    Json& left = node(n);
    if (!left.contains("extras")) left["extras"] = {{"skinned_mesh_node", root}};
    add_to_scenes(root, scenes_of(n));
  }
}

std::vector<std::size_t> Patcher::scenes_of(int index) const {
  int root = index;
  while (document_.nodes[static_cast<std::size_t>(root)].parent >= 0) {
    root = document_.nodes[static_cast<std::size_t>(root)].parent;
  }
  std::vector<std::size_t> found;
  const Json& scenes = document_.list("scenes");
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    for (const int n : document_.indices(scenes[s], "nodes", "nodes", "scene")) {
      if (n == root || n == index) {
        found.push_back(s);
        break;
      }
    }
  }
  return found;
}

void Patcher::add_to_scenes(int index, const std::vector<std::size_t>& scenes) {
  for (const std::size_t s : scenes) out_.json["scenes"][s]["nodes"].push_back(index);
}

}  // namespace

Extension patched_document(const Asset& source, const GltfDocument& document,
                           std::span<const SkinWeights> weights, const GltfWriteOptions& options) {
  return Patcher(source, document, weights, options).patch();
}

}  // namespace skinfield::gltf
