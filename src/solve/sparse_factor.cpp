#include "skinfield/solve/sparse_factor.h"

#include "skinfield/base/error.h"
#include "solve/factor_backend.h"

#include <algorithm>
#include <string>

namespace skinfield {
namespace {

std::unique_ptr<SparseFactor::Backend> make(FactorBackend which) {
  switch (which) {
    case FactorBackend::eigen:
      return make_eigen_factor();
    case FactorBackend::cholmod: {
      auto backend = make_cholmod_factor();
      if (!backend) {
        throw SolveError("this build has no CHOLMOD", "sparse factor", "use the profile full");
      }
      return backend;
    }
    case FactorBackend::automatic:
    case FactorBackend::supernodal:
      break;
  }
  return make_supernodal_factor();
}

}  // namespace

void throw_not_positive_definite(Eigen::Index column) {
  throw SolveError("the matrix is not positive definite (pivot " + std::to_string(column) + ")",
                   "sparse factor", "a part without fixed rows, or a degenerate element");
}

bool has_cholmod() { return make_cholmod_factor() != nullptr; }

SparseFactor::SparseFactor(FactorBackend backend) : backend_(make(backend)) {}
SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

void SparseFactor::analyse(const SparseRows& A) {
  if (A.rows() != A.cols() || !A.isCompressed()) {
    throw SolveError("the matrix is not square and compressed", "sparse factor");
  }
  n_ = A.rows();
  diagonal_.resize(static_cast<std::size_t>(n_));
  const std::int32_t* outer = A.outerIndexPtr();
  const std::int32_t* inner = A.innerIndexPtr();
  for (Eigen::Index i = 0; i < n_; ++i) {
    const std::int32_t* end = inner + outer[i + 1];
    const std::int32_t* at = std::lower_bound(inner + outer[i], end, i);
    if (at == end || *at != i) {
      throw SolveError("diagonal entry " + std::to_string(i) + " is not stored", "sparse factor");
    }
    diagonal_[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(at - inner);
  }
  if (n_ > 0) backend_->analyse(A);
}

void SparseFactor::factor(const SparseRows& A, const Vector& shift, PanelStorage storage) {
  if (A.rows() != n_ || (shift.size() != 0 && shift.size() != n_)) {
    throw SolveError("the matrix is not the one analysed", "sparse factor");
  }
  if (n_ == 0) return;
  if (!A.coeffs().allFinite() || !shift.allFinite()) {
    throw SolveError("the matrix holds infinite or undefined values", "sparse factor",
                     "check the mesh for degenerate elements");
  }
  if (shift.size() == 0) return backend_->factor(A, storage);
  SparseRows shifted = A;
  for (Eigen::Index i = 0; i < n_; ++i) {
    shifted.valuePtr()[diagonal_[static_cast<std::size_t>(i)]] += shift[i];
  }
  backend_->factor(shifted, storage);
}

void SparseFactor::solve(RowMatrix& B) const {
  if (B.rows() != n_) throw SolveError("right-hand side of a wrong size", "sparse factor");
  if (B.size() > 0) backend_->solve(B);
}

void SparseFactor::solve(const ActiveRows& active, Vector& values) const {
  if (active.rows() != n_ || values.size() != active.size()) {
    throw SolveError("right-hand side of a wrong size", "sparse factor");
  }
  if (values.size() > 0) backend_->solve(active, values);
}

void SparseFactor::Backend::solve(const ActiveRows& active, Vector& values) const {
  RowMatrix B = RowMatrix::Zero(active.rows(), active.columns);
  const auto each = [&](const auto& visit) {
    for (std::int64_t i = 0; i < active.rows(); ++i) {
      for (auto e = active.start[static_cast<std::size_t>(i)];
           e < active.start[static_cast<std::size_t>(i) + 1]; ++e) {
        visit(B(i, active.column[static_cast<std::size_t>(e)]), values[e]);
      }
    }
  };
  each([](double& b, double v) { b = v; });
  solve(B);
  each([](double b, double& v) { v = b; });
}

std::int64_t SparseFactor::nonzeros() const { return n_ > 0 ? backend_->nonzeros() : 0; }

}  // namespace skinfield
