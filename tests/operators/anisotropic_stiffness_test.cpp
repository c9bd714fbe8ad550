#include "skinfield/operators/anisotropic_stiffness.h"

#include "operators/apply.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/operators/stiffness.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>

#include <array>

namespace skinfield {
namespace {

Mesh jittered_box() {
  Mesh mesh = skinfield_test::box_tets(4, 3, 3, 0.25);
  Random random(3);
  for (double& x : mesh.V.reshaped()) x += 0.05 * random.uniform();
  return mesh;
}

/// Triangles bent in space.
Mesh sheet() {
  Mesh mesh;
  const int n = 7;
  mesh.V.resize(n * n, 3);
  mesh.F.resize(2 * (n - 1) * (n - 1), 3);
  Random random(5);
  Eigen::Index f = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.V.row(i * n + j) << i + 0.2 * random.uniform(), j, std::sin(0.7 * i) + 0.1 * j * j;
      if (i + 1 == n || j + 1 == n) continue;
      mesh.F.row(f++) << i * n + j, (i + 1) * n + j, i * n + j + 1;
      mesh.F.row(f++) << (i + 1) * n + j + 1, i * n + j + 1, (i + 1) * n + j;
    }
  }
  return mesh;
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd A(rows, columns);
  for (double& x : A.reshaped()) x = random.normal();
  return A;
}

/// Coefficients of random symmetric positive definite tensors.
Eigen::MatrixXd random_tensors(Eigen::Index elements, int d) {
  Eigen::MatrixXd A(elements, d * (d + 1) / 2);
  for (Eigen::Index e = 0; e < elements; ++e) {
    const Eigen::MatrixXd L = random_matrix(d, d, static_cast<std::uint64_t>(e));
    const Eigen::MatrixXd one = L * L.transpose();
    Eigen::Index k = 0;
    for (int c = 0; c < d; ++c) {
      for (int r = c; r < d; ++r) A(e, k++) = one(r, c);
    }
  }
  return A;
}

/// The tensor of element e in space.
Eigen::Matrix3d tensor(const AnisotropicStiffness& K, const Eigen::MatrixXd& A, Eigen::Index e) {
  const int d = K.dimension();
  Eigen::Matrix3d one = Eigen::Matrix3d::Zero();
  Eigen::Index k = 0;
  for (int c = 0; c < d; ++c) {
    for (int r = c; r < d; ++r) one(r, c) = one(c, r) = A(e, k++);
  }
  return K.frame(e) * one * K.frame(e).transpose();
}

template <class Elements>
void expect_gradients_product(const Points& V, const Elements& E) {
  const AnisotropicStiffness stiffness(V, E);
  const Eigen::MatrixXd isotropic = skinfield::stiffness(V, E);
  const double size = isotropic.cwiseAbs().maxCoeff();
  EXPECT_LT((Eigen::MatrixXd(stiffness.isotropic()) - isotropic).cwiseAbs().maxCoeff(),
            1e-12 * size);

  const Eigen::MatrixXd A = random_tensors(E.rows(), stiffness.dimension());
  SparseRows K = stiffness.isotropic();
  stiffness.assemble(A, K);
  const Eigen::MatrixXd dense(K);
  EXPECT_EQ((dense - dense.transpose()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT((dense * Vector::Ones(V.rows())).cwiseAbs().maxCoeff(), 1e-12 * dense.maxCoeff());
  const SparseRows G = gradient(V, E);
  Eigen::MatrixXd AG = G;
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    AG.middleRows<3>(3 * e) =
        (stiffness.volumes()[e] * tensor(stiffness, A, e) * AG.middleRows<3>(3 * e)).eval();
  }
  EXPECT_LT((G.transpose() * AG - dense).cwiseAbs().maxCoeff(), 1e-12 * dense.maxCoeff());

  // tr(X' K(A) Y) is linear in A: its derivative gives it back.
  for (const Eigen::Index m : {1, 3, 21}) {
    const RowMatrix X = random_matrix(V.rows(), m, 7), Y = random_matrix(V.rows(), m, 8);
    Eigen::MatrixXd D;
    stiffness.derivative(X, Y, D);
    RowMatrix KY;
    apply(K, Y, KY);
    EXPECT_LT((KY - dense * Y).cwiseAbs().maxCoeff(), 1e-12 * dense.maxCoeff() * V.rows());
    const double whole = X.cwiseProduct(KY).sum();
    EXPECT_NEAR(D.cwiseProduct(A).sum(), whole, 1e-10 * X.norm() * KY.norm());
  }

  // K x = G' vol grad x.
  const Vector x = V * Vec3(0.3, -1, 2);
  EXPECT_LT((stiffness.divergence(stiffness.gradient(x)) - isotropic * x).cwiseAbs().maxCoeff(),
            1e-11 * size);
}

TEST(AnisotropicStiffness, IsTheProductOfGradientsOnTets) {
  const Mesh mesh = jittered_box();
  expect_gradients_product(mesh.V, mesh.T);
}

TEST(AnisotropicStiffness, IsTheProductOfGradientsOnTriangles) {
  const Mesh mesh = sheet();
  expect_gradients_product(mesh.V, mesh.F);
}

TEST(AnisotropicStiffness, PlanarFramesAreTheCoordinates) {
  Mesh mesh = sheet();
  mesh.V.col(2).setConstant(0.5);
  const AnisotropicStiffness K(mesh.V, mesh.F);
  for (Eigen::Index e = 0; e < K.elements(); ++e) {
    EXPECT_LT((K.frame(e) - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  }
}

TEST(AnisotropicStiffness, LeavesDegenerateElementsOut) {
  Mesh mesh = jittered_box();
  Tetrahedra more(mesh.T.rows() + 2, 4);
  more << mesh.T, mesh.T.row(0), mesh.T.row(1);
  more(mesh.T.rows(), 3) = more(mesh.T.rows(), 0);  // repeats a corner
  const Eigen::Index extra = mesh.V.rows();
  mesh.V.conservativeResize(extra + 1, 3);
  mesh.V.row(extra) = mesh.V.row(more(mesh.T.rows() + 1, 0));  // no volume
  more.row(mesh.T.rows() + 1) << more(1, 0), extra, more(1, 1), more(1, 2);
  const AnisotropicStiffness with(mesh.V, more), without(mesh.V, mesh.T);
  EXPECT_EQ(with.isotropic().nonZeros(), without.isotropic().nonZeros());
  EXPECT_EQ((with.isotropic() - without.isotropic()).norm(), 0.0);
  EXPECT_EQ(with.volumes()[mesh.T.rows()], 0);
  const RowMatrix X = random_matrix(mesh.V.rows(), 4, 1);
  Eigen::MatrixXd D;
  with.derivative(X, X, D);
  EXPECT_EQ(D.bottomRows(2).cwiseAbs().maxCoeff(), 0.0);
  more(0, 0) = -1;
  EXPECT_THROW(AnisotropicStiffness(mesh.V, more), InputError);
}

TEST(AnisotropicStiffness, IsTheSameAtAnyThreadCount) {
  const Mesh mesh = skinfield_test::box_tets(14, 14, 14, 0.1);
  const Eigen::MatrixXd A = random_tensors(mesh.T.rows(), 3);
  const RowMatrix X = random_matrix(mesh.V.rows(), 5, 2), Y = random_matrix(mesh.V.rows(), 5, 3);
  std::array<SparseRows, 2> K;
  std::array<Eigen::MatrixXd, 2> D;
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    const auto t = static_cast<std::size_t>(threads) - 1;
    const AnisotropicStiffness stiffness(mesh.V, mesh.T);
    K[t] = stiffness.isotropic();
    stiffness.assemble(A, K[t]);
    stiffness.derivative(X, Y, D[t]);
  }
  EXPECT_TRUE(K[0].coeffs().matrix() == K[1].coeffs().matrix());
  EXPECT_TRUE(D[0] == D[1]);
}

}  // namespace
}  // namespace skinfield
