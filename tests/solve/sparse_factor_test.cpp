#include "skinfield/solve/sparse_factor.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "support/grid.h"

#include <gtest/gtest.h>

#include <limits>

namespace skinfield {
namespace {

using skinfield_test::grid_laplacian;

RowMatrix random_matrix(Eigen::Index rows, Eigen::Index columns) {
  Random random(7);
  RowMatrix B(rows, columns);
  for (Eigen::Index i = 0; i < B.size(); ++i) B.data()[i] = random.normal();
  return B;
}

class EveryBackend : public ::testing::TestWithParam<FactorBackend> {
 protected:
  void SetUp() override {
    if (GetParam() == FactorBackend::cholmod && !has_cholmod()) {
      GTEST_SKIP() << "this build has no CHOLMOD";
    }
  }
};

TEST_P(EveryBackend, SolvesAndRefactorsOnOneAnalysis) {
  const SparseRows K = grid_laplacian(9);
  SparseFactor factor(GetParam());
  factor.analyse(K);
  for (const double scale : {0.01, 3.0}) {
    Vector shift = Vector::Constant(K.rows(), scale);
    shift[5] *= 100;
    factor.factor(K, shift);
    const RowMatrix B = random_matrix(K.rows(), 23);
    RowMatrix X = B;
    factor.solve(X);
    const RowMatrix R = K * X + shift.asDiagonal() * X - B;
    EXPECT_LT(R.cwiseAbs().maxCoeff(), 1e-10 * X.cwiseAbs().maxCoeff() * 10);
  }
  EXPECT_GE(factor.nonzeros(), K.rows());
}

TEST_P(EveryBackend, RefusesSingularAndIndefinite) {
  const SparseRows K = grid_laplacian(5);
  SparseFactor factor(GetParam());
  factor.analyse(K);
  SparseRows singular = K;
  for (SparseRows::InnerIterator it(singular, 0); it; ++it) {
    it.valueRef() = 0;
    singular.coeffRef(it.col(), 0) = 0;
  }
  EXPECT_THROW(factor.factor(singular, Vector::Unit(K.rows(), 5)), SolveError);
  EXPECT_THROW(factor.factor(K, Vector::Constant(K.rows(), -0.5)), SolveError);
  Vector broken = Vector::Constant(K.rows(), 1.0);
  broken[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(factor.factor(K, broken), SolveError);
  factor.factor(K, Vector::Constant(K.rows(), 1.0));  // usable after a refusal
  RowMatrix X = RowMatrix::Ones(K.rows(), 1);
  factor.solve(X);
  EXPECT_LT((X.array() - 1).abs().maxCoeff(), 1e-12);
}

TEST_P(EveryBackend, RaggedRightHandSidesAgreeWithFullOnes) {
  const SparseRows K = grid_laplacian(12);
  SparseFactor factor(GetParam());
  factor.analyse(K);
  factor.factor(K, Vector::Constant(K.rows(), 0.1));
  // Column j lives on its own stretch of rows; column 5 nowhere.
  ActiveRows active;
  active.columns = 19;
  active.start.push_back(0);
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    for (int j = 0; j < active.columns; ++j) {
      if (j != 5 && i > 80 * j && i < 80 * j + 300) active.column.push_back(j);
    }
    active.start.push_back(static_cast<std::int64_t>(active.column.size()));
  }
  Vector values = random_matrix(active.size(), 1);
  RowMatrix X = RowMatrix::Zero(K.rows(), active.columns);
  const auto at = [&](std::int64_t e, Eigen::Index i) -> double& {
    return X(i, active.column[static_cast<std::size_t>(e)]);
  };
  for (std::size_t i = 0; i + 1 < active.start.size(); ++i) {
    for (auto e = active.start[i]; e < active.start[i + 1]; ++e) {
      at(e, static_cast<Eigen::Index>(i)) = values[e];
    }
  }
  factor.solve(X);
  factor.solve(active, values);
  for (std::size_t i = 0; i + 1 < active.start.size(); ++i) {
    for (auto e = active.start[i]; e < active.start[i + 1]; ++e) {
      EXPECT_NEAR(values[e], at(e, static_cast<Eigen::Index>(i)), 1e-12);
    }
  }
}

TEST_P(EveryBackend, SameBytesAtAnyThreadCount) {
  const SparseRows K = grid_laplacian(8);
  RowMatrix result[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    SparseFactor factor(GetParam());
    factor.analyse(K);
    factor.factor(K, Vector::Constant(K.rows(), 0.1));
    result[threads - 1] = random_matrix(K.rows(), 33);
    factor.solve(result[threads - 1]);
  }
  EXPECT_TRUE((result[0].array() == result[1].array()).all());
}

INSTANTIATE_TEST_SUITE_P(Backends, EveryBackend,
                         ::testing::Values(FactorBackend::supernodal, FactorBackend::cholmod,
                                           FactorBackend::eigen));

TEST(SparseFactor, OneFactorServesManySolvesAtOnce) {
  const SparseRows A = skinfield_test::grid_laplacian(7);
  SparseFactor factor;
  factor.analyse(A);
  factor.factor(A, Vector::Constant(A.rows(), 0.1));
  std::vector<RowMatrix> sides, expected;
  Random random(3);
  for (int k = 0; k < 8; ++k) {
    sides.emplace_back(
        RowMatrix::NullaryExpr(A.rows(), 1 + 5 * k, [&] { return random.uniform(); }));
    expected.push_back(sides.back());
    factor.solve(expected.back());
  }
  parallel_for(sides.size(), 1, [&](std::size_t k) { factor.solve(sides[k]); });
  for (std::size_t k = 0; k < sides.size(); ++k) EXPECT_TRUE(sides[k] == expected[k]) << k;
}

TEST(SparseFactor, SinglePanelsAreRefusedWhereFloatsEnd) {
  for (const double scale : {1e-60, 1e80}) {
    const SparseRows K = grid_laplacian(5) * scale;
    const Vector shift = Vector::Constant(K.rows(), 0.1 * scale);
    const RowMatrix B = random_matrix(K.rows(), 3);
    RowMatrix X = B;
    SparseFactor factor(FactorBackend::supernodal);
    factor.analyse(K);
    factor.factor(K, shift, PanelStorage::single);
    factor.solve(X);
    const RowMatrix R = K * X + shift.asDiagonal() * X - B;
    EXPECT_LT(R.cwiseAbs().maxCoeff(), 1e-12) << scale;
  }
}

TEST(SparseFactor, SinglePanelsCostDigitsOfTheSolutionOnly) {
  const SparseRows K = grid_laplacian(9);
  const Vector shift = Vector::Constant(K.rows(), 0.1);
  const RowMatrix B = random_matrix(K.rows(), 50);
  RowMatrix X[2] = {B, B};
  for (const auto storage : {PanelStorage::full, PanelStorage::single}) {
    SparseFactor factor(FactorBackend::supernodal);
    factor.analyse(K);
    factor.factor(K, shift, storage);
    RowMatrix& Y = X[storage == PanelStorage::single];
    factor.solve(Y);
    const RowMatrix R = K * Y + shift.asDiagonal() * Y - B;
    const double residual = R.cwiseAbs().maxCoeff() / Y.cwiseAbs().maxCoeff();
    if (storage == PanelStorage::full) {
      EXPECT_LT(residual, 1e-13);
    } else {
      EXPECT_LT(residual, 1e-5);
      EXPECT_GT(residual, 1e-10) << "not stored in single precision";
      // One step of refinement, which iterations do anyway, brings the digits back.
      RowMatrix correction = -R;
      factor.solve(correction);
      Y += correction;
    }
  }
  EXPECT_LT((X[0] - X[1]).cwiseAbs().maxCoeff(), 1e-10 * X[0].cwiseAbs().maxCoeff());
}

TEST(SparseFactor, TinyAndEmpty) {
  SparseFactor factor;
  SparseRows A(1, 1);
  A.insert(0, 0) = 4;
  A.makeCompressed();
  factor.analyse(A);
  factor.factor(A);
  RowMatrix X = RowMatrix::Constant(1, 3, 8.0);
  factor.solve(X);
  EXPECT_DOUBLE_EQ(X(0, 2), 2.0);
  SparseRows none(0, 0);
  factor.analyse(none);
  factor.factor(none);
  RowMatrix nothing(0, 3);
  factor.solve(nothing);
  EXPECT_EQ(factor.nonzeros(), 0);
}

TEST(SparseFactor, NeedsTheDiagonal) {
  SparseRows A(2, 2);
  A.insert(0, 0) = 1;
  A.insert(0, 1) = 0.5;
  A.insert(1, 0) = 0.5;
  A.makeCompressed();
  EXPECT_THROW(SparseFactor().analyse(A), SolveError);
}

}  // namespace
}  // namespace skinfield
