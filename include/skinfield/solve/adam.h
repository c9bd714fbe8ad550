// Adam with restarts: gradient steps for parameters of very different scales.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

struct AdamOptions {
  double rate = 0.1;     ///< a step moves a parameter by about this much
  double beta1 = 0.9;    ///< memory of the mean
  double beta2 = 0.999;  ///< memory of the square
  /// Gradients below this share of the first gradient's root mean square count as none.
  double epsilon = 1e-8;
  int restart = 0;     ///< every so many steps the moments are forgotten; 0: never
  double decay = 0.5;  ///< and the rate is multiplied by this
};

/// Kingma and Ba 2014, algorithm 1, with the restarts of Wang and Solomon 2021, section 6.1.
/// `epsilon` is relative, so that the units of the objective do not matter. Parallel,
/// deterministic.
class Adam {
 public:
  explicit Adam(const AdamOptions& options = {}) : options_(options), rate_(options.rate) {}
  /// x -= step. gradient and x have the same size at every call.
  void step(const Eigen::MatrixXd& gradient, Eigen::MatrixXd& x);
  int steps() const { return steps_; }
  double rate() const { return rate_; }  ///< of the next step

 private:
  AdamOptions options_;
  double rate_;
  double floor_ = 0;  ///< epsilon in the gradient's units
  int steps_ = 0, since_restart_ = 0;
  Eigen::MatrixXd mean_, square_;
};

}  // namespace skinfield
