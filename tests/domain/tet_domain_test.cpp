#include "skinfield/domain/tet_domain.h"

#include "domain/fixtures.h"
#include "domain/tet_splitter.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield_test {
namespace {

Vec3 random_point(std::uint64_t number, double low, double high) {
  Random random(7, number);
  return {low + (high - low) * random.uniform(), low + (high - low) * random.uniform(),
          low + (high - low) * random.uniform()};
}

Points random_points(int count, double low, double high) {
  Points X(count, 3);
  for (int i = 0; i < count; ++i) X.row(i) = random_point(static_cast<std::uint64_t>(i), low, high);
  return X;
}

/// The box of 4 x 4 x 4 cells in the unit box.
Mesh unit_tets() { return box_tets(4, 4, 4, 0.25); }

double signed_volume(const Points& V, const Tetrahedra& T, Eigen::Index t) {
  const Vec3 a = V.row(T(t, 0)), b = V.row(T(t, 1)), c = V.row(T(t, 2)), d = V.row(T(t, 3));
  return (b - a).cross(c - a).dot(d - a) / 6;
}

/// The row of a fixed node, or an empty one.
Eigen::RowVectorXd fixed_row(const Domain& domain, int node) {
  const FixedRows& fixed = domain.fixed();
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    if (fixed.node[k] == node) return fixed.weights.row(static_cast<Eigen::Index>(k));
  }
  return {};
}

TEST(TetDomain, GivesStiffnessAndMassOfTheMesh) {
  const Mesh mesh = unit_tets();
  const TetDomain domain(mesh.V, mesh.T, {bone({0.25, 0.5, 0.5}, {0.75, 0.5, 0.5})});
  EXPECT_EQ(domain.nodes(), mesh.V);
  EXPECT_EQ(domain.elements(), mesh.T);
  const Vector ones = Vector::Ones(mesh.V.rows());
  EXPECT_LT((domain.stiffness() * ones).cwiseAbs().maxCoeff(), 1e-13);
  // x' K x of a coordinate is the volume.
  const Vector x = mesh.V.col(0);
  EXPECT_NEAR(x.dot(domain.stiffness() * x), 1, 1e-12);
  EXPECT_NEAR(domain.mass().sum(), 1, 1e-12);
  EXPECT_NEAR(domain.facts().volume, 1, 1e-12);
  EXPECT_EQ(domain.facts().components, 1);
  EXPECT_EQ(domain.facts().components_without_handle, 0);
}

TEST(TetDomain, EvaluatesLinearFunctionsExactly) {
  const Mesh mesh = unit_tets();
  const TetDomain domain(mesh.V, mesh.T, {point_handle({0.5, 0.5, 0.5})});
  const Points X = random_points(500, 0, 1);
  const Interpolation inside = domain.at(X, {});
  EXPECT_LT((inside.P * mesh.V - X).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((inside.P * Vector::Ones(mesh.V.rows()) - Vector::Ones(500)).cwiseAbs().maxCoeff(),
            1e-14);
  for (Eigen::Index k = 0; k < inside.P.nonZeros(); ++k) EXPECT_GE(inside.P.valuePtr()[k], 0);
  // At the nodes it is the identity, exactly.
  const SparseRows own = domain.at(mesh.V, {}).P;
  EXPECT_EQ(own.nonZeros(), mesh.V.rows());
  for (int i = 0; i < own.rows(); ++i) EXPECT_EQ(own.coeff(i, i), 1);
}

TEST(TetDomain, OutsidePointsTakeTheClosestPointOfTheBoundary) {
  const Mesh mesh = unit_tets();
  const TetDomain domain(mesh.V, mesh.T, {point_handle({0.5, 0.5, 0.5})});
  const Points X = random_points(500, -1, 2);
  const Points reached = domain.at(X, {}).P * mesh.V;
  for (int i = 0; i < 500; ++i) {
    const Vec3 clamped = Vec3(X.row(i)).cwiseMax(0.0).cwiseMin(1.0);
    EXPECT_LT((Vec3(reached.row(i)) - clamped).norm(), 1e-12) << i;
  }
  EXPECT_TRUE(domain.contains({0.1, 0.9, 0.3}));
  EXPECT_FALSE(domain.contains({0.1, 1.01, 0.3}));
}

TEST(TetDomain, FixesVerticesWithinAMillionthOfTheDiagonal) {
  Mesh mesh = unit_tets();
  const double diagonal = std::sqrt(3.0);
  // Vertex 62 is the middle; its neighbour along z moves off the bone by more, and by less.
  const int middle = (2 * 5 + 2) * 5 + 2, beside = middle + 1;
  const std::vector<Handle> handles{bone({0.5, 0.5, 0.25}, {0.5, 0.5, 0.75})};
  mesh.V(beside, 0) += 0.9e-6 * diagonal;
  const TetDomain near(mesh.V, mesh.T, handles);
  EXPECT_EQ(near.fixed().node, (std::vector<int>{middle - 1, middle, beside}));
  mesh.V(beside, 0) += 0.2e-6 * diagonal;
  const TetDomain far(mesh.V, mesh.T, handles);
  EXPECT_EQ(far.fixed().node, (std::vector<int>{middle - 1, middle}));
  EXPECT_EQ(far.facts().new_nodes, 0);
}

TEST(TetDomain, SharesNodesOfSeveralHandles) {
  const Mesh mesh = unit_tets();
  const int middle = (2 * 5 + 2) * 5 + 2;
  const TetDomain domain(
      mesh.V, mesh.T,
      {bone({0.25, 0.5, 0.5}, {0.5, 0.5, 0.5}), bone({0.5, 0.5, 0.5}, {0.75, 0.5, 0.5}),
       bone({0.5, 0.5, 0.5}, {0.5, 0.75, 0.5}), point_handle({0.25, 0.25, 0.25}),
       point_handle({0.25, 0.25, 0.25})});
  const Eigen::RowVectorXd joint = fixed_row(domain, middle);
  ASSERT_EQ(joint.size(), 5);
  for (int h = 0; h < 3; ++h) EXPECT_DOUBLE_EQ(joint[h], 1.0 / 3);
  const Eigen::RowVectorXd both = fixed_row(domain, (1 * 5 + 1) * 5 + 1);
  ASSERT_EQ(both.size(), 5);
  EXPECT_DOUBLE_EQ(both[3], 0.5);
  EXPECT_DOUBLE_EQ(both[4], 0.5);
  for (Eigen::Index k = 0; k < domain.fixed().weights.rows(); ++k) {
    EXPECT_NEAR(domain.fixed().weights.row(k).sum(), 1, 1e-15);
  }
}

TEST(TetDomain, SplitsTheMeshWhereAHandleHasNoVertex) {
  const Mesh mesh = unit_tets();
  const std::vector<Handle> handles{bone({0.25, 0.5, 0.5}, {0.5, 0.5, 0.5}, "on"),
                                    bone({0.31, 0.33, 0.07}, {0.62, 0.71, 0.88}, "between"),
                                    point_handle({0.86, 0.08, 0.21}, "point")};
  const TetDomain domain(mesh.V, mesh.T, handles);
  const TetDomainFacts& facts = domain.facts();
  EXPECT_EQ(facts.split_handles, 2);
  EXPECT_GE(facts.new_nodes, 7);
  EXPECT_EQ(domain.nodes().topRows(mesh.V.rows()), mesh.V);
  // The volume stays, and no child is a splinter of its parent.
  const Vector volumes = element_volumes(domain.nodes(), domain.elements());
  EXPECT_NEAR(volumes.sum(), 1, 1e-12);
  EXPECT_GT(volumes.minCoeff(), 1e-6);
  // Every new node is some handle's, and near it; ends of bones too.
  for (int v = static_cast<int>(mesh.V.rows()); v < domain.nodes().rows(); ++v) {
    EXPECT_EQ(fixed_row(domain, v).size(), 3) << v;
  }
  double to_end = 1;
  for (const int v : domain.fixed().node) {
    to_end = std::min(to_end, (Vec3(domain.nodes().row(v)) - handles[1].segments[0].second).norm());
  }
  EXPECT_LT(to_end, 0.05 * 0.45);
  // About two samples a mean edge; and still a finite element mesh: K 1 = 0, linear precision.
  EXPECT_LT((domain.stiffness() * Vector::Ones(domain.nodes().rows())).cwiseAbs().maxCoeff(),
            1e-11);
  const Points X = random_points(300, 0, 1);
  EXPECT_LT((domain.at(X, {}).P * domain.nodes() - X).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(domain.mass().sum(), 1, 1e-12);
}

TEST(TetDomain, NeighboursStillShareFacesAfterSplits) {
  const Mesh mesh = unit_tets();
  TetSplitter splitter(mesh.V, mesh.T);
  for (int i = 0; i < 400; ++i) {
    Vec3 x = random_point(static_cast<std::uint64_t>(i), 0, 1);
    // Some on faces and edges of the cells, and on the boundary.
    for (int axis = 0; axis < i % 3; ++axis) x[axis] = std::round(4 * x[axis]) / 4;
    const TetSplitter::Place place = splitter.find(x);
    ASSERT_FALSE(place.corner.empty()) << i;
    const Vec3 made = splitter.position(splitter.make_vertex(place));
    EXPECT_LT((made - x).norm(), 0.08) << i;
  }
  const Points V = splitter.points();
  const Tetrahedra T = splitter.tets();
  // No hanging vertices: the boundary is still the box, with the box's area.
  const Triangles F = boundary_faces(V, T);
  EXPECT_NEAR(face_areas(V, F).sum(), 6, 1e-12);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vec3 c = (V.row(F(f, 0)) + V.row(F(f, 1)) + V.row(F(f, 2))) / 3;
    EXPECT_LT(std::min(c.minCoeff(), 1 - c.maxCoeff()), 1e-12);
  }
  EXPECT_NEAR(element_volumes(V, T).sum(), 1, 1e-12);
}

TEST(TetDomain, SplitsKeepTheOrientationOfEveryTet) {
  Mesh mesh = unit_tets();
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    if (signed_volume(mesh.V, mesh.T, t) < 0) std::swap(mesh.T(t, 2), mesh.T(t, 3));
  }
  TetSplitter splitter(mesh.V, mesh.T);
  for (int i = 0; i < 300; ++i) {
    splitter.make_vertex(splitter.find(random_point(static_cast<std::uint64_t>(i), 0, 1)));
  }
  const Points V = splitter.points();
  const Tetrahedra T = splitter.tets();
  ASSERT_GT(T.rows(), mesh.T.rows() + 500);
  for (Eigen::Index t = 0; t < T.rows(); ++t) EXPECT_GT(signed_volume(V, T, t), 0) << t;
}

TEST(TetDomain, AHandleOnTheBoundaryHolds) {
  const Mesh mesh = unit_tets();
  // In the middle of a face, a rounding error outside.
  const TetDomain domain(mesh.V, mesh.T,
                         {point_handle({0.4, 0.3, -1e-9}), bone({0.1, 0.37, 1}, {0.9, 0.37, 1})});
  EXPECT_TRUE(domain.facts().outside.empty());
  EXPECT_EQ(domain.facts().split_handles, 2);
  for (const int v : domain.fixed().node) {
    const double z = domain.nodes()(v, 2);
    EXPECT_TRUE(std::abs(z) < 1e-12 || std::abs(z - 1) < 1e-12);
  }
}

TEST(TetDomain, CutsBonesThatLeaveTheShapeAndReportsThoseOutside) {
  const Mesh mesh = unit_tets();
  const TetDomain domain(mesh.V, mesh.T,
                         {bone({0.6, 0.1, 0.3}, {5, 0.1, 0.3}, "leaves"),
                          bone({2, 2, 2}, {3, 3, 3}, "outside"), point_handle({0.5, 0.5, 0.5})});
  EXPECT_EQ(domain.facts().outside, (std::vector<int>{1}));
  int held = 0;
  for (const int v : domain.fixed().node) {
    const Eigen::RowVectorXd row = fixed_row(domain, v);
    EXPECT_EQ(row[1], 0);
    if (row[0] == 0) continue;
    ++held;
    EXPECT_NEAR(domain.nodes()(v, 1), 0.1, 0.04);
  }
  EXPECT_GE(held, 2);
  EXPECT_THROW(TetDomain(mesh.V, mesh.T, {bone({2, 2, 2}, {3, 3, 3})}), DomainError);
}

TEST(TetDomain, RegionsHoldTheirVertices) {
  const Mesh mesh = unit_tets();
  Handle region;
  region.kind = Handle::Kind::region;
  region.vertices = {0, 5, 9};
  const TetDomain domain(mesh.V, mesh.T, {point_handle({0.5, 0.5, 0.5}), region});
  EXPECT_EQ(fixed_row(domain, 5)[1], 1);
  EXPECT_EQ(domain.fixed().node.size(), 4u);
  EXPECT_EQ(domain.facts().new_nodes, 0);
}

TEST(TetDomain, DuplicateAndUnreferencedVerticesAreRead) {
  const Mesh mesh = unit_tets();
  // Every tet with corners of its own, and two vertices of no tet, one of them on the bone.
  Mesh torn;
  torn.V.resize(4 * mesh.T.rows() + 2, 3);
  torn.T.resize(mesh.T.rows(), 4);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) {
      torn.T(t, c) = static_cast<std::int32_t>(4 * t + c);
      torn.V.row(4 * t + c) = mesh.V.row(mesh.T(t, c));
    }
  }
  torn.V.bottomRows(2) << 0.3, 0.5, 0.5, 0.9, 0.2, 0.1;
  const TetDomain domain(torn.V, torn.T, {bone({0.25, 0.5, 0.5}, {0.75, 0.5, 0.5})});
  const TetDomainFacts& facts = domain.facts();
  EXPECT_EQ(facts.components, 1);
  EXPECT_EQ(facts.uncoupled_nodes, static_cast<int>(torn.V.rows() - mesh.V.rows()));
  EXPECT_EQ(facts.new_nodes, 0);
  EXPECT_EQ(domain.fixed().node.size(), 3u);
  EXPECT_TRUE((domain.mass().array() > 0).all());
  // Their rows lean on coupled nodes.
  const SparseRows P = domain.at(torn.V, {}).P;
  EXPECT_LT((P * torn.V - torn.V).cwiseAbs().maxCoeff(), 1e-12);
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    for (SparseRows::InnerIterator it(P, i); it; ++it) {
      EXPECT_GT(domain.stiffness().coeff(it.col(), it.col()), 0);
    }
  }
}

TEST(TetDomain, InvertedTetsCountLikeTheirMirrorImages) {
  const Mesh mesh = unit_tets();
  Mesh inverted = mesh;
  for (Eigen::Index t = 0; t < mesh.T.rows(); t += 3) std::swap(inverted.T(t, 0), inverted.T(t, 1));
  const std::vector<Handle> handles{point_handle({0.5, 0.5, 0.5}), point_handle({0.31, 0.2, 0.77})};
  const TetDomain a(mesh.V, mesh.T, handles), b(inverted.V, inverted.T, handles);
  EXPECT_NE(a.facts().inverted_tets, b.facts().inverted_tets);
  ASSERT_EQ(a.nodes().rows(), b.nodes().rows());
  EXPECT_LT((SparseRows(a.stiffness() - b.stiffness())).norm(), 1e-12);
  EXPECT_LT((a.mass() - b.mass()).norm(), 1e-15);
  const Points X = random_points(200, 0, 1);
  EXPECT_LT((b.at(X, {}).P * b.nodes() - X).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(TetDomain, EmptyAndNearlyEmptyTetsDoNoHarm) {
  Mesh mesh = unit_tets();
  const Eigen::Index t = mesh.T.rows();
  const Points V = mesh.V;
  mesh.T.conservativeResize(t + 3, 4);
  mesh.T.row(t) << 0, 1, 2, 3;      // in a line
  mesh.T.row(t + 1) << 7, 7, 8, 9;  // a corner twice
  mesh.T.row(t + 2) << 0, 1, 5, 6;  // in a plane
  const TetDomain flat(mesh.V, mesh.T, {point_handle({0.5, 0.5, 0.5})});
  EXPECT_EQ(flat.facts().degenerate_tets, 3);
  EXPECT_NEAR(flat.facts().volume, 1, 1e-12);
  // A sliver of height 1e-9 beside a tet of the usual size: finite entries, K 1 = 0.
  Points sliver(5, 3);
  sliver << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.3, 0.3, 1e-9, 0.3, 0.3, 1;
  Tetrahedra T(2, 4);
  T << 0, 1, 2, 3, 0, 1, 2, 4;
  const TetDomain thin(sliver, T, {point_handle({0.3, 0.3, 1})});
  EXPECT_TRUE(Eigen::Map<const Vector>(thin.stiffness().valuePtr(), thin.stiffness().nonZeros())
                  .allFinite());
  const Vector K1 = thin.stiffness() * Vector::Ones(5);
  EXPECT_LT(K1.cwiseAbs().maxCoeff() / thin.stiffness().norm(), 1e-14);
  EXPECT_TRUE((thin.mass().array() > 0).all());
  EXPECT_THROW(TetDomain(V, Tetrahedra(mesh.T.bottomRows(3)), {}), DomainError);
}

TEST(TetDomain, CountsComponentsWithoutAHandle) {
  const Mesh one = unit_tets();
  Points V(2 * one.V.rows(), 3);
  V << one.V, one.V.rowwise() + Eigen::RowVector3d(2, 0, 0);
  Tetrahedra T(2 * one.T.rows(), 4);
  T << one.T, (one.T.array() + static_cast<std::int32_t>(one.V.rows())).matrix();
  const TetDomain domain(V, T, {point_handle({0.5, 0.5, 0.5})});
  EXPECT_EQ(domain.facts().components, 2);
  EXPECT_EQ(domain.facts().components_without_handle, 1);
  EXPECT_EQ(domain.facts().nodes_without_handle, static_cast<int>(one.V.rows()));
}

TEST(TetDomain, TakesGivenMassesAndKeepsTheirDensity) {
  const Mesh mesh = unit_tets();
  TetDomainOptions options;
  options.mass = 3 * barycentric_mass(mesh.V, mesh.T);
  const TetDomain whole(mesh.V, mesh.T, {point_handle({0.5, 0.5, 0.5})}, options);
  EXPECT_EQ(whole.mass(), options.mass);
  const TetDomain split(mesh.V, mesh.T, {point_handle({0.41, 0.53, 0.38})}, options);
  ASSERT_EQ(split.facts().new_nodes, 1);
  EXPECT_NEAR(split.mass().sum(), 3, 1e-12);
  EXPECT_LT((split.mass() - 3 * barycentric_mass(split.nodes(), split.elements())).norm(), 1e-14);
  options.mass[3] = 0;
  EXPECT_THROW(TetDomain(mesh.V, mesh.T, {}, options), InputError);
  options.mass.resize(5);
  EXPECT_THROW(TetDomain(mesh.V, mesh.T, {}, options), InputError);
}

}  // namespace
}  // namespace skinfield_test
