// Every bad input gives one clear line, exit code 3 and no output.
#include "cli/characters.h"
#include "support/data.h"
#include "support/gltf_builder.h"

#include <limits>

namespace skinfield_test {
namespace {

void refuses(const std::string& name, const std::string& bytes,
             const std::vector<std::string>& words) {
  const BoxFolder folder;
  write_file(folder / name, bytes);
  std::vector<std::string> all = words;
  all.push_back(name);
  expect_refused(folder, {"bind", name, "-o", "out.glb"}, 3, all);
}

void refuses_skeleton(const std::string& text, const std::vector<std::string>& words) {
  const BoxFolder folder;
  write_file(folder / "bad.tgf", text);
  std::vector<std::string> all = words;
  all.push_back("bad.tgf");
  expect_refused(folder, {"bind", "box.obj", "--skeleton", "bad.tgf", "-o", "out.glb"}, 3, all);
}

TEST(BadInput, MissingFileOrFolder) {
  const BoxFolder folder;
  for (const char* verb : {"bind", "pose", "render"}) {
    const std::string output = std::string(verb) == "bind"   ? "out.glb"
                               : std::string(verb) == "pose" ? "out.obj"
                                                             : "out.png";
    expect_refused(folder, {verb, "none.glb", "-o", output}, 3, {"none.glb: no such file"});
  }
  expect_refused(folder, {"inspect", "none.glb"}, 3, {"none.glb: no such file"});
  expect_refused(folder, {"compare", "none.npz", "none.dmat"}, 3, {"none.npz: no such file"});
  expect_refused(folder,
                 {"transfer", "box.obj", "none.obj", "--skeleton", "box.tgf", "-o", "out.glb"}, 3,
                 {"none.obj: no such file"});
  expect_refused(folder, {"bind", ".", "-o", "out.glb"}, 3, {"is a folder"});
  expect_refused(folder, {"bind", "box.obj", "--skeleton", "none.tgf", "-o", "out.glb"}, 3,
                 {"none.tgf: no such file"});
  for (const char* option : {"--paint", "--weights-in"})
    expect_refused(
        folder, {"bind", "box.obj", "--skeleton", "box.tgf", option, "none.npz", "-o", "out.glb"},
        3, {"none.npz: no such file"});
}

TEST(BadInput, DamagedContainers) {
  const std::string good = skinned_square().glb();
  for (const double share : {0.01, 0.1, 0.5, 0.99})
    refuses("cut.glb",
            good.substr(0, static_cast<std::size_t>(share * static_cast<double>(good.size()))), {});
  refuses("cut.glb", good.substr(0, good.size() / 2), {"truncated"});
  refuses("magic.glb", "XXXX" + good.substr(4), {"does not begin as a .glb file"});
  refuses("garbage.gltf", R"({"asset": {"version": "2.0"}, garbage)", {"JSON is damaged"});
  refuses("words.gltf", "once upon a time", {"JSON is damaged"});
  refuses("list.gltf", R"([{"asset": 1}])", {"JSON is damaged"});
  refuses("zeros.glb", std::string(1000, '\0'), {});
  refuses("empty.glb", "", {"empty"});
  refuses("box.xyz", "1 2 3", {"unknown file format"});
  refuses("obj.glb", box_obj(), {});
}

TEST(BadInput, LiesInAccessors) {
  const auto altered = [](auto change) {
    GltfBuilder b = skinned_square();
    change(b.json);
    return b.glb();
  };
  refuses("range.glb", altered([](auto& json) { json["accessors"][0]["count"] = 400; }),
          {"accessor"});
  refuses("claim.glb", altered([](auto& json) { json["accessors"][0]["count"] = 4294967295U; }),
          {"accessor"});
  refuses("view.glb",
          altered([](auto& json) { json["bufferViews"][0]["byteLength"] = 4294967295U; }), {});
  refuses("index.glb", altered([](auto& json) { json["accessors"][0]["bufferView"] = 99; }),
          {"99"});
  refuses("missing.glb", altered([](auto& json) {
            json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 99;
          }),
          {"99"});
  refuses("negative.glb", altered([](auto& json) { json["accessors"][0]["count"] = -1; }), {});
  refuses("cycle.glb", altered([](auto& json) { json["nodes"][3]["children"] = {1}; }), {});
  refuses("nothing.glb", altered([](auto& json) {
            json.erase("meshes");
            json["nodes"][0].erase("mesh");
            json["nodes"][0].erase("skin");
          }),
          {});
}

TEST(BadInput, PositionsAndFaces) {
  for (const float bad :
       {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    GltfBuilder b = skinned_square();
    std::memcpy(b.binary.data() + 16, &bad, sizeof bad);
    refuses("position.glb", b.glb(), {"vertex 1", "finite"});
  }
  GltfBuilder b = skinned_square();
  const std::uint16_t far = 500;
  const auto offset = b.json["bufferViews"][1]["byteOffset"].get<std::size_t>();
  std::memcpy(b.binary.data() + offset, &far, sizeof far);
  refuses("face.glb", b.glb(), {"500"});

  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  refuses("face.obj", triangle + "f 1 2 9\n", {"face.obj:4", "9"});
  refuses("nan.obj", triangle + "v nan 0 0\nf 1 2 3\n", {"vertex 4", "finite"});
  refuses("inf.obj", triangle + "v 0 1e999 0\nf 1 2 3\n", {});
  refuses("empty.obj", "# no vertices\n", {});
  refuses("letters.obj", "v a b c\n", {"letters.obj:1"});
  refuses("claim.ply",
          "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
          "property float y\nproperty float z\nend_header\nabcd",
          {"impossible"});
  refuses("claim.off", "OFF\n4000000000 4000000000 0\n0 0 0\n", {});
  std::string stl(84, '\0');
  stl[80] = stl[81] = stl[82] = stl[83] = '\xff';
  refuses("claim.stl", stl, {});
}

TEST(BadInput, Skeletons) {
  refuses_skeleton("1 0 0 0\n2 1 0 0\n#\n1 9\n", {"bad.tgf:4", "\"9\""});
  refuses_skeleton("1 0 0 0\n1 1 0 0\n#\n1 1\n", {});
  refuses_skeleton("1 0 0 nan\n2 1 0 0\n#\n1 2\n", {"bad.tgf:1"});
  refuses_skeleton("", {"empty"});
  refuses_skeleton("#\n", {});
  refuses_skeleton("hello\n", {});
}

TEST(BadInput, NoBones) {
  refuses("bare.obj", box_obj(), {"no bones", "--skeleton"});
  const BoxFolder folder;
  expect_refused(folder, {"bind", "box.obj", "--skeleton", "box.obj", "-o", "out.glb"}, 3,
                 {"box.obj: is no skeleton", ".tgf"});
  write_file(folder / "square.glb", skinned_square().glb());
  expect_refused(folder, {"bind", "square.glb", "--joints", "zz*", "-o", "out.glb"}, 3,
                 {"square.glb", "joint"});
  expect_refused(folder, {"bind", "square.glb", "--only", "hat", "-o", "out.glb"}, 3,
                 {"hat", "there are: square"});
}

TEST(BadInput, FormatsThatAreNotRead) {
  GltfBuilder draco = skinned_square();
  draco.json["extensionsUsed"] = draco.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  draco.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  refuses("draco.glb", draco.glb(), {"KHR_draco_mesh_compression", "decompress"});
  GltfBuilder meshopt = skinned_square();
  meshopt.json["extensionsUsed"] = meshopt.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  meshopt.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0}, {"byteLength", 48}, {"byteStride", 12}, {"count", 4}, {"mode", "ATTRIBUTES"}};
  refuses("meshopt.glb", meshopt.glb(), {"EXT_meshopt_compression", "decompress"});
  refuses("binary.fbx", std::string("Kaydara FBX Binary  \0\x1a", 22),
          {"FBX", "convert it to glTF"});
  refuses("text.fbx", "; FBX 7.3.0 project file\n", {"FBX", "convert it to glTF"});
}

TEST(BadInput, CompressedFilesOfOthers) {
  SKINFIELD_NEEDS_DATA(draco, "rigged/draco_astronaut.glb");
  SKINFIELD_NEEDS_DATA(meshopt, "rigged/meshopt_no_skin.glb");
  SKINFIELD_NEEDS_DATA(boneless, "rigged/node_animated_no_skin.glb");
  const BoxFolder folder;
  expect_refused(folder, {"bind", draco.string(), "-o", "out.glb"}, 3,
                 {"KHR_draco_mesh_compression"});
  expect_refused(folder, {"bind", meshopt.string(), "-o", "out.glb"}, 3,
                 {"EXT_meshopt_compression"});
  expect_refused(folder, {"bind", boneless.string(), "-o", "out.glb"}, 3,
                 {"no bones", "--skeleton"});
}

TEST(BadInput, PaintAndWeightsThatDoNotFit) {
  const BoxFolder folder;
  const auto refused = [&folder](const char* option, const std::string& text,
                                 const std::vector<std::string>& words) {
    write_file(folder / "rows.csv", text);
    std::vector<std::string> all = words;
    all.push_back("rows.csv");
    expect_refused(
        folder, {"bind", "box.obj", "--skeleton", "box.tgf", option, "rows.csv", "-o", "out.glb"},
        3, all);
  };
  refused("--paint", "0,1,0,0\n", {"3 columns", "2 handles"});
  refused("--paint", "20,1,0\n", {"20"});
  refused("--paint", "0,1,0\n0,0,1\n", {});
  refused("--paint", "0,-1,2\n", {});
  refused("--paint", "0,nan,1\n", {});
  refused("--paint", "0,0.2,0.2\n", {});
  refused("--weights-in", "1,0\n0,1\n", {"2 x 2", "20 vertices and 2 handles"});
  refused("--weights-in", "a,b\nc,d\n", {});
}

TEST(BadInput, NanInExistingWeightsIsAWarning) {
  GltfBuilder b = skinned_square();
  const float bad = std::numeric_limits<float>::quiet_NaN();
  const auto offset = b.json["bufferViews"][3]["byteOffset"].get<std::size_t>();
  std::memcpy(b.binary.data() + offset, &bad, sizeof bad);
  const BoxFolder folder;
  write_file(folder / "square.glb", b.glb());
  const RunResult result =
      expect_runs(folder, {"bind", "square.glb", "--nodes", "100", "--quiet", "-o", "out.glb"});
  ASSERT_EQ(lines(result.err).size(), 1U) << result.err;
  EXPECT_TRUE(result.err.starts_with("warning: ")) << result.err;
  EXPECT_NE(result.err.find("not finite"), std::string::npos);
  const RunResult validated = validate_gltf(folder / "out.glb", folder / "square.glb");
  SKINFIELD_NEEDS_VALIDATOR(validated);
  EXPECT_EQ(validated.code, 0) << validated.out;
}

}  // namespace
}  // namespace skinfield_test
