// Eigen's SimplicialLDLT behind the seam: small, always there, the referee of the others.
#include "skinfield/base/parallel.h"
#include "solve/factor_backend.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>

namespace skinfield {
namespace {

constexpr Eigen::Index kColumnsPerBlock = 4;

class EigenFactor : public SparseFactor::Backend {
 public:
  // A is symmetric, so that its rows are its columns.
  using ColumnView = Eigen::Map<const Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>>;

  void analyse(const SparseRows& A) override { ldlt_.analyzePattern(view(A)); }

  void factor(const SparseRows& A, PanelStorage) override {
    ldlt_.factorize(view(A));
    if (ldlt_.info() != Eigen::Success) throw_not_positive_definite(0);
    // LDL' also exists for indefinite matrices; a pivot lost to cancellation is no pivot.
    const Vector& D = ldlt_.vectorD();
    for (Eigen::Index i = 0; i < D.size(); ++i) {
      const Eigen::Index original = ldlt_.permutationPinv().indices()[i];
      const double scale = A.coeff(original, original);
      if (!(D[i] > 1e-15 * scale)) throw_not_positive_definite(original);
    }
  }

  using SparseFactor::Backend::solve;
  void solve(RowMatrix& B) const override {
    const auto columns = static_cast<std::size_t>(B.cols());
    parallel_blocks(columns, kColumnsPerBlock, [&](std::size_t begin, std::size_t end) {
      const auto first = static_cast<Eigen::Index>(begin);
      const auto count = static_cast<Eigen::Index>(end - begin);
      // Row-major blocks let each entry of L serve all columns of the block.
      RowMatrix X = ldlt_.permutationP() * B.middleCols(first, count);
      forward(X);
      X.array().colwise() /= ldlt_.vectorD().array();
      backward(X);
      B.middleCols(first, count) = ldlt_.permutationPinv() * X;
    });
  }

  std::int64_t nonzeros() const override { return ldlt_.matrixL().nestedExpression().nonZeros(); }

 private:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>,
                                       Eigen::Lower, Eigen::AMDOrdering<std::int32_t>>;

  static ColumnView view(const SparseRows& A) {
    return ColumnView(A.rows(), A.cols(), A.nonZeros(), A.outerIndexPtr(), A.innerIndexPtr(),
                      A.valuePtr());
  }

  void forward(RowMatrix& X) const {
    const auto& L = ldlt_.matrixL().nestedExpression();
    for (Eigen::Index j = 0; j < X.rows(); ++j) {
      for (auto p = L.outerIndexPtr()[j]; p < L.outerIndexPtr()[j + 1]; ++p) {
        const Eigen::Index i = L.innerIndexPtr()[p];
        if (i > j) X.row(i).noalias() -= L.valuePtr()[p] * X.row(j);
      }
    }
  }

  void backward(RowMatrix& X) const {
    const auto& L = ldlt_.matrixL().nestedExpression();
    for (Eigen::Index j = X.rows() - 1; j >= 0; --j) {
      for (auto p = L.outerIndexPtr()[j]; p < L.outerIndexPtr()[j + 1]; ++p) {
        const Eigen::Index i = L.innerIndexPtr()[p];
        if (i > j) X.row(j).noalias() -= L.valuePtr()[p] * X.row(i);
      }
    }
  }

  Factor ldlt_;
};

}  // namespace

std::unique_ptr<SparseFactor::Backend> make_eigen_factor() {
  return std::make_unique<EigenFactor>();
}

}  // namespace skinfield
