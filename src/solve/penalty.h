// Per-node penalties of the alternating directions.
#pragma once

#include "solve/free_rows.h"

namespace skinfield {

/// (n) > 0 from the local energy density of the start X (n,m) of the free rows (findings.md B): a
/// penalty in proportion to the mass alone fails on slivers.
Vector local_penalty(const SimplexProblem& problem, const FreeRows& free, const RowMatrix& X,
                     const RowMatrix& Z);

}  // namespace skinfield
