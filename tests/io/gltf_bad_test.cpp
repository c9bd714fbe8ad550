// Damaged glTF: one clear error each, never a crash.
#include "skinfield/base/random.h"
#include "skinfield/io/gltf.h"
#include "skinfield/io/gltf_animation.h"
#include "support/gltf_builder.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace skinfield;
using skinfield_test::GltfBuilder;
using skinfield_test::Json;
using skinfield_test::read;
using skinfield_test::skinned_square;

/// Expects an InputError that names the file and says `words`.
void expect_refused(const std::string& bytes, const std::string& words) {
  try {
    read(bytes, "bad.glb");
    ADD_FAILURE() << "was read, though: " << words;
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("bad.glb"), std::string::npos) << what;
    EXPECT_NE(what.find(words), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos);
  }
}

TEST(GltfBad, Containers) {
  const std::string good = skinned_square().glb();
  expect_refused(good.substr(0, good.size() - 8), "truncated");
  expect_refused(good.substr(0, 10), "ends inside");
  expect_refused("glTX" + good.substr(4), "JSON");
  expect_refused("", "JSON");
  std::string version = good;
  version[4] = 1;
  expect_refused(version, "version 1");
  std::string chunk = good;
  chunk[16] = 'X';
  expect_refused(chunk, "first GLB chunk");
  std::string garbage = good;
  garbage[20] = '}';
  expect_refused(garbage, "JSON");
  expect_refused(std::string(100000, '['), "nested");
  expect_refused("{\"asset\":{\"version\":\"1.0\"}}", "glTF 2.0");
  expect_refused("{\"asset\":{\"version\":\"2.0\"}}", "no mesh");
}

TEST(GltfBad, AccessorsOutOfRange) {
  const auto with = [](const char* list, int index, const char* key, const Json& value) {
    GltfBuilder b = skinned_square();
    b.json[list][static_cast<std::size_t>(index)][key] = value;
    return b.glb();
  };
  expect_refused(with("accessors", 0, "count", 4000000000u), "claims");
  expect_refused(with("accessors", 0, "count", 1000000000), "claims");
  expect_refused(with("accessors", 0, "count", -4), "count");
  expect_refused(with("accessors", 0, "count", "many"), "count");
  expect_refused(with("accessors", 0, "byteOffset", 4), "claims");
  expect_refused(with("accessors", 0, "byteOffset", 9007199254740000), "claims");
  expect_refused(with("accessors", 0, "bufferView", 99), "out of range");
  expect_refused(with("accessors", 0, "componentType", 5124), "componentType");
  expect_refused(with("accessors", 0, "type", "VEC7"), "type");
  expect_refused(with("bufferViews", 0, "byteOffset", 100000), "out of range");
  expect_refused(with("bufferViews", 0, "byteLength", 9007199254740000), "out of range");
  expect_refused(with("bufferViews", 0, "buffer", 7), "out of range");
  GltfBuilder empty = skinned_square();
  empty.json["accessors"][0].erase("bufferView");
  empty.json["accessors"][0]["count"] = 2000000000;
  expect_refused(empty.glb(), "without data");
}

TEST(GltfBad, IndicesOutOfRange) {
  const auto with = [](const auto& change) {
    GltfBuilder b = skinned_square();
    change(b);
    return b.glb();
  };
  expect_refused(with([](GltfBuilder& b) {
                   b.json["meshes"][0]["primitives"][0]["indices"] =
                       b.add<std::uint16_t>({0, 1, 4}, 5123, 3, "SCALAR");
                 }),
                 "index 4 is out of range");
  expect_refused(with([](GltfBuilder& b) {
                   b.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
                       b.add<std::uint8_t>(std::vector<std::uint8_t>(16, 2), 5121, 4, "VEC4");
                 }),
                 "names joint 2");
  expect_refused(with([](GltfBuilder& b) { b.json["nodes"][0]["skin"] = 3; }), "out of range");
  expect_refused(with([](GltfBuilder& b) { b.json["nodes"][0]["mesh"] = 3; }), "out of range");
  expect_refused(with([](GltfBuilder& b) { b.json["skins"][0]["joints"] = {1, 9}; }), "joints");
  expect_refused(with([](GltfBuilder& b) { b.json["skins"][0]["joints"] = {1, 1}; }), "twice");
  expect_refused(with([](GltfBuilder& b) { b.json["nodes"][1]["children"] = {17}; }), "children");
}

TEST(GltfBad, CyclesOfNodes) {
  GltfBuilder b = skinned_square();
  b.json["nodes"][3]["children"] = {1};
  expect_refused(b.glb(), "cycle");
  b.json["nodes"][3]["children"] = {2};
  expect_refused(b.glb(), "two parents");
}

TEST(GltfBad, PositionsAndTransformsThatAreNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    GltfBuilder b = skinned_square();
    b.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
        b.add<float>({0, 0, 0, 1, 0, 0, 1, bad, 0, 0, 1, 0}, 5126, 4, "VEC3");
    expect_refused(b.glb(), "vertex 2");
  }
  GltfBuilder b = skinned_square();
  b.json["nodes"][0]["rotation"] = {0, 0, 1};
  expect_refused(b.glb(), "rotation needs 4");
}

TEST(GltfBad, RequiredExtensions) {
  GltfBuilder b = skinned_square();
  b.json["extensionsRequired"] = {"VENDOR_odd_mesh_encoding"};
  expect_refused(b.glb(), "VENDOR_odd_mesh_encoding");
  b.json["extensionsRequired"] = {"KHR_texture_transform", "VENDOR_smell"};
  EXPECT_EQ(read(b.glb()).characters.size(), 1u);
}

TEST(GltfBad, ChangedBytesAreReadOrRefused) {
  const std::string good = skinned_square().glb();
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed);
    std::string bytes = good;
    for (std::uint32_t k = 0; k < 1 + seed % 3; ++k) {
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
          static_cast<char>(random.below(256));
    }
    try {
      const Asset asset = read(bytes);
      gltf_animations(asset);
      std::vector<SkinWeights> weights;
      for (const Character& c : asset.characters) {
        weights.push_back(c.weights.value_or(SkinWeights{}));
      }
      format_gltf(asset, weights, true);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_LT(refused, 4000);
}

}  // namespace
