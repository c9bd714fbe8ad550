// Weights that stay smooth when every vertex keeps only a few influences: choose which, then solve
// again for them, so that a column fades to zero where it may no longer be used instead of being
// cut off.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"

#include <vector>

namespace skinfield {

struct SupportOptions {
  int influences = 4;  ///< k >= 1 columns a vertex
  /// A node may use a column that is among the k largest at this share of the vertices that it
  /// is interpolated to (by their interpolation weights); 1 = at all of them.
  double agreement = 0.9;
};

/// (N) columns that each node may use. P (n,N) interpolates nodal weights W (N,m) to vertices.
/// A node's largest column is always allowed; nodes of no vertex may use every column.
std::vector<std::vector<int>> kept_support(const RowMatrix& W, const SparseRows& P,
                                           const SupportOptions& options = {});

/// The problem solved again on kept_support(), warm started from W = the full solution's weights.
/// `options` are those of the full solution; its start and support are replaced (locked columns
/// are taken from W, which holds them). Fixed rows keep their weights whatever the support.
BoundedBiharmonicResult resolve_on_support(const BoundedBiharmonicProblem& problem,
                                           const RowMatrix& W, const SparseRows& P,
                                           const SupportOptions& support = {},
                                           BoundedBiharmonicOptions options = {},
                                           const Progress& progress = {});

}  // namespace skinfield
