// Binding on tetrahedra: the input's own, and made from a surface.
#include "bind/fixtures.h"
#include "domain/alpha_wrap.h"
#include "domain/tetgen_mesher.h"
#include "skinfield/base/error.h"
#include "skinfield/bind/report.h"
#include "skinfield/domain/tet_domain.h"
#include "skinfield/domain/tetrahedraliser.h"
#include "support/box_tets.h"
#include "support/data.h"

namespace skinfield_test {
namespace {

#define SKINFIELD_NEEDS_MESHERS() \
  if (!have_tetgen() || !have_alpha_wrap()) GTEST_SKIP() << "this profile has no meshers"

/// A bar of tets along x, 8 x 2 x 2 cells, file units a hundredth.
Character tet_bar(const std::vector<Handle>& handles) {
  Mesh mesh = box_tets(8, 2, 2, 0.01);
  mesh.F = boundary_faces(mesh.V, mesh.T);
  Character c = character(mesh, handles);
  return c;
}

std::vector<Handle> on_vertices() {
  return {bone({0.01, 0.01, 0.01}, {0.04, 0.01, 0.01}),
          bone({0.04, 0.01, 0.01}, {0.07, 0.01, 0.01})};
}

BindOptions on_tets(int nodes = 800) {
  BindOptions options = quick(nodes);
  options.domain = BindOptions::DomainKind::tets;
  return options;
}

TEST(BindOnTets, IsTheDefaultForTetMeshesAndCoversInteriorVertices) {
  const Character c = tet_bar(on_vertices());
  const BindResult result = bound(c, BindOptions{});
  const BindReport& r = result.report;
  EXPECT_EQ(r.domain_kind, "tets");
  EXPECT_EQ(r.tet_route, "given");
  EXPECT_EQ(name_of(r.rung), "volume");
  EXPECT_EQ(r.nodes, c.mesh.V.rows());
  EXPECT_EQ(r.elements, c.mesh.T.rows());
  EXPECT_EQ(r.split_nodes, 0);
  EXPECT_EQ(r.handles_inside.size(), 2u);
  // Rows on bones are exact, in the interior: vertex (2,1,1) and the joint (4,1,1).
  const RowMatrix W = dense_weights(result.weights);
  EXPECT_NEAR(W((2 * 3 + 1) * 3 + 1, 0), 1, 1e-12);
  EXPECT_NEAR(W((4 * 3 + 1) * 3 + 1, 0), 0.5, 1e-12);
  // The bar and its bones are mirrored about x = 0.04, though its tets are not.
  for (int i = 0; i <= 8; ++i) {
    EXPECT_NEAR(W((i * 3 + 0) * 3 + 0, 0), W(((8 - i) * 3 + 0) * 3 + 2, 1), 0.05);
  }
  EXPECT_NE(report_json({r}, {}).find("\"route\": \"given\""), std::string::npos);
}

TEST(BindOnTets, SplitsWhereAHandleHasNoVertex) {
  std::vector<Handle> handles = on_vertices();
  handles.push_back(point_handle({0.0753, 0.0141, 0.0062}));
  const BindResult result = bound(tet_bar(handles), on_tets());
  EXPECT_EQ(result.report.tet_route, "split");
  EXPECT_EQ(result.report.split_nodes, 1);
  EXPECT_GT(dense_weights(result.weights).col(2).maxCoeff(), 0.5);
}

TEST(BindOnTets, PiecesWithoutAHandleTakeTheNearest) {
  const Mesh one = box_tets(4, 2, 2, 0.1), other = box_tets(2, 2, 2, 0.1);
  Mesh mesh;
  mesh.V.resize(one.V.rows() + other.V.rows(), 3);
  mesh.V << one.V, other.V.rowwise() + Eigen::RowVector3d(0.6, 0, 0);
  mesh.T.resize(one.T.rows() + other.T.rows(), 4);
  mesh.T << one.T, (other.T.array() + static_cast<std::int32_t>(one.V.rows())).matrix();
  mesh.F = boundary_faces(mesh.V, mesh.T);
  const BindResult result = bound(character(mesh, {bone({0, 0.1, 0.1}, {0.1, 0.1, 0.1}),
                                                   bone({0.3, 0.1, 0.1}, {0.4, 0.1, 0.1})}),
                                  on_tets());
  EXPECT_EQ(result.report.node_components_without_handle, 1);
  const RowMatrix W = dense_weights(result.weights);
  EXPECT_TRUE((W.bottomRows(other.V.rows()).col(1).array() == 1).all());
  std::int64_t filled = 0;
  for (const auto& [cause, count] : result.report.vertices_filled) filled += count;
  EXPECT_EQ(filled, other.V.rows());
}

TEST(BindOnTets, FillsSurfacesAndAgreesWithPoints) {
  SKINFIELD_NEEDS_MESHERS();
  const Character c = character(bar(), bar_bones());
  const BindResult tets = bound(c, on_tets(1500));
  EXPECT_EQ(tets.report.tet_route, "tetgen");
  EXPECT_LT(tv(tets.weights, bound(c, quick(1500)).weights), 0.04);
  // Torn open, the same bar goes through a wrap, to nearly the same weights.
  Mesh torn = bar();
  torn.F.conservativeResize(torn.F.rows() - 1, 3);
  const BindResult wrapped = bound(character(torn, bar_bones()), on_tets(1500));
  EXPECT_EQ(wrapped.report.tet_route, "wrap");
  EXPECT_FALSE(wrapped.report.warnings.empty());
  EXPECT_LT(tv(tets.weights, wrapped.weights), 0.04);
}

TEST(BindOnTets, PaintLocksAndStartsHold) {
  SKINFIELD_NEEDS_MESHERS();
  const Character closed = character(bar(), bar_bones());
  Mesh torn = bar();
  torn.F.conservativeResize(torn.F.rows() - 1, 3);
  for (const Character& c : {closed, character(torn, bar_bones())}) {
    BindOptions options = on_tets(1500);
    const BindResult plain = bound(c, options);
    options.paint = Paint{{3, 40}, RowMatrix::Zero(2, 3)};
    options.paint->weights.col(2).setOnes();
    const BindResult painted = bound(c, options);
    EXPECT_EQ(dense_weights(painted.weights)(40, 2), 1);
    EXPECT_GT(tv(painted.weights, plain.weights), 1e-4);
    options.paint.reset();
    options.start = plain.weights;
    options.locked_columns = {1};
    const BindResult locked = bound(c, options);
    EXPECT_LT((dense_weights(locked.weights).col(1) - dense_weights(plain.weights).col(1))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
  }
}

TEST(BindOnTets, SaysWhyThereAreNone) {
  // Points in a line enclose nothing, not even wrapped they hold the bone far away.
  Mesh line;
  line.V.resize(3, 3);
  line.V << 0, 0, 0, 1, 0, 0, 2, 0, 0;
  try {
    bind(character(line, {bone({0, 5, 0}, {1, 5, 0})}), on_tets());
    FAIL() << "bound without tetrahedra";
  } catch (const DomainError& error) {
    EXPECT_FALSE(error.remedy().empty());
  }
}

TEST(BindOnTetsData, TheHandReachesItsOptimum) {
  SKINFIELD_NEEDS_DATA(mesh, "fem/hand.mesh");
  SKINFIELD_NEEDS_DATA(tgf, "fem/hand.tgf");
  const Character c = read_case(mesh, tgf);
  BindOptions options;
  options.tolerance = 1e-4;
  const BindResult result = bound(c, options);
  EXPECT_EQ(result.report.tet_route, "given");
  EXPECT_EQ(result.report.handle_nodes, 221);
  EXPECT_NEAR(result.report.solve.energy, 13288.1427, 1e-5 * 13288.1427);
  EXPECT_LE(result.report.solve.lower_bound, 13288.1428);
}

TEST(BindOnTetsData, TheArmLiesWithinItsBounds) {
  SKINFIELD_NEEDS_DATA(mesh, "fem/arm.mesh");
  SKINFIELD_NEEDS_DATA(tgf, "fem/arm.tgf");
  const BindResult result = bound(read_case(mesh, tgf), BindOptions{});
  EXPECT_GT(result.report.solve.energy, 940.783);
  EXPECT_LT(result.report.solve.energy, 940.848 * (1 + 1e-4));
}

TEST(BindOnTetsData, SamplesBecomeVerticesOfFineSurfaces) {
  SKINFIELD_NEEDS_MESHERS();
  SKINFIELD_NEEDS_DATA(mesh, "surface/spot-23k.obj");
  SKINFIELD_NEEDS_DATA(tgf, "surface/spot-23k.tgf");
  Character c = read_case(mesh, tgf);
  const UnitBox box = unit_box(c.mesh.V);
  c.mesh.V = box.to(c.mesh.V);
  for (Handle& handle : c.skeleton.handles) {
    for (auto& [a, b] : handle.segments) {
      a = box.to(a);
      b = box.to(b);
    }
  }
  TetrahedraliserOptions options;
  options.nodes = 4000;
  const Tetrahedralisation tets = tetrahedralise(c.mesh, c.skeleton.handles, options);
  EXPECT_EQ(tets.route, TetRoute::tetgen);
  EXPECT_GT(tets.handle_points, 300);
  EXPECT_GT(tet_statistics(tets.V, tets.T).min_dihedral, 3);
  EXPECT_EQ(TetDomain(tets.V, tets.T, c.skeleton.handles).facts().new_nodes, 0);
}

TEST(BindOnTetsData, TheOctopusIsSplit) {
  SKINFIELD_NEEDS_DATA(mesh, "fem/octopus-low.mesh");
  SKINFIELD_NEEDS_DATA(tgf, "fem/octopus-low.tgf");
  const BindResult result = bound(read_case(mesh, tgf), BindOptions{});
  EXPECT_EQ(result.report.tet_route, "split");
  EXPECT_GT(result.report.split_nodes, 72);
  EXPECT_EQ(result.report.rows, 452);
  EXPECT_TRUE(result.report.handles_outside.empty());
}

}  // namespace
}  // namespace skinfield_test
