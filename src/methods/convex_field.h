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
  double tolerance = 1e-2;      ///< largest change of the field's weights over a check's five steps
  double held_out_gain = 2e-4;  ///< stop where the held-out energy falls by less in a check's steps
  /// Asked before every step: true stops with status limit.
  std::function<bool()> stop;
  /// The field's weights (places,m) at places that stand for all: parameters beside handles and
  /// behind others may change much where that moves no weight. Empty: the parameters themselves.
  std::function<RowMatrix(const FloatRows& F)> probe;
};

/// Columns where `bound` is 0 stay zero. F is the start and the result; rows on the simplex
/// throughout. `eigenvalue`: of the level before, or 0; replaced. Stats: energy, iterations,
/// largest_change, status: converged if that is below the tolerance, else limit.
SolveStats minimise_convex(const FieldRows& rows, const FieldRows& held_out,
                           const std::vector<char>& bound, const ConvexOptions& options,
                           double& eigenvalue, FloatRows& F, const Progress& progress);

/// Energy, a lower bound of the minimum (Frank and Wolfe: E + sum_i min over the simplex of
/// <G_i, s - F_i>) and the relative gap.
void certify(const FieldRows& rows, const std::vector<char>& bound, const FloatRows& F,
             SolveStats& stats, const Progress& progress);

}  // namespace skinfield
