// Biharmonic energies under bounds along edges: one factor for all columns.
#pragma once

#include "methods/monotone_order.h"
#include "skinfield/base/progress.h"
#include "skinfield/base/types.h"
#include "skinfield/solve/simplex_qp.h"
#include "skinfield/solve/sparse_factor.h"

#include <cstdint>
#include <vector>

namespace skinfield {

struct MonotoneProgram {
  const SparseRows& K;               ///< (n,n) connected to fixed nodes
  const Vector& M;                   ///< (n)
  const FixedRows& fixed;            ///< (k,m)
  std::vector<MonotoneOrder> order;  ///< (m)
  bool coupled = true;               ///< rows sum to 1
  double tolerance = 1e-3;
  int max_iterations = 400;
  double time_limit_s = 0;
};

struct MonotoneSolution {
  RowMatrix W;  ///< (n,m) within a millionth of the bounds
  SolveStats stats;
};

/// minimise 1/2 tr(W' K M^-1 K W) subject to the orders' bounds and the fixed rows. Alternating
/// directions over differences along edges (Boyd et al. 2011, section 5): W <- a solve with the
/// one factor of Q + R, R a Laplacian of positive links; differences <- their projections.
MonotoneSolution solve_monotone(const MonotoneProgram& program, const Progress& progress = {});

}  // namespace skinfield
