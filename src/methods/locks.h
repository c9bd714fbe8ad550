// Columns that are kept from given weights, while the others share what they leave.
#pragma once

#include "skinfield/base/types.h"

#include <algorithm>
#include <vector>

namespace skinfield {

/// Splits rows into locked columns and the open rest.
class Locks {
 public:
  Locks(const std::vector<int>& locked, Eigen::Index columns)
      : locked_(static_cast<std::size_t>(columns), 0) {
    for (const int j : locked) locked_[static_cast<std::size_t>(j)] = 1;
    for (int j = 0; j < columns; ++j) {
      if (!locked_[static_cast<std::size_t>(j)]) open_.push_back(j);
    }
  }
  bool any() const { return open_.size() < locked_.size(); }
  bool is_locked(int j) const { return locked_[static_cast<std::size_t>(j)] != 0; }
  const std::vector<int>& open() const { return open_; }

  /// The locked part of the start's row, scaled so that it leaves something non-negative.
  Eigen::RowVectorXd part(const RowMatrix& start, Eigen::Index row) const {
    Eigen::RowVectorXd kept = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(locked_.size()));
    for (int j = 0; j < kept.size(); ++j) {
      if (is_locked(j)) kept[j] = std::max(0.0, start(row, j));
    }
    if (kept.sum() > 1) kept /= kept.sum();
    return kept;
  }
  /// The open columns of a row that has no negative entry, scaled to `sum`, which is what the
  /// locked ones leave.
  Eigen::RowVectorXd rest(const Eigen::RowVectorXd& all, const RowMatrix& start, Eigen::Index row,
                          double sum) const {
    Eigen::RowVectorXd w(static_cast<Eigen::Index>(open_.size()));
    for (std::size_t t = 0; t < open_.size(); ++t) w[static_cast<Eigen::Index>(t)] = all[open_[t]];
    if (!(w.sum() > 0)) {
      // The row belongs to locked handles alone: what they leave goes where the start has it.
      for (std::size_t t = 0; t < open_.size(); ++t) {
        w[static_cast<Eigen::Index>(t)] = std::max(0.0, start(row, open_[t]));
      }
    }
    if (!(w.sum() > 0)) w.setOnes();
    return w * (sum / w.sum());
  }

 private:
  std::vector<char> locked_;
  std::vector<int> open_;
};

}  // namespace skinfield
