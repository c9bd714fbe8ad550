// The solving half of the supernodal Cholesky.
#pragma once

#include "base/large_array.h"
#include "skinfield/solve/active_rows.h"
#include "solve/supernodes.h"

namespace skinfield {

/// values := the active entries of A^-1 B, where B is `values` on `active` and zero elsewhere.
/// L: the panels of the factor, as Panel has them. Supernodes carry only the columns that reach
/// them from below, in chunks of kChunk. Subtrees run in parallel, then the supernodes above them
/// in strips of columns. `space` is for reuse: fresh memory costs as much as a small solve.
void solve_supernodal(const SupernodalStructure& structure, const double* L,
                      const ActiveRows& active, double* values, LargeArray<double>& space);
void solve_supernodal(const SupernodalStructure& structure, const float* L,
                      const ActiveRows& active, double* values, LargeArray<double>& space);

}  // namespace skinfield
