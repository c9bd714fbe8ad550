// Which nodes the fixed rows can speak for, and the problem cut down to them.
#pragma once

#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

/// Some of the nodes, numbered in ascending order.
struct NodeSubset {
  std::vector<int> node;      ///< at each position of the subset
  std::vector<int> position;  ///< of each node, -1: not in it
  std::vector<int> left_out;  ///< the other nodes, ascending
};

/// Nodes that a path of A's graph joins to one of `seeds`.
NodeSubset reached_nodes(const SparseRows& A, const std::vector<int>& seeds);
/// Nodes 0..n-1 but `fixed`.
NodeSubset free_nodes(Eigen::Index n, const std::vector<int>& fixed);

/// The rows and columns of A that are in the subset.
SparseRows restrict_to(const SparseRows& A, const NodeSubset& subset);

}  // namespace skinfield
