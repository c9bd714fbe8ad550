// The symbolic half of the supernodal Cholesky: ordering, elimination tree, supernodes.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// Columns [first, first + width) of L that share one row structure.
struct Supernode {
  int first = 0, width = 0;
  int parent = -1;            ///< supernode that receives the update, -1 for roots
  std::vector<int> rows;      ///< below the columns, ascending
  std::vector<int> children;  ///< ascending
  /// Where a forward solve puts the updates of `rows`: rows of the subtree themselves, rows above
  /// it in the subtree's own spare rows, so that subtrees run in parallel.
  std::vector<int> target;
  std::size_t offset = 0;  ///< of the (width + rows) x width row-major panel in L's values
  int size() const { return width + static_cast<int>(rows.size()); }
};

struct SupernodalStructure {
  std::vector<int> old_of_new, new_of_old;  ///< fill-reducing, postordered
  std::vector<Supernode> nodes;             ///< children before parents
  std::vector<int> subtrees;  ///< roots of disjoint subtrees of comparable work, ascending
  std::vector<int> begin;     ///< (subtrees) first supernode of each: [begin, root] is the subtree
  std::vector<int> top;       ///< the supernodes above them, ascending
  /// (subtrees + 1) first spare row of each, from n on: one for each of its root's `rows`.
  std::vector<int> spare;
  std::size_t values = 0;  ///< entries of all panels
};

/// A: symmetric pattern, both triangles stored. Supernodes relaxed as in Ashcraft and Grimes 1989.
/// order: A's rows, first eliminated first.
SupernodalStructure analyse_supernodes(const SparseRows& A, std::vector<int> order);
/// The order with the smaller factor: minimum degree, or nested dissection where the factor is so
/// large that the search pays.
SupernodalStructure analyse_supernodes(const SparseRows& A);

}  // namespace skinfield
