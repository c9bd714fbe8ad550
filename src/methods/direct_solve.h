// Linear systems with given rows: the methods that need no bounds while they solve.
#pragma once

#include "skinfield/solve/simplex_qp.h"

namespace skinfield {

struct DirectSolution {
  RowMatrix X;       ///< (n,m) the fixed rows included
  SolveStats stats;  ///< all but the energies; largest_change is the last refinement's
};

/// X with the fixed rows given and (A X - B)_i = 0 on all others. A (n,n) symmetric, positive
/// definite on the free nodes; B (n,m), or empty for zero. One factor for all columns, and steps
/// of iterative refinement until they change nothing.
/// @throws SolveError if A is not positive definite on the free nodes.
DirectSolution solve_with_fixed_rows(const SparseRows& A, const RowMatrix& B,
                                     const FixedRows& fixed, const Progress& progress);

}  // namespace skinfield
