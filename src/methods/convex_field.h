// The convex solver of geometric fields: minimise 1/2 |A F + C|^2 with every row of F on the
// simplex, by projected gradient with a diagonal majorant, acceleration (Nesterov; Beck and
// Teboulle 2009) and adaptive restart (O'Donoghue and Candes 2015).
#pragma once

#include "methods/field_rows.h"
#include "skinfield/solve/simplex_qp.h"

#include <functional>

namespace skinfield {

struct ConvexOptions {
  int max_steps = 30;
  double tolerance = 1e-3;      ///< largest change of a weight over a check's steps
  double held_out_gain = 2e-3;  ///< stop where the held-out energy falls by less in a check's steps
  /// Asked before every step: true stops with status limit.
  std::function<bool()> stop;
};

/// Columns where `bound` is 0 stay zero. F is the start and the result; rows on the simplex
/// throughout. `eigenvalue`: of the level before, or 0; replaced. Stats: energy, status,
/// iterations, largest_change.
SolveStats minimise_convex(const FieldRows& rows, const FieldRows& held_out,
                           const std::vector<char>& bound, const ConvexOptions& options,
                           double& eigenvalue, FloatRows& F, const Progress& progress);

/// Energy, a lower bound of the minimum (Frank and Wolfe: E + sum_i min over the simplex of
/// <G_i, s - F_i>) and the relative gap.
void certify(const FieldRows& rows, const std::vector<char>& bound, const FloatRows& F,
             SolveStats& stats, const Progress& progress);

}  // namespace skinfield
