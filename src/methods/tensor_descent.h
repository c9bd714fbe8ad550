// The optimisers that bring quasi-harmonic weights' tensors downhill.
#pragma once

#include "methods/quasi_harmonic_objective.h"
#include "skinfield/methods/quasi_harmonic.h"

namespace skinfield {

struct TensorDescent {
  QuasiHarmonicObjective::State best;  ///< of all parameters met
  SolveStats stats;                    ///< status, iterations, energy of the best, largest change
  std::vector<double> history;         ///< energies: [0] at the start, [k] after k steps
};

/// Steps from `theta` until a limit, the tolerance or the caller ends them.
/// @throws Cancelled
TensorDescent descend(QuasiHarmonicObjective& objective, const QuasiHarmonicOptions& options,
                      Eigen::MatrixXd theta, const Progress& progress);

}  // namespace skinfield
