#include "skinfield/solve/lbfgs.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace skinfield {
namespace {

/// Sums of Rosenbrock's valley over consecutive pairs.
double rosenbrock(const Vector& x, Vector& g) {
  double f = 0;
  g.setZero();
  for (Eigen::Index i = 0; i + 1 < x.size(); i += 2) {
    const double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
    f += 100 * a * a + b * b;
    g[i] = -400 * a * x[i] - 2 * b;
    g[i + 1] = 200 * a;
  }
  return f;
}

Vector valley(Eigen::Index n) {
  Vector x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = i % 2 == 0 ? -1.2 : 1.0;
  return x;
}

TEST(Lbfgs, RosenbrocksValley) {
  for (const int n : {2, 100}) {
    LbfgsOptions options;
    options.gradient_tolerance = 1e-9;
    const LbfgsResult result = minimise_lbfgs(rosenbrock, valley(n), options);
    EXPECT_EQ(result.status, LbfgsResult::Status::converged);
    EXPECT_LT((result.x.array() - 1).abs().maxCoeff(), 1e-8);
    EXPECT_LT(result.iterations, 80);
    EXPECT_LT(result.evaluations, 2 * result.iterations);
    EXPECT_LE(result.gradient, 1e-9);
  }
}

/// 1/2 sum d_i (x_i - c_i)^2, d from 1 to `condition`.
struct Quadratic {
  Vector d, c;
  Quadratic(Eigen::Index n, double condition) : d(n), c(n) {
    Random random(3);
    for (Eigen::Index i = 0; i < n; ++i) {
      d[i] = std::pow(condition, static_cast<double>(i) / static_cast<double>(n - 1));
      c[i] = random.normal();
    }
  }
  LbfgsObjective objective() const {
    return [this](const Vector& x, Vector& g) {
      g = d.cwiseProduct(x - c);
      return 0.5 * g.dot(x - c);
    };
  }
};

TEST(Lbfgs, Quadratics) {
  const Quadratic q(50, 1e4);
  LbfgsOptions options;
  options.gradient_tolerance = 1e-8;
  const LbfgsResult few = minimise_lbfgs(q.objective(), Vector::Zero(50), options);
  EXPECT_EQ(few.status, LbfgsResult::Status::converged);
  EXPECT_LT((few.x - q.c).cwiseAbs().maxCoeff(), 1e-8);
  // With room for every direction it comes close to conjugate gradients' n steps.
  options.memory = 60;
  const LbfgsResult all = minimise_lbfgs(q.objective(), Vector::Zero(50), options);
  EXPECT_LT((all.x - q.c).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT(all.iterations, few.iterations);
  options.memory = 1;
  options.max_iterations = 20000;
  const LbfgsResult one = minimise_lbfgs(q.objective(), Vector::Zero(50), options);
  EXPECT_LT((one.x - q.c).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Lbfgs, ValuesNeverRiseAndAreSeen) {
  std::vector<double> values;
  int last = -1;
  const LbfgsObserver observer = [&](const LbfgsState& state) {
    EXPECT_EQ(state.iteration, ++last);
    Vector g(state.x.size());
    EXPECT_EQ(rosenbrock(state.x, g), state.value);
    EXPECT_TRUE(g == state.g);
    EXPECT_EQ(g.cwiseAbs().maxCoeff(), state.gradient);
    values.push_back(state.value);
    return state.iteration == 12;
  };
  const LbfgsResult result = minimise_lbfgs(rosenbrock, valley(10), {}, observer);
  EXPECT_EQ(result.status, LbfgsResult::Status::stopped);
  EXPECT_EQ(result.iterations, 12);
  ASSERT_EQ(values.size(), 13u);
  for (std::size_t k = 1; k < values.size(); ++k) EXPECT_LT(values[k], values[k - 1]);
}

TEST(Lbfgs, StopsAsToldTo) {
  LbfgsOptions options;
  options.max_iterations = 3;
  EXPECT_EQ(minimise_lbfgs(rosenbrock, valley(2), options).status, LbfgsResult::Status::limit);
  options.max_iterations = 1000;
  options.gradient_tolerance = 0;
  options.value_tolerance = 1e-3;
  const LbfgsResult loose = minimise_lbfgs(rosenbrock, valley(2), options);
  EXPECT_EQ(loose.status, LbfgsResult::Status::converged);
  EXPECT_GT(loose.gradient, 1e-9);
  // Nothing to gain from rounding alone.
  options.value_tolerance = 0;
  const LbfgsResult exact = minimise_lbfgs(rosenbrock, valley(2), options);
  EXPECT_LT((exact.x.array() - 1).abs().maxCoeff(), 1e-7);
  EXPECT_LT(exact.iterations, 1000);
}

TEST(Lbfgs, BacksOutOfWhatIsNotFinite) {
  // -log has no value left of zero; the first step from a steep start would go there.
  const LbfgsObjective f = [](const Vector& x, Vector& g) {
    g[0] = 40 - 1 / x[0];
    return x[0] > 0 ? 40 * x[0] - std::log(x[0]) : std::numeric_limits<double>::quiet_NaN();
  };
  const LbfgsResult result = minimise_lbfgs(f, Vector::Constant(1, 0.2));
  EXPECT_NEAR(result.x[0], 1.0 / 40, 1e-6);
  EXPECT_THROW(minimise_lbfgs(f, Vector::Constant(1, -1.0)), SolveError);
  LbfgsOptions options;
  options.memory = 0;
  EXPECT_THROW(minimise_lbfgs(f, Vector::Constant(1, 0.2), options), SolveError);
}

TEST(Lbfgs, WrongGradientsStall) {
  const LbfgsObjective uphill = [](const Vector& x, Vector& g) {
    g = -x;
    return 0.5 * x.squaredNorm();
  };
  const LbfgsResult result = minimise_lbfgs(uphill, Vector::Constant(3, 2.0));
  EXPECT_EQ(result.status, LbfgsResult::Status::stalled);
  EXPECT_EQ(result.value, 6.0);
}

TEST(Lbfgs, SameBytesAtAnyThreadCount) {
  const Quadratic q(20000, 1e3);
  LbfgsOptions options;
  options.max_iterations = 25;
  Vector x[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    x[threads - 1] = minimise_lbfgs(q.objective(), Vector::Zero(20000), options).x;
  }
  EXPECT_TRUE(x[0] == x[1]);
}

}  // namespace
}  // namespace skinfield
