// Geometric fields of flat shapes: outlines, triangles in a plane, soups of edges.
#include "bind/fixtures.h"
#include "skinfield/base/parallel.h"
#include "skinfield/domain/planar_mesher.h"
#include "skinfield/io/sfield.h"
#include "skinfield/methods/geometric_fields.h"
#include "support/data.h"
#include "support/outlines.h"

#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

using namespace skinfield_test;

std::vector<Handle> bones_of_fork(double gap) {
  return {bone({0.1, 0.15, 0}, {0.1, 0.85, 0}), bone({0.3 + gap, 0.15, 0}, {0.3 + gap, 0.85, 0})};
}

Character fork_outline(double gap, double longest = 0.05) {
  return character(outline_of({fork_loop(gap)}, longest), bones_of_fork(gap));
}

BindOptions on_triangles() {
  BindOptions options = quick();
  options.nodes = 8000;
  options.tolerance = 1e-4;
  return options;
}

TEST(PlanarField, AgreesWithExactWeightsOnTriangles) {
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  const Character c = fork_outline(0.02);
  const SkinWeights exact = bound(c, on_triangles()).weights;
  BindOptions options = field(4000);
  for (const Boundary boundary : {Boundary::natural, Boundary::neumann}) {
    options.boundary = boundary;
    const BindResult result = bound(c, options);
    expect_valid(result, c);
    EXPECT_EQ(result.report.domain_kind, "field");
    EXPECT_EQ(result.report.rung, Rung::surface);
    EXPECT_TRUE(result.report.warnings.empty());
    EXPECT_LT(tv(result.weights, exact), 0.03);
  }
}

TEST(PlanarField, TheAlligatorAgreesWithExactWeights) {
  for (const char* handles : {"planar/alligator.tgf", "planar/alligator-points.tgf"}) {
    SKINFIELD_NEEDS_DATA(mesh, "planar/alligator.obj");
    SKINFIELD_NEEDS_DATA(tgf, handles);
    const Character c = read_case(mesh, tgf);
    const SkinWeights exact = bound(c, on_triangles()).weights;
    EXPECT_LT(tv(bound(c, field(1 << 13)).weights, exact), 0.05) << handles;
  }
}

TEST(PlanarField, DoesNotBleedAcrossAThinSlit) {
  for (const double gap : {0.02, 1e-3, 1e-4}) {
    const Character c = fork_outline(gap);
    const BindResult result = bound(c, field(2000));
    expect_valid(result, c);
    // The other prong's weight on the walls of the slit is no more than on the walls outside.
    double slit = 0, outside = 0;
    for (Eigen::Index v = 0; v < c.mesh.V.rows(); ++v) {
      const double x = c.mesh.V(v, 0);
      if (c.mesh.V(v, 1) < 0.6) continue;
      const double other = result.weights.W.coeff(v, x < 0.2 + 0.5 * gap ? 1 : 0);
      double& largest = x > 0.1 && x < 0.3 + gap ? slit : outside;
      largest = std::max(largest, other);
    }
    EXPECT_LT(slit, outside + 0.01) << gap;
    EXPECT_LT(slit, 0.04) << gap;
  }
  BindOptions open = field(2000);
  open.field.visibility = FieldVisibility::none;
  const Character c = fork_outline(1e-3);
  const RowMatrix W(bound(c, open).weights.W);
  double across = 0;
  for (Eigen::Index v = 0; v < c.mesh.V.rows(); ++v)
    if (c.mesh.V(v, 1) > 0.6) across = std::max(across, W(v, c.mesh.V(v, 0) < 0.2 ? 1 : 0));
  EXPECT_GT(across, 0.1);
}

TEST(PlanarField, TheSameInAnyPlane) {
  const Character flat = fork_outline(0.02);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.5).normalized()).toRotationMatrix();
  Character tilted = flat;
  tilted.mesh.V = flat.mesh.V * R.transpose();
  tilted.mesh.V.rowwise() += Eigen::RowVector3d(3, -1, 2);
  for (Handle& handle : tilted.skeleton.handles)
    for (auto& [a, b] : handle.segments) a = R * a + Vec3(3, -1, 2), b = R * b + Vec3(3, -1, 2);
  const BindResult there = bound(tilted, field(2000));
  EXPECT_EQ(there.report.domain_kind, "field");
  EXPECT_LT(tv(there.weights, bound(flat, field(2000)).weights), 0.02);
}

TEST(PlanarField, AnOutlineAndItsTrianglesAgree) {
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  const Character outline = fork_outline(0.02);
  const PlanarMesh planar = mesh_outline(outline.mesh, {}, {.nodes = 300});
  Mesh mesh;
  mesh.V = planar.V;
  mesh.F = planar.F;
  const Character triangles = character(mesh, bones_of_fork(0.02));
  const SkinWeights a = bound(outline, field(2000)).weights,
                    b = bound(triangles, field(2000)).weights;
  EXPECT_GT(b.W.rows(), a.W.rows());
  EXPECT_LT(tv(a, rows_of(b, 0, a.W.rows())), 1e-3) << "the same area, the same samples";
}

TEST(PlanarField, SoupsOfEdgesAreNearlyTheirOutline) {
  const double gap = 0.1;
  const Mesh whole = outline_of({fork_loop(gap)}, 0.03);
  const SkinWeights exact = bound(character(whole, bones_of_fork(gap)), field(2000)).weights;
  for (const double removed : {0.1, 0.3}) {
    const Mesh soup = segment_soup(whole, removed, 0.002, 11);
    const Character c = character(soup, bones_of_fork(gap));
    const BindResult result = bound(c, field(2000));
    expect_valid(result, c);
    EXPECT_EQ(result.report.domain_kind, "field");
    EXPECT_GT(result.report.dirty_parts, 10);
    // Each end against the outline's nearest vertex.
    double difference = 0;
    for (Eigen::Index v = 0; v < soup.V.rows(); ++v) {
      Eigen::Index nearest = 0;
      (whole.V.rowwise() - soup.V.row(v)).rowwise().squaredNorm().minCoeff(&nearest);
      difference +=
          0.5 *
          (RowMatrix(result.weights.W).row(v) - RowMatrix(exact.W).row(nearest)).cwiseAbs().sum();
    }
    EXPECT_LT(difference / static_cast<double>(soup.V.rows()), 0.05) << removed;
  }
}

TEST(PlanarField, PaintIsKept) {
  const Character c = fork_outline(0.02);
  BindOptions options = field(2000);
  options.paint.emplace();
  for (int v = 0; v < c.mesh.V.rows(); ++v)
    if (c.mesh.V(v, 0) == 0 && c.mesh.V(v, 1) > 0.5) options.paint->vertex.push_back(v);
  options.paint->weights =
      RowMatrix::Zero(static_cast<Eigen::Index>(options.paint->vertex.size()), 2);
  options.paint->weights.col(1).setOnes();
  const BindResult painted = bound(c, options), plain = bound(c, field(2000));
  for (const int v : options.paint->vertex) EXPECT_NEAR(painted.weights.W.coeff(v, 1), 1, 1e-12);
  EXPECT_GT(options.paint->vertex.size(), 5u);
  // The other prong does not feel it.
  for (Eigen::Index v = 0; v < c.mesh.V.rows(); ++v)
    if (c.mesh.V(v, 0) > 0.3 && c.mesh.V(v, 1) > 0.6) {
      EXPECT_NEAR(painted.weights.W.coeff(v, 1), plain.weights.W.coeff(v, 1), 0.02);
    }
}

TEST(PlanarField, NormalDerivativesVanishUnderNeumann) {
  const Mesh bar = outline_of({{{0, 0}, {1, 0}, {1, 0.25}, {0, 0.25}}});
  // Slanted, so that level lines meet the sides askew where they may.
  const std::vector<Handle> across{bone({0.1, 0.05, 0}, {0.4, 0.2, 0}),
                                   bone({0.6, 0.05, 0}, {0.9, 0.2, 0})};
  double slope[2] = {0, 0};
  for (const bool neumann : {false, true}) {
    GeometricFieldsOptions options;
    options.points = 600;
    if (neumann) options.boundary = GeometricFieldsOptions::Boundary::neumann;
    const GeometricFieldsResult result = geometric_fields(bar, across, {}, options);
    const double t = 0.1 * (neumann ? result.facts.radii.neumann : 0.03);
    for (int k = 1; k < 40; ++k) {
      Points X(2, 3);
      X << 0.1 + 0.8 * k / 40, 1e-6, 0, 0.1 + 0.8 * k / 40, t, 0;
      std::vector<Fill> fill;
      const RowMatrix W = result.field->at(X, {}, fill);
      slope[neumann] = std::max(slope[neumann], std::abs(W(1, 0) - W(0, 0)) / t);
    }
  }
  EXPECT_GT(slope[0], 0.1);
  EXPECT_LT(slope[1], 1e-3);
}

TEST(PlanarField, TheOptimisersAgreeAndThreadsChangeNothing) {
  const Character c = fork_outline(0.05);
  const SkinWeights convex = bound(c, field(800)).weights;
  for (const Solver solver : {Solver::convex, Solver::adam, Solver::adam_pool}) {
    BindOptions options = field(800);
    options.solver = solver;
    options.field.samples_per_step = 64;
    RowMatrix W[2];
    for (const int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      W[threads - 1] = RowMatrix(bound(c, options).weights.W);
    }
    EXPECT_EQ(W[0], W[1]);
    EXPECT_LT(0.5 * (W[0] - RowMatrix(convex.W)).cwiseAbs().rowwise().sum().mean(), 0.05);
  }
}

TEST(PlanarField, SavedOnesKeepTheirOutline) {
  for (const Character& c :
       {fork_outline(0.02),
        character(segment_soup(outline_of({fork_loop(0.1)}, 0.03), 0.1, 0.002, 11),
                  bones_of_fork(0.1))}) {
    BindOptions options = field(600);
    options.keep_field = true;
    const BindResult result = bound(c, options);
    ASSERT_TRUE(result.field.has_value());
    const FieldFile back = parse_sfield(format_sfield(*result.field), "test");
    EXPECT_EQ(back.shape.outline.E, c.mesh.outline.E);
    EXPECT_EQ(back.shape.outline.loose, c.mesh.outline.loose);
    const auto solved = solved_field(back);
    // Without normals, too: in the middle of the left prong, and of the right one.
    Character places = c;
    places.mesh = Mesh{};
    places.mesh.V.resize(2, 3);
    places.mesh.V << 0.1, 0.8, 0, 0.32, 0.8, 0;
    places.vertex_of_input = {0, 1};
    const SkinWeights W = transfer(*solved, places);
    EXPECT_GT(W.W.coeff(0, 0), 0.95);
    EXPECT_GT(W.W.coeff(1, 1), 0.95);
    options.keep_field = false;
    options.resume = std::make_shared<const FieldFile>(back);
    EXPECT_LT(tv(bound(c, options).weights, result.weights), 0.02);
  }
}

TEST(PlanarField, WithoutAnInsideTrianglesStandIn) {
  if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  Character c = fork_outline(0.02);
  for (Handle& handle : c.skeleton.handles)
    for (auto& [a, b] : handle.segments) a.x() += 5, b.x() += 5;
  const BindResult result = bound(c, field(2000));
  EXPECT_NE(result.report.domain_kind, "field");
  ASSERT_FALSE(result.report.warnings.empty());
  EXPECT_NE(result.report.warnings.front().find("on the surface"), std::string::npos);
}

}  // namespace
}  // namespace skinfield
