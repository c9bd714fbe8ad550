#include "skinfield/geometry/mesh.h"

#include "geometry/shapes.h"
#include "skinfield/geometry/winding_number.h"

#include <gtest/gtest.h>

#include <set>

using namespace skinfield_test;

namespace {

TEST(Mesh, UnitBoxIsUndoneByItsInverse) {
  const Points X = random_points(50, -3, 40, 1);
  const UnitBox unit = unit_box(X);
  const Box3 box = bounding_box(unit.to(X));
  EXPECT_NEAR((box.row(1) - box.row(0)).maxCoeff(), 1, 1e-12);
  EXPECT_LT((unit.from(unit.to(X)) - X).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(unit.to(row(X, 7)), row(unit.to(X), 7));
  EXPECT_EQ(unit_box(X.topRows(1)).scale, 1);
  EXPECT_NEAR(diagonal(box), (box.row(1) - box.row(0)).norm(), 0);
}

TEST(Weld, MergesEqualPositionsInOrderOfAppearance) {
  Points V(5, 3);
  V << 1, 2, 3, 0, 0, 0, 1, 2, 3, -0.0, 0, 0, 1, 2, 3.0000001;
  const Welded welded = weld(V);
  EXPECT_EQ(welded.vertex, (std::vector<int>{0, 1, 0, 1, 2}));
  ASSERT_EQ(welded.V.rows(), 3);
  for (Eigen::Index i = 0; i < V.rows(); ++i) EXPECT_EQ(row(welded.V, welded.vertex[i]), row(V, i));
  EXPECT_EQ(weld(V, 1e-3).vertex, (std::vector<int>{0, 1, 0, 1, 0}));
}

TEST(Weld, WithToleranceKeepsRepresentativesApartAndMembersNear) {
  const Points X = random_points(3000, 0, 1, 2);
  const double tolerance = 0.05;
  const Welded welded = weld(X, tolerance);
  EXPECT_LT(welded.V.rows(), X.rows());
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    EXPECT_LT((row(welded.V, welded.vertex[i]) - row(X, i)).norm(), tolerance);
  for (Eigen::Index i = 0; i < welded.V.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      EXPECT_GE((row(welded.V, i) - row(welded.V, j)).norm(), tolerance);
}

TEST(Weld, NonFiniteVerticesStayApart) {
  Points V = Points::Constant(3, 3, std::nan(""));
  EXPECT_EQ(weld(V).V.rows(), 3);
  EXPECT_EQ(weld(Points(0, 3)).V.rows(), 0);
}

TEST(Components, AreCountedByFirstFace) {
  Triangles F(5, 3);
  F << 4, 5, 6, 0, 1, 2, 6, 7, 8, 2, 3, 9, 10, 11, 12;
  const Components components = connected_components(F, 13);
  EXPECT_EQ(components.count, 3);
  EXPECT_EQ(components.of_face, (std::vector<int>{0, 1, 0, 1, 2}));
}

TEST(Mesh, AreasAndNormalsOfABox) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 2, 3});
  EXPECT_NEAR(face_areas(box.V, box.F).sum(), 22, 1e-12);
  EXPECT_NEAR(face_normals(box.V, box.F).colwise().sum().norm(), 0, 1e-12);
  const Points N = vertex_normals(box.V, box.F);
  const Points outward = (box.V.rowwise() - Eigen::RowVector3d(0.5, 1, 1.5)).array().sign();
  EXPECT_LT((N - outward / std::sqrt(3.0)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Mesh, VertexNormalsDoNotDependOnTheTriangulation) {
  const Mesh coarse = box_mesh({0, 0, 0}, {1, 1, 1});
  Mesh turned = coarse;  // the other diagonal of one side
  turned.F.row(0) << 0, 2, 1;
  turned.F.row(1) << 1, 2, 3;
  EXPECT_LT((vertex_normals(coarse.V, coarse.F) - vertex_normals(turned.V, turned.F)).norm(),
            1e-12);
  const Mesh flat = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}}, {{0, 1, 2}});
  EXPECT_EQ(vertex_normals(flat.V, flat.F).norm(), 0);
}

/// A grid of cubes of six tets each, every second of them inverted.
Mesh tet_grid(int n) {
  Mesh mesh;
  const auto at = [n](int x, int y, int z) { return (z * (n + 1) + y) * (n + 1) + x; };
  mesh.V.resize((n + 1) * (n + 1) * (n + 1), 3);
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) mesh.V.row(at(x, y, z)) << x, y, z;
  std::vector<Eigen::Vector4i> tets;
  const int steps[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (const auto& step : steps) {  // Kuhn: along the axes in every order
          Eigen::Vector3i p(x, y, z);
          Eigen::Vector4i tet;
          tet[0] = at(x, y, z);
          for (int k = 0; k < 3; ++k) {
            ++p[step[k]];
            tet[k + 1] = at(p[0], p[1], p[2]);
          }
          tets.push_back(tet);
        }
  mesh.T.resize(static_cast<Eigen::Index>(tets.size()), 4);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) mesh.T.row(t) = tets[t].transpose();
  return mesh;
}

TEST(BoundaryFaces, CloseAndPointOutwardWhateverTheTetsOrder) {
  Mesh mesh = tet_grid(3);
  const Triangles F = boundary_faces(mesh.V, mesh.T);
  EXPECT_EQ(F.rows(), 6 * 9 * 2);
  std::multiset<std::pair<int, int>> edges;
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) edges.insert({F(f, k), F(f, (k + 1) % 3)});
  for (const auto& [a, b] : edges) EXPECT_EQ(edges.count({a, b}), edges.count({b, a}));
  EXPECT_NEAR(winding_number_direct(mesh.V, F, {1.3, 1.4, 1.7}), 1, 1e-12);
  EXPECT_NEAR(winding_number_direct(mesh.V, F, {-1, 1.4, 1.7}), 0, 1e-12);
}

TEST(BoundaryFaces, OfOneTetAreItsFourSides) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {});
  for (const bool inverted : {false, true}) {
    Tetrahedra T(1, 4);
    T << 0, 1, 2, 3;
    if (inverted) T << 1, 0, 2, 3;
    const Triangles F = boundary_faces(mesh.V, T);
    EXPECT_EQ(F.rows(), 4);
    EXPECT_NEAR(winding_number_direct(mesh.V, F, {0.1, 0.1, 0.1}), 1, 1e-12);
  }
  EXPECT_EQ(boundary_faces(mesh.V, Tetrahedra(0, 4)).rows(), 0);
}

}  // namespace
