// A projection of rows onto the simplex that has a derivative everywhere
// (Wang and Solomon 2021, section 5.5).
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// p(w): each entry through a smooth threshold that is 0 below 0 and leaves entries above 1e-4
/// alone (equation 20), then the row divided by its sum (equation 21). In place; a row of m
/// entries, of which at least one is above 1e-4.
void project_smoothly(double* w, Eigen::Index m);
/// g, a derivative by p(w), becomes the derivative by w. w: before the projection.
void project_smoothly_adjoint(const double* w, double* g, Eigen::Index m);

}  // namespace skinfield
