// A Laplacian on the graph of another, whose harmonic functions have no local extrema.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// Links of K's graph, never below a thousandth of the mean: (n,n) with values > 0 off the diagonal
/// and row sums zero, so that its harmonic functions have no extrema at free nodes.
SparseRows positive_links(const SparseRows& K);

}  // namespace skinfield
