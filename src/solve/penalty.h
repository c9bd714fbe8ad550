// Per-node penalties of the alternating directions.
#pragma once

#include "solve/free_rows.h"

namespace skinfield {

/// (n) > 0 from the local energy density of the start X (n,m) of the free rows (findings.md B): a
/// penalty in proportion to the mass alone fails on slivers.
/// landscape: (n) the solution of Q u = M, or empty. 1 / |u| estimates the local lowest eigenvalue
/// of Q (Filoche and Mayboroda 2012, "Universal mechanism for Anderson and weak localization"): a
/// long limb that no bone reaches bends so softly that a floor from the mean density holds it fast.
Vector local_penalty(const SimplexProblem& problem, const FreeRows& free, const RowMatrix& X,
                     const RowMatrix& Z, const Vector& landscape);

/// Residual balancing row by row: multiplies `scale` (n) so that the rows' primal and dual
/// residuals, squared sums of a turn smoothed over the neighbours in Q, come nearer to the ratio
/// aimed at. At most tenfold a turn and in all.
void balance_rows(const FreeRows& free, Vector primal, Vector dual, Vector& scale);

}  // namespace skinfield
