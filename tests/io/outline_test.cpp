// Polylines of OBJ files: outlines if they close and lie in a plane.
#include "skinfield/base/error.h"
#include "skinfield/io/obj.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

Asset read(const std::string& text) { return asset_from(parse_obj(text, "test"), "test"); }
const Mesh& mesh_of(const Asset& asset) { return asset.characters.front().mesh; }

TEST(Outline, OnePolylineOrManySegments) {
  for (const std::string lines :
       {"l 1 2 3 4 1\n", "l 1 2\nl 3 4\nl 2 3\nl 1 4\n", "l 1/1 2/1 3\nl -4 -1 -2\n"}) {
    const Asset asset = read(kSquare + "vt 0 0\n" + lines);
    EXPECT_TRUE(mesh_of(asset).is_outline()) << lines;
    EXPECT_FALSE(mesh_of(asset).is_point_cloud());
    EXPECT_EQ(mesh_of(asset).outline.E.rows(), 4) << lines;
    EXPECT_TRUE(asset.warnings.empty());
  }
}

TEST(Outline, CornersAtOnePlaceAreOne) {
  // The last point repeats the first: closed by position, and a segment of no length.
  const Asset asset = read(kSquare + "v 0 0 0\nl 1 2 3 4 5 1\n");
  EXPECT_EQ(mesh_of(asset).outline.E.rows(), 4);
  EXPECT_EQ(asset.characters.front().vertex_of_input.size(), 5u);
}

TEST(Outline, OpenEndsGoWithAWarning) {
  const Asset tail = read(kSquare + "v 2 2 0\nl 1 2 3 4 1\nl 3 5\n");
  EXPECT_EQ(mesh_of(tail).outline.E.rows(), 4);
  EXPECT_EQ(mesh_of(tail).outline.loose.rows(), 1);
  EXPECT_EQ(tail.warnings.size(), 1u);
  const Asset open = read(kSquare + "l 1 2 3 4\n");
  EXPECT_TRUE(mesh_of(open).is_point_cloud());
  EXPECT_EQ(open.warnings.size(), 1u);
  // As it was drawn: what is left of it is inside.
  Segments drawn(3, 2);
  drawn << 0, 1, 1, 2, 2, 3;
  EXPECT_EQ(mesh_of(open).outline.loose, drawn);
  drawn << 1, 0, 2, 1, 3, 2;
  EXPECT_EQ(mesh_of(read(kSquare + "l 4 3 2 1\n")).outline.loose, drawn);
  // Drawn twice, a segment bounds nothing.
  EXPECT_TRUE(mesh_of(read(kSquare + "l 1 2 3 4 1\nl 1 2 3 4 1\n")).is_point_cloud());
  // Three ways meet: nobody can say what is inside.
  const Asset branch = read(kSquare + "l 1 2 3 4 1\nl 1 3\n");
  EXPECT_TRUE(mesh_of(branch).is_point_cloud());
  EXPECT_EQ(branch.warnings.size(), 1u);
  EXPECT_EQ(mesh_of(branch).outline.loose.rows(), 5);
}

TEST(Outline, OnlyFlatOnesAndOnlyWithoutFaces) {
  const Asset bent = read("v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nl 1 2 3 4 1\n");
  EXPECT_TRUE(mesh_of(bent).is_point_cloud());
  EXPECT_EQ(bent.warnings.size(), 1u);
  const Asset faces = read(kSquare + "l 1 2 3 1\nf 1 2 3\n");
  EXPECT_TRUE(mesh_of(faces).outline.empty());
  EXPECT_EQ(faces.warnings.size(), 1u);
  EXPECT_THROW(read(kSquare + "l 1 9\n"), InputError);
  EXPECT_THROW(read(kSquare + "l 1 x\n"), InputError);
}

}  // namespace
}  // namespace skinfield
