// A long box of tetrahedra with point handles spread along it.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "support/box_tets.h"

#include <algorithm>

namespace skinfield_test {

struct BoxCase {
  skinfield::Mesh mesh;
  skinfield::SparseRows K;
  skinfield::Vector M;
  skinfield::FixedRows fixed;

  explicit BoxCase(int m, int length = 12) : mesh(box_tets(length, 3, 3, 1.0 / length)) {
    K = skinfield::stiffness(mesh.V, mesh.T);
    M = skinfield::barycentric_mass(mesh.V, mesh.T);
    for (int h = 0; h < m; ++h) {
      const int i = length * h / std::max(1, m - 1);
      fixed.node.push_back((i * 4 + 1) * 4 + 1 + h % 2);
    }
    fixed.weights = skinfield::RowMatrix::Identity(m, m);
  }
  skinfield::BoundedBiharmonicProblem problem() const { return {K, M, fixed}; }
};

}  // namespace skinfield_test
