// Flat shapes, given as triangles or as outlines, from the character to its weights.
#include "skinfield/bind/triangulate.h"

#include "bind/fixtures.h"
#include "skinfield/bind/handles.h"
#include "skinfield/domain/planar_mesher.h"
#include "skinfield/io/io.h"
#include "skinfield/io/obj.h"
#include "support/data.h"

#include <set>

namespace skinfield {
namespace {

using namespace skinfield_test;

#define NEEDS_MESHER() \
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher"

/// A strip from x = 0 to 4 with a bone in each half, as an outline.
Character strip(const std::string& outline = "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 0 1 0\nl 1 2 3 4 1\n") {
  Asset asset = asset_from(parse_obj(outline, "strip"), "strip");
  Mesh mesh = asset.characters.front().mesh;
  Character c = character(Mesh{mesh.V, {}, {}, {}, {}},
                          {bone({0.5, 0.5, 0}, {1.5, 0.5, 0}), bone({2.5, 0.5, 0}, {3.5, 0.5, 0})});
  c.mesh.outline = mesh.outline;
  c.parts = asset.characters.front().parts;
  return c;
}

TEST(Triangulate, InnerVerticesAreNoInputUntilTheyAreAskedFor) {
  NEEDS_MESHER();
  Character c = strip();
  triangulate_outline(c, 500);
  EXPECT_GT(c.mesh.V.rows(), 400);
  EXPECT_EQ(c.vertex_of_input.size(), 4u);
  EXPECT_EQ(c.parts.front().face_end, c.mesh.F.rows());
  EXPECT_FALSE(c.mesh.is_outline());
  const Triangles before = c.mesh.F;
  triangulate_outline(c, 900);  // it has its triangles already
  EXPECT_EQ(c.mesh.F, before);
  count_inner_vertices(c);
  ASSERT_EQ(static_cast<Eigen::Index>(c.vertex_of_input.size()), c.mesh.V.rows());
  std::set<int> all(c.vertex_of_input.begin(), c.vertex_of_input.end());
  EXPECT_EQ(static_cast<Eigen::Index>(all.size()), c.mesh.V.rows());
  Character points = strip();
  triangulate_outline(points, 0);
  EXPECT_EQ(points.mesh.V.rows(), 4);
  EXPECT_EQ(points.mesh.F.rows(), 2);
}

TEST(Triangulate, AnOutlineCrossingItselfNeedsVerticesForThat) {
  NEEDS_MESHER();
  const std::string bow = "v 0 0 0\nv 4 1 0\nv 4 0 0\nv 0 1 0\nl 1 2 3 4 1\n";
  Character c = strip(bow);
  EXPECT_THROW(triangulate_outline(c, 0), DomainError);
  triangulate_outline(c, 300);
  EXPECT_NEAR(face_areas(c.mesh.V, c.mesh.F).sum(), 2, 1e-9);
}

TEST(Triangulate, OutlinesBindAsTheirTrianglesDo) {
  NEEDS_MESHER();
  const Character c = strip();
  const BindResult outline = bound(c, quick(3000));
  EXPECT_EQ(outline.report.domain_kind, "tris");
  EXPECT_EQ(outline.report.rung, Rung::surface);
  EXPECT_EQ(outline.report.handles_inside.size(), 2u);
  EXPECT_EQ(outline.weights.W.rows(), 4);
  Character fine = c;
  triangulate_outline(fine, 3000);
  count_inner_vertices(fine);
  const BindResult mesh = bound(fine, quick(3000));
  EXPECT_LT(tv(rows_of(mesh.weights, 0, 4), outline.weights), 1e-9);
  EXPECT_LT(tv(transfer(*outline.solved, fine), mesh.weights), 1e-9);
  // One half each, mirrored.
  for (Eigen::Index i = 0; i < mesh.weights.W.rows(); ++i) {
    const double x = fine.mesh.V(fine.vertex_of_input[static_cast<std::size_t>(i)], 0);
    if (x < 1.2) {
      EXPECT_GT(mesh.weights.W.coeff(i, 0), 0.9) << x;
    }
    if (x > 2.8) {
      EXPECT_GT(mesh.weights.W.coeff(i, 1), 0.9) << x;
    }
    if (std::abs(x - 2) < 0.02) {
      EXPECT_NEAR(mesh.weights.W.coeff(i, 0), 0.5, 0.03) << x;
    }
  }
}

TEST(Triangulate, AHandleBesideTheShapeHasNoInfluence) {
  NEEDS_MESHER();
  Character c = strip();
  c.skeleton.handles[1] = bone({6, 0, 0}, {7, 0, 0}, "beside");
  const BindResult result = bound(c);
  EXPECT_EQ(result.report.handles_outside, std::vector<std::string>{"beside"});
  EXPECT_EQ(result.weights.W.col(1).sum(), 0);
  EXPECT_FALSE(result.report.warnings.empty());
}

TEST(Triangulate, PaintAndStartOnAnOutline) {
  NEEDS_MESHER();
  const Character c = strip();
  BindOptions options = quick();
  options.paint = Paint{{1}, RowMatrix::Constant(1, 2, 0.5)};
  EXPECT_EQ(bound(c, options).weights.W.coeff(1, 0), 0.5);
  options.paint.reset();
  options.start = bound(c, quick()).weights;
  EXPECT_LT(tv(bound(c, options).weights, *options.start), 2e-3);
  options.locked_columns = {0};
  EXPECT_THROW(bind(c, options), InputError);
}

TEST(Triangulate, SoundMeshesInSpaceKeepTheirElements) {
  BindOptions options = quick();
  options.domain = BindOptions::DomainKind::surface;
  const BindResult sound = bound(character(bar(), bar_bones()), options);
  EXPECT_EQ(sound.report.domain_kind, "tris");
  // A heap of loose triangles is joined instead.
  Mesh loose = bar();
  Mesh soup;
  soup.V.resize(3 * loose.F.rows(), 3);
  soup.F.resize(loose.F.rows(), 3);
  for (Eigen::Index f = 0; f < loose.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      soup.V.row(3 * f + k) = loose.V.row(loose.F(f, k));
      soup.V.row(3 * f + k)[0] += 1e-4 * static_cast<double>(f % 7);
      soup.F(f, k) = static_cast<int>(3 * f + k);
    }
  const BindResult joined = bound(character(soup, bar_bones()), options);
  EXPECT_EQ(joined.report.domain_kind, "surface");
  EXPECT_FALSE(joined.report.warnings.empty());
}

TEST(Triangulate, KeepOnlyKeepsAShapesSegments) {
  Character c = strip("v 0 0 0\nv 4 0 0\nv 4 1 0\nv 0 1 0\nl 1 2 3 1\nl 1 3 4 1\n");
  c.mesh.outline.shape = {0, 0, 1, 1};
  c.mesh.outline.E.resize(4, 2);
  c.mesh.outline.E << 0, 1, 0, 1, 2, 3, 2, 3;
  Part first, second;
  first.name = "first", first.end = 2;
  second.name = "second", second.begin = 2, second.end = 4;
  c.parts = {first, second};
  Asset asset;
  asset.characters.push_back(c);
  keep_only(asset, "second");
  const Mesh& kept = asset.characters.front().mesh;
  EXPECT_EQ(kept.V.rows(), 2);
  ASSERT_EQ(kept.outline.E.rows(), 2);
  EXPECT_EQ(kept.outline.E(0, 0), 0);
  EXPECT_EQ(kept.outline.E(0, 1), 1);
  EXPECT_EQ(kept.outline.shape, (std::vector<int>{0, 0}));
}

/// The weights of one tip, turned onto the next.
TEST(Triangulate, TheStarsTipsAreRotationsOfEachOther) {
  NEEDS_MESHER();
  SKINFIELD_NEEDS_DATA(file, "planar/star.svg");
  SKINFIELD_NEEDS_DATA(tgf, "planar/star.tgf");
  const Character c = read_case(file, tgf);
  const BindResult result = bound(c, quick(8000));
  // 60 points, 12 a tip: handle 0 is the middle, tips follow counterclockwise as the points do.
  ASSERT_EQ(result.weights.W.rows(), 60);
  double worst = 0, mean = 0;
  for (int i = 0; i < 60; ++i)
    for (int tip = 0; tip < 5; ++tip) {
      const double difference = std::abs(result.weights.W.coeff(i, 1 + tip) -
                                         result.weights.W.coeff((i + 12) % 60, 1 + (tip + 1) % 5));
      worst = std::max(worst, difference);
      mean += difference / 300;
    }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(mean, 2e-3);
}

TEST(Triangulate, CombFingersDoNotLeak) {
  NEEDS_MESHER();
  SKINFIELD_NEEDS_DATA(file, "planar/comb-outline.obj");
  SKINFIELD_NEEDS_DATA(tgf, "planar/comb-points.tgf");
  const Character c = read_case(file, tgf);
  const BindResult result = bound(c, quick(4000));
  // At a finger's end its own handle rules: the neighbours, 0.02 away, have nothing.
  const Points& V = c.mesh.V;
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    if (V(i, 1) < 1.1) continue;
    const int finger = static_cast<int>(V(i, 0) / 0.2 + 1e-9);
    EXPECT_GT(result.weights.W.coeff(i, 1 + finger), 0.98) << V.row(i);
  }
}

}  // namespace
}  // namespace skinfield
