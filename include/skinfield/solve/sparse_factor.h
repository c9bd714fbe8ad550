// The seam to sparse Cholesky: symmetric positive definite systems with many right-hand sides.
#pragma once

#include "skinfield/base/types.h"
#include "skinfield/solve/active_rows.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace skinfield {

enum class FactorBackend {
  automatic,   ///< the fastest that this build has
  supernodal,  ///< our own multifrontal factorisation
  cholmod,     ///< SuiteSparse, profile full only
  eigen,       ///< Eigen's SimplicialLDLT
};

/// How our own backend keeps the factor, which is always computed in double precision. The others
/// know only doubles.
enum class PanelStorage {
  full,    ///< residuals of solves near 1e-15 of |A| |X|
  single,  ///< half the memory and traffic; residuals near 1e-7: for iterations that correct them.
           ///< Full all the same where diagonal entries leave 1e-50 .. 1e70.
};

bool has_cholmod();

/// A = P' L L' P. One symbolic analysis serves every matrix with the same pattern. Solves give
/// the same bytes at any thread count: right-hand sides are split into blocks of fixed size.
class SparseFactor {
 public:
  /// @throws SolveError if this build lacks the backend.
  explicit SparseFactor(FactorBackend backend = FactorBackend::automatic);
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  /// Fill-reducing ordering and symbolic factorisation. A is (n,n), compressed, both triangles
  /// stored, every diagonal entry stored; its values are not used.
  /// @throws SolveError if A is not square or lacks a diagonal entry.
  void analyse(const SparseRows& A);
  /// Factors A + diag(shift); A has the pattern that was analysed. An empty shift adds nothing.
  /// @throws SolveError if the matrix is not positive definite or not finite. (Rounding can hide
  /// that a matrix is singular.)
  void factor(const SparseRows& A, const Vector& shift = {},
              PanelStorage storage = PanelStorage::full);
  /// Replaces B (n,m) by A^-1 B. Precondition: factor() succeeded.
  void solve(RowMatrix& B) const;
  /// The same for right-hand sides that are zero outside `active`, of whose solutions only the
  /// active entries are asked for. values: (active.size()).
  void solve(const ActiveRows& active, Vector& values) const;
  /// Entries of L.
  std::int64_t nonzeros() const;

  struct Backend;

 private:
  std::unique_ptr<Backend> backend_;
  std::vector<std::int32_t> diagonal_;  ///< where A's value array holds the diagonal
  Eigen::Index n_ = 0;
};

}  // namespace skinfield
