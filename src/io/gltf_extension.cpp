// Growing a document: new accessors at the end, or in the place of those they replace.
#include "io/gltf_writing.h"

#include <algorithm>

namespace skinfield::gltf {
namespace {

Json& array_of(Json& json, const char* key) {
  if (!json.contains(key)) json[key] = Json::array();
  return json[key];
}

std::int64_t number(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<std::int64_t>() : 0;
}

/// Calls `visit` for every bufferView index that the document holds outside `skip`'s accessors.
template <class Visit>
void for_views(const Json& json, const std::set<int>& skip, const Visit& visit) {
  const auto look = [&visit](const Json& object) {
    const auto found = object.find("bufferView");
    if (found != object.end() && found->is_number()) visit(found->template get<int>());
  };
  // Everything but the accessors is searched whole: extensions may refer to views anywhere.
  std::vector<const Json*> stack;
  for (const auto& [key, value] : json.items()) {
    if (key != "accessors" && value.is_structured()) stack.push_back(&value);
  }
  if (json.contains("accessors")) {
    const Json& accessors = json["accessors"];
    for (std::size_t a = 0; a < accessors.size(); ++a) {
      if (!skip.contains(static_cast<int>(a))) stack.push_back(&accessors[a]);
    }
  }
  while (!stack.empty()) {
    const Json& value = *stack.back();
    stack.pop_back();
    if (value.is_object()) look(value);
    for (const Json& child : value) {
      if (child.is_structured()) stack.push_back(&child);
    }
  }
}

}  // namespace

Extension::Extension(Json given, std::vector<std::optional<std::string>> given_buffers)
    : json(std::move(given)), buffers(std::move(given_buffers)) {
  for (std::size_t b = 0; b < buffers.size() && buffer_ < 0; ++b) {
    if (buffers[b]) buffer_ = static_cast<int>(b);
  }
}

void Extension::release(const std::set<int>& accessors) {
  const std::size_t views = array_of(json, "bufferViews").size();
  for (const int a : accessors) {
    const Json& accessor = json["accessors"][static_cast<std::size_t>(a)];
    if (accessor.contains("sparse")) continue;  // its index and value views would stay behind
    free_accessors_.insert(a);
    const auto view = static_cast<std::size_t>(number(accessor, "bufferView"));
    if (!accessor.contains("bufferView") || view >= views) continue;
    const auto buffer = static_cast<std::size_t>(number(json["bufferViews"][view], "buffer"));
    if (buffer < buffers.size() && buffers[buffer]) free_views_.insert(static_cast<int>(view));
  }
  for_views(json, free_accessors_, [this](int view) { free_views_.erase(view); });
}

std::size_t Extension::append_bytes(int index, const std::string& bytes) {
  std::string& buffer = *buffers[static_cast<std::size_t>(index)];
  buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  const std::size_t offset = buffer.size();
  buffer += bytes;
  json["buffers"][static_cast<std::size_t>(index)]["byteLength"] = buffer.size();
  return offset;
}

int Extension::place_view(const std::string& bytes, int target, int old_view) {
  Json& views = array_of(json, "bufferViews");
  const auto fill = [&](Json& view, int buffer, std::size_t offset) {
    view["buffer"] = buffer;
    view["byteOffset"] = offset;
    view["byteLength"] = bytes.size();
    view.erase("byteStride");
    if (target) view["target"] = target;
  };
  if (old_view < 0 || free_views_.erase(old_view) == 0) {
    if (buffer_ < 0) {
      buffer_ = static_cast<int>(buffers.size());
      array_of(json, "buffers").push_back({{"byteLength", 0}});
      buffers.emplace_back(std::string());
    }
    Json view = Json::object();
    fill(view, buffer_, append_bytes(buffer_, bytes));
    views.push_back(std::move(view));
    return static_cast<int>(views.size()) - 1;
  }
  // The new data goes into the old one's buffer, which might have no other use; in its place if
  // it fits there and nothing else lies there.
  Json& view = views[static_cast<std::size_t>(old_view)];
  const std::int64_t begin = number(view, "byteOffset"), length = number(view, "byteLength");
  const auto buffer = static_cast<int>(number(view, "buffer"));
  bool alone = begin % 4 == 0 && static_cast<std::int64_t>(bytes.size()) <= length;
  for (std::size_t v = 0; v < views.size() && alone; ++v) {
    if (static_cast<int>(v) == old_view || number(views[v], "buffer") != buffer) continue;
    const std::int64_t other = number(views[v], "byteOffset");
    alone = other + number(views[v], "byteLength") <= begin || other >= begin + length;
  }
  if (alone) {
    buffers[static_cast<std::size_t>(buffer)]->replace(static_cast<std::size_t>(begin),
                                                       bytes.size(), bytes);
  }
  fill(view, buffer, alone ? static_cast<std::size_t>(begin) : append_bytes(buffer, bytes));
  return old_view;
}

int Extension::put(const std::string& bytes, Json accessor, int target, int old) {
  const std::string key = accessor.dump() + std::to_string(target) + ":" + bytes;
  Json& accessors = array_of(json, "accessors");
  const bool reuse = old >= 0 && free_accessors_.erase(old) > 0;
  if (!reuse) {
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;
  }
  int old_view = -1, index = old;
  if (reuse) {
    Json& place = accessors[static_cast<std::size_t>(old)];
    if (place.contains("bufferView")) old_view = static_cast<int>(number(place, "bufferView"));
    for (const char* stale :
         {"byteOffset", "componentType", "normalized", "count", "type", "max", "min", "sparse"}) {
      place.erase(stale);
    }
  } else {
    index = static_cast<int>(accessors.size());
    accessors.push_back(Json::object());
  }
  const int view = place_view(bytes, target, old_view);
  Json& place = json["accessors"][static_cast<std::size_t>(index)];
  place["bufferView"] = view;
  for (const auto& [name, value] : accessor.items()) place[name] = value;
  known_.emplace(key, index);
  return index;
}

int Extension::append_node(Json node) {
  Json& nodes = array_of(json, "nodes");
  nodes.push_back(std::move(node));
  return static_cast<int>(nodes.size()) - 1;
}

}  // namespace skinfield::gltf
