// Nearest vertex by a uniform grid; ties go to the lower index.
#pragma once

#include "skinfield/base/types.h"

#include <array>
#include <vector>

namespace skinfield {

class PointGrid {
 public:
  /// Precondition: at least one row; all finite. Keeps a reference to V.
  explicit PointGrid(const Points& V);
  int nearest(const Vec3& x) const;

 private:
  std::array<int, 3> cell(const Vec3& x) const;
  std::size_t index(int a, int b, int c) const;

  const Points& V_;
  Vec3 lower_;
  double size_ = 1;
  std::array<int, 3> cells_{1, 1, 1};
  std::vector<int> start_, vertex_;
};

}  // namespace skinfield
