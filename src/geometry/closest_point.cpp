#include "skinfield/geometry/closest_point.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace skinfield {
namespace {

constexpr int kLeafFaces = 4;

struct Candidate {
  Vec3 barycentric;
  double distance2;
};

/// Closest point of the triangle p to x, which is at the origin: inside if the projection is,
/// else on the nearest edge. Triangles without area are their edges.
Candidate closest_on_triangle(const std::array<Vec3, 3>& p) {
  const Vec3 e = p[1] - p[0], g = p[2] - p[0];
  const Vec3 n = e.cross(g);
  const double n2 = n.squaredNorm();
  if (n2 > 0) {
    const double u = n.dot(g.cross(p[0])) / n2;
    const double v = n.dot(p[0].cross(e)) / n2;
    if (u >= 0 && v >= 0 && u + v <= 1) {
      const double height = n.dot(p[0]);
      return {{1 - u - v, u, v}, height * height / n2};
    }
  }
  Candidate best{{1, 0, 0}, std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const double t = closest_on_segment(p[k], p[next], Vec3::Zero());
    const double d2 = ((1 - t) * p[k] + t * p[next]).squaredNorm();
    if (d2 >= best.distance2) continue;
    best.distance2 = d2;
    best.barycentric.setZero();
    best.barycentric[k] = 1 - t;
    best.barycentric[next] = t;
  }
  return best;
}

}  // namespace

double closest_on_segment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  return length2 > 0 ? std::clamp((x - a).dot(d) / length2, 0.0, 1.0) : 0;
}

double distance_to_segment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const double t = closest_on_segment(a, b, x);
  return (a + t * (b - a) - x).norm();
}

struct ClosestPointQuery::Impl {
  struct Node {
    Vec3 low, high;
    int begin, end;  // faces of a leaf in order_
    int second;      // the second child; the first follows its parent; 0: a leaf
  };
  struct Face {
    std::array<Vec3, 3> corner;
    int number;
  };
  std::vector<Face> faces;
  std::vector<Node> nodes;

  Impl(const Points& V, const Triangles& F) {
    for (Eigen::Index f = 0; f < F.rows(); ++f) {
      Face face;
      face.number = static_cast<int>(f);
      bool finite = true;
      for (int k = 0; k < 3; ++k) {
        face.corner[k] = V.row(F(f, k)).transpose();
        finite = finite && face.corner[k].allFinite();
      }
      if (finite) faces.push_back(face);
    }
    if (!faces.empty()) build(0, static_cast<int>(faces.size()));
  }

  static double middle(const Face& face, int axis) {
    return face.corner[0][axis] + face.corner[1][axis] + face.corner[2][axis];
  }

  int build(int begin, int end) {
    const int n = static_cast<int>(nodes.size());
    Node node{faces[begin].corner[0], faces[begin].corner[0], begin, end, 0};
    for (int i = begin; i < end; ++i) {
      for (const Vec3& x : faces[i].corner) {
        node.low = node.low.cwiseMin(x);
        node.high = node.high.cwiseMax(x);
      }
    }
    nodes.push_back(node);
    if (end - begin <= kLeafFaces) return n;
    int axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    const int half = begin + (end - begin) / 2;
    std::nth_element(faces.begin() + begin, faces.begin() + half, faces.begin() + end,
                     [&](const Face& a, const Face& b) {
                       const double p = middle(a, axis), q = middle(b, axis);
                       return p != q ? p < q : a.number < b.number;
                     });
    build(begin, half);
    const int second = build(half, end);
    nodes[n].second = second;
    return n;
  }

  double distance2(int n, const Vec3& x) const {
    const Node& node = nodes[n];
    return (node.low - x).cwiseMax(x - node.high).cwiseMax(0).squaredNorm();
  }

  ClosestPoint at(const Vec3& x, double max_distance) const {
    ClosestPoint best;
    double reach2 = max_distance * max_distance;
    struct Open {
      double distance2;
      int node;
    };
    std::array<Open, 64> stack;  // medians: the depth is below 32
    int open = 0;
    if (!nodes.empty()) stack[open++] = {distance2(0, x), 0};
    while (open > 0) {
      const Open top = stack[--open];
      if (top.distance2 > reach2) continue;
      const Node& node = nodes[top.node];
      if (node.second > 0) {
        Open near{distance2(top.node + 1, x), top.node + 1};
        Open far{distance2(node.second, x), node.second};
        if (far.distance2 < near.distance2) std::swap(near, far);
        stack[open++] = far;
        stack[open++] = near;
        continue;
      }
      for (int i = node.begin; i < node.end; ++i) {
        const auto& c = faces[i].corner;
        const Candidate found = closest_on_triangle({c[0] - x, c[1] - x, c[2] - x});
        const bool first = best.face < 0 || faces[i].number < best.face;
        if (found.distance2 > reach2 || (found.distance2 == reach2 && !first)) continue;
        reach2 = found.distance2;
        best.face = faces[i].number;
        best.barycentric = found.barycentric;
        best.point =
            found.barycentric[0] * c[0] + found.barycentric[1] * c[1] + found.barycentric[2] * c[2];
      }
    }
    if (best.face >= 0) best.distance = std::sqrt(reach2);
    return best;
  }
};

ClosestPointQuery::ClosestPointQuery(const Points& V, const Triangles& F)
    : impl_(std::make_unique<Impl>(V, F)) {}
ClosestPointQuery::~ClosestPointQuery() = default;
ClosestPointQuery::ClosestPointQuery(ClosestPointQuery&&) noexcept = default;
ClosestPointQuery& ClosestPointQuery::operator=(ClosestPointQuery&&) noexcept = default;

ClosestPoint ClosestPointQuery::at(const Vec3& x, double max_distance) const {
  return impl_->at(x, max_distance);
}

}  // namespace skinfield
