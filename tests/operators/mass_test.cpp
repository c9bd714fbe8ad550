#include "skinfield/operators/mass.h"

#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "skinfield/operators/stiffness.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <numbers>

namespace skinfield {
namespace {

using skinfield_test::box_tets;

Points random_points(Eigen::Index n, std::uint64_t seed) {
  Points V(n, 3);
  Random random(seed);
  for (double& x : V.reshaped()) x = random.uniform();
  return V;
}

Tetrahedra one_tet() {
  Tetrahedra T(1, 4);
  T << 0, 1, 2, 3;
  return T;
}

Triangles one_triangle() {
  Triangles F(1, 3);
  F << 0, 1, 2;
  return F;
}

/// Circumcentre by the linear system, in barycentric coordinates of the tetrahedron.
Eigen::Vector4d circumcentre(const Points& X) {
  Eigen::Matrix3d A;
  Vec3 b;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = X.row(k + 1) - X.row(0);
    A.row(k) = 2 * e.transpose();
    b[k] = e.squaredNorm();
  }
  const Vec3 c = A.lu().solve(b);
  const Vec3 w = (A.transpose() / 2).lu().solve(c);
  return {1 - w.sum(), w[0], w[1], w[2]};
}

/// The circumcentric cell of corner 0 by its six signed pieces: an independent formula, right
/// where the circumcentre lies inside.
double circumcentric_share(const Points& X, int corner) {
  double sum = 0;
  const Vec3 x = X.row(corner);
  const Eigen::Vector4d w = circumcentre(X);
  const Vec3 c = X.transpose() * w - x;
  for (int j = 0; j < 4; ++j)
    for (int k = 0; k < 4; ++k) {
      if (j == corner || k == corner || j == k) continue;
      const int l = 6 - corner - j - k;
      const Vec3 ej = X.row(j).transpose() - x, ek = X.row(k).transpose() - x,
                 el = X.row(l).transpose() - x;
      const Vec3 n = ej.cross(ek);
      const Vec3 face =
          (ej.squaredNorm() * ek.cross(n) - ek.squaredNorm() * ej.cross(n)) / (2 * n.squaredNorm());
      const double sign = ej.dot(ek.cross(el)) > 0 ? 1 : -1;
      sum += sign * (ej / 2).dot(face.cross(c)) / 6;
    }
  return sum;
}

TEST(Mass, SumsToTheVolumeAndIsPositive) {
  Mesh mesh = box_tets(4, 2, 3, 0.25);
  Random random(2);
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i)
    if ((mesh.V.row(i).array() > 0.01).all() && mesh.V(i, 0) < 0.99 && mesh.V(i, 1) < 0.49 &&
        mesh.V(i, 2) < 0.74)
      for (int k = 0; k < 3; ++k) mesh.V(i, k) += 0.2 * (random.uniform() - 0.5);
  mesh.V.conservativeResize(mesh.V.rows() + 1, 3);
  mesh.V.row(mesh.V.rows() - 1) << 9, 9, 9;  // in no element
  for (const MassKind kind : {MassKind::barycentric, MassKind::voronoi}) {
    const Vector M = lumped_mass(mesh.V, mesh.T, kind);
    EXPECT_NEAR(M.sum(), element_volumes(mesh.V, mesh.T).sum(), 1e-9);
    EXPECT_GT(M.minCoeff(), 0);
    // Obtuse triangles are among the faces.
    const Triangles F = boundary_faces(mesh.V, mesh.T);
    const Vector area = lumped_mass(mesh.V, F, kind);
    EXPECT_NEAR(area.sum(), face_areas(mesh.V, F).sum(), 1e-9);
    EXPECT_GT(area.minCoeff(), 0);
  }
}

bool acute_faces(const Points& X) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k)
        if (i != j && j != k && k != i && (X.row(j) - X.row(i)).dot(X.row(k) - X.row(i)) <= 0)
          return false;
  return true;
}

TEST(Mass, VoronoiTetsAreCircumcentricWhereTheCircumcentresAreInside) {
  int well_centred = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Points X(4, 3);
    X << 1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1;  // regular, and far from it
    X += (seed % 4) * random_points(4, seed);
    const Vector M = lumped_mass(X, one_tet(), MassKind::voronoi);
    EXPECT_NEAR(M.sum(), element_volumes(X, one_tet())[0], 1e-12);
    EXPECT_GT(M.minCoeff(), 0);
    if (circumcentre(X).minCoeff() < 0 || !acute_faces(X)) continue;
    ++well_centred;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(M[i], circumcentric_share(X, i), 1e-12) << seed;
  }
  EXPECT_GT(well_centred, 120) << "the regular ones and more";
  EXPECT_LT(well_centred, 380);
}

TEST(Mass, VoronoiTetsCountThePointsNearestToEachCorner) {
  Points X(4, 3);
  X << 0, 0, 0, 1, 0, 0, 0.9, 0.2, 0, 0.5, 0.1, 0.3;  // flat: the circumcentre lies outside
  ASSERT_LT(circumcentre(X).minCoeff(), 0);
  const Vector M = lumped_mass(X, one_tet(), MassKind::voronoi);
  Random random(1);
  Eigen::Vector4d hits = Eigen::Vector4d::Zero();
  const int samples = 200000;
  for (int s = 0; s < samples; ++s) {
    Eigen::Vector4d w;
    for (double& a : w) a = -std::log(1 - random.uniform());  // uniform on the simplex
    const Vec3 x = X.transpose() * (w / w.sum());
    Eigen::Index nearest = 0;
    (X.rowwise() - x.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    ++hits[nearest];
  }
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(M[i] / M.sum(), hits[i] / samples, 5e-3) << i;
}

TEST(Mass, MixedAreasOfRightAndObtuseTriangles) {
  Points V(3, 3);
  V << 0, 0, 0, 2, 0, 0, 0, 1, 0;  // right at the first corner: half, a quarter, a quarter
  EXPECT_TRUE(lumped_mass(V, one_triangle(), MassKind::voronoi).isApprox(Vec3(0.5, 0.25, 0.25)));
  V.row(2) << -0.5, 1, 0;  // obtuse there
  EXPECT_TRUE(lumped_mass(V, one_triangle(), MassKind::voronoi).isApprox(Vec3(0.5, 0.25, 0.25)));
  V.row(2) << 1e-9, 1, 0;  // hardly acute: continuous across the right angle
  EXPECT_TRUE(
      lumped_mass(V, one_triangle(), MassKind::voronoi).isApprox(Vec3(0.5, 0.25, 0.25), 1e-8));
  V.row(2) << 1, std::sqrt(3.0), 0;  // equilateral: thirds
  const double third = std::sqrt(3.0) / 3;
  EXPECT_TRUE(
      lumped_mass(V, one_triangle(), MassKind::voronoi).isApprox(Vec3(third, third, third), 1e-12));
}

TEST(Mass, ARegularGridHasEqualInnerCells) {
  const Mesh mesh = box_tets(4, 4, 4, 0.25);
  const Vector M = lumped_mass(mesh.V, mesh.T, MassKind::voronoi);
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    double cell = 1;  // halved at each side of the box
    for (int k = 0; k < 3; ++k) cell *= mesh.V(i, k) < 0.01 || mesh.V(i, k) > 0.99 ? 0.125 : 0.25;
    EXPECT_NEAR(M[i], cell, 1e-14);
  }
}

TEST(Mass, FollowsPermutationAndScale) {
  const Points X = random_points(12, 5);
  Tetrahedra T(2, 4);
  T << 3, 7, 1, 10, 7, 2, 1, 10;
  Triangles F(2, 3);
  F << 3, 7, 1, 7, 2, 1;
  Points reversed = X.colwise().reverse();
  const Tetrahedra TR = 11 - T.array();
  const Triangles FR = 11 - F.array();
  for (const MassKind kind : {MassKind::barycentric, MassKind::voronoi}) {
    const Vector M = lumped_mass(X, T, kind), A = lumped_mass(X, F, kind);
    EXPECT_TRUE(lumped_mass(reversed, TR, kind).reverse().isApprox(M, 1e-12));
    EXPECT_TRUE(lumped_mass(reversed, FR, kind).reverse().isApprox(A, 1e-12));
    EXPECT_TRUE(lumped_mass(100 * X, T, kind).isApprox(1e6 * M, 1e-12));
    EXPECT_TRUE(lumped_mass(0.01 * X, F, kind).isApprox(1e-4 * A, 1e-12));
    Tetrahedra turned = T;
    turned.col(0).swap(turned.col(2));
    EXPECT_TRUE(lumped_mass(X, turned, kind).isApprox(M, 1e-12)) << "corners in any order";
  }
}

TEST(Mass, SameBytesAtAnyThreadCount) {
  const Mesh mesh = box_tets(8, 8, 8, 0.1);
  Vector M[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    M[threads - 1] = lumped_mass(mesh.V, mesh.T, MassKind::voronoi);
  }
  EXPECT_TRUE((M[0].array() == M[1].array()).all());
}

/// Smallest eigenvalue above zero of K x = a M x.
template <class Elements>
double first_eigenvalue(const Points& V, const Elements& E, MassKind kind) {
  const Eigen::MatrixXd K(stiffness(V, E));
  const Eigen::MatrixXd M = lumped_mass(V, E, kind).asDiagonal();
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(K, M, Eigen::EigenvaluesOnly)
      .eigenvalues()[1];
}

/// The unit square in n x n cells, the diagonals all one way or jittered.
Mesh square(int n) {
  Mesh mesh;
  mesh.V.resize((n + 1) * (n + 1), 3);
  mesh.F.resize(2 * n * n, 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = 1.0 * i / n, y = 1.0 * j / n;
      // A smooth bend keeps convergence regular and makes angles obtuse.
      const double bend = 0.1 * std::sin(std::numbers::pi * x) * std::sin(std::numbers::pi * y);
      mesh.V.row(i * (n + 1) + j) << x + bend, y + bend, 0;
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      mesh.F.row(2 * (i * n + j)) << a, b, b + 1;
      mesh.F.row(2 * (i * n + j) + 1) << a, b + 1, a + 1;
    }
  return mesh;
}

TEST(Mass, EigenvaluesOfSquareAndCubeConvergeAtSecondOrder) {
  const double exact = std::numbers::pi * std::numbers::pi;  // Neumann: cos(pi x)
  for (const MassKind kind : {MassKind::barycentric, MassKind::voronoi}) {
    double error[2];
    for (int level = 0; level < 2; ++level) {
      const Mesh mesh = square(8 << level);
      error[level] = std::abs(first_eigenvalue(mesh.V, mesh.F, kind) - exact);
    }
    EXPECT_LT(error[1], 0.07 * exact);
    EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.25) << static_cast<int>(kind);
    for (int level = 0; level < 2; ++level) {
      const Mesh mesh = box_tets(3 << level, 3 << level, 3 << level, 1.0 / (3 << level));
      error[level] = std::abs(first_eigenvalue(mesh.V, mesh.T, kind) - exact);
    }
    EXPECT_LT(error[1], 0.07 * exact);
    EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.25) << static_cast<int>(kind);
  }
}

}  // namespace
}  // namespace skinfield
