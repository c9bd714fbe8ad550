#include "skinfield/bind/handles.h"

#include "bind/fixtures.h"
#include "skinfield/bind/report.h"

#include <nlohmann/json.hpp>

namespace skinfield {
namespace {

using namespace skinfield_test;

/// Two boxes that share a corner, parts "near" and "far", with weights that name the part.
Asset two_parts() {
  const Mesh both = together(box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({1, 1, 1}, {2, 2, 2}));
  Asset asset;
  asset.path = "two.obj";
  asset.characters.push_back(
      character(both, {bone({0, 0, 0}, {1, 1, 1}), bone({1, 1, 1}, {2, 2, 2})}));
  Character& c = asset.characters[0];
  c.input_faces = both.F;
  Part near, far;
  near.name = "near", near.end = 8, near.face_end = 12;
  far.name = "far", far.begin = 8, far.end = 16, far.face_begin = 12, far.face_end = 24;
  c.parts = {near, far};
  RowMatrix W = RowMatrix::Zero(16, 2);
  W.block(0, 0, 8, 1).setOnes();
  W.block(8, 1, 8, 1).setOnes();
  c.weights = sparse_weights(W);
  return asset;
}

TEST(KeepOnly, KeepsOnePartWhole) {
  Asset asset = two_parts();
  ASSERT_EQ(asset.characters[0].mesh.V.rows(), 15);
  keep_only(asset, "far");
  ASSERT_EQ(asset.characters.size(), 1u);
  const Character& c = asset.characters[0];
  ASSERT_EQ(c.parts.size(), 1u);
  EXPECT_EQ(c.parts[0].begin, 0);
  EXPECT_EQ(c.parts[0].end, 8);
  EXPECT_EQ(c.parts[0].face_end, 12);
  EXPECT_EQ(c.vertex_of_input.size(), 8u);
  EXPECT_EQ(c.mesh.V.rows(), 8);
  const Mesh far = box_mesh({1, 1, 1}, {2, 2, 2});
  for (Eigen::Index f = 0; f < 12; ++f)
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(c.mesh.V.row(c.mesh.F(f, k)), far.V.row(far.F(f, k)));
      EXPECT_EQ(c.input_faces(f, k), far.F(f, k));
    }
  EXPECT_EQ(c.weights->W.rows(), 8);
  EXPECT_EQ(c.weights->W.col(1).sum(), 8);
}

TEST(KeepOnly, NamesThePartsThatExist) {
  Asset asset = two_parts();
  try {
    keep_only(asset, "middle");
    FAIL() << "there is no such part";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("near"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("far"), std::string::npos);
  }
  EXPECT_EQ(asset.characters.size(), 1u);
}

Joint joint(const std::string& name, int parent, const Vec3& x) {
  Joint j;
  j.name = name;
  j.parent = parent;
  j.position = x;
  j.inverse_bind.block<3, 1>(0, 3) = -x;
  j.world_rest.block<3, 1>(0, 3) = x;
  j.local_rest = j.world_rest;
  return j;
}

Character jointed_bar() {
  Character c = character(bar(), {});
  c.skeleton = {};
  c.skeleton.source = Skeleton::Source::gltf;
  c.skeleton.joints = {joint("root", -1, {0.1, -0.5, 0.1}), joint("hip", 0, {0.1, 0.1, 0.1}),
                       joint("knee", 1, {0.5, 0.1, 0.1}), joint("foot", 2, {0.8, 0.1, 0.1}),
                       joint("foot_ik", 2, {0.8, 0.5, 0.1})};
  return c;
}

TEST(MakeHandles, LeavesOutRootsOutsideAndHelpers) {
  Character c = jointed_bar();
  make_handles(c);
  EXPECT_EQ(c.skeleton.columns, 5);
  EXPECT_EQ(c.skeleton.left_out, (std::vector<int>{0, 4}));
  EXPECT_EQ(c.skeleton.column, (std::vector<int>{1, 2, 3}));
  const BindResult result = bound(c);
  EXPECT_EQ(result.report.joints_left_out, (std::vector<std::string>{"root", "foot_ik"}));
  EXPECT_EQ(result.weights.W.cols(), 5);
  EXPECT_EQ(result.weights.W.col(0).sum() + result.weights.W.col(4).sum(), 0);
  // The leaf runs on to the end of the bar, no further.
  const auto& [a, b] = c.skeleton.handles[2].segments.at(0);
  EXPECT_NEAR(a[0], 0.8, 1e-12);
  EXPECT_GT(b[0], 0.85);
  EXPECT_LE(b[0], 1.0 + 1e-6);
}

TEST(MakeHandles, ExistingWeightsSayWhichJointsDeform) {
  Character c = jointed_bar();
  RowMatrix W = RowMatrix::Zero(c.mesh.V.rows(), 5);
  W.col(1).setConstant(0.5);
  W.col(4).setConstant(0.5);
  c.weights = sparse_weights(W);
  make_handles(c);
  EXPECT_EQ(c.skeleton.column, (std::vector<int>{1, 4}));
  give_skeleton(c, jointed_bar().skeleton);
  EXPECT_FALSE(c.weights.has_value());
  make_handles(c);
  EXPECT_EQ(c.skeleton.column, (std::vector<int>{1, 2, 3}));
}

TEST(Report, SaysWhatHappened) {
  std::vector<Handle> bones = bar_bones();
  bones.push_back(bone({0.2, 0.6, 0.1}, {0.8, 0.6, 0.1}, "halo"));
  const BindResult result = bound(character(bar(), bones));
  ReportContext context;
  context.input_path = "bar.obj";
  context.seed = 7;
  context.options["nodes"] = "1000";
  const auto json = nlohmann::json::parse(report_json({result.report}, context));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["file"], "bar.obj");
  EXPECT_EQ(json["seed"], 7);
  EXPECT_EQ(json["options"]["nodes"], "1000");
  EXPECT_EQ(json["input"]["vertices"], bar().V.rows());
  EXPECT_EQ(json["input"]["watertight"], true);
  EXPECT_EQ(json["input"]["handles_outside"], (std::vector<std::string>{"halo"}));
  EXPECT_EQ(json["domain"]["rung"], "volume");
  EXPECT_EQ(json["domain"]["nodes"], result.report.nodes);
  EXPECT_EQ(json["solve"]["status"], "converged");
  EXPECT_EQ(json["weights"]["handles_without_vertices"], (std::vector<std::string>{"halo"}));
  std::int64_t rows = 0;
  for (const auto& [count, number] : json["weights"]["influences"].items())
    rows += number.get<std::int64_t>();
  EXPECT_EQ(rows, bar().V.rows());
  EXPECT_GT(json["timings_s"]["domain"], 0);
  EXPECT_GE(json["cpu_s"]["solve"], 0);
  EXPECT_EQ(json["warnings"].size(), 1u);
  // Two characters stand in a list.
  const auto two = nlohmann::json::parse(report_json({result.report, result.report}, context));
  EXPECT_EQ(two["characters"].size(), 2u);
  EXPECT_EQ(two["characters"][1]["domain"]["kind"], "points");
}

TEST(Report, EnergiesAreInFileUnits) {
  // 1/2 tr(W' K M^-1 K W) scales with 1/length in space.
  Mesh large = bar();
  large.V *= 10;
  std::vector<Handle> bones = bar_bones();
  for (Handle& handle : bones)
    for (auto& [a, b] : handle.segments) a *= 10, b *= 10;
  const double small_energy = bound(character(bar(), bar_bones())).report.solve.energy;
  EXPECT_NEAR(10 * bound(character(large, bones)).report.solve.energy, small_energy,
              1e-3 * small_energy);
}

TEST(AddRegions, NamesMergedVerticesBehindTheOtherHandles) {
  Asset asset = two_parts();
  Character& c = asset.characters[0];
  RowMatrix regions = RowMatrix::Zero(16, 2);
  // The whole near box: the corner that it shares belongs to it, whichever input names it.
  regions.col(0).head(8).setOnes();
  regions(0, 1) = regions(15, 1) = 1;
  add_regions(c, sparse_weights(regions, {"near", "ends"}));
  ASSERT_EQ(c.skeleton.handles.size(), 4u);
  EXPECT_EQ(c.skeleton.columns, 4);
  EXPECT_EQ(c.skeleton.column, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(c.skeleton.column_names.back(), "ends");
  EXPECT_EQ(c.skeleton.handles[2].vertices.size(), 8u);
  const Handle& ends = c.skeleton.handles[3];
  EXPECT_EQ(ends.kind, Handle::Kind::region);
  EXPECT_EQ(ends.vertices, (std::vector<int>{c.vertex_of_input[0], c.vertex_of_input[15]}));
  EXPECT_LT((ends.point -
             0.5 * (c.mesh.V.row(ends.vertices[0]) + c.mesh.V.row(ends.vertices[1])).transpose())
                .norm(),
            1e-15);
}

}  // namespace
}  // namespace skinfield
