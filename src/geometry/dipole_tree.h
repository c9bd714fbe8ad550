// A hierarchy of dipoles with second-order Taylor expansions of their field.
//
// The field at x of dipole density n dA at y is n.(y-x) / D^(3/2), D = |y-x|^2 + e^2 (e = 0: the
// winding number's kernel, times 4 pi). It is a derivative of -D^(-1/2), so that its derivatives
// are symmetric and only the symmetric parts of the moments about a cluster's centre c matter
// (s = y - c; Barill et al. 2018, section 3, with the symmetry used):
//   N = sum n,  E = sum sym(n s),  S = sum sym(n s s).
// With R = c - x:
//   field = N.R D^(-3/2) + tr E D^(-3/2) - 3 E(R,R) D^(-5/2)
//           + 1/2 (-9 tr S.R D^(-5/2) + 15 S(R,R,R) D^(-7/2)).
#pragma once

#include "skinfield/base/types.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skinfield {

class DipoleTree {
 public:
  /// xxx yyy zzz xxy xxz xyy yyz xzz yzz xyz of a symmetric tensor.
  using Cubic = std::array<double, 10>;

  struct Item {
    Vec3 position;  ///< a triangle's centroid, or the point
    Vec3 dipole;    ///< area times unit normal
    int number;     ///< row in the input
  };

  struct Node {
    Vec3 centre;
    double far2;  ///< squared distance from which the expansion serves
    Vec3 N;
    std::array<double, 6> E;  ///< xx yy zz xy xz yz
    Cubic S;
    int begin, end;  ///< its items
    int next;        ///< the node after its subtree; children follow their parent
    bool leaf;
    bool is_leaf() const { return leaf; }
  };

  /// Triangles without area and such with non-finite corners are left out.
  DipoleTree(const Points& V, const Triangles& F, double accuracy);
  DipoleTree(const Points& P, const Points& N, const Vector& area, double accuracy);

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Item>& items() const { return items_; }

  /// Adds the expansions of far clusters to `far` and calls near(node) for the leaves in between.
  /// With e2 > 0 the items count as points at their positions.
  template <class Near>
  void walk(const Vec3& x, double e2, double& far, const Near& near) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const Vec3 R = node.centre - x;
      const double D = R.squaredNorm() + e2;
      if (D > node.far2) {
        far += expansion(node, e2 > 0 ? point_S_[n] : node.S, R, D);
        n = static_cast<std::size_t>(node.next);
      } else if (node.leaf) {
        near(n);
        ++n;
      } else {
        ++n;
      }
    }
  }

  /// The direct sum over a leaf's items as points.
  double leaf_sum(std::size_t n, const Vec3& x, double e2) const {
    double sum = 0;
    for (int i = nodes_[n].begin; i < nodes_[n].end; ++i) {
      const Vec3 r = items_[i].position - x;
      const double D = r.squaredNorm() + e2;
      if (D > 0) sum += items_[i].dipole.dot(r) / (D * std::sqrt(D));
    }
    return sum;
  }

 private:
  static double expansion(const Node& node, const Cubic& S, const Vec3& R, double D) {
    const auto& E = node.E;
    const double x = R[0], y = R[1], z = R[2], inv = 1 / D;
    const double square = E[0] * x * x + E[1] * y * y + E[2] * z * z +
                          2 * (E[3] * x * y + E[4] * x * z + E[5] * y * z);
    const double trace =
        (S[0] + S[5] + S[7]) * x + (S[1] + S[3] + S[8]) * y + (S[2] + S[4] + S[6]) * z;
    const double cube = x * x * (S[0] * x + 3 * (S[3] * y + S[4] * z)) +
                        y * y * (S[1] * y + 3 * (S[5] * x + S[6] * z)) +
                        z * z * (S[2] * z + 3 * (S[7] * x + S[8] * y)) + 6 * S[9] * x * y * z;
    return inv * std::sqrt(inv) *
           (node.N.dot(R) + E[0] + E[1] + E[2] -
            inv * (3 * square + 4.5 * trace - 7.5 * inv * cube));
  }

  /// Fills nodes_ and orders items_; corners: `per_item` rows of `corner` an item.
  void build(const Points& corners, int per_item, double accuracy, const std::vector<Cubic>& own_S);

  std::vector<Item> items_;
  std::vector<Node> nodes_;
  std::vector<Cubic> point_S_;  // S without the items' own extent
};

}  // namespace skinfield
