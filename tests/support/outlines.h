// Flat shapes as outlines, for tests of fields in the plane.
#pragma once

#include "skinfield/base/random.h"
#include "skinfield/geometry/mesh.h"

#include <cmath>
#include <utility>
#include <vector>

namespace skinfield_test {

using skinfield::Mesh;
using skinfield::Vec3;
using Loop = std::vector<std::pair<double, double>>;

/// Closed loops of one shape (even-odd), every side cut in parts of at most `longest`.
inline Mesh outline_of(const std::vector<Loop>& loops, double longest = 1e9) {
  std::vector<Vec3> V;
  std::vector<std::pair<int, int>> E;
  for (const Loop& loop : loops) {
    const auto first = static_cast<int>(V.size());
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vec3 a(loop[k].first, loop[k].second, 0);
      const auto& next = loop[(k + 1) % loop.size()];
      const Vec3 b(next.first, next.second, 0);
      const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / longest)));
      for (int p = 0; p < parts; ++p) V.emplace_back(a + (b - a) * p / parts);
    }
    const auto end = static_cast<int>(V.size());
    for (int v = first; v < end; ++v) E.emplace_back(v, v + 1 < end ? v + 1 : first);
  }
  Mesh mesh;
  mesh.V.resize(static_cast<Eigen::Index>(V.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v) mesh.V.row(static_cast<Eigen::Index>(v)) = V[v];
  mesh.outline.E.resize(static_cast<Eigen::Index>(E.size()), 2);
  for (std::size_t e = 0; e < E.size(); ++e)
    mesh.outline.E.row(static_cast<Eigen::Index>(e)) << E[e].first, E[e].second;
  mesh.outline.shape.assign(E.size(), 0);
  return mesh;
}

/// Two prongs on a base, `gap` apart, counterclockwise.
inline Loop fork_loop(double gap) {
  const double w = 0.2;
  return {{0, 0},         {2 * w + gap, 0}, {2 * w + gap, 1}, {w + gap, 1},
          {w + gap, 0.3}, {w, 0.3},         {w, 1},           {0, 1}};
}

/// Its segments as a soup: a share of them gone, both ends of each of the rest moved on their own.
inline Mesh segment_soup(const Mesh& outline, double removed, double jitter, std::uint64_t seed) {
  skinfield::Random random(seed);
  std::vector<Vec3> V;
  for (Eigen::Index e = 0; e < outline.outline.E.rows(); ++e) {
    const bool gone = random.uniform() < removed;
    for (int end = 0; end < 2; ++end) {
      const Vec3 shift = jitter * Vec3(random.normal(), random.normal(), 0);
      if (!gone) V.emplace_back(outline.V.row(outline.outline.E(e, end)).transpose() + shift);
    }
  }
  Mesh soup;
  soup.V.resize(static_cast<Eigen::Index>(V.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v) soup.V.row(static_cast<Eigen::Index>(v)) = V[v];
  soup.outline.loose.resize(soup.V.rows() / 2, 2);
  for (Eigen::Index e = 0; e < soup.outline.loose.rows(); ++e)
    soup.outline.loose.row(e) << static_cast<int>(2 * e), static_cast<int>(2 * e + 1);
  return soup;
}

}  // namespace skinfield_test
