// A hash grid of spheres of different sizes, for dart throwing.
#pragma once

#include "skinfield/base/types.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace skinfield {

/// A hash grid of spheres, one level a power of two of the radius. The size field changes slowly,
/// so that only neighbouring levels can conflict.
class DiskGrid {
 public:
  DiskGrid(double smallest, std::size_t expected)
      : smallest_(smallest), table_(std::bit_ceil(8 * expected + 64), Slot{0, -1}) {}

  bool conflicts(const Vec3& x, double radius, double handle_factor) const {
    const int own = level(radius);
    for (int l : {own, own - 1, own + 1}) {
      if (l < 0) continue;
      const double side = std::ldexp(smallest_, l + 1);
      const double search = 0.5 * (radius + side);  // side: the largest radius of the level
      int low[3], high[3];
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = static_cast<int>(std::floor((x[axis] - search) / side));
        high[axis] = static_cast<int>(std::floor((x[axis] + search) / side));
      }
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i)
            for (int d = table_[slot(key(l, i, j, k))].head; d >= 0;
                 d = disks_[static_cast<std::size_t>(d)].next) {
              const Disk& other = disks_[static_cast<std::size_t>(d)];
              const double apart =
                  0.5 * (radius + other.radius) * (other.handle ? handle_factor : 1);
              if ((other.x - x).squaredNorm() < apart * apart) return true;
            }
    }
    return false;
  }

  void add(const Vec3& x, double radius, bool handle) {
    if (4 * disks_.size() > table_.size()) grow();
    const int l = level(radius);
    const double side = std::ldexp(smallest_, l + 1);
    int c[3];
    for (int axis = 0; axis < 3; ++axis) c[axis] = static_cast<int>(std::floor(x[axis] / side));
    Slot& cell = table_[slot(key(l, c[0], c[1], c[2]))];
    cell.key = key(l, c[0], c[1], c[2]);
    disks_.push_back({x, radius, handle, cell.head});
    cell.head = static_cast<int>(disks_.size()) - 1;
  }

 private:
  struct Disk {
    Vec3 x;
    double radius;
    bool handle;
    int next;  // in the same cell
  };
  struct Slot {
    std::uint64_t key;
    int head;  // -1: free
  };
  int level(double radius) const {
    return std::max(0, static_cast<int>(std::floor(std::log2(radius / smallest_ + 1e-9))));
  }
  static std::uint64_t key(int l, int i, int j, int k) {
    const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 17)) & 0x3ffff; };
    return (static_cast<std::uint64_t>(l) << 54) | (part(i) << 36) | (part(j) << 18) | part(k);
  }
  /// The key's slot, or the free one where it would go (linear probing).
  std::size_t slot(std::uint64_t key) const {
    std::uint64_t h = key * 0x9E3779B97F4A7C15ull;
    h ^= h >> 32;
    const std::size_t mask = table_.size() - 1;
    std::size_t s = static_cast<std::size_t>(h) & mask;
    while (table_[s].head >= 0 && table_[s].key != key) s = (s + 1) & mask;
    return s;
  }
  void grow() {
    std::vector<Slot> old = std::move(table_);
    table_.assign(2 * old.size(), Slot{0, -1});
    for (const Slot& s : old)
      if (s.head >= 0) table_[slot(s.key)] = s;
  }
  double smallest_;
  std::vector<Slot> table_;
  std::vector<Disk> disks_;
};

}  // namespace skinfield
