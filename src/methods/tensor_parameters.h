// Tensors of bounded condition from free parameters (Wang and Solomon 2021, section 5.4).
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// A = scale (L L' + kappa (what the other rows of L hold) + epsilon I), with L the Cholesky factor
/// whose entries are a = 1/a', b = b'/a', c = c'/a', ... of the parameters: a row an element, the
/// columns a' b' c' (plane) or a' b' c' d' e' f' (space), in the paper's order.
struct TensorModel {
  double kappa = 0.2, epsilon = 1e-4;
  Vector scale;  ///< (elements) > 0
};

/// The parameters of A = a multiple of the identity.
Eigen::MatrixXd identity_parameters(Eigen::Index elements, int dimension);

/// A (elements, coefficients) in the order of anisotropic_stiffness.h. Parallel.
void tensors(const TensorModel& model, const Eigen::MatrixXd& theta, Eigen::MatrixXd& A);

/// The chain rule: D, a derivative by A's coefficients, becomes one by theta, in place.
void to_parameters(const TensorModel& model, const Eigen::MatrixXd& theta, Eigen::MatrixXd& D);

}  // namespace skinfield
