// A geometric field as it is saved and taken up again: plain data, positions in the unit box.
#pragma once

#include "skinfield/base/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace skinfield {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct FieldState {
  std::string solver;  ///< convex, adam or adam-pool: what the parameters mean
  std::uint64_t seed = 0;
  std::vector<int> counts;    ///< points of each level, coarse to fine
  int level = 0;              ///< that the points belong to
  std::int64_t step = 0;      ///< steps taken at this level
  std::int64_t steps = 0;     ///< in all
  Points X;                   ///< (N,3) kernel points
  FloatRows F;                ///< (N,m) parameters
  FloatRows first, second;    ///< (N,m) Adam's moments, or empty
  double neumann_radius = 0;  ///< kept from the first level on

  bool empty() const { return X.rows() == 0; }
};

}  // namespace skinfield
