#include "domain/plane_insertion.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr int kMostFlips = 10000;    // of one insertion: rounding must not turn in circles
constexpr double kConvex = 1e-10;    // least area of a flipped triangle, of the quad's
constexpr double kInCircle = 1e-10;  // a flip must gain more than rounding

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Distance of p from the segment a-b, and the place on it.
double distance_to_edge(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& p, Eigen::Vector2d& nearest) {
  const Eigen::Vector2d d = b - a;
  const double length = d.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0.0;
  nearest = a + t * d;
  return (p - nearest).norm();
}

/// Is d inside the circle through a, b, c (counterclockwise), by more than rounding?
bool in_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
               const Eigen::Vector2d& d) {
  const Eigen::Vector2d p = a - d, q = b - d, r = c - d;
  const double pp = p.squaredNorm(), qq = q.squaredNorm(), rr = r.squaredNorm();
  const double one = pp * cross(q, r), two = qq * cross(r, p), three = rr * cross(p, q);
  return one + two + three > kInCircle * (std::abs(one) + std::abs(two) + std::abs(three));
}

}  // namespace

PlaneInsertion::PlaneInsertion(const Points& V, const Triangles& F, const Plane& plane,
                               double tolerance)
    : V_(V), plane_(plane), tolerance_(tolerance) {
  for (Eigen::Index i = 0; i < V.rows(); ++i) p_.push_back(plane.to(V.row(i).transpose()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    Face corners{F(f, 0), F(f, 1), F(f, 2)};
    if (twice_area(corners[0], corners[1], corners[2]) < 0) std::swap(corners[1], corners[2]);
    append(corners);
  }
}

PlaneInsertion::Key PlaneInsertion::key(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  return (static_cast<Key>(low) << 32) | static_cast<Key>(high);
}

double PlaneInsertion::twice_area(int a, int b, int c) const {
  const auto at = [&](int v) -> const Eigen::Vector2d& { return p_[static_cast<std::size_t>(v)]; };
  return cross(at(b) - at(a), at(c) - at(a));
}

void PlaneInsertion::link(int face) {
  const Face& f = faces_[static_cast<std::size_t>(face)];
  for (std::size_t c = 0; c < 3; ++c) faces_of_edge_[key(f[c], f[(c + 1) % 3])].push_back(face);
}

void PlaneInsertion::unlink(int face) {
  const Face& f = faces_[static_cast<std::size_t>(face)];
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<int>& list = faces_of_edge_[key(f[c], f[(c + 1) % 3])];
    list.erase(std::find(list.begin(), list.end(), face));
  }
}

void PlaneInsertion::replace(int face, const Face& corners) {
  unlink(face);
  faces_[static_cast<std::size_t>(face)] = corners;
  link(face);
}

void PlaneInsertion::append(const Face& corners) {
  faces_.push_back(corners);
  link(static_cast<int>(faces_.size()) - 1);
}

bool PlaneInsertion::has_corner(int face, const std::vector<int>& vertices) const {
  const Face& f = faces_[static_cast<std::size_t>(face)];
  return std::any_of(f.begin(), f.end(), [&](int v) {
    return std::find(vertices.begin(), vertices.end(), v) != vertices.end();
  });
}

int PlaneInsertion::add_vertex(const Eigen::Vector2d& p) {
  p_.push_back(p);
  return static_cast<int>(p_.size()) - 1;
}

int PlaneInsertion::split_edge(int a, int b, const Eigen::Vector2d& p) {
  const int v = add_vertex(p);
  std::vector<std::array<int, 2>> opposite;
  const std::vector<int> around = faces_of_edge_[key(a, b)];
  for (const int face : around) {
    const Face f = faces_[static_cast<std::size_t>(face)];
    std::size_t top = 0;
    while (f[top] == a || f[top] == b) ++top;
    const int c = f[top], from = f[(top + 1) % 3], to = f[(top + 2) % 3];
    replace(face, {c, from, v});
    append({c, v, to});
    opposite.push_back({c, from});
    opposite.push_back({to, c});
  }
  flip_around(v, std::move(opposite));
  return v;
}

int PlaneInsertion::split_face(int face, const Eigen::Vector2d& p) {
  const int v = add_vertex(p);
  const Face f = faces_[static_cast<std::size_t>(face)];
  replace(face, {v, f[0], f[1]});
  append({v, f[1], f[2]});
  append({v, f[2], f[0]});
  flip_around(v, {{f[0], f[1]}, {f[1], f[2]}, {f[2], f[0]}});
  return v;
}

void PlaneInsertion::flip_around(int vertex, std::vector<std::array<int, 2>> opposite) {
  const auto at = [&](int v) -> const Eigen::Vector2d& { return p_[static_cast<std::size_t>(v)]; };
  for (int flips = 0; !opposite.empty() && flips < kMostFlips;) {
    const int a = opposite.back()[0], b = opposite.back()[1];
    opposite.pop_back();
    const std::vector<int>& around = faces_of_edge_[key(a, b)];
    if (around.size() != 2) continue;  // a border, or sheets that meet
    const auto third = [&](int face) {
      for (const int v : faces_[static_cast<std::size_t>(face)]) {
        if (v != a && v != b) return v;
      }
      return -1;
    };
    int own = around[0], other = around[1];
    if (third(own) != vertex) std::swap(own, other);
    const int d = third(other);
    if (third(own) != vertex || d < 0 || d == vertex) continue;
    const double left = twice_area(vertex, a, d), right = twice_area(vertex, d, b);
    const double least =
        kConvex * std::max({(at(a) - at(b)).squaredNorm(), (at(vertex) - at(d)).squaredNorm()});
    if (!(left > least && right > least)) continue;  // not convex, or folded over
    if (!in_circle(at(vertex), at(a), at(b), at(d))) continue;
    const auto across = faces_of_edge_.find(key(vertex, d));
    if (across != faces_of_edge_.end() && !across->second.empty()) continue;
    replace(own, {vertex, a, d});
    replace(other, {vertex, d, b});
    opposite.push_back({a, d});
    opposite.push_back({d, b});
    ++flips;
  }
}

std::vector<int> PlaneInsertion::insert(const Vec3& x) {
  const Eigen::Vector2d p = plane_.to(x);
  std::vector<int> found;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Face& f = faces_[i];
    const Eigen::Vector2d &a = p_[static_cast<std::size_t>(f[0])],
                          &b = p_[static_cast<std::size_t>(f[1])],
                          &c = p_[static_cast<std::size_t>(f[2])];
    const auto reach = Eigen::Array2d::Constant(tolerance_);
    if ((p.array() < a.array().min(b.array()).min(c.array()) - reach).any() ||
        (p.array() > a.array().max(b.array()).max(c.array()) + reach).any() ||
        !(cross(b - a, c - a) > 0)) {
      continue;
    }
    Eigen::Vector2d on;
    const bool inside =
        cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0;
    if (inside || std::min({distance_to_edge(a, b, p, on), distance_to_edge(b, c, p, on),
                            distance_to_edge(c, a, p, on)}) <= tolerance_) {
      found.push_back(static_cast<int>(i));
    }
  }
  std::vector<int> made;
  for (const int face : found) {
    // Changed triangles have the new vertex for a corner.
    if (has_corner(face, made)) continue;
    const Face f = faces_[static_cast<std::size_t>(face)];
    const auto corner = std::find_if(f.begin(), f.end(), [&](int v) {
      return (p_[static_cast<std::size_t>(v)] - p).norm() <= tolerance_;
    });
    if (corner != f.end()) {
      made.push_back(*corner);
      continue;
    }
    double least = tolerance_;
    int edge = -1;
    Eigen::Vector2d place = p;
    for (int c = 0; c < 3; ++c) {
      Eigen::Vector2d on;
      const double distance = distance_to_edge(
          p_[static_cast<std::size_t>(f[static_cast<std::size_t>(c)])],
          p_[static_cast<std::size_t>(f[static_cast<std::size_t>((c + 1) % 3)])], p, on);
      if (distance > least) continue;
      least = distance;
      edge = c;
      place = on;
    }
    made.push_back(edge < 0 ? split_face(face, p)
                            : split_edge(f[static_cast<std::size_t>(edge)],
                                         f[static_cast<std::size_t>((edge + 1) % 3)], place));
  }
  return made;
}

Points PlaneInsertion::vertices() const {
  const Eigen::Index n = V_.rows();
  Points V(static_cast<Eigen::Index>(p_.size()), 3);
  V.topRows(n) = V_;
  for (Eigen::Index i = n; i < V.rows(); ++i) {
    V.row(i) = plane_.from(p_[static_cast<std::size_t>(i)]).transpose();
  }
  return V;
}

Triangles PlaneInsertion::faces() const {
  Triangles F(static_cast<Eigen::Index>(faces_.size()), 3);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c)) = faces_[f][c];
    }
  }
  return F;
}

}  // namespace skinfield
