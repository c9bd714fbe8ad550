#include "methods/handle_distance.h"

#include "domain/kd_tree.h"
#include "methods/reached.h"
#include "skinfield/base/parallel.h"
#include "skinfield/solve/sparse_factor.h"

#include <cmath>

namespace skinfield {

Vector straight_distance(const Points& centres, const Points& V, const std::vector<int>& nodes) {
  Points sites(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    sites.row(static_cast<Eigen::Index>(k)) = V.row(nodes[k]);
  }
  const KdTree tree(sites);
  Vector distance(centres.rows());
  parallel_blocks(
      static_cast<std::size_t>(centres.rows()), 1024, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbour> found;
        for (auto e = static_cast<Eigen::Index>(begin); e < static_cast<Eigen::Index>(end); ++e) {
          tree.nearest(centres.row(e).transpose(), 1, found);
          distance[e] = found.front().distance;
        }
      });
  return distance;
}

Vector heat_distance(const AnisotropicStiffness& stiffness, const Vector& M, double edge,
                     const std::vector<int>& nodes) {
  const SparseRows& K = stiffness.isotropic();
  SparseRows graph = K;
  graph.coeffs().setOnes();
  NodeSubset open = reached_nodes(graph, nodes);
  // The handles' nodes are given, the rest is solved for: they leave the reached ones.
  for (const int v : nodes) open.position[static_cast<std::size_t>(v)] = -1;
  std::vector<int> rest;
  for (const int v : open.node) {
    int& position = open.position[static_cast<std::size_t>(v)];
    if (position < 0) continue;
    position = static_cast<int>(rest.size());
    rest.push_back(v);
  }
  open.node = rest;
  const SparseRows free_K = restrict_to(K, open);
  const auto n = static_cast<Eigen::Index>(rest.size());
  SparseFactor factor;
  factor.analyse(free_K);

  // Step 1: heat that the handles hold at 1 spreads for a short time.
  const double time = edge * edge;
  Vector shift(n);
  RowMatrix x(n, 1);
  Vector heat = Vector::Zero(K.rows());
  for (const int v : nodes) heat[v] = 1;
  const Vector from_handles = K * heat;
  for (Eigen::Index i = 0; i < n; ++i) {
    shift[i] = M[rest[static_cast<std::size_t>(i)]] / time;
    x(i, 0) = -from_handles[rest[static_cast<std::size_t>(i)]];
  }
  factor.factor(free_K, shift);
  factor.solve(x);
  for (Eigen::Index i = 0; i < n; ++i) heat[rest[static_cast<std::size_t>(i)]] = x(i, 0);

  // Step 2: distance rises against the heat's gradient, at rate 1 everywhere.
  Points direction = stiffness.gradient(heat);
  for (Eigen::Index e = 0; e < direction.rows(); ++e) {
    const double norm = direction.row(e).stableNorm();  // heat decays to tiny values
    direction.row(e) *= norm > 0 && std::isfinite(norm) ? -1 / norm : 0.0;
  }

  // Step 3: the function that has these gradients, as nearly as may be.
  const Vector divergence = stiffness.divergence(direction);
  for (Eigen::Index i = 0; i < n; ++i) x(i, 0) = divergence[rest[static_cast<std::size_t>(i)]];
  factor.factor(free_K);
  factor.solve(x);
  Vector distance = Vector::Zero(K.rows());
  for (Eigen::Index i = 0; i < n; ++i) {
    distance[rest[static_cast<std::size_t>(i)]] = std::max(0.0, x(i, 0));
  }
  return distance;
}

}  // namespace skinfield
