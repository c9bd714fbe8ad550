#include "domain/tet_locator.h"

#include <Eigen/Dense>

#include <algorithm>
#include <numeric>

namespace skinfield {
namespace {

constexpr int kLeafTets = 4;
constexpr double kOutside = -1e-9;  // a barycentric coordinate from which on a point is outside

}  // namespace

Barycentric barycentric_in(const std::array<Vec3, 4>& corner, const Vec3& x) {
  const Vec3 p[4] = {corner[0] - x, corner[1] - x, corner[2] - x, corner[3] - x};
  Barycentric b;
  b[0] = p[1].cross(p[2]).dot(p[3]);
  b[1] = -p[2].cross(p[3]).dot(p[0]);
  b[2] = p[3].cross(p[0]).dot(p[1]);
  b[3] = -p[0].cross(p[1]).dot(p[2]);
  const Vec3 e[3] = {corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]};
  return b / e[0].cross(e[1]).dot(e[2]);
}

TetLocator::TetLocator(const Points& V, const Tetrahedra& T)
    : V_(V), T_(T), order_(static_cast<std::size_t>(T.rows())) {
  std::iota(order_.begin(), order_.end(), 0);
  low_.reserve(order_.size());
  high_.reserve(order_.size());
  for (int t = 0; t < T.rows(); ++t) {
    const std::array<Vec3, 4> x = corners(t);
    low_.push_back(x[0].cwiseMin(x[1]).cwiseMin(x[2]).cwiseMin(x[3]));
    high_.push_back(x[0].cwiseMax(x[1]).cwiseMax(x[2]).cwiseMax(x[3]));
  }
  if (!order_.empty()) build(0, static_cast<int>(order_.size()));
  low_.clear();
  high_.clear();
}

std::array<Vec3, 4> TetLocator::corners(int tet) const {
  std::array<Vec3, 4> x;
  for (int c = 0; c < 4; ++c) x[static_cast<std::size_t>(c)] = V_.row(T_(tet, c)).transpose();
  return x;
}

int TetLocator::build(int begin, int end) {
  const auto number = static_cast<int>(nodes_.size());
  const auto at = [this](int i) {
    return static_cast<std::size_t>(order_[static_cast<std::size_t>(i)]);
  };
  Node node{low_[at(begin)], high_[at(begin)], begin, end, 0};
  for (int i = begin; i < end; ++i) {
    node.low = node.low.cwiseMin(low_[at(i)]);
    node.high = node.high.cwiseMax(high_[at(i)]);
  }
  nodes_.push_back(node);
  if (end - begin <= kLeafTets) return number;
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const int half = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                   [&](int a, int b) {
                     const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
                     const double p = low_[i][axis] + high_[i][axis];
                     const double q = low_[j][axis] + high_[j][axis];
                     return p != q ? p < q : a < b;
                   });
  build(begin, half);
  const int second = build(half, end);
  nodes_[static_cast<std::size_t>(number)].second = second;
  return number;
}

TetLocator::Place TetLocator::find(const Vec3& x) const {
  Place best;
  double depth = kOutside;
  bool corner = false;
  // Rounding may leave a corner just outside its own box: a hair of margin.
  candidates(x, 1e-14, [&](int t) {
    const std::array<Vec3, 4> y = corners(t);
    for (int c = 0; c < 4; ++c) {
      if (y[static_cast<std::size_t>(c)] != x || (corner && t > best.tet)) continue;
      corner = true;
      best.tet = t;
      best.b = Barycentric::Unit(c);
    }
    if (corner) return;
    const Barycentric b = barycentric_in(y, x);
    const double least = b.minCoeff();
    if (!(least >= kOutside) || !b.allFinite()) return;
    if (best.tet < 0 || least > depth || (least == depth && t < best.tet)) {
      best = {t, b};
      depth = least;
    }
  });
  if (best.tet < 0) return best;
  best.b = best.b.cwiseMax(0.0);
  best.b /= best.b.sum();
  return best;
}

}  // namespace skinfield
