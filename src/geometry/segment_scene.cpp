#include "skinfield/geometry/segment_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr int leaf_segments = 4;
constexpr double margin = 1e-12;  // boxes are this much wider, of the scene's size: rounding

/// Twice the signed area of a, b, p: positive where p is to the left of a-b. The same bits for the
/// same point whichever segment asks, so that two segments never both miss their common end.
double side(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

}  // namespace

struct SegmentScene::Impl {
  struct Segment {
    Vec2 p, q;
    int number;
  };
  struct Node {
    Vec2 low, high;
    int begin = 0, end = 0, second = 0;  // second 0: a leaf
  };
  std::vector<Segment> segments;
  std::vector<Node> nodes;
  Vec2 far = Vec2::Zero();  // outside everything

  Impl(const Points& V, const Segments& E) {
    for (Eigen::Index e = 0; e < E.rows(); ++e) {
      const Vec2 p = V.row(E(e, 0)).head<2>().transpose(), q = V.row(E(e, 1)).head<2>().transpose();
      if (p != q) segments.push_back({p, q, static_cast<int>(e)});
    }
    if (segments.empty()) return;
    nodes.reserve(segments.size());
    Vec2 low = segments[0].p, high = low;
    for (const Segment& s : segments) {
      low = low.cwiseMin(s.p).cwiseMin(s.q);
      high = high.cwiseMax(s.p).cwiseMax(s.q);
    }
    const double size = (high - low).maxCoeff();
    // Along no direction that outlines like to have.
    far = high + size * Vec2(1, std::numbers::inv_pi);
    build(0, static_cast<int>(segments.size()), margin * size);
  }

  int build(int begin, int end, double wider) {
    Node node;
    node.begin = begin, node.end = end;
    node.low = node.high = segments[static_cast<std::size_t>(begin)].p;
    for (int i = begin; i < end; ++i) {
      const Segment& s = segments[static_cast<std::size_t>(i)];
      node.low = node.low.cwiseMin(s.p).cwiseMin(s.q);
      node.high = node.high.cwiseMax(s.p).cwiseMax(s.q);
    }
    int axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    node.low.array() -= wider;
    node.high.array() += wider;
    const auto n = nodes.size();
    nodes.push_back(node);
    if (end - begin <= leaf_segments) return static_cast<int>(n);
    const int half = begin + (end - begin) / 2;
    std::nth_element(segments.begin() + begin, segments.begin() + half, segments.begin() + end,
                     [axis](const Segment& a, const Segment& b) {
                       const double u = a.p[axis] + a.q[axis], v = b.p[axis] + b.q[axis];
                       return u != v ? u < v : a.number < b.number;
                     });
    build(begin, half, wider);
    const int second = build(half, end, wider);
    nodes[n].second = second;
    return static_cast<int>(n);
  }

  /// Calls hit(RayHit) for each segment that a-b crosses, until it returns false.
  template <class Hit>
  void visit(const Vec2& a, const Vec2& b, const Hit& hit) const {
    if (nodes.empty()) return;
    const Vec2 d = b - a;
    std::array<int, 64> stack;  // medians: the depth is below 32
    std::size_t open = 0;
    stack[open++] = 0;
    while (open > 0) {
      const Node& node = nodes[static_cast<std::size_t>(stack[--open])];
      if (misses(node, a, b, d)) continue;
      if (node.second > 0) {
        stack[open++] = node.second;
        stack[open++] = static_cast<int>(&node - nodes.data()) + 1;
        continue;
      }
      for (int i = node.begin; i < node.end; ++i) {
        const Segment& s = segments[static_cast<std::size_t>(i)];
        // Ends on the line itself count as right of it: closed chains cross it evenly.
        const bool left_p = side(a, b, s.p) > 0, left_q = side(a, b, s.q) > 0;
        if (left_p == left_q) continue;
        const double of_a = side(s.p, s.q, a), of_b = side(s.p, s.q, b);
        // a on the segment has its winding number of neither side: what is left of it is inside.
        if ((of_a >= 0) == (of_b >= 0)) continue;
        RayHit found;
        found.t = std::clamp(of_a / (of_a - of_b), 0.0, 1.0);
        found.face = s.number;
        found.sign = of_a >= 0 ? -1 : 1;
        if (!hit(found)) return;
      }
    }
  }

  /// By separating axes: the box's, and the normal of a-b.
  static bool misses(const Node& node, const Vec2& a, const Vec2& b, const Vec2& d) {
    if ((a.cwiseMax(b).array() < node.low.array()).any() ||
        (a.cwiseMin(b).array() > node.high.array()).any())
      return true;
    const Vec2 middle = 0.5 * (node.low + node.high) - a, half = 0.5 * (node.high - node.low);
    return std::abs(d.x() * middle.y() - d.y() * middle.x()) >
           std::abs(d.x()) * half.y() + std::abs(d.y()) * half.x();
  }
};

SegmentScene::SegmentScene(const Points& V, const Segments& E)
    : impl_(std::make_unique<Impl>(V, E)) {}
SegmentScene::~SegmentScene() = default;
SegmentScene::SegmentScene(SegmentScene&&) noexcept = default;
SegmentScene& SegmentScene::operator=(SegmentScene&&) noexcept = default;

bool SegmentScene::empty() const { return impl_->segments.empty(); }

bool SegmentScene::occluded(const Vec3& a, const Vec3& b) const {
  bool found = false;
  impl_->visit(a.head<2>(), b.head<2>(), [&found](const RayHit&) {
    found = true;
    return false;
  });
  return found;
}

RayHit SegmentScene::first_hit(const Vec3& origin, const Vec3& direction, double t_max) const {
  RayHit first;
  impl_->visit(origin.head<2>(), (origin + t_max * direction).head<2>(), [&](const RayHit& hit) {
    if (!first || hit.t < first.t || (hit.t == first.t && hit.face < first.face)) first = hit;
    return true;
  });
  first.t *= t_max;
  return first;
}

void SegmentScene::all_hits(const Vec3& a, const Vec3& b, std::vector<RayHit>& hits) const {
  hits.clear();
  impl_->visit(a.head<2>(), b.head<2>(), [&hits](const RayHit& hit) {
    hits.push_back(hit);
    return true;
  });
  std::sort(hits.begin(), hits.end(), [](const RayHit& p, const RayHit& q) {
    return p.t != q.t ? p.t < q.t : p.face < q.face;
  });
}

double SegmentScene::winding(const Vec3& x) const {
  double sum = 0;
  impl_->visit(x.head<2>(), impl_->far, [&sum](const RayHit& hit) {
    sum -= hit.sign;
    return true;
  });
  return sum;
}

double winding_number_of_segments(const Points& V, const Segments& E, const Vec3& x) {
  double angle = 0;
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Vec2 p = (V.row(E(e, 0)) - x.transpose()).head<2>().transpose();
    const Vec2 q = (V.row(E(e, 1)) - x.transpose()).head<2>().transpose();
    angle += std::atan2(p.x() * q.y() - p.y() * q.x(), p.dot(q));
  }
  return angle / (2 * std::numbers::pi);
}

}  // namespace skinfield
