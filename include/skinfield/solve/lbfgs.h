// Limited-memory BFGS for smooth functions of many variables, without constraints.
#pragma once

#include "skinfield/base/types.h"

#include <functional>

namespace skinfield {

struct LbfgsOptions {
  int memory = 10;  ///< pairs of steps and gradient changes, at least 1
  int max_iterations = 1000;
  double gradient_tolerance = 1e-6;  ///< stop when no entry of the gradient is larger
  /// Stop when a step lowers f by less than this share of max(|f|, 1); 0: never.
  double value_tolerance = 0;
};

/// What an observer sees after every iteration (and before the first, as iteration 0).
struct LbfgsState {
  int iteration = 0;
  double value = 0;
  double gradient = 0;  ///< largest entry, absolute
  const Vector& x;
  const Vector& g;
};

struct LbfgsResult {
  enum class Status {
    converged,  ///< the gradient or the decrease fell below its tolerance
    stopped,    ///< by the observer
    limit,      ///< of iterations
    stalled,    ///< no step lowers f any further: rounding, or a wrong gradient
  };
  Status status = Status::limit;
  Vector x;
  double value = 0;
  double gradient = 0;
  int iterations = 0, evaluations = 0;
};

/// f at x; fills g (as long as x). A value that is not finite shortens the step.
using LbfgsObjective = std::function<double(const Vector& x, Vector& g)>;
/// True: stop here.
using LbfgsObserver = std::function<bool(const LbfgsState&)>;

/// Nocedal and Wright 2006, algorithm 7.5, with a strong Wolfe line search (algorithms 3.5, 3.6).
/// The two loops run on inner products of the stored vectors (Chen, Wang and Zhou 2014,
/// "Large-scale L-BFGS using MapReduce"), so that every iteration passes over the memory twice.
/// Deterministic at any thread count.
/// @throws SolveError if f is not finite at the start, or memory < 1.
LbfgsResult minimise_lbfgs(const LbfgsObjective& f, Vector x, const LbfgsOptions& options = {},
                           const LbfgsObserver& observer = {});

}  // namespace skinfield
