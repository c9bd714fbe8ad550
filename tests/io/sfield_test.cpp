#include "skinfield/io/sfield.h"

#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/npy.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace skinfield {
namespace {

FieldFile example(bool moments) {
  FieldFile file;
  file.state.solver = "adam";
  file.state.seed = 0xfedcba9876543210ull;
  file.state.counts = {16, 32};
  file.state.level = 1;
  file.state.step = 70;
  file.state.steps = 1570;
  file.state.neumann_radius = 0.125;
  file.state.X = Points::Random(5, 3);
  file.state.F = FloatRows::Random(5, 3);
  if (moments) {
    file.state.first = FloatRows::Random(5, 3);
    file.state.second = FloatRows::Random(5, 3);
  }
  file.shape.V = Points::Random(4, 3);
  file.shape.F.resize(2, 3);
  file.shape.F << 0, 1, 2, 2, 1, 3;
  file.shape.outline.E.resize(2, 2);
  file.shape.outline.E << 0, 1, 1, 0;
  file.shape.outline.shape = {0, 1};
  file.shape.outline.loose.resize(1, 2);
  file.shape.outline.loose << 2, 3;
  file.box.origin = Vec3(1, -2, 3.5);
  file.box.scale = 0.01;
  file.handles.resize(3);
  file.handles[0].name = "spine";
  file.handles[0].segments = {{Vec3(0, 0, 0), Vec3(1, 0, 0)}, {Vec3(1, 0, 0), Vec3(1, 1, 0)}};
  file.handles[1].name = "über";
  file.handles[1].kind = Handle::Kind::point;
  file.handles[1].point = Vec3(0.1, 0.2, 0.3);
  file.handles[2].kind = Handle::Kind::region;
  file.handles[2].vertices = {3, 1};
  file.paint.index = {2};
  file.paint.weights = RowMatrix::Constant(1, 3, 1.0 / 3);
  file.settings = {{"step", 0.5}, {"points", 32}};
  file.mirror_partner = {1, 0, 2};
  file.mirror_plane = 0.25;
  Skeleton& skeleton = file.skeleton;
  skeleton.source = Skeleton::Source::gltf;
  skeleton.joints.resize(4);
  skeleton.joints[1].name = "Hüfte";
  skeleton.joints[1].parent = 0;
  skeleton.joints[1].position = Vec3(1, 2, 3);
  skeleton.joints[1].inverse_bind(0, 3) = -1;
  skeleton.joints[1].local_rest(1, 2) = 0.5;
  skeleton.joints[1].world_rest(2, 0) = 0.25;
  skeleton.bones = {{0, 1}, {1, 3}};
  skeleton.column = {1, 3, 0};
  skeleton.columns = 4;
  skeleton.column_names = {"a", "b", "c", "d"};
  file.handles[0].joint = 1;
  skeleton.handles = file.handles;
  return file;
}

TEST(SavedField, ComesBackAsItWas) {
  for (const bool moments : {true, false}) {
    const FieldFile file = example(moments);
    const FieldFile back = parse_sfield(format_sfield(file), "test");
    EXPECT_EQ(back.state.solver, file.state.solver);
    EXPECT_EQ(back.state.seed, file.state.seed);
    EXPECT_EQ(back.state.counts, file.state.counts);
    EXPECT_EQ(back.state.level, 1);
    EXPECT_EQ(back.state.step, 70);
    EXPECT_EQ(back.state.steps, 1570);
    EXPECT_EQ(back.state.neumann_radius, 0.125);
    EXPECT_EQ(back.state.X, file.state.X);
    EXPECT_EQ(back.state.F, file.state.F);
    EXPECT_EQ(back.state.first.size(), file.state.first.size());
    if (moments) {
      EXPECT_EQ(back.state.first, file.state.first);
      EXPECT_EQ(back.state.second, file.state.second);
    }
    EXPECT_EQ(back.shape.V, file.shape.V);
    EXPECT_EQ(back.shape.F, file.shape.F);
    EXPECT_EQ(back.box.origin, file.box.origin);
    EXPECT_EQ(back.box.scale, file.box.scale);
    ASSERT_EQ(back.handles.size(), 3u);
    EXPECT_EQ(back.handles[0].name, "spine");
    EXPECT_EQ(back.handles[0].segments, file.handles[0].segments);
    EXPECT_EQ(back.handles[1].name, file.handles[1].name);
    EXPECT_EQ(back.handles[1].kind, Handle::Kind::point);
    EXPECT_EQ(back.handles[1].point, file.handles[1].point);
    EXPECT_EQ(back.handles[2].vertices, file.handles[2].vertices);
    EXPECT_EQ(back.paint.index, file.paint.index);
    EXPECT_EQ(back.paint.weights, file.paint.weights);
    EXPECT_EQ(back.settings, file.settings);
    EXPECT_EQ(back.mirror_partner, file.mirror_partner);
    EXPECT_EQ(back.mirror_plane, file.mirror_plane);
    EXPECT_EQ(back.shape.outline.E, file.shape.outline.E);
    EXPECT_EQ(back.shape.outline.shape, file.shape.outline.shape);
    EXPECT_EQ(back.shape.outline.loose, file.shape.outline.loose);
  }
}

TEST(SavedField, CarriesItsSkeleton) {
  const FieldFile file = example(false);
  const FieldFile read = parse_sfield(format_sfield(file), "test");
  const Skeleton& back = read.skeleton;
  EXPECT_EQ(back.source, Skeleton::Source::gltf);
  ASSERT_EQ(back.joints.size(), 4u);
  const Joint &joint = back.joints[1], &was = file.skeleton.joints[1];
  EXPECT_EQ(joint.name, was.name);
  EXPECT_EQ(joint.parent, 0);
  EXPECT_EQ(back.joints[0].parent, -1);
  EXPECT_EQ(joint.position, was.position);
  EXPECT_EQ(joint.inverse_bind, was.inverse_bind);
  EXPECT_EQ(joint.local_rest, was.local_rest);
  EXPECT_EQ(joint.world_rest, was.world_rest);
  EXPECT_EQ(back.bones, file.skeleton.bones);
  EXPECT_EQ(back.column, file.skeleton.column);
  EXPECT_EQ(back.columns, 4);
  EXPECT_EQ(back.column_names, file.skeleton.column_names);
  // Handles are in the file's units, regions points in the middle of their vertices.
  ASSERT_EQ(back.handles.size(), 3u);
  EXPECT_EQ(back.handles[0].joint, 1);
  EXPECT_LT((file.box.to(back.handles[0].segments[1].second) - Vec3(1, 1, 0)).norm(), 1e-12);
  EXPECT_EQ(back.handles[2].kind, Handle::Kind::point);
  const Vec3 middle = 0.5 * (file.shape.V.row(1) + file.shape.V.row(3)).transpose();
  EXPECT_LT((file.box.to(back.handles[2].point) - middle).norm(), 1e-12);
}

TEST(SavedField, RefusesWhatDoesNotFitTogether) {
  const auto broken = [](auto change) {
    NpzArrays arrays = parse_npz(format_sfield(example(true)), "test");
    for (auto& [key, array] : arrays) change(key, array);
    return format_npz(arrays);
  };
  const auto set = [&](const std::string& wanted, const NpyArray& value) {
    return broken([&](const std::string& key, NpyArray& array) {
      if (key == wanted) array = value;
    });
  };
  EXPECT_THROW(parse_sfield("no zip", "test"), InputError);
  try {
    parse_sfield(set("schema", npy_from_integers({9})), "test");
    FAIL() << "another version is read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("version 9"), std::string::npos);
  }
  EXPECT_THROW(parse_sfield(set("faces", npy_from_integers({0, 1, 7})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("faces", npy_from_integers({0, 1})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("outline", npy_from_integers({0, 9})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("loose_segments", npy_from_integers({0})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("outline_shapes", npy_from_integers({0})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("outline_shapes", npy_from_integers({-1, 0})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("progress", npy_from_integers({0, 0, 2, 0, 0})), "test"),
               InputError);
  EXPECT_THROW(parse_sfield(set("counts", npy_from_integers({32, 16})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("parameters", npy_from_matrix(RowMatrix::Zero(4, 3))), "test"),
               InputError);
  EXPECT_THROW(
      parse_sfield(set("points", npy_from_matrix(RowMatrix::Constant(5, 3, std::nan("")))), "test"),
      InputError);
  EXPECT_THROW(parse_sfield(set("segment_handles", npy_from_integers({0, 0, 5})), "test"),
               InputError);
  EXPECT_THROW(parse_sfield(set("joint_parents", npy_from_integers({-1, 4, 0, 0})), "test"),
               InputError);
  EXPECT_THROW(parse_sfield(set("joint_parents", npy_from_integers({-1, 2, 1, 0})), "test"),
               InputError);
  EXPECT_THROW(parse_sfield(set("bones", npy_from_integers({0, 4})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("handle_columns", npy_from_integers({0, 1, 4})), "test"),
               InputError);
  EXPECT_THROW(parse_sfield(set("mirror_partner", npy_from_integers({0})), "test"), InputError);
  EXPECT_THROW(parse_sfield(set("paint_index", npy_from_integers({4})), "test"), InputError);
  NpzArrays arrays = parse_npz(format_sfield(example(true)), "test");
  std::erase_if(arrays, [](const auto& entry) { return entry.first == "points"; });
  EXPECT_THROW(parse_sfield(format_npz(arrays), "test"), InputError);
}

TEST(SavedField, LivesInAFile) {
  const auto path = std::filesystem::temp_directory_path() / "skinfield-saved-field-test.sfield";
  write_sfield(path, example(true));
  EXPECT_EQ(read_sfield(path).state.steps, 1570);
  std::filesystem::remove(path);
  EXPECT_THROW(read_sfield(path), InputError);
  EXPECT_THROW(write_sfield("/no/such/folder/a.sfield", example(true)), IoError);
}

}  // namespace
}  // namespace skinfield
