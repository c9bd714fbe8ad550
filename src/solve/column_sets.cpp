#include "solve/column_sets.h"

#include "skinfield/base/parallel.h"

namespace skinfield {
namespace {
constexpr std::size_t kRowsPerBlock = 256;
}  // namespace

ColumnSets::ColumnSets(Eigen::Index rows, int columns)
    : rows_(rows),
      columns_(columns),
      words_(static_cast<std::size_t>(columns + 63) / 64),
      bits_(static_cast<std::size_t>(rows) * words_, 0) {}

ColumnSets::ColumnSets(const RowMatrix& W) : ColumnSets(W.rows(), static_cast<int>(W.cols())) {
  for (Eigen::Index i = 0; i < rows_; ++i) {
    for (int j = 0; j < columns_; ++j) {
      if (W(i, j) != 0) add(i, j);
    }
  }
}

void ColumnSets::join(const ColumnSets& other) {
  for (std::size_t k = 0; k < bits_.size(); ++k) bits_[k] |= other.bits_[k];
}

void ColumnSets::meet(const ColumnSets& other) {
  for (std::size_t k = 0; k < bits_.size(); ++k) bits_[k] &= other.bits_[k];
}

bool ColumnSets::contains(const ColumnSets& other) const {
  for (std::size_t k = 0; k < bits_.size(); ++k) {
    if (other.bits_[k] & ~bits_[k]) return false;
  }
  return true;
}

ColumnSets ColumnSets::grown(const SparseRows& Q, int rings) const {
  ColumnSets result = *this;
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<std::uint64_t> old = result.bits_;
    parallel_for(static_cast<std::size_t>(rows_), kRowsPerBlock, [&](std::size_t i) {
      std::uint64_t* own = result.bits_.data() + i * words_;
      for (auto p = Q.outerIndexPtr()[i]; p < Q.outerIndexPtr()[i + 1]; ++p) {
        const auto other = static_cast<std::size_t>(Q.innerIndexPtr()[p]) * words_;
        for (std::size_t k = 0; k < words_; ++k) own[k] |= old[other + k];
      }
    });
  }
  return result;
}

ActiveRows ColumnSets::list() const {
  ActiveRows active;
  active.columns = columns_;
  active.start.reserve(static_cast<std::size_t>(rows_) + 1);
  active.start.push_back(0);
  for (Eigen::Index i = 0; i < rows_; ++i) {
    for (int j = 0; j < columns_; ++j) {
      if (has(i, j)) active.column.push_back(j);
    }
    active.start.push_back(static_cast<std::int64_t>(active.column.size()));
  }
  return active;
}

std::vector<std::int64_t> old_entries(const ActiveRows& before, const ActiveRows& now) {
  std::vector<std::int64_t> old(now.column.size(), -1);
  for (std::size_t i = 0; i + 1 < now.start.size(); ++i) {
    auto b = before.start[i];
    for (auto e = now.start[i]; e < now.start[i + 1]; ++e) {
      const int j = now.column[static_cast<std::size_t>(e)];
      while (b < before.start[i + 1] && before.column[static_cast<std::size_t>(b)] < j) ++b;
      if (b < before.start[i + 1] && before.column[static_cast<std::size_t>(b)] == j) {
        old[static_cast<std::size_t>(e)] = b;
      }
    }
  }
  return old;
}

}  // namespace skinfield
