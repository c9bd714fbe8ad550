// The weights' energy on a face of the row simplices.
#pragma once

#include "solve/free_rows.h"

namespace skinfield {

/// The step from Z to the minimiser of the energy over the points whose zeros are those of Z
/// (negative entries allowed): rows of zero sum. Each row's largest entry follows from the others.
/// G = Q Z - R.
RowMatrix face_step(const FreeRows& free, const RowMatrix& Z, const RowMatrix& G);

}  // namespace skinfield
