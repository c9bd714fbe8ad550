// A ragged matrix: every row stores the entries of some columns only. Weights are local, and so
// their solver carries each column where it can matter.
#pragma once

#include <cstdint>
#include <vector>

namespace skinfield {

/// The pattern; values are a flat array beside it, row after row.
struct ActiveRows {
  std::vector<std::int64_t> start;  ///< (n+1) row i holds entries [start[i], start[i+1])
  std::vector<int> column;          ///< of each entry, ascending in a row
  int columns = 0;                  ///< of the full matrix

  std::int64_t rows() const { return static_cast<std::int64_t>(start.size()) - 1; }
  std::int64_t size() const { return start.back(); }
};

}  // namespace skinfield
