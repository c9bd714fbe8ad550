// Nodes with prescribed weights, collected by position.
#pragma once

#include "domain/point_sampling.h"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace skinfield {

/// Distinct positions and what is prescribed there. Positions within 1e-6 of the box diagonal are
/// the same (design.md 4).
class FixedNodeList {
 public:
  /// A handle's point; where it stands already, the handles share it. Handles come before paint.
  void add(const Vec3& x, int handle) {
    Entry* known = find(x);
    if (!known)
      insert({x, {handle}, {}});
    else if (known->handles.back() != handle)
      known->handles.push_back(handle);
  }
  /// Paint wins over handles.
  void paint(const Vec3& x, const Vector& weights) {
    if (Entry* known = find(x))
      known->painted = weights;
    else
      insert({x, {}, weights});
  }

  FixedNodes nodes(Eigen::Index columns) const {
    FixedNodes result;
    const auto n = static_cast<Eigen::Index>(entries_.size());
    result.X.resize(n, 3);
    result.weights = RowMatrix::Zero(n, columns);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Entry& e = entries_[static_cast<std::size_t>(i)];
      result.X.row(i) = e.x.transpose();
      if (e.painted.size() > 0)
        result.weights.row(i) = e.painted.transpose();
      else
        for (int h : e.handles) result.weights(i, h) = 1.0 / static_cast<double>(e.handles.size());
    }
    return result;
  }

 private:
  struct Entry {
    Vec3 x;
    std::vector<int> handles;
    Vector painted;
  };
  static constexpr double tolerance = 1e-6 * 1.7320508;
  static std::uint64_t key(const Vec3& x, int neighbour) {
    const int d[3] = {neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1};
    std::uint64_t k = 0;
    for (int axis = 0; axis < 3; ++axis)
      k = k << 21 | (static_cast<std::uint64_t>(
                         static_cast<std::int64_t>(std::floor(x[axis] / (4 * tolerance))) +
                         d[axis] + (1 << 20)) &
                     0x1fffff);
    return k;
  }
  Entry* find(const Vec3& x) {
    for (int d = 0; d < 27; ++d) {
      const auto cell = cells_.find(key(x, d));
      if (cell == cells_.end()) continue;
      for (std::size_t i : cell->second)
        if ((entries_[i].x - x).norm() <= tolerance) return &entries_[i];
    }
    return nullptr;
  }
  void insert(Entry entry) {
    cells_[key(entry.x, 13)].push_back(entries_.size());
    entries_.push_back(std::move(entry));
  }
  std::vector<Entry> entries_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

}  // namespace skinfield
