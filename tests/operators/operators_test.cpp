#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "skinfield/operators/biharmonic.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/operators/triharmonic.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace skinfield {
namespace {

using skinfield_test::box_tets;

Mesh jittered_box() {
  Mesh mesh = box_tets(4, 3, 3, 0.25);
  Random random(3);
  for (double& x : mesh.V.reshaped()) x += 0.05 * random.uniform();
  return mesh;
}

/// A strip of triangles bent in space.
Mesh strip() {
  Mesh mesh;
  const int n = 12;
  mesh.V.resize(2 * n, 3);
  mesh.F.resize(2 * (n - 1), 3);
  for (int i = 0; i < n; ++i) {
    const double a = 0.3 * i;
    mesh.V.row(2 * i) << std::cos(a), std::sin(a), 0;
    mesh.V.row(2 * i + 1) << std::cos(a), std::sin(a), 0.4 + 0.05 * a;
    if (i + 1 == n) break;
    mesh.F.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    mesh.F.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  return mesh;
}

template <class Elements>
void expect_laplacian(const Points& V, const Elements& E) {
  const SparseRows K = stiffness(V, E);
  EXPECT_EQ((Eigen::MatrixXd(K) - Eigen::MatrixXd(K).transpose()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT((K * Vector::Ones(V.rows())).cwiseAbs().maxCoeff(), 1e-12 * K.coeffs().maxCoeff());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(K)};
  EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues().maxCoeff());
  EXPECT_GT(eigen.eigenvalues()[1], 1e-6 * eigen.eigenvalues().maxCoeff());
  // K = G' A G with A the elements' volumes.
  const SparseRows G = gradient(V, E);
  const Vector volume = element_volumes(V, E);
  Vector A(3 * volume.size());
  for (Eigen::Index e = 0; e < volume.size(); ++e) A.segment<3>(3 * e).setConstant(volume[e]);
  const Eigen::MatrixXd other = G.transpose() * A.asDiagonal() * Eigen::MatrixXd(G);
  EXPECT_LT((other - Eigen::MatrixXd(K)).cwiseAbs().maxCoeff(), 1e-12 * K.coeffs().maxCoeff());
}

TEST(Stiffness, IsALaplacianOnTets) {
  const Mesh mesh = jittered_box();
  expect_laplacian(mesh.V, mesh.T);
}

TEST(Stiffness, IsALaplacianOnTriangles) {
  const Mesh mesh = strip();
  expect_laplacian(mesh.V, mesh.F);
}

TEST(Gradient, IsExactOnLinearFunctions) {
  const Mesh mesh = jittered_box();
  const Vec3 slope(0.3, -2, 1);
  const Vector g = gradient(mesh.V, mesh.T) * (mesh.V * slope).array().operator+(4.0).matrix();
  for (Eigen::Index e = 0; e < mesh.T.rows(); ++e) {
    EXPECT_LT((g.segment<3>(3 * e) - slope).norm(), 1e-12);
  }
  // On a surface it is the slope's tangential part: orthogonal to the normal.
  const Mesh sheet = strip();
  const Vector t = gradient(sheet.V, sheet.F) * (sheet.V * slope);
  for (Eigen::Index e = 0; e < sheet.F.rows(); ++e) {
    const Vec3 a = sheet.V.row(sheet.F(e, 0)), b = sheet.V.row(sheet.F(e, 1)),
               c = sheet.V.row(sheet.F(e, 2));
    const Vec3 normal = (b - a).cross(c - a).normalized();
    EXPECT_LT((t.segment<3>(3 * e) - (slope - slope.dot(normal) * normal)).norm(), 1e-12);
  }
}

TEST(Stiffness, MatchesCotangentsOfATriangle) {
  Points V(3, 3);
  V << 0, 0, 0, 2, 0, 0, 0.5, 1.5, 0;
  Triangles F(1, 3);
  F << 0, 1, 2;
  const SparseRows K = stiffness(V, F);
  const auto cotangent = [&](int at, int b, int c) {
    const Vec3 u = V.row(b) - V.row(at), v = V.row(c) - V.row(at);
    return u.dot(v) / u.cross(v).norm();
  };
  EXPECT_NEAR(K.coeff(0, 1), -cotangent(2, 0, 1) / 2, 1e-14);
  EXPECT_NEAR(K.coeff(1, 2), -cotangent(0, 1, 2) / 2, 1e-14);
  EXPECT_NEAR(K.coeff(0, 2), -cotangent(1, 0, 2) / 2, 1e-14);
}

TEST(Stiffness, DegenerateElementsAddNothing) {
  Mesh mesh = box_tets(2, 2, 2, 0.5);
  const SparseRows clean = stiffness(mesh.V, mesh.T);
  const Vector mass = barycentric_mass(mesh.V, mesh.T);
  const Eigen::Index t = mesh.T.rows();
  mesh.T.conservativeResize(t + 2, 4);
  mesh.T.row(t) << 0, 0, 5, 9;
  mesh.T.row(t + 1) << 0, 1, 3, 4;  // four vertices of one face of the box: flat
  const SparseRows K = stiffness(mesh.V, mesh.T);
  EXPECT_EQ((Eigen::MatrixXd(K) - Eigen::MatrixXd(clean)).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((barycentric_mass(mesh.V, mesh.T) - mass).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Stiffness, InvertedElementsCountLikeTheirMirrorImages) {
  Mesh mesh = jittered_box();
  const SparseRows K = stiffness(mesh.V, mesh.T);
  for (Eigen::Index e = 0; e < mesh.T.rows(); e += 2) std::swap(mesh.T(e, 0), mesh.T(e, 1));
  const SparseRows turned = stiffness(mesh.V, mesh.T);
  EXPECT_LT((Eigen::MatrixXd(K) - Eigen::MatrixXd(turned)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Biharmonic, IsTheProductAndKillsConstants) {
  const Mesh mesh = jittered_box();
  const SparseRows K = stiffness(mesh.V, mesh.T);
  const Vector M = barycentric_mass(mesh.V, mesh.T);
  const SparseRows Q = biharmonic(K, M);
  const Eigen::MatrixXd direct =
      Eigen::MatrixXd(K) * M.cwiseInverse().asDiagonal() * Eigen::MatrixXd(K);
  const double scale = direct.cwiseAbs().maxCoeff();
  EXPECT_LT((Eigen::MatrixXd(Q) - direct).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_EQ((Eigen::MatrixXd(Q) - Eigen::MatrixXd(Q).transpose()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT((Q * Vector::Ones(Q.rows())).cwiseAbs().maxCoeff(), 1e-11 * scale);
  EXPECT_TRUE(Q.isCompressed());
  for (Eigen::Index i = 0; i < Q.rows(); ++i) {
    for (auto p = Q.outerIndexPtr()[i] + 1; p < Q.outerIndexPtr()[i + 1]; ++p) {
      ASSERT_LT(Q.innerIndexPtr()[p - 1], Q.innerIndexPtr()[p]);
    }
  }
}

TEST(Triharmonic, IsTheProductAndKillsConstants) {
  const Mesh mesh = jittered_box();
  const SparseRows K = stiffness(mesh.V, mesh.T);
  const Vector M = barycentric_mass(mesh.V, mesh.T);
  const SparseRows A = triharmonic(K, M);
  const Eigen::MatrixXd half = M.cwiseInverse().asDiagonal() * Eigen::MatrixXd(K);
  const Eigen::MatrixXd direct = Eigen::MatrixXd(K) * half * half;
  const double scale = direct.cwiseAbs().maxCoeff();
  EXPECT_LT((Eigen::MatrixXd(A) - direct).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_EQ((Eigen::MatrixXd(A) - Eigen::MatrixXd(A).transpose()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT((A * Vector::Ones(A.rows())).cwiseAbs().maxCoeff(), 1e-10 * scale);
  EXPECT_TRUE(A.isCompressed());
  // Its energy is that of the Laplacian's gradient.
  const Vector w = mesh.V.col(0).cwiseAbs2() - mesh.V.col(2);
  const Vector laplacian = M.cwiseInverse().asDiagonal() * (K * w);
  const double energy = laplacian.dot(K * laplacian);
  EXPECT_NEAR(w.dot(A * w), energy, 1e-10 * energy);
}

TEST(Energies, FollowTheScaleLaw) {
  const Mesh mesh = jittered_box();
  const Vector w = mesh.V.col(0).array().sin();
  const auto energies = [&](double unit) {
    const SparseRows K = stiffness(unit * mesh.V, mesh.T);
    const Vector M = barycentric_mass(unit * mesh.V, mesh.T);
    return Vec3(w.dot(K * w), w.dot(biharmonic(K, M) * w), w.dot(triharmonic(K, M) * w));
  };
  // length^(3 - 2 order)
  for (const double unit : {0.01, 100.0})
    for (int order = 1; order <= 3; ++order)
      EXPECT_NEAR(
          energies(unit)[order - 1] / energies(1)[order - 1] / std::pow(unit, 3 - 2 * order), 1,
          1e-10);
}

TEST(Biharmonic, SameBytesAtAnyThreadCount) {
  const Mesh mesh = box_tets(12, 8, 8, 0.1);
  const SparseRows K = stiffness(mesh.V, mesh.T);
  const Vector M = barycentric_mass(mesh.V, mesh.T);
  SparseRows Q[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    Q[threads - 1] = biharmonic(K, M);
  }
  EXPECT_TRUE((Q[0].coeffs() == Q[1].coeffs()).all());
}

}  // namespace
}  // namespace skinfield
