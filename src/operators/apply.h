// Sparse times dense, by rows.
#pragma once

#include "operators/element_kernels.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/types.h"

namespace skinfield {

/// Rows [begin, end) of Y = A X. Y has its size already.
inline void multiply(const SparseRows& A, const RowMatrix& X, RowMatrix& Y, std::size_t begin,
                     std::size_t end) {
  multiply_rows(A.outerIndexPtr(), A.innerIndexPtr(), A.valuePtr(), X.data(), X.cols(), Y.data(),
                static_cast<std::ptrdiff_t>(begin), static_cast<std::ptrdiff_t>(end));
}

/// Y = A X, the rows in parallel; Y keeps its memory. A is compressed; X is not Y.
inline void apply(const SparseRows& A, const RowMatrix& X, RowMatrix& Y) {
  Y.resize(A.rows(), X.cols());
  parallel_blocks(static_cast<std::size_t>(A.rows()), 512,
                  [&](std::size_t begin, std::size_t end) { multiply(A, X, Y, begin, end); });
}

}  // namespace skinfield
