// Which tetrahedron holds a point: a bounding-volume hierarchy.
#pragma once

#include "skinfield/base/types.h"

#include <array>
#include <vector>

namespace skinfield {

using Barycentric = Eigen::Vector4d;

/// Barycentric coordinates of x in the tet of these corners, inverted or not; not finite where it
/// has no volume.
Barycentric barycentric_in(const std::array<Vec3, 4>& corner, const Vec3& x);

/// Immutable; thread-safe for queries. Deterministic.
class TetLocator {
 public:
  struct Place {
    int tet = -1;  ///< -1: in none
    Barycentric b = Barycentric::Zero();
  };

  TetLocator(const Points& V, const Tetrahedra& T);

  /// Calls visit(tet) for every tet whose box, grown by `margin`, holds x.
  template <class Visit>
  void candidates(const Vec3& x, double margin, const Visit& visit) const {
    std::array<int, 64> stack{};  // medians: the depth is below 32
    int open = 0;
    if (!nodes_.empty()) stack[open++] = 0;
    while (open > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(stack[--open])];
      if (((x - node.low).array() < -margin).any() || ((node.high - x).array() < -margin).any()) {
        continue;
      }
      if (node.second > 0) {
        stack[open++] = node.second;
        stack[open++] = static_cast<int>(&node - nodes_.data()) + 1;
        continue;
      }
      for (int i = node.begin; i < node.end; ++i) visit(order_[static_cast<std::size_t>(i)]);
    }
  }

  /// The tet that x lies deepest in; of equals, the first. A point on a corner gets exactly it.
  Place find(const Vec3& x) const;

 private:
  struct Node {
    Vec3 low, high;
    int begin, end;  // of order_
    int second;      // the second child; the first follows its parent; 0: a leaf
  };
  int build(int begin, int end);
  std::array<Vec3, 4> corners(int tet) const;

  Points V_;
  Tetrahedra T_;
  std::vector<int> order_;
  std::vector<Vec3> low_, high_;  // of each tet, while building
  std::vector<Node> nodes_;
};

}  // namespace skinfield
