#include "skinfield/operators/biharmonic.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace skinfield {
namespace {

/// Every block clears arrays of n entries: many rows a block keep that cheap.
std::size_t rows_per_block(std::size_t n) { return std::max<std::size_t>(256, n / 64); }

/// Calls visit(columns) with the sorted column pattern of K K's rows begin..end.
template <class Visit>
void for_row_patterns(const SparseRows& K, std::size_t begin, std::size_t end, const Visit& visit) {
  const std::int32_t* outer = K.outerIndexPtr();
  const std::int32_t* inner = K.innerIndexPtr();
  std::vector<std::int32_t> mark(static_cast<std::size_t>(K.rows()), -1);
  std::vector<std::int32_t> columns;
  for (std::size_t row = begin; row < end; ++row) {
    const auto i = static_cast<std::int32_t>(row);
    columns.assign(1, i);
    mark[row] = i;
    for (std::int32_t p = outer[i]; p < outer[i + 1]; ++p) {
      const std::int32_t k = inner[p];
      for (std::int32_t q = outer[k]; q < outer[k + 1]; ++q) {
        const std::int32_t j = inner[q];
        if (mark[static_cast<std::size_t>(j)] == i) continue;
        mark[static_cast<std::size_t>(j)] = i;
        columns.push_back(j);
      }
    }
    std::sort(columns.begin(), columns.end());
    visit(i, columns);
  }
}

}  // namespace

SparseRows biharmonic(const SparseRows& K, const Vector& M) {
  const auto n = static_cast<std::size_t>(K.rows());
  SparseRows Q(K.rows(), K.rows());
  std::vector<std::int32_t> counts(n, 0);
  // Patterns are found twice: cheaper than keeping them all.
  parallel_blocks(n, rows_per_block(n), [&](std::size_t begin, std::size_t end) {
    for_row_patterns(K, begin, end, [&](std::int32_t i, const std::vector<std::int32_t>& columns) {
      counts[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(columns.size());
    });
  });
  std::int32_t* start = Q.outerIndexPtr();
  start[0] = 0;
  for (std::size_t i = 0; i < n; ++i) start[i + 1] = start[i] + counts[i];
  Q.resizeNonZeros(start[n]);

  const std::int32_t* outer = K.outerIndexPtr();
  const std::int32_t* inner = K.innerIndexPtr();
  const double* value = K.valuePtr();
  const Vector inverse = M.cwiseInverse();
  parallel_blocks(n, rows_per_block(n), [&](std::size_t begin, std::size_t end) {
    std::vector<double> sum(n, 0.0);
    for_row_patterns(K, begin, end, [&](std::int32_t i, const std::vector<std::int32_t>& columns) {
      // Q_ij = sum over k ascending of (K_ik K_kj) / M_k: the order and the rounding of each
      // term are the same for Q_ji, which makes Q symmetric to the last bit.
      for (std::int32_t p = outer[i]; p < outer[i + 1]; ++p) {
        const std::int32_t k = inner[p];
        for (std::int32_t q = outer[k]; q < outer[k + 1]; ++q) {
          sum[static_cast<std::size_t>(inner[q])] += (value[p] * value[q]) * inverse[k];
        }
      }
      std::int32_t at = start[i];
      for (const std::int32_t j : columns) {
        Q.innerIndexPtr()[at] = j;
        Q.valuePtr()[at++] = sum[static_cast<std::size_t>(j)];
        sum[static_cast<std::size_t>(j)] = 0;
      }
    });
  });
  return Q;
}

SparseRows natural_biharmonic(const SparseRows& K, const Vector& M,
                              const std::vector<int>& boundary) {
  Vector interior = M;
  for (const int i : boundary) interior[i] = std::numeric_limits<double>::infinity();
  return biharmonic(K, interior);
}

}  // namespace skinfield
