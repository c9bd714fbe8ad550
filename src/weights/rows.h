// Sparse rows built in parallel: the one loop that all operations on weights share.
#pragma once

#include "skinfield/base/parallel.h"
#include "skinfield/base/types.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace skinfield::rows {

using Entry = std::pair<std::int32_t, double>;
using Row = std::vector<Entry>;  ///< sorted by column

constexpr std::size_t block = 512;

/// The matrix whose row i is what fill(i, row) leaves in `row`. `make()` gives each block its own
/// `fill` (with scratch space of its own).
template <class Make>
SparseRows build(Eigen::Index n, Eigen::Index m, const Make& make) {
  const std::size_t count = static_cast<std::size_t>(n);
  std::vector<Row> entries((count + block - 1) / block);
  SparseRows W(n, m);
  std::vector<std::int32_t> start(count + 1, 0);
  parallel_blocks(count, block, [&](std::size_t begin, std::size_t end) {
    auto fill = make();
    Row row;
    Row& all = entries[begin / block];
    for (std::size_t i = begin; i < end; ++i) {
      row.clear();
      fill(static_cast<Eigen::Index>(i), row);
      start[i + 1] = static_cast<std::int32_t>(row.size());
      all.insert(all.end(), row.begin(), row.end());
    }
  });
  for (std::size_t i = 0; i < count; ++i) start[i + 1] += start[i];
  W.resizeNonZeros(start[count]);
  std::copy(start.begin(), start.end(), W.outerIndexPtr());
  parallel_for(entries.size(), 1, [&](std::size_t b) {
    std::int32_t at = start[b * block];
    for (const auto& [column, value] : entries[b]) {
      W.innerIndexPtr()[at] = column;
      W.valuePtr()[at++] = value;
    }
  });
  return W;
}

inline void read(const SparseRows& W, Eigen::Index i, Row& row) {
  row.clear();
  for (SparseRows::InnerIterator it(W, i); it; ++it) row.emplace_back(it.col(), it.value());
}

/// A dense row that knows where it is not zero.
class Accumulator {
 public:
  explicit Accumulator(Eigen::Index m)
      : value_(static_cast<std::size_t>(m), 0.0), used_(static_cast<std::size_t>(m), 0) {}
  void add(std::int32_t column, double x) {
    const auto j = static_cast<std::size_t>(column);
    if (!used_[j]) {
      used_[j] = 1;
      columns_.push_back(column);
    }
    value_[j] += x;
  }
  void add(const SparseRows& W, Eigen::Index i, double factor) {
    for (SparseRows::InnerIterator it(W, i); it; ++it) {
      add(static_cast<std::int32_t>(it.col()), factor * it.value());
    }
  }
  /// Empties itself into `row`, sorted; zeros left out.
  void take(Row& row) {
    std::sort(columns_.begin(), columns_.end());
    row.clear();
    for (const std::int32_t column : columns_) {
      const auto j = static_cast<std::size_t>(column);
      if (value_[j] != 0) row.emplace_back(column, value_[j]);
      value_[j] = 0;
      used_[j] = 0;
    }
    columns_.clear();
  }

 private:
  std::vector<double> value_;
  std::vector<unsigned char> used_;
  std::vector<std::int32_t> columns_;
};

}  // namespace skinfield::rows
