#include "io/gltf_writing.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"

#include <algorithm>

namespace skinfield {
namespace {

using namespace gltf;
namespace fs = std::filesystem;

/// A text document that becomes a GLB: all its buffers in one, for the binary chunk. Not where
/// views have extensions, which may name buffers in ways of their own.
void join_buffers(Extension& out) {
  Json& list = out.json["buffers"];
  if (out.buffers.size() < 2 || !list[0].contains("uri") || !out.json.contains("bufferViews")) {
    return;
  }
  Json& views = out.json["bufferViews"];
  const auto extended = [](const Json& view) { return view.contains("extensions"); };
  const auto absent = [](const std::optional<std::string>& bytes) { return !bytes; };
  if (std::any_of(views.begin(), views.end(), extended) ||
      std::any_of(out.buffers.begin(), out.buffers.end(), absent)) {
    return;
  }
  std::string all;
  std::vector<std::size_t> begin;
  for (const std::optional<std::string>& bytes : out.buffers) {
    all.resize((all.size() + 3) / 4 * 4, '\0');
    begin.push_back(all.size());
    all += *bytes;
  }
  for (Json& view : views) {
    const std::size_t offset = view.value("byteOffset", std::size_t{0});
    view["byteOffset"] = begin[view["buffer"].get<std::size_t>()] + offset;
    view["buffer"] = 0;
  }
  list.erase(list.begin() + 1, list.end());
  list[0]["byteLength"] = all.size();
  out.buffers = {std::move(all)};
}

/// Puts the buffers' bytes where the container wants them; gives the binary chunk, if any.
std::optional<std::string> settle_buffers(Extension& out, bool binary) {
  std::optional<std::string> chunk;
  if (binary) join_buffers(out);
  for (std::size_t b = 0; b < out.buffers.size(); ++b) {
    if (!out.buffers[b]) continue;
    Json& buffer = out.json["buffers"][b];
    if (binary && b == 0) {
      buffer.erase("uri");
      chunk = std::move(*out.buffers[b]);
      continue;
    }
    std::string prefix = "data:application/octet-stream;base64,";
    if (buffer.contains("uri") && buffer["uri"].is_string()) {
      const std::string old = buffer["uri"].get<std::string>();
      if (old.starts_with("data:")) prefix = old.substr(0, old.find(',') + 1);
    }
    buffer["uri"] = prefix + encode_base64(*out.buffers[b]);
  }
  return chunk;
}

/// Image files stay where they are, so their links follow the document to another folder.
void relink_images(Json& json, const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (from.empty() || to.empty() || fs::equivalent(from, to, error) || !json.contains("images")) {
    return;
  }
  for (Json& image : json["images"]) {
    if (!image.is_object() || !image.contains("uri") || !image["uri"].is_string()) continue;
    const std::string uri = image["uri"].get<std::string>();
    if (uri.starts_with("data:") || uri.find("://") != std::string::npos) continue;
    const fs::path file = from / decode_uri(uri);
    if (!fs::exists(file, error)) continue;
    const fs::path link = fs::relative(file, to, error);
    if (!error && !link.empty()) image["uri"] = encode_uri(link.generic_string());
  }
}

}  // namespace

std::string format_gltf(const Asset& source, std::span<const SkinWeights> weights, bool binary,
                        const GltfWriteOptions& options, const fs::path& folder) {
  if (weights.size() != source.characters.size()) {
    throw InputError("weights for " + std::to_string(weights.size()) +
                         " characters, the source has " + std::to_string(source.characters.size()),
                     source.path);
  }
  const auto* document = dynamic_cast<const GltfDocument*>(source.document.get());
  if (document && document->characters.size() != source.characters.size()) {
    throw InputError("the asset does not have its document's characters", source.path);
  }
  for (std::size_t c = 0; document && c < document->characters.size(); ++c) {
    for (const Binding& binding : document->characters[c].bindings) {
      if (binding.part_end > static_cast<int>(source.characters[c].parts.size())) {
        throw InputError("the asset does not have its document's parts", source.path);
      }
    }
  }
  try {
    Extension out = document ? patched_document(source, *document, weights, options)
                             : fresh_document(source, weights, options);
    if (document) relink_images(out.json, document->folder, folder);
    Container container;
    container.binary = settle_buffers(out, binary);
    container.json = out.json.dump(binary ? -1 : 2);
    if (!binary) return container.json + "\n";
    if (document) container.further = document->further_chunks;
    return format_glb(container);
  } catch (const Json::exception&) {
    throw InputError("the glTF document is malformed", source.path, "export it again");
  }
}

std::string format_coloured_gltf(const Asset& source, std::span<const Points> colours,
                                 bool binary) {
  bool fits = colours.size() == source.characters.size();
  for (std::size_t c = 0; fits && c < colours.size(); ++c) {
    fits =
        colours[c].rows() == static_cast<Eigen::Index>(source.characters[c].vertex_of_input.size());
  }
  if (!fits) throw InputError("there is not a colour for every vertex", source.path);
  const std::vector<SkinWeights> no_weights(source.characters.size());
  Extension out = fresh_document(source, no_weights, {}, colours);
  Container container;
  container.binary = settle_buffers(out, binary);
  container.json = out.json.dump(binary ? -1 : 2);
  return binary ? format_glb(container) : container.json + "\n";
}

void write_gltf(const Asset& source, std::span<const SkinWeights> weights, const fs::path& path,
                const GltfWriteOptions& options) {
  const std::string extension = lower_extension(path);
  if (extension != ".glb" && extension != ".gltf") {
    throw InputError("glTF is written to .glb or .gltf", path.string(), "change the name");
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  write_file_atomically(path, format_gltf(source, weights, extension == ".glb", options, folder));
}

}  // namespace skinfield
