#include "solve/constrained_inverse.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <vector>

namespace skinfield {
namespace {

constexpr double kRegulariser = 1e-9;
constexpr int kRefinements = 3;
constexpr std::size_t kColumnsPerTask = 4;

double median_of_diagonal(const SparseRows& Q) {
  Vector d = Q.diagonal();
  if (d.size() == 0) return 1;
  const auto middle = d.begin() + d.size() / 2;
  std::nth_element(d.begin(), middle, d.end());
  return *middle > 0 ? *middle : 1.0;
}

}  // namespace

/// [Q + e, C'; C, -e] is quasidefinite: it has a factor L D L' in any order (Vanderbei 1995), and
/// constraints that repeat each other do no harm.
struct ConstrainedInverse::Indefinite {
  using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>;

  Indefinite(const SparseRows& Q, const SparseRows& constraints)
      : n(Q.rows()), C(constraints), scale(median_of_diagonal(Q)) {
    std::vector<Eigen::Triplet<double, std::int32_t>> entries;
    entries.reserve(static_cast<std::size_t>(Q.nonZeros() + 2 * C.nonZeros()));
    for (Eigen::Index i = 0; i < n; ++i) {
      for (SparseRows::InnerIterator it(Q, i); it; ++it) {
        entries.emplace_back(it.row(), it.col(), it.value() / scale);
      }
    }
    for (Eigen::Index k = 0; k < C.rows(); ++k) {
      for (SparseRows::InnerIterator it(C, k); it; ++it) {
        const auto row = static_cast<std::int32_t>(n + k);
        entries.emplace_back(row, it.col(), it.value());
        entries.emplace_back(it.col(), row, it.value());
      }
    }
    A.resize(n + C.rows(), n + C.rows());
    A.setFromTriplets(entries.begin(), entries.end());
    Columns shift(A.rows(), A.cols());
    shift.setIdentity();
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      shift.coeffRef(i, i) = i < n ? kRegulariser : -kRegulariser;
    }
    factor.compute(A + shift);
    if (factor.info() != Eigen::Success || !factor.vectorD().allFinite()) {
      throw SolveError("the constrained system cannot be factored", "constrained energy",
                       "check the energy and the constraints for infinite values");
    }
  }

  /// Columns of a right-hand side of the system in which Q is divided by `scale`.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const {
    Eigen::MatrixXd x = factor.solve(b);
    for (int step = 0; step < kRefinements; ++step) x += factor.solve(b - A * x);
    return x;
  }

  Eigen::Index n;
  SparseRows C;
  double scale;
  Columns A;
  Eigen::SimplicialLDLT<Columns, Eigen::Lower, Eigen::AMDOrdering<std::int32_t>> factor;
};

ConstrainedInverse::ConstrainedInverse(const SparseRows& Q, const SparseRows& C) {
  if (C.rows() > 0) {
    indefinite_ = std::make_unique<Indefinite>(Q, C);
    return;
  }
  cholesky_.analyse(Q);
  cholesky_.factor(Q);
}

ConstrainedInverse::~ConstrainedInverse() = default;

void ConstrainedInverse::apply(RowMatrix& U) const {
  RowMatrix D;
  apply(U, D);
}

void ConstrainedInverse::apply(RowMatrix& U, RowMatrix& D) const {
  if (!indefinite_) return cholesky_.solve(U);
  const Eigen::Index n = indefinite_->n, k = indefinite_->C.rows();
  if (D.size() == 0) D = RowMatrix::Zero(k, U.cols());
  parallel_blocks(static_cast<std::size_t>(U.cols()), kColumnsPerTask,
                  [&](std::size_t begin, std::size_t end) {
                    const auto at = static_cast<Eigen::Index>(begin);
                    const auto count = static_cast<Eigen::Index>(end - begin);
                    Eigen::MatrixXd b(n + k, count);
                    b.topRows(n) = U.middleCols(at, count) / indefinite_->scale;
                    b.bottomRows(k) = D.middleCols(at, count);
                    const Eigen::MatrixXd x = indefinite_->solve(b);
                    U.middleCols(at, count) = x.topRows(n);
                    D.middleCols(at, count) = x.bottomRows(k) * indefinite_->scale;
                  });
}

}  // namespace skinfield
