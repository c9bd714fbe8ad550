// The edges of a triangle mesh with the faces around them.
#pragma once

#include "skinfield/base/types.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <vector>

namespace skinfield {

struct HalfEdge {
  int low, high;  ///< corners, the smaller first
  int face;
  bool forward;  ///< the face runs from low to high
};

inline bool has_three_corners(const Triangles& F, Eigen::Index f) {
  return F(f, 0) != F(f, 1) && F(f, 1) != F(f, 2) && F(f, 2) != F(f, 0);
}

/// visit(std::span<const HalfEdge>) for every edge, in the order of its corners; faces with
/// repeated corners have none.
template <class Visit>
void for_each_edge(const Triangles& F, const Visit& visit) {
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(F.rows()) * 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (!has_three_corners(F, f)) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = F(f, k), b = F(f, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(f), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    visit(std::span<const HalfEdge>(edges.data() + i, end - i));
  }
}

}  // namespace skinfield
