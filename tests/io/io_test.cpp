#include "skinfield/io/io.h"

#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/tgf.h"
#include "support/data.h"

#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>
#include <fstream>
#include <functional>
#include <random>

namespace skinfield {
namespace {
namespace fs = std::filesystem;

/// A folder of its own that goes away with the test.
class Io : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("skinfield-io-" + std::to_string(::getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  fs::path put(const std::string& name, const std::string& bytes) const {
    write_file_atomically(folder_ / name, bytes);
    return folder_ / name;
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }
  fs::path folder_;
};

template <class Exception>
void expect_error(const std::function<void()>& body, const std::string& part) {
  try {
    body();
    ADD_FAILURE() << "nothing was thrown for: " << part;
  } catch (const Exception& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find(part), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    EXPECT_FALSE(error.remedy().empty()) << what;
  }
}

TEST_F(Io, WritesWholeFilesOrNothing) {
  const fs::path path = folder_ / "a.bin";
  const std::string bytes("a\0b\n", 4);
  write_file_atomically(path, bytes);
  EXPECT_EQ(read_file(path), bytes);
  write_file_atomically(path, "second");
  EXPECT_EQ(read_file(path), "second");
  EXPECT_EQ(files(), 1u);
  expect_error<IoError>([&] { write_file_atomically(folder_ / "absent" / "a", "x"); },
                        "folder does not exist");
  expect_error<IoError>([&] { write_file_atomically(folder_, "x"); }, "is a folder");
  fs::create_symlink("a.bin", folder_ / "link");
  write_file_atomically(folder_ / "link", "through");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_file(path), "through");
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Io, FullDiskLeavesTheOldFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  expect_error<IoError>([] { write_file_atomically("/dev/full", "x"); }, "No space left");
}

TEST_F(Io, ReadOnlyFolderIsReported) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  put("old", "old");
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  expect_error<IoError>([&] { write_file_atomically(folder_ / "old", "x"); }, "Permission denied");
  EXPECT_EQ(read_file(folder_ / "old"), "old");
}

TEST_F(Io, RefusesWhatItCannotRead) {
  expect_error<InputError>([&] { read_asset(folder_ / "absent.obj"); }, "no such file");
  expect_error<InputError>([&] { read_asset(folder_); }, "is a folder");
  expect_error<InputError>([&] { read_asset(put("a.obj", " \n")); }, "the file is empty");
  expect_error<InputError>([&] { read_asset(put("a.fbx", "x")); }, "convert it to glTF");
  expect_error<InputError>([&] { read_asset(put("b.obj", "Kaydara FBX Binary  ")); }, "FBX");
  expect_error<InputError>([&] { read_asset(put("a.blend", "BLENDER")); }, "are read from .glb");
  expect_error<InputError>([&] { read_asset(put("a.ply", "OFF\n")); }, "rename it to .off");
  expect_error<InputError>([&] { read_asset(put("b.ply", "garbage")); },
                           "does not begin as a .ply");
  expect_error<InputError>([&] { read_asset(put("a.tgf", "1 0 0 0\n#\n")); }, "--skeleton");
  expect_error<InputError>([&] { read_asset(put("c.obj", "# nothing\n")); }, "no vertices");
  expect_error<InputError>([&] { read_skeleton(put("d.obj", "v 0 0 0\n")); }, "is no skeleton");
}

TEST_F(Io, ReadsByContentWhereTheNameSaysNothing) {
  const Asset off = read_asset(put("mesh.txt", "OFF\n1 0 0\n1 2 3\n"));
  EXPECT_EQ(off.characters[0].mesh.V.row(0), Eigen::RowVector3d(1, 2, 3));
  const Asset obj = read_asset(put("B.OBJ", "\xEF\xBB\xBFv 1 2 3\r\nv 1 2 3\r\n"));
  EXPECT_EQ(obj.characters[0].mesh.V.rows(), 1);
  EXPECT_EQ(obj.characters[0].vertex_of_input, (std::vector<int>{0, 0}));
}

TEST_F(Io, FindsMaterialsBesideTheObj) {
  put("a.mtl", "newmtl m\nKd 0 1 0\n");
  const Asset asset =
      read_asset(put("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
  EXPECT_EQ(asset.characters[0].parts[0].colour, Eigen::Vector3d(0, 1, 0));
  EXPECT_TRUE(asset.warnings.empty());
}

TEST(Tgf, AllItsVariants) {
  const Skeleton skeleton = parse_tgf(
      "  7\t1 2 3 2.79e+199 nan\r\n 3 4 5\n\n9 0 0 1\n#\n7 3\n3\t9 1 0 0\n9 7 0 1 0\n#\n"
      "anything after\n",
      "a.tgf");
  ASSERT_EQ(skeleton.joints.size(), 3u);
  EXPECT_EQ(skeleton.joints[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(skeleton.joints[1].position, Vec3(4, 5, 0));
  EXPECT_EQ(skeleton.joints[0].name, "7");
  EXPECT_EQ(skeleton.bones, (std::vector<std::pair<int, int>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(skeleton.source, Skeleton::Source::tgf);
  EXPECT_TRUE((skeleton.joints[0].inverse_bind * skeleton.joints[0].world_rest).isIdentity());
  const Skeleton points = parse_tgf("1 0 0 0\n2 1 0 0", "a.tgf");
  EXPECT_EQ(points.joints.size(), 2u);
  EXPECT_TRUE(points.bones.empty());
}

TEST(Tgf, TurnsAndScalesWithTheMesh) {
  Skeleton skeleton = parse_tgf("1 1 2 3\n#\n", "a.tgf");
  transform_skeleton(skeleton, {Up::z, 10});
  EXPECT_EQ(skeleton.joints[0].position, Vec3(10, 30, -20));
  EXPECT_EQ(skeleton.joints[0].world_rest(1, 3), 30);
}

TEST(Tgf, RefusesBrokenSkeletons) {
  const auto parse = [](const std::string& bytes) {
    return [bytes] { parse_tgf(bytes, "a.tgf"); };
  };
  expect_error<InputError>(parse("1 0 0 0\n#\n1 2\n"), "a.tgf:3: a bone names vertex \"2\"");
  expect_error<InputError>(parse("1 0 0 0\n1 0 0 1\n"), "occurs twice");
  expect_error<InputError>(parse("1 0 nan 0\n"), "not finite");
  expect_error<InputError>(parse("#\n"), "no vertices");
  expect_error<InputError>(parse("hello\n"), "no TGF skeleton");
}

TEST(Tgf, HandHasTwentyBonesDespiteItsGarbageColumns) {
  SKINFIELD_NEEDS_DATA(path, "fem/hand.tgf");
  const Skeleton skeleton = read_skeleton(path);
  EXPECT_EQ(skeleton.joints.size(), 21u);
  EXPECT_EQ(skeleton.bones.size(), 20u);
  EXPECT_NEAR(skeleton.joints[1].position[1], -0.57479244, 1e-12);
  SKINFIELD_NEEDS_DATA(points, "planar/alligator-points.tgf");
  EXPECT_TRUE(read_skeleton(points).bones.empty());
}

}  // namespace
}  // namespace skinfield
