#include "io/bytes.h"
#include "io/gltf_document.h"

namespace skinfield::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;

void put_chunk(std::string& out, std::uint32_t type, std::string_view bytes, char padding) {
  const std::size_t padded = (bytes.size() + 3) / 4 * 4;
  put_little(out, static_cast<std::uint32_t>(padded));
  put_little(out, type);
  out.append(bytes);
  out.append(padded - bytes.size(), padding);
}

}  // namespace

bool is_glb(std::string_view bytes) { return bytes.starts_with("glTF"); }

Container parse_glb(std::string_view bytes, const std::string& name) {
  ByteReader header(bytes, name);
  if (header.get<std::uint32_t>("the GLB header") != kMagic) {
    throw InputError("is no GLB: wrong magic number", name, "export it again");
  }
  const auto version = header.get<std::uint32_t>("the GLB header");
  if (version != 2) {
    throw InputError("GLB version " + std::to_string(version) + " is not read", name,
                     "convert it to glTF 2.0");
  }
  const auto length = header.get<std::uint32_t>("the GLB header");
  if (length > bytes.size() || length < 20) {
    throw InputError("truncated GLB: the header says " + std::to_string(length) +
                         " bytes, the file has " + std::to_string(bytes.size()),
                     name, "copy or export it again");
  }
  Container container;
  ByteReader reader(bytes.substr(12, length - 12), name + ": GLB chunks");
  bool first = true;
  while (reader.remaining() >= 8) {
    const auto size = reader.get<std::uint32_t>("a GLB chunk header");
    const auto type = reader.get<std::uint32_t>("a GLB chunk header");
    const std::string_view data = reader.take(size, "a GLB chunk");
    if (first) {
      if (type != kJson)
        throw InputError("the first GLB chunk is not JSON", name, "export it again");
      container.json = data;
    } else if (type == kBinary && !container.binary) {
      container.binary = std::string(data);
    } else {
      container.further.emplace_back(type, std::string(data));
    }
    first = false;
  }
  if (first) throw InputError("GLB without chunks", name, "export it again");
  return container;
}

std::string format_glb(const Container& container) {
  std::string body;
  put_chunk(body, kJson, container.json, ' ');
  if (container.binary) put_chunk(body, kBinary, *container.binary, '\0');
  for (const auto& [type, data] : container.further) put_chunk(body, type, data, '\0');
  if (body.size() + 12 > UINT32_MAX) {
    throw IoError("a GLB holds at most 4 GB", {}, "write .gltf instead");
  }
  std::string out;
  put_little(out, kMagic);
  put_little(out, std::uint32_t{2});
  put_little(out, static_cast<std::uint32_t>(body.size() + 12));
  return out + body;
}

}  // namespace skinfield::gltf
