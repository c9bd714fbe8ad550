#include "geometry/dipole_tree.h"

#include <Eigen/Dense>

#include <algorithm>

namespace skinfield {
namespace {

using Cubic = DipoleTree::Cubic;
using Item = DipoleTree::Item;
using Node = DipoleTree::Node;

constexpr int kLeafItems = 8;
constexpr int kMaxMiddleSplits = 48;  // then medians, so that the depth stays bounded

constexpr int kSquare[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
constexpr int kCubic[10][3] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {0, 0, 1}, {0, 0, 2},
                               {0, 1, 1}, {1, 1, 2}, {0, 2, 2}, {1, 2, 2}, {0, 1, 2}};
constexpr int kSquareIndex[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

/// The symmetric part of a (x) B for a symmetric B.
Cubic symmetric(const Vec3& a, const std::array<double, 6>& B) {
  Cubic S;
  for (int t = 0; t < 10; ++t) {
    const auto [i, j, k] = kCubic[t];
    S[t] = (a[i] * B[kSquareIndex[j][k]] + a[j] * B[kSquareIndex[i][k]] +
            a[k] * B[kSquareIndex[i][j]]) /
           3;
  }
  return S;
}

std::array<double, 6> square(const Vec3& a) {
  std::array<double, 6> B;
  for (int t = 0; t < 6; ++t) B[t] = a[kSquare[t][0]] * a[kSquare[t][1]];
  return B;
}

struct Moments {
  Vec3 N = Vec3::Zero();
  std::array<double, 6> E{};
  Cubic S{}, point_S{};

  /// Adds moments that are given about a centre at `d` from this one.
  void add(const Moments& other, const Vec3& d) {
    N += other.N;
    for (int t = 0; t < 6; ++t) {
      const auto [i, j] = kSquare[t];
      E[t] += other.E[t] + (other.N[i] * d[j] + other.N[j] * d[i]) / 2;
    }
    const Cubic once = symmetric(d, other.E), twice = symmetric(other.N, square(d));
    for (int t = 0; t < 10; ++t) {
      const double shift = 2 * once[t] + twice[t];
      S[t] += other.S[t] + shift;
      point_S[t] += other.point_S[t] + shift;
    }
  }
};

/// int s s' dA of a triangle about its centroid is A/12 sum over corners of s s'.
Cubic own_moment(const Vec3& dipole, const Vec3 (&s)[3]) {
  std::array<double, 6> B{};
  for (const Vec3& corner : s) {
    const auto C = square(corner);
    for (int t = 0; t < 6; ++t) B[t] += C[t] / 12;
  }
  return symmetric(dipole, B);
}

struct Builder {
  const Points& corners;
  int per_item;
  double accuracy;
  const std::vector<Cubic>& own_S;
  const std::vector<Item>& items;
  std::vector<int> order;
  std::vector<Node> nodes;
  std::vector<Moments> moments;

  /// Splits [begin,end) of `order` at the middle of the longest side, else in halves.
  int split(int begin, int end, int depth) {
    Vec3 low = items[order[begin]].position, high = low;
    for (int i = begin; i < end; ++i) {
      low = low.cwiseMin(items[order[i]].position);
      high = high.cwiseMax(items[order[i]].position);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const double middle = low[axis] + (high[axis] - low[axis]) / 2;
    const auto first = order.begin() + begin, last = order.begin() + end;
    if (depth < kMaxMiddleSplits) {
      const auto at = std::stable_partition(
          first, last, [&](int i) { return items[i].position[axis] < middle; });
      if (at != first && at != last) return static_cast<int>(at - order.begin());
    }
    const auto half = first + (end - begin) / 2;
    std::nth_element(first, half, last, [&](int i, int j) {
      const double a = items[i].position[axis], b = items[j].position[axis];
      return a != b ? a < b : i < j;
    });
    return begin + (end - begin) / 2;
  }

  double radius(const Vec3& centre, int begin, int end) const {
    double r2 = 0;
    for (int i = begin; i < end; ++i)
      for (int k = 0; k < per_item; ++k) {
        const Vec3 p = corners.row(static_cast<Eigen::Index>(order[i]) * per_item + k).transpose();
        r2 = std::max(r2, (p - centre).squaredNorm());
      }
    return std::sqrt(r2);
  }

  /// Appends the subtree of [begin,end) in preorder and returns its number.
  int add(int begin, int end, int depth) {
    const int n = static_cast<int>(nodes.size());
    nodes.emplace_back();
    moments.emplace_back();
    Vec3 centre = Vec3::Zero(), mean = Vec3::Zero();
    double weight = 0;
    for (int i = begin; i < end; ++i) {
      const Item& item = items[order[i]];
      const double w = item.dipole.norm();
      centre += w * item.position;
      weight += w;
      mean += item.position;
    }
    centre = weight > 0 ? Vec3(centre / weight) : Vec3(mean / (end - begin));
    Moments sum;
    const bool leaf = end - begin <= kLeafItems;
    if (leaf) {
      for (int i = begin; i < end; ++i) {
        Moments own;
        own.N = items[order[i]].dipole;
        if (!own_S.empty()) own.S = own_S[order[i]];
        sum.add(own, items[order[i]].position - centre);
      }
    } else {
      const int middle = split(begin, end, depth);
      for (const auto& [from, to] : {std::pair{begin, middle}, std::pair{middle, end}}) {
        const int child = add(from, to, depth + 1);
        sum.add(moments[child], nodes[child].centre - centre);
      }
    }
    const double reach = accuracy * radius(centre, begin, end);
    nodes[n] = {centre, reach * reach, sum.N, sum.E,
                sum.S,  begin,         end,   static_cast<int>(nodes.size()),
                leaf};
    moments[n] = sum;
    return n;
  }
};

}  // namespace

DipoleTree::DipoleTree(const Points& V, const Triangles& F, double accuracy) {
  std::vector<Cubic> own_S;
  Points corners(F.rows() * 3, 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vec3 p[3] = {V.row(F(f, 0)).transpose(), V.row(F(f, 1)).transpose(),
                       V.row(F(f, 2)).transpose()};
    const Vec3 centroid = (p[0] + p[1] + p[2]) / 3;
    const Vec3 dipole = (p[1] - p[0]).cross(p[2] - p[0]) / 2;
    if (!dipole.allFinite() || !centroid.allFinite() || dipole.isZero(0)) continue;
    const auto row = static_cast<Eigen::Index>(items_.size()) * 3;
    Vec3 s[3];
    for (int k = 0; k < 3; ++k) {
      corners.row(row + k) = p[k].transpose();
      s[k] = p[k] - centroid;
    }
    items_.push_back({centroid, dipole, static_cast<int>(f)});
    own_S.push_back(own_moment(dipole, s));
  }
  build(corners, 3, accuracy, own_S);
}

DipoleTree::DipoleTree(const Points& P, const Points& N, const Vector& area, double accuracy) {
  Points positions(P.rows(), 3);
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    const Vec3 dipole = area[i] * N.row(i).transpose();
    if (!dipole.allFinite() || !P.row(i).allFinite() || dipole.isZero(0)) continue;
    positions.row(static_cast<Eigen::Index>(items_.size())) = P.row(i);
    items_.push_back({P.row(i).transpose(), dipole, static_cast<int>(i)});
  }
  build(positions, 1, accuracy, {});
}

void DipoleTree::build(const Points& corners, int per_item, double accuracy,
                       const std::vector<Cubic>& own_S) {
  if (items_.empty()) return;
  Builder builder{corners, per_item, accuracy, own_S, items_, {}, {}, {}};
  builder.order.resize(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) builder.order[i] = static_cast<int>(i);
  builder.add(0, static_cast<int>(items_.size()), 0);
  nodes_ = std::move(builder.nodes);
  point_S_.reserve(builder.moments.size());
  for (const Moments& m : builder.moments) point_S_.push_back(m.point_S);
  std::vector<Item> ordered;
  ordered.reserve(items_.size());
  for (const int i : builder.order) ordered.push_back(items_[i]);
  items_ = std::move(ordered);
}

}  // namespace skinfield
