// The nearest of many points (nanoflann behind it).
#pragma once

#include "skinfield/base/types.h"

#include <nanoflann.hpp>

#include <algorithm>
#include <vector>

namespace skinfield {

class NearestPoints {
 public:
  /// P must outlive the tree; all finite.
  explicit NearestPoints(const Points& P) : cloud_{P}, tree_(3, cloud_) {}

  /// The k nearest rows to x (fewer if there are not so many), nearest first; ties by number.
  std::vector<std::pair<double, int>> at(const Vec3& x, int k) const {
    const std::size_t count = std::min<std::size_t>(k, cloud_.kdtree_get_point_count());
    std::vector<std::uint32_t> index(count);
    std::vector<double> distance2(count);
    const std::size_t found = tree_.knnSearch(x.data(), count, index.data(), distance2.data());
    std::vector<std::pair<double, int>> nearest(found);
    for (std::size_t i = 0; i < found; ++i)
      nearest[i] = {std::sqrt(distance2[i]), static_cast<int>(index[i])};
    std::sort(nearest.begin(), nearest.end());
    return nearest;
  }

 private:
  struct Cloud {
    const Points& P;
    std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(P.rows()); }
    double kdtree_get_pt(std::size_t i, std::size_t k) const {
      return P(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  Cloud cloud_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3> tree_;
};

}  // namespace skinfield
