#include "skinfield/geometry/normals.h"

#include "geometry/neighbours.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/winding_number.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace skinfield {
namespace {

using Neighbours = std::vector<std::vector<std::pair<double, int>>>;

/// Of every point: the others nearest to it, in parallel.
Neighbours all_neighbours(const Points& P, int count) {
  const NearestPoints tree(P);
  Neighbours neighbours(static_cast<std::size_t>(P.rows()));
  parallel_for(neighbours.size(), 256, [&](std::size_t i) {
    auto& nearest = neighbours[i];
    nearest = tree.at(P.row(static_cast<Eigen::Index>(i)).transpose(), count + 1);
    std::erase_if(nearest, [&](const auto& n) { return n.second == static_cast<int>(i); });
  });
  return neighbours;
}

/// The direction of least spread of a point and its neighbours.
Vec3 plane_normal(const Points& P, Eigen::Index i,
                  const std::vector<std::pair<double, int>>& neighbours) {
  Vec3 mean = P.row(i).transpose();
  for (const auto& [d, j] : neighbours) mean += P.row(j).transpose();
  mean /= static_cast<double>(neighbours.size() + 1);
  const Vec3 own = P.row(i).transpose() - mean;
  Eigen::Matrix3d spread = own * own.transpose();
  for (const auto& [d, j] : neighbours) {
    const Vec3 r = P.row(j).transpose() - mean;
    spread += r * r.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
}

struct Link {
  double cost;
  int a, b;
  bool operator<(const Link& other) const {
    if (cost != other.cost) return cost < other.cost;
    return a != other.a ? a < other.a : b < other.b;
  }
};

/// Points joined by links, each with its sign relative to its root.
class SignedForest {
 public:
  explicit SignedForest(int n) : parent_(n), sign_(n, 1) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  /// The root of i, and in `sign` whether i agrees with it.
  int root(int i, int& sign) {
    sign = 1;
    int r = i;
    for (; parent_[r] != r; r = parent_[r]) sign *= sign_[r];
    int s = sign;
    while (parent_[i] != i) {  // compress the path
      const int next = parent_[i], own = sign_[i];
      parent_[i] = r;
      sign_[i] = s;
      s *= own;
      i = next;
    }
    return r;
  }
  /// Joins the trees of a and b so that a and b have the relative sign; no-op within one tree.
  void join(int a, int b, int relative) {
    int sa, sb;
    const int ra = root(a, sa), rb = root(b, sb);
    if (ra == rb) return;
    parent_[std::max(ra, rb)] = std::min(ra, rb);
    sign_[std::max(ra, rb)] = sa * sb * relative;
  }

 private:
  std::vector<int> parent_, sign_;
};

/// How much the normals of two points agree, in [-1,1], the one carried over to the other as on a
/// circle through both (mirrored at the plane between them: Koenig and Gumhold 2009). So along a
/// surface they should be alike, and across a thin part or a gap opposite.
double agreement(const Points& P, const Points& N, int i, int j) {
  const Vec3 r = (P.row(j) - P.row(i)).normalized().transpose();
  const Vec3 n = N.row(i).transpose(), m = N.row(j).transpose();
  return n.dot(m) - 2 * r.dot(n) * r.dot(m);
}

/// Kruskal's spanning tree over the neighbour graph, clearest links first; flips normals to agree
/// along it. Returns the component of every point.
std::vector<int> agree_along_tree(const Points& P, const Neighbours& neighbours, Points& N,
                                  int& components) {
  const int n = static_cast<int>(N.rows());
  std::vector<Link> links;
  for (int i = 0; i < n; ++i)
    for (const auto& [d, j] : neighbours[i])
      links.push_back({1 - std::abs(agreement(P, N, i, j)), std::min(i, j), std::max(i, j)});
  std::sort(links.begin(), links.end());
  SignedForest forest(n);
  for (const Link& link : links)
    forest.join(link.a, link.b, agreement(P, N, link.a, link.b) < 0 ? -1 : 1);
  std::vector<int> component(n, -1), number(n, -1);
  components = 0;
  for (int i = 0; i < n; ++i) {
    int sign;
    int& c = number[forest.root(i, sign)];
    if (c < 0) c = components++;
    component[i] = c;
    if (sign < 0) N.row(i) = -N.row(i);
  }
  return component;
}

/// Which way a component should face: the sign of its winding number at the inside points that it
/// matters to, else of the volume about its own centroid.
int component_sign(const Points& P, const Points& N, const Vector& area, const Points& inside) {
  constexpr double kMatters = 0.1;
  if (inside.rows() > 0) {
    const Vector w = WindingNumber(P, N, area).at(inside);
    double sum = 0;
    for (const double value : w)
      if (std::abs(value) > kMatters) sum += value;
    if (sum != 0) return sum > 0 ? 1 : -1;
  }
  const Eigen::RowVector3d mean = P.colwise().mean();
  const double volume = area.dot(((P.rowwise() - mean).cwiseProduct(N)).rowwise().sum());
  return volume < 0 ? -1 : 1;
}

/// Cuts the half plane nearer to q than to the origin off a polygon around the origin.
void clip_bisector(std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& q) {
  const double half = q.squaredNorm() / 2;
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double sa = a.dot(q) - half, sb = b.dot(q) - half;
    if (sa <= 0) kept.push_back(a);
    if ((sa < 0 && sb > 0) || (sa > 0 && sb < 0)) kept.push_back(a + sa / (sa - sb) * (b - a));
  }
  polygon = std::move(kept);
}

double polygon_area(const std::vector<Eigen::Vector2d>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::max(0.0, twice / 2);
}

/// The Voronoi cell in the tangent plane, within half the distance of the farthest neighbour:
/// points beyond that cannot cut it.
double cell_area(const Points& P, const Points& N, Eigen::Index i,
                 const std::vector<std::pair<double, int>>& neighbours) {
  constexpr int kCorners = 24;
  if (neighbours.empty()) return 0;
  const Vec3 n = N.row(i).transpose();
  const Vec3 u = n.unitOrthogonal(), v = n.cross(u);
  // A regular polygon of the area of the circle.
  const double turn = 2 * std::numbers::pi / kCorners;
  const double radius = neighbours.back().first / 2 * std::sqrt(turn / std::sin(turn));
  std::vector<Eigen::Vector2d> polygon(kCorners);
  for (int k = 0; k < kCorners; ++k)
    polygon[k] = radius * Eigen::Vector2d(std::cos(k * turn), std::sin(k * turn));
  for (const auto& [d, j] : neighbours) {
    if (N.row(j).dot(N.row(i)) <= 0) continue;  // the other side of a thin part
    const Vec3 r = P.row(j).transpose() - P.row(i).transpose();
    const Eigen::Vector2d q(r.dot(u), r.dot(v));
    if (q.norm() > 1e-6 * d) clip_bisector(polygon, q);
  }
  return polygon_area(polygon);
}

/// One row for every place; `of` maps points to places.
struct Places {
  Points P;
  std::vector<int> of;
  std::vector<int> copies, first;

  explicit Places(const Points& points) {
    Welded welded = weld(points);
    P = std::move(welded.V);
    of = std::move(welded.vertex);
    copies.assign(P.rows(), 0);
    first.assign(P.rows(), -1);
    for (std::size_t i = 0; i < of.size(); ++i) {
      ++copies[of[i]];
      if (first[of[i]] < 0) first[of[i]] = static_cast<int>(i);
    }
  }
};

Vector place_areas(const Points& P, const Points& N, const Neighbours& neighbours) {
  Vector area(P.rows());
  parallel_for(static_cast<std::size_t>(P.rows()), 256, [&](std::size_t i) {
    const auto r = static_cast<Eigen::Index>(i);
    area[r] = cell_area(P, N, r, neighbours[i]);
  });
  return area;
}

}  // namespace

Points estimate_point_normals(const Points& P, const Points& inside, int neighbours) {
  const Places places(P);
  const Neighbours near = all_neighbours(places.P, neighbours);
  Points N(places.P.rows(), 3);
  parallel_for(near.size(), 256, [&](std::size_t i) {
    const auto r = static_cast<Eigen::Index>(i);
    N.row(r) = plane_normal(places.P, r, near[i]).transpose();
  });
  int components = 0;
  const std::vector<int> component = agree_along_tree(places.P, near, N, components);
  const Vector area = place_areas(places.P, N, near);
  std::vector<std::vector<Eigen::Index>> members(components);
  for (Eigen::Index i = 0; i < N.rows(); ++i) members[component[i]].push_back(i);
  for (const auto& rows : members) {
    const Points part_N = N(rows, Eigen::all);
    if (component_sign(places.P(rows, Eigen::all), part_N, area(rows), inside) < 0)
      N(rows, Eigen::all) = -part_N;
  }
  return N(places.of, Eigen::all);
}

Vector point_areas(const Points& P, const Points& N, int neighbours) {
  const Places places(P);
  const Points place_N = N(places.first, Eigen::all);
  const Vector area = place_areas(places.P, place_N, all_neighbours(places.P, neighbours));
  Vector shared(P.rows());
  for (Eigen::Index i = 0; i < P.rows(); ++i)
    shared[i] = area[places.of[i]] / places.copies[places.of[i]];
  return shared;
}

}  // namespace skinfield
