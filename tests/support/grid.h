// Weights' programs on a grid with graph Laplacians: no meshes, no files.
#pragma once

#include "skinfield/base/random.h"
#include "skinfield/solve/simplex_qp.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace skinfield_test {

/// The 7-point Laplacian of s^3 nodes with link weights between 0.5 and 1.5.
inline skinfield::SparseRows grid_laplacian(int s) {
  std::vector<Eigen::Triplet<double>> entries;
  skinfield::Random random(1);
  const auto id = [&](int i, int j, int k) { return (i * s + j) * s + k; };
  const auto link = [&](int a, int b) {
    const double w = 0.5 + random.uniform();
    entries.emplace_back(a, a, w);
    entries.emplace_back(b, b, w);
    entries.emplace_back(a, b, -w);
    entries.emplace_back(b, a, -w);
  };
  for (int i = 0; i < s; ++i) {
    for (int j = 0; j < s; ++j) {
      for (int k = 0; k < s; ++k) {
        if (i + 1 < s) link(id(i, j, k), id(i + 1, j, k));
        if (j + 1 < s) link(id(i, j, k), id(i, j + 1, k));
        if (k + 1 < s) link(id(i, j, k), id(i, j, k + 1));
      }
    }
  }
  skinfield::SparseRows K(s * s * s, s * s * s);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

/// s^3 nodes, m columns, each fixed to 1 at one node; Q = K M^-1 K.
inline skinfield::SimplexProblem grid_program(int s, int m) {
  skinfield::SimplexProblem p;
  const int n = s * s * s;
  p.K = grid_laplacian(s);
  skinfield::Random random(4);
  p.M.resize(n);
  for (double& mass : p.M) mass = 0.5 + random.uniform();
  p.Q = p.K * p.M.cwiseInverse().asDiagonal() * p.K;
  p.Q = 0.5 * (p.Q + skinfield::SparseRows(p.Q.transpose()));
  p.Q.makeCompressed();
  p.columns = m;
  while (static_cast<int>(p.fixed.node.size()) < m) {
    const int v = static_cast<int>(random.below(static_cast<std::uint32_t>(n)));
    if (std::count(p.fixed.node.begin(), p.fixed.node.end(), v) == 0) p.fixed.node.push_back(v);
  }
  std::sort(p.fixed.node.begin(), p.fixed.node.end());
  p.fixed.weights = skinfield::RowMatrix::Identity(m, m);
  return p;
}

}  // namespace skinfield_test
