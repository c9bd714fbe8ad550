#include "skinfield/solve/adam.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

/// The distance from the minimum of a badly scaled quadratic after some steps.
double distance_after(int steps, const AdamOptions& options, double units = 1) {
  Eigen::MatrixXd x = Eigen::MatrixXd::Constant(3, 2, 1), gradient;
  Eigen::MatrixXd scale(3, 2);
  scale << 1e-3, 1, 1e3, 10, 1e-2, 5;
  Adam adam(options);
  for (int k = 0; k < steps; ++k) {
    gradient = units * scale.cwiseProduct(x);
    adam.step(gradient, x);
  }
  EXPECT_EQ(adam.steps(), steps);
  return x.cwiseAbs().maxCoeff();
}

TEST(Adam, FirstStepMovesByTheRate) {
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(2, 1), gradient(2, 1);
  gradient << 1e-3, -50;
  Adam adam;
  adam.step(gradient, x);
  EXPECT_NEAR(x(0), -0.1, 1e-4);
  EXPECT_NEAR(x(1), 0.1, 1e-4);
}

TEST(Adam, RestartsWithHalfTheRateConverge) {
  AdamOptions plain, customised;
  customised.restart = 4;
  EXPECT_LT(distance_after(400, plain), 1e-2);
  // Steps sum to about 4 (0.1 + 0.05 + ...): far enough from 0.5, never beyond 0.86.
  Eigen::MatrixXd x = Eigen::MatrixXd::Constant(1, 1, 2), gradient(1, 1);
  Adam adam(customised);
  for (int k = 0; k < 60; ++k) {
    gradient = x;
    adam.step(gradient, x);
  }
  EXPECT_NEAR(x(0), 2 - 0.8, 0.1);
  EXPECT_NEAR(adam.rate(), 0.1 / (1 << 15), 1e-12);
}

TEST(Adam, DoesNotCareForUnits) {
  AdamOptions options;
  options.restart = 4;
  EXPECT_NEAR(distance_after(12, options, 1e-12), distance_after(12, options), 1e-12);
  EXPECT_NEAR(distance_after(12, options, 1e12), distance_after(12, options), 1e-12);
}

TEST(Adam, IgnoresParametersThatDoNotMatter) {
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(2, 1), gradient(2, 1);
  gradient << 0, 1;
  Adam adam;
  adam.step(gradient, x);
  EXPECT_EQ(x(0), 1);
  gradient.setZero();
  Adam resting;
  resting.step(gradient, x);
  EXPECT_EQ(x(0), 1);
}

}  // namespace
}  // namespace skinfield
