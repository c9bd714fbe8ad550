#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gmsh.h"
#include "skinfield/io/io.h"
#include "skinfield/io/medit.h"
#include "skinfield/io/obj.h"
#include "skinfield/io/off.h"
#include "skinfield/io/ply.h"
#include "skinfield/io/stl.h"
#include "support/data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace skinfield {
namespace {

Points square() {
  Points V(4, 3);
  V << 0, 0, 0, 1, 0, 0, 1, 1, 0.1, 0, 1, 1.0 / 3.0;
  return V;
}

Triangles two_triangles() {
  Triangles F(2, 3);
  F << 0, 1, 2, 0, 2, 3;
  return F;
}

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

void expect_refused(const std::function<void()>& body, const std::string& part) {
  EXPECT_NE(message_of(body).find(part), std::string::npos) << message_of(body);
}

TEST(MeshFormats, EachWriterIsUndoneByItsReader) {
  const Points V = square();
  const Triangles F = two_triangles();
  const Points N = Points::Constant(4, 3, 0.125);
  for (const bool normals : {false, true}) {
    const Points none;
    const Points& given = normals ? N : none;
    for (const MeshFile& mesh :
         {parse_obj(format_obj(V, F, given), "a.obj"), parse_ply(format_ply(V, F, given), "a.ply"),
          parse_off(format_off(V, F, given), "a.off")}) {
      EXPECT_EQ(mesh.V, V);
      EXPECT_EQ(mesh.F, F);
      EXPECT_EQ(mesh.N, given);
    }
  }
}

TEST(MeshFormats, ObjFormsOfFaces) {
  const MeshFile mesh = parse_obj(
      "# a comment with C:\\\n"
      "v 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 1 1\nv 0 1 0\nvt 0 0\nvt 1 0.5 0\nvn 0 0 1\n"
      "o first\nf 1/1/1 2/2/1 3//1 -1\nusemtl red\nf -4 \\\n-3 -2\n"
      "o second\ng part\nf 1 2 4\nl 1 2 3\nf 1 2\n",
      "a.obj");
  ASSERT_EQ(mesh.F.rows(), 4);
  Triangles F(4, 3);
  F << 0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 1, 3;
  EXPECT_EQ(mesh.F, F);
  EXPECT_EQ(mesh.V(2, 2), 0);
  const auto& document = dynamic_cast<const ObjDocument&>(*mesh.document);
  EXPECT_EQ(document.texcoord_of_corner.row(0), Eigen::RowVector3i(0, 1, -1));
  EXPECT_EQ(document.normal_of_corner.row(1), Eigen::RowVector3i(0, 0, -1));
  EXPECT_EQ(document.texcoords(1, 1), 0.5);
  ASSERT_EQ(mesh.parts.size(), 3u);
  EXPECT_EQ(mesh.parts[0].name, "first");
  EXPECT_EQ(mesh.parts[0].face_end, 2);
  EXPECT_EQ(mesh.parts[2].name, "second");
  EXPECT_EQ(mesh.parts[2].face_begin, 3);
  EXPECT_EQ(mesh.parts[2].face_end, 4);
  EXPECT_EQ(mesh.outline.E.rows(), 2);
  EXPECT_EQ(mesh.warnings.size(), 1u);  // the face with two corners
}

TEST(MeshFormats, ObjMaterialsColourTheirParts) {
  const auto load = [](const std::string& file) -> std::optional<std::string> {
    if (file != "my colours.mtl") return std::nullopt;
    return "newmtl red\nKd 1 0.25 0\nd 0.5\nnewmtl blue\nKd 0 0 1\nTr 0.25\n";
  };
  const MeshFile mesh = parse_obj(
      "mtllib my colours.mtl\nmtllib absent.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
      "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 2\nusemtl blue\nf 1 2 3\n",
      "a.obj", load);
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(mesh.parts[0].colour, Eigen::Vector3d(1, 0.25, 0));
  EXPECT_EQ(mesh.parts[1].colour, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(mesh.parts[1].face_end, 3);
  const auto& document = dynamic_cast<const ObjDocument&>(*mesh.document);
  EXPECT_EQ(document.materials[0].alpha, 0.5);
  EXPECT_EQ(document.materials[1].alpha, 0.75);
  EXPECT_EQ(document.material_of_part, (std::vector<int>{0, 1}));
  EXPECT_EQ(mesh.warnings.size(), 1u);
}

TEST(MeshFormats, PlyInAnyOrderAndByteOrder) {
  const std::string ascii =
      "ply\r\nformat ascii 1.0\r\ncomment made here\r\nelement face 1\r\n"
      "property uchar red\r\nproperty list int short vertex_index\r\nelement other 2\r\n"
      "property list uchar float junk\r\nelement vertex 4\r\nproperty double z\r\n"
      "property uchar alpha\r\nproperty float y\r\nproperty int x\r\nend_header\r\n"
      "7 4 0 1 2 3\r\n2 1 2\r\n0\r\n0 9 0 0\r\n0 9 0 1\r\n0.1 9 1 1\r\n0.25 9 1 0\r\n";
  const MeshFile mesh = parse_ply(ascii, "a.ply");
  EXPECT_EQ(mesh.F, two_triangles());
  EXPECT_EQ(mesh.V(3, 2), 0.25);
  EXPECT_EQ(mesh.V(2, 0), 1);

  std::string little = format_ply(square(), two_triangles());
  std::string big = little;
  big.replace(big.find("little"), 6, "big");
  const std::size_t data = big.find("end_header\n") + 11;
  for (std::size_t i = 0; i < 12; ++i) {
    std::reverse(big.begin() + static_cast<long>(data + 8 * i),
                 big.begin() + static_cast<long>(data + 8 * i + 8));
  }
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto at = static_cast<long>(data + 96 + 13 * f + 1 + 4 * c);
      std::reverse(big.begin() + at, big.begin() + at + 4);
    }
  }
  const MeshFile swapped = parse_ply(big, "a.ply");
  EXPECT_EQ(swapped.V, square());
  EXPECT_EQ(swapped.F, two_triangles());
}

TEST(MeshFormats, OffVariants) {
  const std::string body = "0 0 0\n1 0 0 # corner\n\n1 1 0.1\n0 1 0.25\n";
  for (const std::string head : {"OFF\n4 1 0\n", "OFF 4 1 0\n", "4 1 0\n", "OFF # x\n#y\n4 1\n"}) {
    const MeshFile mesh = parse_off(head + body + "4 0 1 2 3 255 0 0\n", "a.off");
    EXPECT_EQ(mesh.F, two_triangles());
    EXPECT_EQ(mesh.V(3, 2), 0.25);
  }
  const MeshFile coloured =
      parse_off("COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n", "a.off");
  EXPECT_EQ(coloured.N.rows(), 0);
  const MeshFile normals =
      parse_off("NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n", "a.off");
  EXPECT_EQ(normals.N.col(2), Eigen::Vector3d::Ones());
}

std::string binary_stl(const std::string& head, std::uint32_t claimed, std::uint32_t facets) {
  std::string bytes = head;
  bytes.resize(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&claimed), 4);
  for (std::uint32_t f = 0; f < facets; ++f) {
    float v[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(f)};
    bytes.append(reinterpret_cast<const char*>(v), 48).append(2, '\0');
  }
  return bytes;
}

TEST(MeshFormats, StlBothWays) {
  const MeshFile binary = parse_stl(binary_stl("solid but binary", 2, 2), "a.stl");
  EXPECT_EQ(binary.V.rows(), 6);
  EXPECT_EQ(binary.V(5, 2), 1);
  const MeshFile ascii = parse_stl(
      "solid one thing\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n"
      "   vertex 0 1 0\n  endloop\n endfacet\nendsolid one\nSOLID two\nFACET NORMAL 0 0 1\n"
      "OUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 1\nENDLOOP\nENDFACET\nENDSOLID\n",
      "a.stl");
  EXPECT_EQ(ascii.V, binary.V);
  ASSERT_EQ(ascii.parts.size(), 2u);
  EXPECT_EQ(ascii.parts[0].name, "one thing");
  EXPECT_EQ(ascii.parts[1].face_begin, 1);
  const Asset asset = asset_from(binary, "a.stl");
  EXPECT_EQ(asset.characters[0].mesh.V.rows(), 4);  // the shared edge is merged
  EXPECT_EQ(asset.characters[0].vertex_of_input, (std::vector<int>{0, 1, 2, 0, 1, 3}));
}

TEST(MeshFormats, MeditAndGmshGiveTheSameTet) {
  const MeshFile medit = parse_medit(
      "MeshVersionFormatted 2 # double\nDimension\n3\nVertices 4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n"
      "0 0 1 1\nEdges 1\n1 2 0\nTetrahedra 1\n1 2 3 4 7\nRequiredVertices\n1\n3\nEnd\n",
      "a.mesh");
  const MeshFile gmsh = parse_gmsh(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"all\"\n$EndPhysicalNames\n"
      "$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 0 1 0\n40 0 0 1\n$EndNodes\n$Elements\n2\n"
      "1 15 2 0 1 10\n2 4 2 0 1 10 20 30 40\n$EndElements\n",
      "a.msh");
  EXPECT_EQ(medit.T, Eigen::RowVector4i(0, 1, 2, 3));
  EXPECT_EQ(medit.T, gmsh.T);
  EXPECT_EQ(medit.V, gmsh.V);
  const Asset asset = asset_from(medit, "a.mesh");
  EXPECT_EQ(asset.characters[0].mesh.F.rows(), 4);
}

TEST(MeshFormats, TetsGoOutAndComeBackToTheLastBit) {
  Points V(5, 3);
  V << 0, 0, 0, 1.0 / 3, 0, 1e-300, 0, -1.5e17, 0, 0.1, 0.2, 0.3, 1, 1, 1;
  Tetrahedra T(2, 4);
  T << 0, 1, 2, 3, 4, 3, 2, 1;
  for (const Triangles& F : {two_triangles(), Triangles(0, 3)}) {
    const MeshFile medit = parse_medit(format_medit(V, F, T), "a.mesh");
    const MeshFile gmsh = parse_gmsh(format_gmsh(V, F, T), "a.msh");
    EXPECT_EQ(medit.V, V);
    EXPECT_EQ(medit.T, T);
    EXPECT_EQ(medit.F, F);
    EXPECT_EQ(gmsh.V, V);
    EXPECT_EQ(gmsh.T, T);
    EXPECT_EQ(gmsh.F, F);
  }
}

TEST(MeshFormats, HalfReadFilesAreRefusedAtTheirPlace) {
  expect_refused([] { parse_obj("v 0 0 0\nf 1 2 3\n", "a.obj"); }, "a.obj:2: a face names vertex");
  expect_refused([] { parse_obj("v 0 zero 0\n", "a.obj"); }, "\"zero\" is not a number");
  expect_refused([] { parse_obj("v 0 0 0\nf 0 0 0\n", "a.obj"); }, "vertex \"0\"");
  expect_refused([] { parse_off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a.off"); },
                 "a.off:6: a face names vertex 3 of 3");
  expect_refused([] { parse_off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "a.off"); },
                 "fewer corners");
  expect_refused([] { parse_off("OFF\n3 1 0\n0 0 0\n1 0 0 1 2 3 4 5\n", "a.off"); }, "truncated");
  expect_refused([] { parse_off("4OFF\n1 0 0\n0 0 0 0\n", "a.off"); }, "three dimensions");
  expect_refused([] { parse_stl(binary_stl("", 2, 1), "a.stl"); }, "truncated");
  expect_refused([] { parse_stl("solid\nfacet normal 0 0 1\nvertex 0 0 0\n", "a.stl"); },
                 "truncated");
  expect_refused(
      [] {
        parse_medit("MeshVersionFormatted 1\nVertices 1\n0 0 0 0\nTriangles 1\n1 1 2 0", "a.mesh");
      },
      "vertex 2 of 1");
  expect_refused([] { parse_medit("MeshVersionFormatted 1\nVertices 2\n0 0 0 0\n0 0", "a.mesh"); },
                 "truncated");
  expect_refused(
      [] { parse_medit("MeshVersionFormatted 1\nHexahedra 1\n1 1 1 1 1 1 1 1 0", "a.mesh"); },
      "split the solids");
  expect_refused([] { parse_gmsh("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "a.msh"); }, "msh22");
  expect_refused(
      [] {
        parse_gmsh(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n"
            "$Elements\n1\n1 2 0 1 1 2\n$EndElements\n",
            "a.msh");
      },
      "names node 2");
  std::string ply = format_ply(square(), two_triangles());
  for (std::size_t size = 0; size < ply.size(); size += 7) {
    EXPECT_THROW(parse_ply(ply.substr(0, size), "a.ply"), InputError) << size;
  }
  ply[ply.size() - 1] = '\x7f';
  expect_refused([&ply] { parse_ply(ply, "a.ply"); }, "face 2 names a vertex");
}

TEST(MeshFormats, ImmenseClaimsFailBeforeAnythingIsAllocated) {
  const std::string n = "4000000000";
  expect_refused([&] { parse_off("OFF\n" + n + " 1 0\n0 0 0\n", "a"); }, "can hold");
  expect_refused([&] { parse_off("OFF\n1 " + n + " 0\n0 0 0\n", "a"); }, "can hold");
  expect_refused([] { parse_stl(binary_stl("", 4000000000u, 1), "a"); }, "more than the file");
  expect_refused([&] { parse_medit("MeshVersionFormatted 1\nVertices " + n, "a"); }, "can hold");
  expect_refused(
      [] {
        parse_ply(
            "ply\nformat ascii 1.0\nelement vertex 2000000000\n"
            "property float x\nproperty float y\nend_header\n0 0\n",
            "a");
      },
      "more than the file");
  expect_refused(
      [] {
        parse_ply(
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
            "property float x\nproperty float y\nelement face 1\n"
            "property list uint int vertex_index\nend_header\n"
            "\1\1\1\1\1\1\1\1\1\1\1\1",
            "a");
      },
      "list claims more");
  expect_refused([&] { parse_gmsh("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + n, "a"); },
                 "impossible");
}

TEST(MeshFormats, UselessMeshesAreRefused) {
  expect_refused([] { asset_from(MeshFile{}, "a.obj"); }, "no vertices");
  for (const char* bad : {"nan", "inf", "-inf", "1e999", "1e200"}) {
    expect_refused(
        [&] { asset_from(parse_obj(std::string("v 0 0 0\nv 0 ") + bad + " 0\n", "a"), "a"); },
        "a: vertex 2 has the position");
  }
  MeshFile mesh;
  mesh.V = square();
  for (const double scale : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    expect_refused([&] { asset_from(mesh, "a", {Up::y, scale}); }, "scale");
  }
  mesh.F = two_triangles();
  mesh.F(1, 2) = 4;
  expect_refused([&] { asset_from(mesh, "a"); }, "face 2 names vertex 5 of 4");
}

TEST(MeshFormats, AxesAndScale) {
  MeshFile mesh;
  mesh.V = square();
  mesh.N = Points::Zero(4, 3);
  mesh.N.col(2).setOnes();
  const Asset asset = asset_from(mesh, "folder/a.ply", {Up::z, 2});
  const Mesh& turned = asset.characters[0].mesh;
  EXPECT_EQ(turned.V.row(2), Eigen::RowVector3d(2, 0.2, -2));
  EXPECT_EQ(turned.N.row(0), Eigen::RowVector3d(0, 1, 0));
  EXPECT_EQ(asset.characters[0].name, "a");
  ASSERT_EQ(asset.characters[0].parts.size(), 1u);
  EXPECT_EQ(asset.characters[0].parts[0].end, 4);
}

TEST(MeshFormats, HandInMeditAndInGmshAreOneMesh) {
  SKINFIELD_NEEDS_DATA(medit, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(gmsh, "fem/hand.msh");
  const Asset a = read_asset(medit), b = read_asset(gmsh);
  const Mesh &A = a.characters[0].mesh, &B = b.characters[0].mesh;
  EXPECT_EQ(A.V.rows(), 7234);
  EXPECT_EQ(A.F.rows(), 9556);
  EXPECT_EQ(A.T.rows(), 29998);
  EXPECT_EQ(A.T, B.T);
  EXPECT_LT((A.V - B.V).cwiseAbs().maxCoeff(), 1e-6);  // the ASCII file has six digits
}

TEST(MeshFormats, SharedDataHasTheSizesItsTableSays) {
  struct Case {
    const char* file;
    int inputs, faces;
  };
  for (const Case& c :
       {Case{"wild/armadillo-soup50.stl", 43707, 14569},
        Case{"wild/human_man-soup70.ply", 12288, 4096}, Case{"wild/cow-points20k.ply", 20000, 0},
        Case{"wild/penguin-points5k.ply", 5000, 0}, Case{"wild/fish-oneside.off", 501, 828},
        Case{"wild/suzanne.obj", 507, 968}, Case{"wild/moebius.obj", 280, 448},
        Case{"wild/degenerate_tiny.obj", 10, 11}, Case{"surface/spot.obj", 829, 1654},
        Case{"fem/octopus-low.mesh", 452, 898}, Case{"planar/alligator.obj", 3208, 5981}}) {
    SKINFIELD_NEEDS_DATA(path, c.file);
    const Asset asset = read_asset(path);
    ASSERT_EQ(asset.characters.size(), 1u) << c.file;
    const Character& character = asset.characters[0];
    EXPECT_EQ(character.vertex_of_input.size(), static_cast<std::size_t>(c.inputs)) << c.file;
    EXPECT_EQ(character.mesh.F.rows(), c.faces) << c.file;
    EXPECT_TRUE(character.skeleton.joints.empty());
  }
  SKINFIELD_NEEDS_DATA(cloud, "wild/cow-points20k.ply");
  const Asset cow = read_asset(cloud);
  const Points& N = cow.characters[0].mesh.N;
  EXPECT_LT((N.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-5);
}

}  // namespace
}  // namespace skinfield
