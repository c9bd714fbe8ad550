// Random weights on the simplex and small meshes.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/weights/operations.h"

#include <cmath>
#include <cstdint>

namespace skinfield_test {

inline double hash_unit(std::uint64_t k) {
  k = (k + 1) * 0x9E3779B97F4A7C15ull;
  k = (k ^ (k >> 29)) * 0xBF58476D1CE4E5B9ull;
  return static_cast<double>((k ^ (k >> 32)) >> 11) / 9007199254740992.0;
}

/// About half of the entries are zero; rows sum to 1.
inline skinfield::SkinWeights random_weights(int n, int m, std::uint64_t seed) {
  skinfield::RowMatrix W = skinfield::RowMatrix::Zero(n, m);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const auto k =
          (seed * 1000003u + static_cast<std::uint64_t>(i)) * 1009u + static_cast<std::uint64_t>(j);
      W(i, j) = std::max(0.0, hash_unit(k) - 0.5);
    }
    W(i, i % m) += 0.1;
    W.row(i) /= W.row(i).sum();
  }
  return skinfield::sparse_weights(W);
}

inline double largest_row_error(const skinfield::SkinWeights& weights) {
  const skinfield::RowMatrix W = skinfield::dense_weights(weights);
  return (W.rowwise().sum().array() - 1).abs().maxCoeff();
}

/// A (k x k) grid of vertices over [-1,1]^2, symmetric in x; vertex (a,b) is a * k + b, x by a.
inline skinfield::Mesh grid_mesh(int k) {
  skinfield::Mesh mesh;
  mesh.V.resize(k * k, 3);
  for (int a = 0; a < k; ++a) {
    for (int b = 0; b < k; ++b) {
      mesh.V.row(a * k + b) << (2.0 * a - (k - 1)) / (k - 1), (2.0 * b - (k - 1)) / (k - 1), 0;
    }
  }
  mesh.F.resize(2 * (k - 1) * (k - 1), 3);
  int f = 0;
  for (int a = 0; a + 1 < k; ++a) {
    for (int b = 0; b + 1 < k; ++b) {
      mesh.F.row(f++) << a * k + b, (a + 1) * k + b, (a + 1) * k + b + 1;
      mesh.F.row(f++) << a * k + b, (a + 1) * k + b + 1, a * k + b + 1;
    }
  }
  return mesh;
}

}  // namespace skinfield_test
