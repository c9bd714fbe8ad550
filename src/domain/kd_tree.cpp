#include "domain/kd_tree.h"

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace skinfield {
namespace {

struct Cloud {
  Points X;
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(X.rows()); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return X(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud, double>, Cloud,
                                        3, std::uint32_t>;

}  // namespace

struct KdTree::Impl {
  explicit Impl(const Points& X)
      : cloud{X}, tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {
    if (X.rows() > 0) tree.buildIndex();
  }
  Cloud cloud;
  Tree tree;
};

KdTree::KdTree(const Points& X) : impl_(std::make_unique<Impl>(X)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

void KdTree::nearest(const Vec3& x, int k, std::vector<Neighbour>& found) const {
  found.clear();
  const auto wanted =
      static_cast<std::size_t>(std::min<Eigen::Index>(std::max(k, 0), impl_->cloud.X.rows()));
  if (wanted == 0) return;
  std::vector<std::uint32_t> index(wanted);
  std::vector<double> squared(wanted);
  nanoflann::KNNResultSet<double, std::uint32_t> result(wanted);
  result.init(index.data(), squared.data());
  impl_->tree.findNeighbors(result, x.data(), nanoflann::SearchParams());
  found.reserve(wanted);
  for (std::size_t i = 0; i < result.size(); ++i)
    found.push_back({static_cast<int>(index[i]), std::sqrt(squared[i])});
  std::sort(found.begin(), found.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  });
}

}  // namespace skinfield
