// Collects polygons as fans of triangles.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

class FaceList {
 public:
  /// Appends the fan of a polygon; returns false (and adds nothing) below three corners.
  bool add(const std::vector<std::int32_t>& polygon) {
    if (polygon.size() < 3) {
      ++skipped_;
      return false;
    }
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      add(polygon[0], polygon[i - 1], polygon[i]);
    }
    return true;
  }
  void add(std::int32_t a, std::int32_t b, std::int32_t c) {
    corners_.insert(corners_.end(), {a, b, c});
  }
  int size() const { return static_cast<int>(corners_.size() / 3); }
  int skipped() const { return skipped_; }
  Triangles matrix() const { return Eigen::Map<const Triangles>(corners_.data(), size(), 3); }

 private:
  std::vector<std::int32_t> corners_;
  int skipped_ = 0;
};

inline Points points_from(const std::vector<double>& xyz) {
  return Eigen::Map<const Points>(xyz.data(), static_cast<Eigen::Index>(xyz.size() / 3), 3);
}

}  // namespace skinfield
