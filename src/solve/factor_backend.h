// What a Cholesky implementation offers to SparseFactor.
#pragma once

#include "skinfield/solve/sparse_factor.h"

namespace skinfield {

struct SparseFactor::Backend {
  virtual ~Backend() = default;
  virtual void analyse(const SparseRows& A) = 0;
  /// `storage` is for backends that have the choice.
  virtual void factor(const SparseRows& A, PanelStorage storage) = 0;
  virtual void solve(RowMatrix& B) const = 0;
  /// By way of the dense solve, where a backend has nothing better.
  virtual void solve(const ActiveRows& active, Vector& values) const;
  virtual std::int64_t nonzeros() const = 0;
};

std::unique_ptr<SparseFactor::Backend> make_supernodal_factor();
std::unique_ptr<SparseFactor::Backend> make_eigen_factor();
/// Null where the build has no CHOLMOD.
std::unique_ptr<SparseFactor::Backend> make_cholmod_factor();

/// The error every backend throws for a matrix without a Cholesky factor.
[[noreturn]] void throw_not_positive_definite(Eigen::Index column);

}  // namespace skinfield
