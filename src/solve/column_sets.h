// Sets of columns, one for every row: where an iterate is non-zero, where it is stored.
#pragma once

#include "skinfield/base/types.h"
#include "skinfield/solve/active_rows.h"

#include <cstdint>
#include <vector>

namespace skinfield {

class ColumnSets {
 public:
  ColumnSets() = default;
  ColumnSets(Eigen::Index rows, int columns);
  /// Where W is not zero.
  explicit ColumnSets(const RowMatrix& W);

  void add(Eigen::Index row, int column) { word(row, column) |= bit(column); }
  bool has(Eigen::Index row, int column) const {
    return (bits_[at(row, column)] & bit(column)) != 0;
  }
  void join(const ColumnSets& other);
  void meet(const ColumnSets& other);
  bool contains(const ColumnSets& other) const;
  /// Every row's set joined with those of its neighbours in the graph of Q.
  ColumnSets grown(const SparseRows& Q, int rings = 1) const;
  ActiveRows list() const;

 private:
  static std::uint64_t bit(int column) { return std::uint64_t{1} << (column % 64); }
  std::size_t at(Eigen::Index row, int column) const {
    return static_cast<std::size_t>(row) * words_ + static_cast<std::size_t>(column / 64);
  }
  std::uint64_t& word(Eigen::Index row, int column) { return bits_[at(row, column)]; }

  Eigen::Index rows_ = 0;
  int columns_ = 0;
  std::size_t words_ = 0;  ///< a row
  std::vector<std::uint64_t> bits_;
};

/// For every entry of `now` its number in `before`, -1 where it has none.
std::vector<std::int64_t> old_entries(const ActiveRows& before, const ActiveRows& now);

}  // namespace skinfield
