#include "io/gltf_document.h"

#include "skinfield/io/file.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace skinfield::gltf {
namespace {

constexpr int kDeepestNesting = 200;

/// Deep nesting would exhaust the stack of a recursive writer; no document needs it.
bool nested_too_deeply(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kDeepestNesting) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

Json parse_json(std::string_view text, const std::string& name) {
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.remove_suffix(1);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (nested_too_deeply(text)) throw InputError("JSON nested too deeply", name, "export it again");
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InputError("the JSON is damaged at byte " + std::to_string(error.byte), name,
                     "export it again");
  } catch (const Json::exception&) {
    json = nullptr;
  }
  if (!json.is_object()) throw InputError("the JSON is damaged", name, "export it again");
  return json;
}

bool contains_word(const std::string& text, std::initializer_list<const char*> words) {
  std::string lower;
  for (const char c : text) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return std::any_of(words.begin(), words.end(),
                     [&lower](const char* word) { return lower.find(word) != std::string::npos; });
}

void check_extensions(const GltfDocument& document) {
  for (const Json& entry : document.list("extensionsRequired")) {
    if (!entry.is_string()) document.fail("extensionsRequired holds something that is no name");
    const std::string extension = entry.get<std::string>();
    if (extension == "KHR_mesh_quantization" || extension == "EXT_mesh_gpu_instancing") continue;
    if (extension.find("draco") != std::string::npos) {
      document.fail("its geometry is compressed with " + extension + ", which is not read",
                    "decompress it first: npx @gltf-transform/cli copy IN.glb OUT.glb, or export "
                    "without Draco compression");
    }
    if (extension.find("meshopt") != std::string::npos) {
      document.fail("its geometry is compressed with " + extension + ", which is not read",
                    "decompress it first: npx @gltf-transform/cli copy IN.glb OUT.glb, or export "
                    "without meshopt compression");
    }
    if (contains_word(extension, {"mesh", "compress", "buffer", "accessor", "geometry", "skin"})) {
      document.fail("requires the extension " + extension + ", which is not read",
                    "export it without that extension");
    }
  }
}

void load_buffers(GltfDocument& document, std::optional<std::string> binary) {
  const Json& buffers = document.list("buffers");
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::string who = "buffer " + std::to_string(i);
    const Json& buffer = document.item("buffers", static_cast<std::int64_t>(i), who);
    const std::int64_t length = document.integer(buffer, "byteLength", 0, who);
    std::optional<std::string> data;
    if (!buffer.contains("uri")) {
      if (i == 0) data = std::exchange(binary, std::nullopt);
    } else {
      const std::string uri = document.text(buffer, "uri");
      if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        bool valid = comma != std::string::npos &&
                     std::string_view(uri).substr(0, comma).ends_with(";base64");
        if (valid) data = decode_base64(std::string_view(uri).substr(comma + 1), valid);
        if (!valid) document.fail(who + ": damaged data URI", "export it again");
      } else {
        if (uri.find("://") != std::string::npos) {
          document.fail(who + " is on a network: " + uri, "download it and its buffers first");
        }
        if (document.folder.empty()) {
          document.fail(who + " is in a file of its own: " + uri, "give the path of the glTF");
        }
        data = read_file(document.folder / decode_uri(uri));
      }
    }
    if (data && static_cast<std::uint64_t>(length) > data->size()) {
      document.fail("truncated: " + who + " says " + std::to_string(length) + " bytes and has " +
                        std::to_string(data->size()),
                    "copy or export it again");
    }
    if (data) data->resize(static_cast<std::size_t>(length));
    document.buffers.push_back(std::move(data));
  }
}

template <int N>
bool read_numbers(const GltfDocument& document, const Json& node, const char* key,
                  std::array<double, N>& out, const std::string& who) {
  const auto found = node.find(key);
  if (found == node.end()) return false;
  if (!found->is_array() || found->size() != N) {
    document.fail(who + ": " + key + " needs " + std::to_string(N) + " numbers");
  }
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*found)[i].is_number()) document.fail(who + ": " + key + " holds no numbers");
    out[i] = (*found)[i].template get<double>();
  }
  return true;
}

void load_nodes(GltfDocument& document) {
  const Json& list = document.list("nodes");
  document.nodes.resize(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string who = "node " + std::to_string(i);
    const Json& json = document.item("nodes", static_cast<std::int64_t>(i), who);
    Node& node = document.nodes[i];
    std::array<double, 16> matrix;
    if (read_numbers<16>(document, json, "matrix", matrix, who)) {
      node.has_matrix = true;
      node.matrix = Eigen::Map<const Transform>(matrix.data());
      node.matrix.row(3) << 0, 0, 0, 1;
    }
    std::array<double, 3> v;
    std::array<double, 4> q;
    if (read_numbers<3>(document, json, "translation", v, who))
      node.translation << v[0], v[1], v[2];
    if (read_numbers<3>(document, json, "scale", v, who)) node.scale << v[0], v[1], v[2];
    if (read_numbers<4>(document, json, "rotation", q, who))
      node.rotation << q[0], q[1], q[2], q[3];
    node.children = document.indices(json, "children", "nodes", who);
    for (const int child : node.children) {
      if (document.nodes[static_cast<std::size_t>(child)].parent >= 0) {
        document.fail("node " + std::to_string(child) + " has two parents, or is one's child twice",
                      "export it again");
      }
      document.nodes[static_cast<std::size_t>(child)].parent = static_cast<int>(i);
    }
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (document.nodes[i].parent < 0) document.node_order.push_back(static_cast<int>(i));
  }
  for (std::size_t k = 0; k < document.node_order.size(); ++k) {
    const Node& node = document.nodes[static_cast<std::size_t>(document.node_order[k])];
    document.node_order.insert(document.node_order.end(), node.children.begin(),
                               node.children.end());
  }
  // Every node has at most one parent, so those that no root reaches are in a cycle or below one.
  if (document.node_order.size() != list.size()) {
    document.fail("its nodes form a cycle: one is its own ancestor", "export it again");
  }
}

}  // namespace

void GltfDocument::fail(const std::string& what, const std::string& remedy) const {
  throw InputError(what, name, remedy);
}

const Json& GltfDocument::list(const char* key) const {
  static const Json empty = Json::array();
  const auto found = json.find(key);
  if (found == json.end()) return empty;
  if (!found->is_array()) fail(std::string(key) + " is no array", "export it again");
  return *found;
}

const Json& GltfDocument::item(const char* key, std::int64_t index, const std::string& who) const {
  const Json& array = list(key);
  if (index < 0 || static_cast<std::uint64_t>(index) >= array.size()) {
    fail(who + ": index " + std::to_string(index) + " is out of range of the " +
             std::to_string(array.size()) + " " + key,
         "export it again");
  }
  const Json& object = array[static_cast<std::size_t>(index)];
  if (!object.is_object()) {
    fail(std::string(key) + "[" + std::to_string(index) + "] is no object", "export it again");
  }
  return object;
}

std::int64_t GltfDocument::integer(const Json& object, const char* key, std::int64_t fallback,
                                   const std::string& who) const {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  // Some exporters write 3.0 for 3; 2^53 bounds what a double counts exactly.
  if (found->is_number()) {
    const double value = found->get<double>();
    if (value >= 0 && value <= 9007199254740992.0 && value == std::floor(value)) {
      return static_cast<std::int64_t>(value);
    }
  }
  fail(who + ": " + key + " is no index or size", "export it again");
}

int GltfDocument::index(const Json& object, const char* key, const char* list_key,
                        const std::string& who) const {
  if (!object.contains(key)) return -1;
  const std::int64_t value = integer(object, key, -1, who);
  item(list_key, value, who + ": " + key);
  return static_cast<int>(value);
}

std::vector<int> GltfDocument::indices(const Json& object, const char* key, const char* list_key,
                                       const std::string& who) const {
  std::vector<int> result;
  const auto found = object.find(key);
  if (found == object.end()) return result;
  if (!found->is_array()) fail(who + ": " + key + " is no array", "export it again");
  const std::size_t size = list(list_key).size();
  for (const Json& entry : *found) {
    const double value = entry.is_number() ? entry.get<double>() : -1;
    if (!(value >= 0 && value < static_cast<double>(size) && value == std::floor(value))) {
      fail(who + ": " + key + " names something out of range of the " + std::to_string(size) + " " +
               list_key,
           "export it again");
    }
    result.push_back(static_cast<int>(value));
  }
  return result;
}

std::string GltfDocument::text(const Json& object, const char* key) const {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::vector<Transform> GltfDocument::world_transforms() const {
  std::vector<Transform> world(nodes.size());
  for (const int i : node_order) {
    const Node& node = nodes[static_cast<std::size_t>(i)];
    world[static_cast<std::size_t>(i)] = local_transform(node);
    if (node.parent >= 0) {
      world[static_cast<std::size_t>(i)] =
          world[static_cast<std::size_t>(node.parent)] * world[static_cast<std::size_t>(i)];
    }
  }
  return world;
}

Transform compose(const Vec3& translation, const Eigen::Vector4d& rotation, const Vec3& scale) {
  const double length = rotation.norm();
  const Eigen::Vector4d q =
      length > 0 ? Eigen::Vector4d(rotation / length) : Eigen::Vector4d(0, 0, 0, 1);
  Transform T = Transform::Identity();
  T.topLeftCorner<3, 3>() =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix() * scale.asDiagonal();
  T.topRightCorner<3, 1>() = translation;
  return T;
}

Transform local_transform(const Node& node) {
  return node.has_matrix ? node.matrix : compose(node.translation, node.rotation, node.scale);
}

std::shared_ptr<GltfDocument> load_document(std::string_view bytes, std::string name,
                                            const std::filesystem::path& folder) {
  auto document = std::make_shared<GltfDocument>();
  document->name = std::move(name);
  document->folder = folder;
  document->source_bytes = bytes.size();
  document->binary = is_glb(bytes);
  Container container;
  if (document->binary) {
    container = parse_glb(bytes, document->name);
  } else {
    container.json = bytes;
  }
  document->json = parse_json(container.json, document->name);
  const auto asset = document->json.find("asset");
  if (asset == document->json.end() || !asset->is_object() ||
      !document->text(*asset, "version").starts_with("2.")) {
    document->fail("is no glTF 2.0 document", "convert it to glTF 2.0");
  }
  check_extensions(*document);
  load_buffers(*document, std::move(container.binary));
  document->further_chunks = std::move(container.further);
  load_nodes(*document);
  return document;
}

}  // namespace skinfield::gltf
