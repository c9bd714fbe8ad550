// What differs between two glTF documents beyond their skinning weights.
#pragma once

#include "io/gltf_document.h"

#include <set>
#include <string>
#include <vector>

namespace skinfield_test {

namespace detail {

using skinfield::gltf::Json;

inline bool is_weight_attribute(const std::string& name) {
  return name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
}

inline std::set<int> weight_accessors(const Json& json) {
  std::set<int> found;
  if (!json.contains("meshes")) return found;
  for (const Json& mesh : json["meshes"]) {
    for (const Json& primitive : mesh["primitives"]) {
      for (const auto& [name, index] : primitive["attributes"].items()) {
        if (is_weight_attribute(name)) found.insert(index.get<int>());
      }
    }
  }
  return found;
}

/// Keys in order, values equal; weight attributes are passed over.
inline void compare(const Json& a, const Json& b, const std::string& at,
                    std::vector<std::string>& out) {
  if (a.type() != b.type() || a.size() != b.size()) {
    out.push_back(at + ": type or size differs");
  } else if (a.is_object()) {
    for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
      if (i.key() != j.key()) {
        out.push_back(at + ": key " + i.key() + " against " + j.key());
      } else if (!is_weight_attribute(i.key())) {
        compare(i.value(), j.value(), at + "/" + i.key(), out);
      }
    }
  } else if (a.is_array()) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      compare(a[i], b[i], at + "/" + std::to_string(i), out);
    }
  } else if (a != b) {
    out.push_back(at + ": " + a.dump() + " against " + b.dump());
  }
}

}  // namespace detail

/// Every difference that rebinding under the same skeleton may not make: anything outside
/// accessors, bufferViews, buffers and weight attributes; any accessor of the source (but those of
/// weights) that is no longer there, or has other values.
inline std::vector<std::string> unexpected_changes(const std::string& before,
                                                   const std::string& after) {
  using namespace detail;
  const auto a = skinfield::gltf::load_document(before, "before", {});
  const auto b = skinfield::gltf::load_document(after, "after", {});
  std::vector<std::string> out;
  std::vector<std::string> keys_a, keys_b;
  for (const auto& [key, value] : a->json.items()) keys_a.push_back(key);
  for (const auto& [key, value] : b->json.items()) keys_b.push_back(key);
  if (keys_a != keys_b) out.push_back("/: keys or their order differ");
  for (const auto& [key, value] : a->json.items()) {
    if (key == "accessors" || key == "bufferViews" || key == "buffers") continue;
    if (b->json.contains(key)) compare(value, b->json[key], "/" + key, out);
  }
  const std::set<int> replaced = weight_accessors(a->json);
  for (std::size_t i = 0; i < a->list("accessors").size(); ++i) {
    if (replaced.contains(static_cast<int>(i))) continue;
    const std::string at = "/accessors/" + std::to_string(i);
    if (i >= b->list("accessors").size()) {
      out.push_back(at + ": missing");
      continue;
    }
    compare(a->json["accessors"][i], b->json["accessors"][i], at, out);
    const std::string type = a->text(a->json["accessors"][i], "type");
    const auto old = read_accessor(*a, static_cast<int>(i), {type}, at);
    const auto now = read_accessor(*b, static_cast<int>(i), {type}, at);
    if (std::memcmp(old.values.data(), now.values.data(), 8 * old.values.size()) != 0) {
      out.push_back(at + ": other values");
    }
  }
  return out;
}

}  // namespace skinfield_test
