// k nearest points (nanoflann behind it), ties broken by index so that results are reproducible.
#pragma once

#include "skinfield/base/types.h"

#include <memory>
#include <vector>

namespace skinfield {

struct Neighbour {
  int index;
  double distance;
};

class KdTree {
 public:
  explicit KdTree(const Points& X);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;
  /// The k nearest (fewer if there are fewer), nearest first.
  void nearest(const Vec3& x, int k, std::vector<Neighbour>& found) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
