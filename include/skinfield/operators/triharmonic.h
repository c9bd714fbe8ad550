// The triharmonic energy of a lumped-mass discretisation.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// K M^-1 K M^-1 K, the energy of the gradient of the Laplacian (Jacobson, Tosun, Sorkine, Zorin
/// 2010, "Mixed finite elements for variational surface modeling", section 4). K (N,N) symmetric,
/// compressed, both triangles stored; M (N) > 0. The result has both triangles, is symmetric to
/// the last bit, sorted, and stores its diagonal. Its condition grows as h^-6.
SparseRows triharmonic(const SparseRows& K, const Vector& M);

}  // namespace skinfield
