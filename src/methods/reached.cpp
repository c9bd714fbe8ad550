#include "methods/reached.h"

namespace skinfield {

namespace {

NodeSubset subset_of(const std::vector<char>& wanted) {
  NodeSubset subset;
  subset.position.assign(wanted.size(), -1);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) {
      subset.left_out.push_back(static_cast<int>(i));
      continue;
    }
    subset.position[i] = static_cast<int>(subset.node.size());
    subset.node.push_back(static_cast<int>(i));
  }
  return subset;
}

}  // namespace

NodeSubset reached_nodes(const SparseRows& A, const std::vector<int>& seeds) {
  std::vector<char> found(static_cast<std::size_t>(A.rows()), 0);
  std::vector<int> stack = seeds;
  for (const int v : stack) found[static_cast<std::size_t>(v)] = 1;
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    for (SparseRows::InnerIterator it(A, v); it; ++it) {
      char& seen = found[static_cast<std::size_t>(it.col())];
      if (seen || it.value() == 0) continue;
      seen = 1;
      stack.push_back(static_cast<int>(it.col()));
    }
  }
  return subset_of(found);
}

NodeSubset free_nodes(Eigen::Index n, const std::vector<int>& fixed) {
  std::vector<char> wanted(static_cast<std::size_t>(n), 1);
  for (const int v : fixed) wanted[static_cast<std::size_t>(v)] = 0;
  return subset_of(wanted);
}

SparseRows restrict_to(const SparseRows& A, const NodeSubset& subset) {
  const auto n = static_cast<Eigen::Index>(subset.node.size());
  SparseRows part(n, n);
  part.reserve(A.nonZeros());
  for (Eigen::Index i = 0; i < n; ++i) {
    part.startVec(i);
    for (SparseRows::InnerIterator it(A, subset.node[static_cast<std::size_t>(i)]); it; ++it) {
      const int j = subset.position[static_cast<std::size_t>(it.col())];
      if (j >= 0) part.insertBack(i, j) = it.value();
    }
  }
  part.finalize();
  return part;
}

}  // namespace skinfield
