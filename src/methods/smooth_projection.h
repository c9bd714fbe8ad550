// A projection of rows onto the simplex that has a derivative everywhere
// (Wang and Solomon 2021, section 5.5).
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// Entries above this pass the threshold as they are (epsilon_2; epsilon_1 is 0).
constexpr double threshold_end = 1e-4;

/// p(w): each entry through a smooth threshold that is 0 below 0 and leaves entries above
/// threshold_end alone (equation 20), then the row divided by its sum (equation 21). In place; a
/// row of m entries, of which at least one is above threshold_end.
void project_smoothly(double* w, Eigen::Index m);
/// g, a derivative by p(w), becomes the derivative by w. w: before the projection.
void project_smoothly_adjoint(const double* w, double* g, Eigen::Index m);

}  // namespace skinfield
