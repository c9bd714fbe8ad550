#include "domain/point_evaluation.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

constexpr int nearest_tried = 48;
constexpr int nearest_used = 24;
constexpr int fewest_seen = 6;
constexpr int width_neighbour = 8;  // sigma is a share of the distance to the 8th
constexpr double width = 0.5;
constexpr double width_on_surface = 0.4;
constexpr double dust = 1e-10;

/// Shepard weights with a Gaussian, sigma = share * d_8; in place of the distances.
void shepard(std::vector<std::pair<int, double>>& row, double share = width) {
  std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second < b.second : a.first < b.first;
  });
  const std::size_t k = std::min<std::size_t>(row.size(), width_neighbour) - 1;
  const double sigma = std::max(share * row[k].second, 1e-300);
  const double nearest = row.front().second;
  double sum = 0;
  for (auto& [node, d] : row) {
    // The common factor exp(nearest^2 / 2 sigma^2) keeps far points from losing every weight.
    d = std::exp(-0.5 * (d - nearest) * (d + nearest) / (sigma * sigma));
    sum += d;
  }
  for (auto& [node, d] : row) d /= sum;
}

/// Makes Shepard weights exact for functions that are linear along the surface, where clamping at
/// zero allows it. Across the surface they stay constant: nodes lie to one side only, and the
/// weights' normal derivative is zero there.
void correct_along_surface(const Vec3& x, const Vec3& normal, const std::vector<Site>& sites,
                           std::vector<std::pair<int, double>>& row) {
  const Vec3 e1 = normal.unitOrthogonal();
  const Vec3 e2 = normal.cross(e1);
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  const auto along = [&](int node) {
    const Vec3 d = sites[static_cast<std::size_t>(node)].x - x;
    return Eigen::Vector2d(d.dot(e1), d.dot(e2));
  };
  for (const auto& [node, w] : row) {
    const Eigen::Vector2d t = along(node);
    A += w * t * t.transpose();
    b += w * t;
  }
  A += 0.01 * A.trace() * Eigen::Matrix2d::Identity();
  if (!(A.determinant() > 0)) return;
  const Eigen::Vector2d slope = A.inverse() * b;
  double sum = 0;
  for (auto& [node, w] : row) {
    w *= std::max(0.0, 1 - slope.dot(along(node)));
    sum += w;
  }
  for (auto& [node, w] : row) w /= sum;
}

}  // namespace

PointEvaluation::PointEvaluation(const Solid& solid, const std::vector<Site>& sites,
                                 const KdTree& tree, const SparseRows& K,
                                 const std::vector<char>& connected, double step)
    : solid_(solid), sites_(sites), tree_(tree), K_(K), connected_(connected), step_(step) {}

bool PointEvaluation::look_from(const Vec3& x, const Vec3& normal, Site& site) const {
  // Surface points look from just inside; a wrong normal is caught by looking from the other side.
  for (double step : {-step_, 0.0, step_, -10 * step_, 10 * step_}) {
    if (step != 0 && normal.squaredNorm() == 0) continue;
    site = solid_.site(x + step * normal);
    if (solid_.inside(site)) return true;
  }
  return false;
}

void PointEvaluation::around(int centre, const Vec3& x,
                             std::vector<std::pair<int, double>>& row) const {
  std::vector<int> ring{centre};
  std::vector<int> seen{centre};
  for (int r = 0; r < 2; ++r) {
    std::vector<int> next;
    for (int i : ring)
      for (SparseRows::InnerIterator it(K_, i); it; ++it)
        if (std::find(seen.begin(), seen.end(), it.col()) == seen.end()) {
          seen.push_back(static_cast<int>(it.col()));
          next.push_back(static_cast<int>(it.col()));
        }
    ring = std::move(next);
  }
  row.clear();
  for (int i : seen) row.emplace_back(i, (sites_[static_cast<std::size_t>(i)].x - x).norm());
  shepard(row);
}

Vec3 PointEvaluation::away_from_nodes(const Vec3& x) const {
  std::vector<Neighbour> found;
  tree_.nearest(x, nearest_tried, found);
  if (found.empty()) return Vec3::Zero();
  const double reach = 1.01 * found.back().distance;
  Vec3 sum = Vec3::Zero();
  for (const Neighbour& n : found) {
    if (!connected_[static_cast<std::size_t>(n.index)]) continue;
    const double share = n.distance / reach;
    sum += (1 - share * share) * (x - sites_[static_cast<std::size_t>(n.index)].x);
  }
  return sum.stableNormalized();
}

Fill PointEvaluation::evaluate(const Vec3& x, const Vec3& normal, bool clean,
                               std::vector<std::pair<int, double>>& row) const {
  std::vector<Neighbour> found;
  tree_.nearest(x, nearest_tried, found);
  Site site;
  const bool inside = look_from(x, normal, site);
  row.clear();
  int unblocked = -1;
  if (inside) {
    for (const Neighbour& n : found) {
      if (!connected_[static_cast<std::size_t>(n.index)]) continue;
      if (solid_.blocked(site, sites_[static_cast<std::size_t>(n.index)])) continue;
      if (unblocked < 0) unblocked = n.index;
      if (!clean) break;  // dirty points need only the nearest
      row.emplace_back(n.index, n.distance);
      if (static_cast<int>(row.size()) == nearest_used) break;
    }
    if (clean && static_cast<int>(row.size()) >= fewest_seen) {
      const bool on_surface = normal.squaredNorm() > 0;
      shepard(row, on_surface ? width_on_surface : width);
      if (on_surface) correct_along_surface(x, normal, sites_, row);
      return Fill::none;
    }
  }
  // From outside there is no view: the nearest node serves.
  for (std::size_t k = 0; !inside && unblocked < 0 && k < found.size(); ++k)
    if (connected_[static_cast<std::size_t>(found[k].index)]) unblocked = found[k].index;
  if (unblocked < 0) {
    // Nothing in view among the nearest: look further before looking through walls.
    std::vector<Neighbour> more;
    tree_.nearest(x, 16 * nearest_tried, more);
    for (const Neighbour& n : more) {
      if (!connected_[static_cast<std::size_t>(n.index)]) continue;
      if (unblocked < 0) unblocked = n.index;
      if (!inside) break;
      if (!solid_.blocked(site, sites_[static_cast<std::size_t>(n.index)])) {
        unblocked = n.index;
        break;
      }
    }
  }
  if (unblocked < 0) {
    double best = 1e300;
    for (std::size_t i = 0; i < sites_.size(); ++i)
      if (connected_[i] && (sites_[i].x - x).squaredNorm() < best) {
        best = (sites_[i].x - x).squaredNorm();
        unblocked = static_cast<int>(i);
      }
  }
  around(unblocked, x, row);
  if (!clean && normal.squaredNorm() > 0) correct_along_surface(x, normal, sites_, row);
  return clean || !inside ? Fill::hidden : Fill::none;
}

void carry_passengers(const Points& from, const Points& from_normals, const Points& X,
                      const Points& N, const InterpolationRows& rows_of_X,
                      const std::vector<int>& wanted, InterpolationRows& result) {
  if (X.rows() == 0) return;
  const KdTree tree(X);
  parallel_for(wanted.size(), 32, [&](std::size_t w) {
    const auto i = static_cast<std::size_t>(wanted[w]);
    const auto row_i = static_cast<Eigen::Index>(i);
    const Vec3 x = from.row(row_i).transpose();
    std::vector<Neighbour> found;
    tree.nearest(x, 16, found);
    std::vector<double> q(found.size());
    double least = 1e300;
    for (std::size_t k = 0; k < found.size(); ++k) {
      double facing = 1;
      if (from_normals.rows() > 0) {
        const double c = std::abs(from_normals.row(row_i).dot(N.row(found[k].index)));
        facing = std::max(0.01, c * c * c * c);
      }
      const double d = std::max(found[k].distance, 1e-9);
      q[k] = d * d / facing;
      least = std::min(least, q[k]);
    }
    std::vector<std::pair<int, double>>& row = result.row[i];
    row.clear();
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double weight = std::exp(-4 * (q[k] / least - 1));
      if (weight < dust) continue;
      for (const auto& [node, value] : rows_of_X.row[static_cast<std::size_t>(found[k].index)])
        row.emplace_back(node, weight * value);
    }
    result.fill[i] = Fill::passenger;
  });
}

void stiffen_floating(const Points& from, const std::vector<int>& component, const Points& X,
                      const std::vector<int>& wanted, InterpolationRows& result) {
  constexpr double clear = 0.05;  // of the piece's diagonal
  constexpr std::size_t holds = 8;
  std::map<int, std::vector<int>> pieces;
  for (int v : wanted)
    if (component[static_cast<std::size_t>(v)] >= 0)
      pieces[component[static_cast<std::size_t>(v)]].push_back(v);
  std::map<int, std::size_t> sizes;
  for (int c : component) ++sizes[c];
  const KdTree tree(X);
  for (const auto& [c, vertices] : pieces) {
    if (vertices.size() != sizes[c]) continue;
    Points V(static_cast<Eigen::Index>(vertices.size()), 3);
    std::vector<std::pair<double, int>> order;
    std::vector<Neighbour> found;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      V.row(static_cast<Eigen::Index>(k)) = from.row(vertices[k]);
      tree.nearest(from.row(vertices[k]).transpose(), 1, found);
      order.emplace_back(found.empty() ? 0 : found.front().distance, vertices[k]);
    }
    std::sort(order.begin(), order.end());
    if (order.front().first <= clear * diagonal(bounding_box(V))) continue;
    std::vector<std::pair<int, double>> row;
    for (std::size_t k = 0; k < std::min(holds, order.size()); ++k) {
      const auto& from_row = result.row[static_cast<std::size_t>(order[k].second)];
      double sum = 0;
      for (const auto& [node, w] : from_row) sum += w;
      for (const auto& [node, w] : from_row) row.emplace_back(node, w / sum);
    }
    for (int v : vertices) result.row[static_cast<std::size_t>(v)] = row;
  }
}

SparseRows to_matrix(const InterpolationRows& rows, Eigen::Index nodes) {
  const auto n = static_cast<Eigen::Index>(rows.row.size());
  SparseRows P(n, nodes);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    auto row = rows.row[static_cast<std::size_t>(i)];
    std::sort(row.begin(), row.end());
    std::size_t used = 0;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (used > 0 && row[used - 1].first == row[k].first)
        row[used - 1].second += row[k].second;
      else
        row[used++] = row[k];
    }
    row.resize(used);
    double sum = 0, largest = 0;
    for (const auto& [node, w] : row) largest = std::max(largest, w);
    for (auto& [node, w] : row) {
      if (w < dust * largest) w = 0;
      sum += w;
    }
    for (const auto& [node, w] : row)
      if (w > 0)
        entries.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(node),
                             w / sum);
  }
  P.setFromTriplets(entries.begin(), entries.end());
  return P;
}

}  // namespace skinfield
