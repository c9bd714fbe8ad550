// Exact bounded biharmonic weights by a primal active-set method: the classic reference, for small
// meshes (solve/active_set.h). It runs to optimality with partition of unity in the problem; what
// other tools call active set (8 iterations, bounds only) is DecoupledSolver::active_set.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/solve/active_set.h"

#include <vector>

namespace skinfield {

struct BoundedBiharmonicActiveSetOptions {
  ActiveSetOptions active_set;  ///< when to stop; its start is replaced by the one below
  RowMatrix start;              ///< (N,m) warm start and the values of locked columns, or empty
  std::vector<int> locked;      ///< columns kept from `start`
  FixedRows paint;              ///< more fixed rows; they win over the problem's
};

/// Locks, paint and errors as bounded_biharmonic.
BoundedBiharmonicResult bounded_biharmonic_active_set(
    const BoundedBiharmonicProblem& problem, const BoundedBiharmonicActiveSetOptions& options = {},
    const Progress& progress = {});

}  // namespace skinfield
