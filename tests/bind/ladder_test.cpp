// Any mesh gets weights: shapes without an inside, without bones inside, without triangles.
#include "bind/fixtures.h"

namespace skinfield {
namespace {

using namespace skinfield_test;

void expect_bones_rule_along_x(const BindResult& result, const Points& V, double share = 0.7) {
  for (Eigen::Index i = 0; i < V.rows(); ++i)
    for (int b = 0; b < 3; ++b)
      if (std::abs(V(i, 0) - (0.17 + 0.33 * b)) < 0.05) {
        EXPECT_GT(result.weights.W.coeff(i, b), share) << V.row(i);
      }
}

TEST(Ladder, AFlatStripLivesOnItsSurface) {
  const Mesh strip = flat_strip();
  const BindResult result = bound(character(strip, three_along_x()));
  EXPECT_EQ(result.report.rung, Rung::surface);
  expect_bones_rule_along_x(result, strip.V);
  // Bones beside the strip serve as well.
  const BindResult above = bound(character(strip, three_along_x(0, 0.05)));
  EXPECT_EQ(above.report.rung, Rung::surface);
  expect_bones_rule_along_x(above, strip.V);
}

TEST(Ladder, AMoebiusStripLivesOnItsSurface) {
  const BindResult result = bound(character(moebius_strip(60), ring_of_bones()));
  EXPECT_EQ(result.report.rung, Rung::surface);
  for (int b = 0; b < 4; ++b) EXPECT_GT(result.weights.W.col(b).sum(), 5);
}

TEST(Ladder, LocksHoldOnRefinedSurfaces) {
  const Character c = character(moebius_strip(60), ring_of_bones());
  const BindResult plain = bound(c);
  ASSERT_GT(plain.report.nodes, c.mesh.V.rows());
  const RowMatrix own = dense_weights(plain.weights);
  const RowMatrix given = 0.7 * own + RowMatrix::Constant(own.rows(), own.cols(), 0.075);
  BindOptions options = quick();
  options.start = sparse_weights(given);
  options.locked_columns = {1};
  const RowMatrix W = dense_weights(bound(c, options).weights);
  EXPECT_LT((W.col(1) - given.col(1)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT((W.col(0) - given.col(0)).cwiseAbs().maxCoeff(), 0.05);
}

TEST(Ladder, CloudsHaveAVolume) {
  const std::vector<Handle> bones{bone({0, 0, -0.4}, {0, 0, 0}), bone({0, 0, 0}, {0, 0, 0.4})};
  const Mesh with = sphere_cloud(0.5, 1500, true), without = sphere_cloud(0.5, 1500, false);
  const BindResult a = bound(character(with, bones)), b = bound(character(without, bones));
  EXPECT_EQ(a.report.rung, Rung::volume);
  EXPECT_EQ(b.report.rung, Rung::volume);
  EXPECT_LT(tv(a.weights, b.weights), 0.02);
  // As the sphere's own surface has it.
  const Mesh ball = sphere_mesh(0.5);
  const BindResult c = bound(character(ball, bones));
  Mesh there;
  there.V = ball.V;
  there.N = ball.V / 0.5;
  EXPECT_LT(tv(transfer(*a.solved, character(there, bones)), c.weights), 0.03);
}

TEST(Ladder, BonesAllOutsideStillBind) {
  const BindResult result = bound(character(bar(), three_along_x(0.5, 0.1)));
  EXPECT_NE(result.report.rung, Rung::volume);
  EXPECT_FALSE(result.report.warnings.empty());
  EXPECT_EQ(result.report.handles_outside.size(), 3u);
  // The bones hold the side that they see; around the corner it is less.
  expect_bones_rule_along_x(result, bar().V, 0.5);
}

TEST(Ladder, TheSmallestMeshes) {
  const std::vector<Handle> bones{bone({0, 0, 0}, {1, 0, 0}), bone({1, 0, 0}, {2, 0, 0})};
  const BindResult vertex = bound(character(make_mesh({{0.2, 0.5, 0}}, {}), bones));
  EXPECT_EQ(vertex.report.rung, Rung::nearest_handle);
  EXPECT_EQ(vertex.weights.W.coeff(0, 0), 1);
  const BindResult two = bound(character(make_mesh({{0.2, 0.5, 0}, {1.8, 0, 1}}, {}), bones));
  EXPECT_EQ(two.weights.W.coeff(0, 0), 1);
  EXPECT_EQ(two.weights.W.coeff(1, 1), 1);
  bound(character(make_mesh({{0.2, 0.5, 0}, {1, 0, 1}, {1.9, 0, 0}}, {{0, 1, 2}}), bones));
  // A triangle without an area, one that names a vertex twice, a vertex on no triangle.
  bound(character(make_mesh({{0, 1, 0}, {1, 1, 0}, {2, 1, 0}}, {{0, 1, 2}}), bones));
  bound(character(make_mesh({{0, 1, 0}, {1, 1, 0}, {2, 2, 0}}, {{0, 1, 1}}), bones));
  bound(character(make_mesh({{0, 1, 0}, {1, 1, 0}, {2, 2, 0}, {2, 0, 0.3}}, {{0, 1, 2}}), bones));
  // All vertices in one place.
  bound(character(make_mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}), bones));
}

TEST(Ladder, PointHandlesAloneBind) {
  const std::vector<Handle> points{point_handle({0.1, 0.1, 0.1}), point_handle({0.9, 0.1, 0.1})};
  const BindResult inside = bound(character(bar(), points));
  EXPECT_EQ(inside.report.rung, Rung::volume);
  EXPECT_GT(inside.weights.W.coeff(0, 0), 0.9);
  bound(character(flat_strip(), points));
}

TEST(Ladder, LooseVerticesAreWeighted) {
  // Vertices that no triangle uses, inside, beside and far from the bar.
  Mesh mesh = bar();
  const Eigen::Index n = mesh.V.rows();
  mesh.V.conservativeResize(n + 3, 3);
  mesh.V.row(n) << 0.2, 0.1, 0.15;
  mesh.V.row(n + 1) << 0.8, 0.1, 0.25;
  mesh.V.row(n + 2) << 0.8, 0.9, 0.9;
  const BindResult result = bound(character(mesh, bar_bones()));
  EXPECT_GT(result.weights.W.coeff(n, 0), 0.7);
  EXPECT_GT(result.weights.W.coeff(n + 1, 2), 0.7);
}

TEST(Ladder, AFloatingPieceWithoutBonesFollows) {
  const Mesh body = bar();
  const Mesh ball = moved(sphere_mesh(0.05, 8), {0.85, 0.1, 0.3});
  const BindResult result = bound(character(together(body, ball), bar_bones()));
  EXPECT_EQ(result.report.rung, Rung::volume);
  // It floats above the last bone's part and takes that bone's weights.
  for (Eigen::Index i = body.V.rows(); i < result.weights.W.rows(); ++i)
    EXPECT_GT(result.weights.W.coeff(i, 2), 0.7);
  // The body does not notice.
  EXPECT_LT(
      tv(rows_of(result.weights, 0, body.V.rows()), bound(character(body, bar_bones())).weights),
      0.02);
}

TEST(Ladder, AFloatingPieceWithABoneHasItsOwn) {
  const Mesh body = bar();
  const Mesh ball = moved(sphere_mesh(0.1, 8), {0.85, 0.1, 0.5});
  std::vector<Handle> bones = bar_bones();
  bones.push_back(bone({0.82, 0.1, 0.5}, {0.88, 0.1, 0.5}));
  const BindResult result = bound(character(together(body, ball), bones));
  EXPECT_EQ(result.report.node_components, 2);
  for (Eigen::Index i = 0; i < result.weights.W.rows(); ++i)
    EXPECT_NEAR(result.weights.W.coeff(i, 3), i < body.V.rows() ? 0 : 1, quick().tolerance);
}

TEST(Ladder, TheSurfaceCanBeAskedFor) {
  BindOptions options = quick();
  options.domain = BindOptions::DomainKind::surface;
  const BindResult result = bound(character(bar(), bar_bones()), options);
  EXPECT_EQ(result.report.rung, Rung::surface);
  EXPECT_EQ(result.report.domain_kind, "tris");
  expect_bones_rule_along_x(result, bar().V);
}

TEST(Ladder, PaintWorksWithoutAVolume) {
  const Mesh strip = flat_strip();
  BindOptions options = quick();
  Paint paint{{0, 1, 40, 41}, RowMatrix::Zero(4, 3)};
  paint.weights << 1, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0.5, 0.5;
  options.paint = paint;
  const BindResult with_bones = bound(character(strip, three_along_x()), options);
  const BindResult alone = bound(character(strip, {}), options);
  for (const BindResult* result : {&with_bones, &alone})
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 3; ++j)
        EXPECT_DOUBLE_EQ(result->weights.W.coeff(paint.vertex[static_cast<std::size_t>(k)], j),
                         paint.weights(k, j));
  // The vertices beside the painted ones follow.
  EXPECT_LT(bound(character(strip, three_along_x())).weights.W.coeff(38, 1), 0.05);
  EXPECT_GT(with_bones.weights.W.coeff(38, 1), 0.1);
  EXPECT_GT(alone.weights.W.coeff(4, 0), 0.5);
  EXPECT_LT(alone.weights.W.coeff(36, 0), 0.5);
}

}  // namespace
}  // namespace skinfield
