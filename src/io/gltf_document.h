// A glTF document as it was read, and checked access to it. Private to io.
#pragma once

#include "skinfield/base/error.h"
#include "skinfield/io/asset.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skinfield::gltf {

using Json = nlohmann::ordered_json;

/// The GLB container: a JSON chunk, a binary chunk, and whatever else follows.
struct Container {
  std::string json;
  std::optional<std::string> binary;
  std::vector<std::pair<std::uint32_t, std::string>> further;
};
bool is_glb(std::string_view bytes);
Container parse_glb(std::string_view bytes, const std::string& name);
std::string format_glb(const Container& container);

/// A node's transform relative to its parent.
struct Node {
  int parent = -1;
  std::vector<int> children;
  bool has_matrix = false;
  Transform matrix = Transform::Identity();
  Vec3 translation = Vec3::Zero(), scale = Vec3::Ones();
  Eigen::Vector4d rotation{0, 0, 0, 1};  ///< xyzw
};
Transform local_transform(const Node& node);
Transform compose(const Vec3& translation, const Eigen::Vector4d& rotation, const Vec3& scale);

/// A mesh under a node: the place where a character's input vertices come from.
struct Binding {
  int node = -1, mesh = -1, skin = -1;
  std::vector<int> twins;           ///< further nodes that show exactly the same vertices
  std::vector<int> slot_of_column;  ///< place of the character's joints in this skin
  Transform to_character = Transform::Identity();  ///< POSITION space -> character space
  int part_begin = 0, part_end = 0;                ///< its parts in Character::parts
};

struct CharacterSource {
  std::vector<int> joint_nodes;  ///< (columns), empty for characters without a skin
  std::vector<Joint> joints;     ///< as the reader made them
  std::vector<Binding> bindings;
};

class GltfDocument : public Document {
 public:
  std::string name;              ///< the file, for messages
  std::filesystem::path folder;  ///< where its links start; empty if read from memory
  std::size_t source_bytes = 0;
  bool binary = false;
  Json json;
  std::vector<std::optional<std::string>> buffers;  ///< nothing where a buffer has no data
  std::vector<std::pair<std::uint32_t, std::string>> further_chunks;
  std::vector<Node> nodes;
  std::vector<int> node_order;  ///< parents before their children
  std::vector<CharacterSource> characters;

  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const;
  /// The array under `key` of the root, or an empty one.
  const Json& list(const char* key) const;
  /// Element `index` of such an array; `who` refers to it.
  const Json& item(const char* key, std::int64_t index, const std::string& who) const;
  /// An index or size under `key`, or `fallback` where there is none.
  std::int64_t integer(const Json& object, const char* key, std::int64_t fallback,
                       const std::string& who) const;
  /// As above, but an index into the array `list_key`, or -1 where there is none.
  int index(const Json& object, const char* key, const char* list_key,
            const std::string& who) const;
  /// An array of indices into `list_key`.
  std::vector<int> indices(const Json& object, const char* key, const char* list_key,
                           const std::string& who) const;
  std::string text(const Json& object, const char* key) const;
  std::vector<Transform> world_transforms() const;
};

/// Parses container, JSON, buffers and nodes; checks required extensions.
std::shared_ptr<GltfDocument> load_document(std::string_view bytes, std::string name,
                                            const std::filesystem::path& folder);

/// Values of an accessor as doubles, normalised integers scaled, sparse ones filled in.
struct AccessorValues {
  std::size_t count = 0;
  int components = 0;
  int component_type = 0;
  std::vector<double> values;  ///< (count * components)
  double operator()(std::size_t row, int component) const {
    return values[row * static_cast<std::size_t>(components) + static_cast<std::size_t>(component)];
  }
};
/// `types`: the glTF types allowed, e.g. "VEC3". `who` names the referrer in messages.
AccessorValues read_accessor(const GltfDocument& document, int accessor,
                             std::initializer_list<std::string_view> types, const std::string& who);
int component_size(int component_type);

std::string decode_base64(std::string_view text, bool& valid);
std::string encode_base64(std::string_view bytes);
std::string decode_uri(std::string_view uri);
std::string encode_uri(std::string_view path);

/// Joint lists and inverse bind matrices of one skin.
struct Skin {
  std::string name;
  std::vector<int> joints;              ///< nodes
  std::vector<Transform> inverse_bind;  ///< (joints)
  bool useful_binds = true;             ///< false: all identity, so they place no joint
};
Skin read_skin(const GltfDocument& document, int skin);
Skeleton make_skeleton(const GltfDocument& document, const Skin& skin);

/// One primitive's vertices, faces and weights as they are in the file.
struct PrimitiveData {
  Points V, N;  ///< N empty where there are none
  Triangles F;  ///< indices into V
  bool weighted = false;
  std::vector<Eigen::Triplet<double>> weights;  ///< (vertex, joint slot, weight), rows sum to 1
  int non_finite_rows = 0, negative_rows = 0;
};
/// `slots`: joints of its skin, 0 without one.
PrimitiveData read_primitive(const GltfDocument& document, const Json& primitive, int slots,
                             const std::string& who);

/// Skins of equal key move vertices in the same way, so a mesh under two of them is the same twice.
std::string skin_key(const Skin& skin);
/// Applies a transform to positions and, by its inverse transpose, to normals.
void move_piece(const Transform& T, PrimitiveData& piece);
/// Takes pieces from their skin's bind space to that of the `first` skin and returns the map.
/// `slot_of_column`: places in `skin` of the first one's joints. `posed`: the two skins were bound
/// in different poses, so no one map does it and vertices followed their weights.
Transform place_in_bind_space(const Skin& first, const Skin& skin,
                              const std::vector<int>& slot_of_column,
                              std::vector<PrimitiveData>& pieces, bool& posed);

}  // namespace skinfield::gltf
