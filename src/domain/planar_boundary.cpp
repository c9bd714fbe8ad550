#include "domain/planar_boundary.h"

#include "skinfield/base/parallel.h"
#include "skinfield/geometry/segment_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace skinfield {
namespace {

constexpr double beside = 1e-7;        // of a segment's length: the two sides of an even-odd rule
constexpr double piece_of_edge = 0.3;  // smoothed winding numbers are 0.35 of an edge wide or more
constexpr int most_pieces = 1000;
constexpr double at_an_end = 1e-9;  // of a segment: no crossing, but a vertex that two have

Segments rows_of(const std::vector<std::array<int, 2>>& list) {
  Segments E(static_cast<Eigen::Index>(list.size()), 2);
  for (std::size_t e = 0; e < list.size(); ++e)
    E.row(static_cast<Eigen::Index>(e)) << list[e][0], list[e][1];
  return E;
}

/// Edges that triangles, all made counterclockwise, have more often one way than the other.
Segments rim(const Mesh& mesh) {
  std::map<std::array<int, 2>, int> net;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    std::array<int, 3> t{mesh.F(f, 0), mesh.F(f, 1), mesh.F(f, 2)};
    const Vec3 u = (mesh.V.row(t[1]) - mesh.V.row(t[0])).transpose();
    const Vec3 v = (mesh.V.row(t[2]) - mesh.V.row(t[0])).transpose();
    const double area = u.x() * v.y() - u.y() * v.x();
    if (area == 0) continue;
    if (area < 0) std::swap(t[1], t[2]);
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = t[c], b = t[(c + 1) % 3];
      net[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  std::vector<std::array<int, 2>> edges;
  for (const auto& [edge, count] : net)
    for (int k = 0; k < std::abs(count); ++k)
      edges.push_back(count > 0 ? edge : std::array<int, 2>{edge[1], edge[0]});
  return rows_of(edges);
}

/// One shape's loops, cut where they cross and turned so that even-odd inside is on the left.
void turn_loops(const Segments& E, std::vector<Vec3>& V, std::vector<std::array<int, 2>>& turned) {
  Points P(static_cast<Eigen::Index>(V.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v) P.row(static_cast<Eigen::Index>(v)) = V[v].transpose();
  const SegmentScene scene(P, E);
  std::vector<std::array<int, 2>> pieces;
  std::map<std::array<int, 2>, int> crossing;  // of two segments: one vertex
  std::vector<RayHit> hits;
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Vec3 a = P.row(E(e, 0)).transpose(), b = P.row(E(e, 1)).transpose();
    scene.all_hits(a, b, hits);
    int from = E(e, 0);
    for (const RayHit& hit : hits) {
      if (hit.t < at_an_end || hit.t > 1 - at_an_end) continue;
      const auto own = static_cast<int>(e);
      const auto [found, fresh] = crossing.try_emplace(
          {std::min(own, hit.face), std::max(own, hit.face)}, static_cast<int>(V.size()));
      if (fresh) V.emplace_back(a + hit.t * (b - a));
      pieces.push_back({from, found->second});
      from = found->second;
    }
    pieces.push_back({from, E(e, 1)});
  }
  const auto odd = [&scene](const Vec3& x) {
    return static_cast<long>(std::llround(scene.winding(x))) % 2 != 0;
  };
  for (const auto& [p, q] : pieces) {
    const Vec3 a = V[static_cast<std::size_t>(p)], b = V[static_cast<std::size_t>(q)];
    const Vec3 left = beside * Vec3(a.y() - b.y(), b.x() - a.x(), 0), middle = 0.5 * (a + b);
    const bool inside_left = odd(middle + left), inside_right = odd(middle - left);
    if (inside_left == inside_right) continue;  // two of them in one place
    turned.push_back(inside_left ? std::array<int, 2>{p, q} : std::array<int, 2>{q, p});
  }
}

}  // namespace

PlanarBoundary planar_boundary(const Mesh& mesh, const Points& handle_samples) {
  PlanarBoundary boundary;
  boundary.V = mesh.V;
  if (mesh.F.rows() > 0) {
    boundary.closed = rim(mesh);
    return boundary;
  }
  std::vector<Vec3> V;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) V.emplace_back(mesh.V.row(v).transpose());
  std::vector<std::array<int, 2>> turned;
  const Outline& outline = mesh.outline;
  const int shapes =
      outline.shape.empty() ? 0 : *std::max_element(outline.shape.begin(), outline.shape.end()) + 1;
  for (int s = 0; s < shapes; ++s) {
    std::vector<std::array<int, 2>> own;
    for (std::size_t e = 0; e < outline.shape.size(); ++e)
      if (outline.shape[e] == s)
        own.push_back({outline.E(static_cast<Eigen::Index>(e), 0),
                       outline.E(static_cast<Eigen::Index>(e), 1)});
    if (!own.empty()) turn_loops(rows_of(own), V, turned);
  }
  boundary.V.resize(static_cast<Eigen::Index>(V.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v)
    boundary.V.row(static_cast<Eigen::Index>(v)) = V[v].transpose();
  boundary.closed = rows_of(turned);
  boundary.open = outline.loose;
  if (boundary.open.rows() == 0) return boundary;
  // Drawn clockwise, handles read as a hole.
  Vector w(handle_samples.rows());
  parallel_for(static_cast<std::size_t>(w.size()), 32, [&](std::size_t i) {
    const auto k = static_cast<Eigen::Index>(i);
    w[k] = winding_number_of_segments(boundary.V, boundary.open, handle_samples.row(k).transpose());
  });
  if (w.size() > 0 && w.sum() < 0) boundary.open = boundary.open.rowwise().reverse().eval();
  return boundary;
}

double DirtySegments::smoothed(const Vec3& x, double epsilon) const {
  double sum = 0;
  for (Eigen::Index k = 0; k < X.rows(); ++k) {
    const double dx = X(k, 0) - x.x(), dy = X(k, 1) - x.y();
    sum += (L(k, 0) * dx + L(k, 1) * dy) / (dx * dx + dy * dy + epsilon * epsilon);
  }
  return sum / (2 * std::numbers::pi);
}

DirtySegments dirty_segments(const Points& V, const Segments& E) {
  DirtySegments pieces;
  std::vector<double> length;
  for (Eigen::Index e = 0; e < E.rows(); ++e)
    length.push_back((V.row(E(e, 1)) - V.row(E(e, 0))).head<2>().norm());
  std::vector<double> sorted = length;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  pieces.edge = *middle;
  std::vector<Vec3> X, L;
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    const Vec3 a = V.row(E(e, 0)).transpose(), d = V.row(E(e, 1)).transpose() - a;
    const double wanted = length[static_cast<std::size_t>(e)] / (piece_of_edge * pieces.edge);
    const int count = std::clamp(static_cast<int>(std::ceil(wanted)), 1, most_pieces);
    for (int k = 0; k < count; ++k) {
      X.emplace_back(a + (k + 0.5) / count * d);
      L.emplace_back(Vec3(d.y(), -d.x(), 0) / count);
    }
  }
  pieces.X.resize(static_cast<Eigen::Index>(X.size()), 3);
  pieces.L.resize(pieces.X.rows(), 3);
  for (std::size_t k = 0; k < X.size(); ++k) {
    pieces.X.row(static_cast<Eigen::Index>(k)) = X[k].transpose();
    pieces.L.row(static_cast<Eigen::Index>(k)) = L[k].transpose();
  }
  return pieces;
}

Points boundary_normals(const Points& V, const Segments& closed, const Segments& open) {
  Points N = Points::Zero(V.rows(), 3);
  for (const Segments* E : {&closed, &open})
    for (Eigen::Index e = 0; e < E->rows(); ++e) {
      const Vec3 d = (V.row((*E)(e, 1)) - V.row((*E)(e, 0))).transpose();
      const double length = d.head<2>().norm();
      if (length == 0) continue;
      const Vec3 right(d.y() / length, -d.x() / length, 0);
      for (int end = 0; end < 2; ++end) N.row((*E)(e, end)) += right.transpose();
    }
  for (Eigen::Index v = 0; v < N.rows(); ++v)
    if (const double length = N.row(v).norm(); length > 1e-12) N.row(v) /= length;
  return N;
}

}  // namespace skinfield
