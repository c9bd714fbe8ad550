// A hash grid over fixed points for radius queries (appendix A of the geometric-fields paper).
#pragma once

#include "skinfield/base/types.h"

#include <cstdint>
#include <vector>

namespace skinfield {

/// The order of the points along a Morton curve through cells of side `side`, ties by index.
std::vector<int> morton_order(const Points& X, double side);

class PointHash {
 public:
  /// @param side of the cells, > 0: the radius that is asked for most.
  PointHash(const Points& X, double side);
  /// Indices of the points nearer to x than `radius`, cell by cell (points in Morton order come
  /// almost ascending), with their squared distances.
  void find(const Vec3& x, double radius, std::vector<std::int32_t>& index,
            std::vector<float>& distance2) const;

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t begin = -1, end = -1;  // in order_; begin -1: free
  };
  static std::uint64_t key(int i, int j, int k);
  const Slot* slot(std::uint64_t key) const;

  double side_;
  std::vector<Slot> table_;
  std::vector<std::int32_t> order_;
  std::vector<double> x_, y_, z_;  // in order_
};

}  // namespace skinfield
