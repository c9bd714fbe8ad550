// Skinning weights: sparse rows over vertices, one column a handle or joint.
#pragma once

#include "skinfield/base/types.h"

#include <string>
#include <vector>

namespace skinfield {

struct SkinWeights {
  SparseRows W;                    ///< (n,m), entries >= 0, rows sum to 1
  std::vector<std::string> names;  ///< (m) column names, or empty

  Eigen::Index vertices() const { return W.rows(); }
  Eigen::Index columns() const { return W.cols(); }
};

}  // namespace skinfield
