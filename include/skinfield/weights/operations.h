// What one does to skinning weights: normalise, prune, between dense and sparse.
// All functions are deterministic at any thread count and leave their arguments alone.
#pragma once

#include "skinfield/weights/skin_weights.h"

namespace skinfield {

/// Rows of a dense matrix (n,m), entries of magnitude <= `drop` left out (NaN stays). `names` is
/// (m) or empty. Throws InputError if it is neither.
SkinWeights sparse_weights(const RowMatrix& W, std::vector<std::string> names = {},
                           double drop = 0);
/// (n,m), zeros where there is no entry.
RowMatrix dense_weights(const SkinWeights& weights);

struct Normalised {
  SkinWeights weights;
  Eigen::Index removed = 0;     ///< negative or non-finite entries that were set to zero
  std::vector<int> empty_rows;  ///< rows without anything positive: they stay empty
};
/// Negative and non-finite entries become zero, every row that has anything left sums to 1.
Normalised normalise(const SkinWeights& weights);

/// (n,k) what `data` (m,k) says for each column, spread by the weights: every row a mean of data's
/// rows. Weights are normalised first.
/// Throws InputError if the sizes differ or a row has no weights.
RowMatrix interpolate(const SkinWeights& weights, const RowMatrix& data);

struct PruneOptions {
  int max_influences = 0;  ///< entries a row may keep; 0 = any number
  double epsilon = 0;      ///< entries below this share of their row go
};
struct Pruned {
  SkinWeights weights;
  double mean_mass = 0;  ///< mean over rows of the share of the row that was cut
  double max_mass = 0;
  Eigen::Index rows_cut = 0;  ///< rows that lost something
};
/// Keeps each row's largest entries (of equal ones those of lower columns) and renormalises; a
/// row's largest entry is never cut. Precondition: entries finite and >= 0 (`normalise`).
/// Throws InputError if max_influences < 0 or epsilon is not in [0,1].
Pruned prune(const SkinWeights& weights, const PruneOptions& options);

}  // namespace skinfield
