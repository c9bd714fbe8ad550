#include "skinfield/domain/tetrahedraliser.h"

#include "domain/alpha_wrap.h"
#include "domain/fixtures.h"
#include "domain/surface_refinement.h"
#include "domain/tetgen_mesher.h"
#include "skinfield/domain/tet_domain.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/geometry/diagnosis.h"

#include <gtest/gtest.h>

namespace skinfield_test {
namespace {

#define SKINFIELD_NEEDS_MESHERS() \
  if (!have_tetgen() || !have_alpha_wrap()) GTEST_SKIP() << "this profile has no meshers"

TetrahedraliserOptions small(int nodes = 600) {
  TetrahedraliserOptions options;
  options.nodes = nodes;
  return options;
}

void expect_sound(const Tetrahedralisation& tets) {
  const TetStatistics s = tet_statistics(tets.V, tets.T);
  EXPECT_EQ(s.inverted, 0);
  EXPECT_EQ(s.degenerate, 0);
  EXPECT_NEAR(s.volume, tets.surface_volume, 1e-9);
  EXPECT_GT(s.median_dihedral, 25);
}

int nodes_on(const TetDomain& domain, int handle) {
  return static_cast<int>((domain.fixed().weights.col(handle).array() > 0).count());
}

TEST(Tetrahedraliser, FillsAClosedSurfaceAndKeepsItsVertices) {
  SKINFIELD_NEEDS_MESHERS();
  const Mesh mesh = fine_box({0, 0, 0}, {1, 0.3, 0.3}, {12, 4, 4});
  const std::vector<Handle> handles{bone({0.1, 0.15, 0.15}, {0.5, 0.15, 0.15}),
                                    bone({0.5, 0.15, 0.15}, {0.9, 0.16, 0.15}),
                                    point_handle({0.3, 0.07, 0.2})};
  const Tetrahedralisation tets = tetrahedralise(mesh, handles, small());
  EXPECT_EQ(tets.route, TetRoute::tetgen);
  EXPECT_EQ(tets.V.topRows(mesh.V.rows()), mesh.V);
  EXPECT_NEAR(tets.surface_volume, 0.09, 1e-12);
  expect_sound(tets);
  EXPECT_GT(tets.V.rows(), 400);
  EXPECT_LT(tets.V.rows(), 1500);
  // Samples are vertices on the handles: nothing is left to split.
  const TetDomain domain(tets.V, tets.T, handles);
  EXPECT_EQ(domain.facts().new_nodes, 0);
  EXPECT_GE(nodes_on(domain, 0), 2);
  EXPECT_GE(nodes_on(domain, 1), 2);
  EXPECT_EQ(nodes_on(domain, 2), 1);
}

TEST(Tetrahedraliser, RefinesCoarseSurfaces) {
  SKINFIELD_NEEDS_MESHERS();
  const Mesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const Tetrahedralisation tets =
      tetrahedralise(mesh, {point_handle({0.5, 0.5, 0.5})}, small(3000));
  expect_sound(tets);
  EXPECT_GT(tets.V.rows(), 1500);
  EXPECT_LT(tets.V.rows(), 6000);
  EXPECT_EQ(tets.V.topRows(8), mesh.V);
}

TEST(Tetrahedraliser, UnreferencedVerticesStayInTheirPlaces) {
  SKINFIELD_NEEDS_MESHERS();
  const Mesh box = fine_box({0, 0, 0}, {1, 1, 1}, {3, 3, 3});
  Mesh mesh = box;
  mesh.V.resize(box.V.rows() + 2, 3);
  mesh.V << Eigen::RowVector3d(0.2, 0.3, 0.4), box.V, Eigen::RowVector3d(0.9, 0.9, 3);
  mesh.F.array() += 1;
  // And faces that add nothing: one twice, one without area.
  mesh.F.conservativeResize(box.F.rows() + 2, 3);
  mesh.F.row(box.F.rows()) = mesh.F.row(0);
  mesh.F.row(box.F.rows() + 1) << 1, 1, 2;
  const Tetrahedralisation tets = tetrahedralise(mesh, {point_handle({0.5, 0.5, 0.5})}, small());
  EXPECT_EQ(tets.route, TetRoute::tetgen);
  EXPECT_EQ(tets.V.topRows(mesh.V.rows()), mesh.V);
  for (Eigen::Index t = 0; t < tets.T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) {
      EXPECT_NE(tets.T(t, c), 0);
      EXPECT_NE(tets.T(t, c), mesh.V.rows() - 1);
    }
  }
  EXPECT_NEAR(tet_statistics(tets.V, tets.T).volume, 1, 1e-9);
}

TEST(Tetrahedraliser, WrapsOpenSoupedAndIntersectingSurfaces) {
  SKINFIELD_NEEDS_MESHERS();
  const Mesh bar = fine_box({0, 0, 0}, {1, 0.3, 0.3}, {20, 6, 6});
  const std::vector<Handle> handles{bone({0.1, 0.15, 0.15}, {0.5, 0.15, 0.15}),
                                    bone({0.5, 0.15, 0.15}, {0.9, 0.15, 0.15})};
  Mesh open = bar;
  open.F.conservativeResize(bar.F.rows() - 1, 3);
  const Mesh crossing =
      together(bar, moved(fine_box({0, 0, 0}, {0.3, 0.3, 0.3}, {3, 3, 3}), {0.35, 0.1, 0.17}));
  struct Case {
    const char* name;
    Mesh mesh;
    double volume;
  };
  for (const Case& c : {Case{"open", open, 0.09}, Case{"soup", soup_of(bar, 0.2, 0.003, 1), 0.09},
                        Case{"crossing", crossing, 0.09 + 0.3 * 0.3 * 0.3 - 0.3 * 0.2 * 0.13},
                        Case{"cloud", {bar.V, {}, {}, {}, {}}, 0.09}}) {
    const Tetrahedralisation tets = tetrahedralise(c.mesh, handles, small(1000));
    EXPECT_EQ(tets.route, TetRoute::wrap) << c.name;
    EXPECT_FALSE(tets.why_not_direct.empty()) << c.name;
    expect_sound(tets);
    // Filled, not hollow.
    EXPECT_GT(tets.surface_volume, c.volume) << c.name;
    EXPECT_LT(tets.surface_volume, 1.4 * c.volume) << c.name;
    const TetDomain domain(tets.V, tets.T, handles);
    EXPECT_EQ(domain.facts().new_nodes, 0) << c.name;
    EXPECT_TRUE(domain.facts().outside.empty()) << c.name;
    EXPECT_EQ(domain.facts().components, 1) << c.name;
    // Every vertex of the input can be asked.
    const Points reached = domain.at(c.mesh.V, {}).P * domain.nodes();
    EXPECT_LT((reached - c.mesh.V).cwiseAbs().maxCoeff(), 1e-9) << c.name;
  }
}

TEST(Tetrahedraliser, KeepsGapsThatAreWiderThanTheWrapCloses) {
  SKINFIELD_NEEDS_MESHERS();
  // Open at the foot, so that it is wrapped; the prongs are a seventh of their height apart.
  Mesh fork = fork_mesh(0.15);
  fork.F.conservativeResize(fork.F.rows() - 2, 3);
  const Tetrahedralisation tets = tetrahedralise(fork, fork_bones(0.15), small(1500));
  ASSERT_EQ(tets.route, TetRoute::wrap);
  const TetDomain domain(tets.V, tets.T, fork_bones(0.15));
  EXPECT_FALSE(domain.contains({0.175, 0.6, 0.05}));
  EXPECT_TRUE(domain.contains({0.05, 0.6, 0.05}));
}

TEST(Tetrahedraliser, SaysWhyNothingWorks) {
  const Mesh none{Points::Zero(3, 3), Triangles(0, 3), {}, {}, {}};
  try {
    tetrahedralise(none, {point_handle({0, 0, 0})}, small());
    FAIL() << "tetrahedra of nothing";
  } catch (const DomainError& error) {
    EXPECT_NE(error.remedy().find("--domain points"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(Tetrahedraliser, SameMeshEveryTime) {
  SKINFIELD_NEEDS_MESHERS();
  Mesh open = fine_box({0, 0, 0}, {1, 0.3, 0.3}, {10, 3, 3});
  open.F.conservativeResize(open.F.rows() - 2, 3);
  const std::vector<Handle> handles{bone({0.1, 0.15, 0.15}, {0.9, 0.15, 0.15})};
  const Tetrahedralisation a = tetrahedralise(open, handles, small());
  const Tetrahedralisation b = tetrahedralise(open, handles, small());
  EXPECT_EQ(a.V, b.V);
  EXPECT_EQ(a.T, b.T);
}

TEST(InsideSamples, StayInsideAndOffTheSurface) {
  const Mesh mesh = fine_box({0, 0, 0}, {1, 0.3, 0.3}, {12, 4, 4});
  const Points X = inside_samples(
      {bone({-0.5, 0.15, 0.15}, {1.5, 0.15, 0.15}), bone({0.2, 0.15, 0.29}, {0.8, 0.15, 0.29}),
       bone({2, 2, 2}, {3, 2, 2}), point_handle({0.5, 0.1, 0.1})},
      mesh.V, mesh.F, 0.05);
  ASSERT_GT(X.rows(), 15);
  const ClosestPointQuery closest(mesh.V, mesh.F);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    EXPECT_TRUE((X.row(i).array() > 0).all() && X(i, 0) < 1);
    EXPECT_GT(closest.at(X.row(i)).distance, 0.015);
    for (Eigen::Index j = 0; j < i; ++j) EXPECT_GT((X.row(i) - X.row(j)).norm(), 0.005);
  }
}

TEST(SurfaceRefinement, KeepsShapeAndClosure) {
  const Mesh mesh = box_mesh({0, 0, 0}, {1, 0.2, 0.5});
  Mesh fine = mesh;
  split_long_edges(fine.V, fine.F, 0.15, 100000);
  EXPECT_EQ(fine.V.topRows(8), mesh.V);
  double longest = 0;
  for (Eigen::Index f = 0; f < fine.F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      longest =
          std::max(longest, (fine.V.row(fine.F(f, c)) - fine.V.row(fine.F(f, (c + 1) % 3))).norm());
    }
  }
  EXPECT_LE(longest, 0.15);
  EXPECT_NEAR(face_areas(fine.V, fine.F).sum(), 2 * (0.2 + 0.5 + 0.1), 1e-12);
  const Diagnosis d = diagnose(fine);
  EXPECT_TRUE(d.watertight);
  EXPECT_NEAR(d.volume, 0.1, 1e-12);
  EXPECT_EQ(d.inconsistent_edges, 0);
}

TEST(TetStatistics, KnowsTheRegularTet) {
  Points V(5, 3);
  V << 1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1, 0, 0, 0;
  Tetrahedra T(3, 4);
  T << 0, 1, 2, 3, 0, 2, 1, 3, 0, 0, 1, 2;
  const TetStatistics one = tet_statistics(V, T.topRows(1));
  EXPECT_NEAR(one.volume, 8.0 / 3, 1e-12);
  EXPECT_NEAR(one.min_dihedral, std::acos(1.0 / 3) * 180 / std::numbers::pi, 1e-9);
  const TetStatistics all = tet_statistics(V, T);
  EXPECT_EQ(all.degenerate, 1);
  EXPECT_EQ(all.inverted, 1);
}

}  // namespace
}  // namespace skinfield_test
