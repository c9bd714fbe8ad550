// Builds small glTF documents in code, so that tests need no files.
#pragma once

#include "io/gltf_document.h"
#include "skinfield/io/gltf.h"

#include <cstring>
#include <string>
#include <vector>

namespace skinfield_test {

using skinfield::gltf::Json;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

class GltfBuilder {
 public:
  Json json = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", Json::array({Json{{"nodes", Json::array({0})}}})}};
  std::string binary;

  int view(const std::string& bytes, int stride = 0, int target = 0) {
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    Json view = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
    if (stride) view["byteStride"] = stride;
    if (target) view["target"] = target;
    binary += bytes;
    return push("bufferViews", std::move(view));
  }
  int accessor(int view_index, int component_type, int count, const std::string& type,
               Json more = Json::object()) {
    Json accessor = {{"componentType", component_type}, {"count", count}, {"type", type}};
    if (view_index >= 0) accessor["bufferView"] = view_index;
    for (const auto& [key, value] : more.items()) accessor[key] = value;
    return push("accessors", std::move(accessor));
  }
  template <class T>
  int add(const std::vector<T>& values, int component_type, int count, const std::string& type,
          Json more = Json::object()) {
    return accessor(view(bytes_of(values)), component_type, count, type, std::move(more));
  }
  int push(const char* key, Json value) {
    if (!json.contains(key)) json[key] = Json::array();
    json[key].push_back(std::move(value));
    return static_cast<int>(json[key].size()) - 1;
  }

  std::string glb() const {
    skinfield::gltf::Container container;
    Json whole = json;
    whole["buffers"] = Json::array({Json{{"byteLength", binary.size()}}});
    container.json = whole.dump();
    container.binary = binary;
    return skinfield::gltf::format_glb(container);
  }
  std::string text(const std::string& uri = {}) const {
    Json whole = json;
    const std::string data =
        "data:application/octet-stream;base64," + skinfield::gltf::encode_base64(binary);
    whole["buffers"] =
        Json::array({Json{{"byteLength", binary.size()}, {"uri", uri.empty() ? data : uri}}});
    return whole.dump();
  }
};

inline skinfield::Asset read(const std::string& bytes, const std::string& name = "test.glb") {
  return skinfield::read_gltf_bytes(std::as_bytes(std::span(bytes.data(), bytes.size())), name);
}

/// A unit square of two triangles in z = 0, bound to two joints at (0,0,0) and (0,1,0); nodes: 0
/// the mesh, 1 the root joint, 2 its child, 3 the child's tip `b_end` at (0,2,0).
/// Weights: lower corners follow joint 0, upper ones are shared 0.25 : 0.75.
inline GltfBuilder skinned_square() {
  GltfBuilder b;
  const int position = b.add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 5126, 4, "VEC3",
                                    {{"min", {0.0, 0.0, 0.0}}, {"max", {1.0, 1.0, 0.0}}});
  const int index = b.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, 6, "SCALAR");
  const int joints =
      b.add<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 5121, 4, "VEC4");
  const int weights = b.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0, 0.75f, 0.25f, 0, 0},
                                   5126, 4, "VEC4");
  const int binds = b.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                                 5126, 2, "MAT4");
  b.push(
      "meshes",
      {{"name", "square"},
       {"primitives",
        Json::array({Json{
            {"attributes", {{"POSITION", position}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
            {"indices", index}}})}});
  b.push("nodes", {{"name", "square"}, {"mesh", 0}, {"skin", 0}});
  b.push("nodes", {{"name", "a"}, {"children", Json::array({2})}});
  b.push("nodes",
         {{"name", "b"}, {"translation", {0.0, 1.0, 0.0}}, {"children", Json::array({3})}});
  b.push("nodes", {{"name", "b_end"}, {"translation", {0.0, 1.0, 0.0}}});
  b.push("skins", {{"inverseBindMatrices", binds}, {"joints", Json::array({1, 2})}});
  b.json["scenes"][0]["nodes"] = {0, 1};
  return b;
}

}  // namespace skinfield_test
