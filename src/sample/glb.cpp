// A small writer for the samples' own binary glTF 2.0 documents.
#include "skinfield/io/file.h"
#include "skinfield/io/gltf.h"
#include "skinfield/sample/sample.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

using Json = nlohmann::ordered_json;

constexpr int gl_float = 5126, gl_unsigned_byte = 5121, gl_unsigned_int = 5125;
constexpr int array_buffer = 34962, element_array_buffer = 34963, no_target = 0;

/// Collects accessors; each has a buffer view of its own, aligned to four bytes.
class Binary {
 public:
  explicit Binary(Json& document) : document_(document) {}

  template <class Value>
  int accessor(const std::vector<Value>& values, int width, const char* type, int component,
               int target, bool with_bounds = false) {
    while (bytes_.size() % 4) bytes_.push_back(0);
    Json view = {{"buffer", 0},
                 {"byteOffset", bytes_.size()},
                 {"byteLength", values.size() * sizeof(Value)}};
    if (target != no_target) view["target"] = target;
    const auto* raw = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes_.insert(bytes_.end(), raw, raw + values.size() * sizeof(Value));
    document_["bufferViews"].push_back(view);

    const auto columns = static_cast<std::size_t>(width);
    Json accessor = {{"bufferView", document_["bufferViews"].size() - 1},
                     {"componentType", component},
                     {"count", values.size() / columns},
                     {"type", type}};
    if (with_bounds) {
      std::vector<Value> low(values.begin(), values.begin() + width), high = low;
      for (std::size_t i = 0; i < values.size(); ++i) {
        low[i % columns] = std::min(low[i % columns], values[i]);
        high[i % columns] = std::max(high[i % columns], values[i]);
      }
      accessor["min"] = low;
      accessor["max"] = high;
    }
    document_["accessors"].push_back(accessor);
    return static_cast<int>(document_["accessors"].size()) - 1;
  }

  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  Json& document_;
  std::vector<std::uint8_t> bytes_;
};

void append(std::vector<float>& values, const Vec3& x) {
  for (int d = 0; d < 3; ++d) values.push_back(static_cast<float>(x[d]));
}

/// One primitive a part, over vertices of its own; positions, normals, colours, placeholder skin.
Json mesh_json(const SampleCharacter& character, Binary& binary, Json& materials) {
  Json primitives = Json::array();
  const Points normals = vertex_normals(character.mesh.V, character.mesh.F);
  const std::vector<int> owner = nearest_handle(character.mesh.V, character.skeleton);
  std::vector<std::int32_t> local(static_cast<std::size_t>(character.mesh.V.rows()), -1);
  for (const SamplePart& part : character.parts) {
    std::vector<float> positions, directions, colours, weights;
    std::vector<std::uint8_t> joints;
    std::vector<std::uint32_t> indices;
    std::uint32_t count = 0;
    for (int f = part.face_begin; f < part.face_end; ++f) {
      for (int c = 0; c < 3; ++c) {
        const Eigen::Index v = character.mesh.F(f, c);
        std::int32_t& index = local[static_cast<std::size_t>(v)];
        if (index < 0) {
          index = static_cast<std::int32_t>(count++);
          append(positions, character.mesh.V.row(v).transpose());
          const double length = normals.row(v).norm();
          append(directions,
                 length > 0 ? Vec3(normals.row(v).transpose() / length) : Vec3::UnitY());
          append(colours, character.colours.row(v).transpose());
          const int handle = owner[static_cast<std::size_t>(v)];
          const int joint = character.skeleton.column[static_cast<std::size_t>(handle)];
          joints.insert(joints.end(), {static_cast<std::uint8_t>(joint), 0, 0, 0});
          weights.insert(weights.end(), {1.0f, 0.0f, 0.0f, 0.0f});
        }
        indices.push_back(static_cast<std::uint32_t>(index));
      }
    }
    Json attributes;
    attributes["POSITION"] = binary.accessor(positions, 3, "VEC3", gl_float, array_buffer, true);
    attributes["NORMAL"] = binary.accessor(directions, 3, "VEC3", gl_float, array_buffer);
    attributes["COLOR_0"] = binary.accessor(colours, 3, "VEC3", gl_float, array_buffer);
    attributes["JOINTS_0"] = binary.accessor(joints, 4, "VEC4", gl_unsigned_byte, array_buffer);
    attributes["WEIGHTS_0"] = binary.accessor(weights, 4, "VEC4", gl_float, array_buffer);
    primitives.push_back(
        {{"attributes", attributes},
         {"indices", binary.accessor(indices, 1, "SCALAR", gl_unsigned_int, element_array_buffer)},
         {"material", materials.size()}});
    materials.push_back(
        {{"name", part.name},
         {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.6}}}});
  }
  return {{"name", character.name}, {"primitives", primitives}};
}

Json animation_json(const SampleCharacter& character, Binary& binary) {
  const SampleAnimation& source = character.animation;
  Json samplers = Json::array(), channels = Json::array();
  std::vector<float> times(source.time.begin(), source.time.end());
  const int input = binary.accessor(times, 1, "SCALAR", gl_float, no_target, true);
  const auto add = [&](std::size_t joint, const char* path, int output) {
    channels.push_back(
        {{"sampler", samplers.size()}, {"target", {{"node", joint}, {"path", path}}}});
    samplers.push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
  };
  for (std::size_t j = 0; j < character.skeleton.joints.size(); ++j) {
    std::vector<float> rotations;
    bool moves = false;
    Eigen::Vector4d previous(0, 0, 0, 1);
    for (const SamplePose& pose : source.key) {
      Eigen::Vector4d q = pose.rotation[j].coeffs();
      if (q.dot(previous) < 0) q = -q;  // the short way
      moves = moves || std::abs(q[3]) < 1 - 1e-9;
      for (int d = 0; d < 4; ++d) rotations.push_back(static_cast<float>(q[d]));
      previous = q;
    }
    if (moves) add(j, "rotation", binary.accessor(rotations, 4, "VEC4", gl_float, no_target));
  }
  std::vector<float> path;
  for (const SamplePose& pose : source.key) {
    append(path, character.skeleton.joints[0].position + pose.root_movement);
  }
  add(0, "translation", binary.accessor(path, 3, "VEC3", gl_float, no_target));
  return {{"name", source.name}, {"samplers", samplers}, {"channels", channels}};
}

/// Joint nodes come first, in skin order, so that a joint's node index is its column.
Json node_list(const SampleCharacter& character) {
  const auto translation = [](const Vec3& x) { return Json{x.x(), x.y(), x.z()}; };
  Json nodes = Json::array();
  const auto& joints = character.skeleton.joints;
  for (const Joint& joint : joints) {
    nodes.push_back({{"name", joint.name},
                     {"translation", translation(joint.local_rest.topRightCorner<3, 1>())}});
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].parent >= 0)
      nodes[static_cast<std::size_t>(joints[j].parent)]["children"].push_back(j);
    for (const JointTip& tip : joints[j].tips) {
      nodes[j]["children"].push_back(nodes.size());
      nodes.push_back(
          {{"name", tip.name}, {"translation", translation(tip.position - joints[j].position)}});
    }
  }
  nodes.push_back({{"name", character.name}, {"mesh", 0}, {"skin", 0}});
  return nodes;
}

void append_word(std::vector<std::uint8_t>& bytes, std::size_t word) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<std::uint8_t>(word >> shift));
  }
}

}  // namespace

std::vector<std::uint8_t> sample_glb(const SampleCharacter& character) {
  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "Skinfield sample"}};
  document["scene"] = 0;
  Json nodes = node_list(character);
  const std::size_t mesh_node = nodes.size() - 1;
  document["scenes"] = {{{"name", character.name}, {"nodes", {0, mesh_node}}}};
  document["nodes"] = std::move(nodes);
  document["accessors"] = Json::array();
  document["bufferViews"] = Json::array();

  Binary binary(document);
  Json materials = Json::array();
  document["meshes"] = {mesh_json(character, binary, materials)};
  document["materials"] = std::move(materials);
  std::vector<float> inverse_binds;
  Json joints = Json::array();
  for (std::size_t j = 0; j < character.skeleton.joints.size(); ++j) {
    const Transform& T = character.skeleton.joints[j].inverse_bind;
    for (int i = 0; i < 16; ++i) inverse_binds.push_back(static_cast<float>(T.data()[i]));
    joints.push_back(j);
  }
  document["skins"] = {
      {{"name", character.name},
       {"inverseBindMatrices", binary.accessor(inverse_binds, 16, "MAT4", gl_float, no_target)},
       {"skeleton", 0},
       {"joints", joints}}};
  document["animations"] = {animation_json(character, binary)};
  document["buffers"] = {{{"byteLength", binary.bytes().size()}}};

  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::uint8_t> chunk = binary.bytes();
  chunk.resize((chunk.size() + 3) / 4 * 4, 0);
  std::vector<std::uint8_t> glb;
  glb.reserve(28 + text.size() + chunk.size());
  append_word(glb, 0x46546C67);  // "glTF"
  append_word(glb, 2);
  append_word(glb, 28 + text.size() + chunk.size());
  append_word(glb, text.size());
  append_word(glb, 0x4E4F534A);  // "JSON"
  glb.insert(glb.end(), text.begin(), text.end());
  append_word(glb, chunk.size());
  append_word(glb, 0x004E4942);  // "BIN"
  glb.insert(glb.end(), chunk.begin(), chunk.end());
  return glb;
}

Asset sample_asset(const SampleCharacter& character) {
  const std::vector<std::uint8_t> glb = sample_glb(character);
  return read_gltf_bytes(std::as_bytes(std::span(glb)), character.name);
}

void write_sample(const std::filesystem::path& path, const SampleCharacter& character) {
  const std::vector<std::uint8_t> glb = sample_glb(character);
  write_file_atomically(path, {reinterpret_cast<const char*>(glb.data()), glb.size()});
}

}  // namespace skinfield
