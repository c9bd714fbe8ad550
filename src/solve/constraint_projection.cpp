#include "solve/constraint_projection.h"

namespace skinfield {
namespace {

constexpr int kRounds = 200;
constexpr double kEnough = 1e-10;  // in weight units
constexpr double kRegulariser = 1e-12;

}  // namespace

ConstraintProjection::ConstraintProjection(const FreeRows& free, const FreeConstraints& constraints)
    : free_(free), constraints_(constraints) {
  if (constraints_.C.rows() == 0) return;
  Eigen::SparseMatrix<double> gram = constraints_.C * SparseRows(constraints_.C.transpose());
  // Rows that repeat each other would make it singular.
  const double shift = kRegulariser * (gram.diagonal().maxCoeff() + 1);
  for (Eigen::Index i = 0; i < gram.rows(); ++i) gram.coeffRef(i, i) += shift;
  gram_.compute(gram);
}

double ConstraintProjection::residual(const RowMatrix& W) const {
  if (constraints_.C.rows() == 0) return 0;
  return (constraints_.C * W - constraints_.D).cwiseAbs().maxCoeff();
}

void ConstraintProjection::project(RowMatrix& W) const {
  RowMatrix Z;
  if (constraints_.C.rows() == 0) {
    free_.project(W, Z);
    W.swap(Z);
    return;
  }
  RowMatrix correction = RowMatrix::Zero(W.rows(), W.cols());
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::MatrixXd excess = constraints_.C * W - constraints_.D;
    const Eigen::MatrixXd step = gram_.solve(excess);
    W -= constraints_.C.transpose() * step;
    W += correction;
    free_.project(W, Z);
    correction = W - Z;
    W.swap(Z);
    if (residual(W) <= kEnough) return;
  }
}

}  // namespace skinfield
