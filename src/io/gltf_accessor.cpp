#include "io/gltf_document.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace skinfield::gltf {
namespace {

enum ComponentType {
  kByte = 5120,
  kUnsignedByte,
  kShort,
  kUnsignedShort,
  kUnsignedInt = 5125,
  kFloat
};

int components_of(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  if (type == "MAT4") return 16;
  return 0;
}

template <class T>
T load(const char* at) {
  static_assert(std::endian::native == std::endian::little, "glTF's numbers are little-endian");
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

double load_component(const char* at, int type, bool normalised) {
  switch (type) {
    case kByte: {
      const double v = load<std::int8_t>(at);
      return normalised ? std::max(v / 127, -1.0) : v;
    }
    case kUnsignedByte: {
      const double v = load<std::uint8_t>(at);
      return normalised ? v / 255 : v;
    }
    case kShort: {
      const double v = load<std::int16_t>(at);
      return normalised ? std::max(v / 32767, -1.0) : v;
    }
    case kUnsignedShort: {
      const double v = load<std::uint16_t>(at);
      return normalised ? v / 65535 : v;
    }
    case kUnsignedInt:
      return load<std::uint32_t>(at);
    default:
      return load<float>(at);
  }
}

/// Checked bytes of `count` elements of `element` bytes each, and the step between them.
struct Run {
  const char* at = nullptr;
  std::size_t stride = 0;
};
Run checked_run(const GltfDocument& document, int view_index, std::int64_t offset,
                std::int64_t count, std::int64_t element, const std::string& who) {
  const Json& view = document.item("bufferViews", view_index, who);
  const std::string view_name = who + ": bufferView " + std::to_string(view_index);
  const int buffer = document.index(view, "buffer", "buffers", view_name);
  if (buffer < 0) document.fail(view_name + " names no buffer", "export it again");
  const auto& data = document.buffers[static_cast<std::size_t>(buffer)];
  if (!data) {
    document.fail(view_name + ": buffer " + std::to_string(buffer) + " has no data",
                  "if it is compressed (meshopt), decompress it first: npx @gltf-transform/cli "
                  "copy IN.glb OUT.glb");
  }
  const std::int64_t size = static_cast<std::int64_t>(data->size());
  const std::int64_t begin = document.integer(view, "byteOffset", 0, view_name);
  const std::int64_t length = document.integer(view, "byteLength", 0, view_name);
  if (begin > size || length > size - begin) {
    document.fail(
        view_name + " is out of range of its buffer of " + std::to_string(size) + " bytes",
        "the file is truncated or damaged; export it again");
  }
  std::int64_t stride = document.integer(view, "byteStride", element, view_name);
  if (stride == 0) stride = element;
  if (stride > 65536) document.fail(view_name + ": byteStride is too large", "export it again");
  if (count > 0 && (offset > length || element > length - offset ||
                    count - 1 > (length - offset - element) / stride)) {
    document.fail(who + ": claims " + std::to_string(count) + " elements, more than bufferView " +
                      std::to_string(view_index) + " holds",
                  "the file is truncated or damaged; export it again");
  }
  Run run;
  if (count > 0) run.at = data->data() + begin + offset;
  run.stride = static_cast<std::size_t>(stride);
  return run;
}

void fill_sparse(const GltfDocument& document, const Json& sparse, bool normalised,
                 AccessorValues& out, const std::string& who) {
  const std::int64_t count = document.integer(sparse, "count", 0, who);
  const auto indices = sparse.find("indices"), values = sparse.find("values");
  if (indices == sparse.end() || values == sparse.end() || !indices->is_object() ||
      !values->is_object()) {
    document.fail(who + " lacks its indices or values", "export it again");
  }
  const auto type = static_cast<int>(document.integer(*indices, "componentType", 0, who));
  if (type != kUnsignedByte && type != kUnsignedShort && type != kUnsignedInt) {
    document.fail(who + ": unknown componentType of its indices", "export it again");
  }
  const int size = component_size(out.component_type);
  const std::int64_t element = std::int64_t{size} * out.components;
  const Run where = checked_run(
      document, document.index(*indices, "bufferView", "bufferViews", who),
      document.integer(*indices, "byteOffset", 0, who), count, component_size(type), who);
  const Run what =
      checked_run(document, document.index(*values, "bufferView", "bufferViews", who),
                  document.integer(*values, "byteOffset", 0, who), count, element, who);
  for (std::int64_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double row = load_component(where.at + k * where.stride, type, false);
    if (row >= static_cast<double>(out.count)) {
      document.fail(
          who + ": index " + std::to_string(static_cast<std::int64_t>(row)) + " is out of range",
          "export it again");
    }
    for (int c = 0; c < out.components; ++c) {
      out.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(out.components) +
                 static_cast<std::size_t>(c)] =
          load_component(what.at + k * what.stride + c * size, out.component_type, normalised);
    }
  }
}

}  // namespace

int component_size(int component_type) {
  switch (component_type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

AccessorValues read_accessor(const GltfDocument& document, int accessor,
                             std::initializer_list<std::string_view> types,
                             const std::string& who) {
  const std::string here = who + " (accessor " + std::to_string(accessor) + ")";
  const Json& json = document.item("accessors", accessor, who);
  AccessorValues out;
  const std::string type = document.text(json, "type");
  out.components = components_of(type);
  if (out.components == 0 || std::find(types.begin(), types.end(), type) == types.end()) {
    document.fail(here + ": has the wrong type '" + type + "'", "export it again");
  }
  out.component_type = static_cast<int>(document.integer(json, "componentType", 0, here));
  const int size = component_size(out.component_type);
  if (size == 0) document.fail(here + ": unknown componentType", "export it again");
  const std::int64_t count = document.integer(json, "count", 0, here);
  if (count > INT32_MAX) {
    document.fail(here + ": claims " + std::to_string(count) + " elements", "export it again");
  }
  const auto flag = json.find("normalized");
  const bool normalised = flag != json.end() && flag->is_boolean() && flag->get<bool>();
  const auto sparse = json.find("sparse");
  const std::int64_t element = std::int64_t{size} * out.components;

  const int view = document.index(json, "bufferView", "bufferViews", here);
  Run run;
  if (view >= 0) {
    run = checked_run(document, view, document.integer(json, "byteOffset", 0, here), count, element,
                      here);
  } else if (count >
             std::max<std::int64_t>(1 << 20, static_cast<std::int64_t>(document.source_bytes))) {
    // Zeros cost no bytes in the file: bound what a small file can make us allocate.
    document.fail(here + ": claims " + std::to_string(count) + " elements without data",
                  "export it again");
  }
  out.count = static_cast<std::size_t>(count);
  out.values.assign(out.count * static_cast<std::size_t>(out.components), 0.0);
  if (run.at) {
    double* to = out.values.data();
    for (std::size_t i = 0; i < out.count; ++i) {
      for (int c = 0; c < out.components; ++c) {
        *to++ = load_component(run.at + i * run.stride + c * size, out.component_type, normalised);
      }
    }
  }
  if (sparse != json.end()) {
    if (!sparse->is_object()) document.fail(here + ": sparse is no object", "export it again");
    fill_sparse(document, *sparse, normalised, out, here + ": sparse");
  }
  return out;
}

}  // namespace skinfield::gltf
