// The biharmonic energy of a lumped-mass discretisation.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// Q = K M^-1 K, the mixed discretisation of the Laplacian energy (Jacobson, Tosun, Sorkine, Zorin
/// 2010, "Mixed finite elements for variational surface modeling", section 4). K (N,N) symmetric,
/// compressed, both triangles stored; M (N) > 0. The result has both triangles, is symmetric to
/// the last bit, sorted, and stores its diagonal. Parallel, deterministic.
SparseRows biharmonic(const SparseRows& K, const Vector& M);

/// The same energy with natural boundaries: only nodes off the boundary count, sum (K w)_i^2 / M_i.
/// The stiffness's rows at the boundary hold the flux through it, and are what makes minimisers of
/// biharmonic() have zero normal derivatives (Stein, Grinspun, Wardetzky, Jacobson 2018, "Natural
/// boundary conditions for smoothing in geometry processing", section 3). Every discrete harmonic
/// function has zero energy: only solvers that regularise (solve/simplex_dual.h with constraints)
/// take it. boundary: node indices.
SparseRows natural_biharmonic(const SparseRows& K, const Vector& M,
                              const std::vector<int>& boundary);

}  // namespace skinfield
