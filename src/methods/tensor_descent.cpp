#include "methods/tensor_descent.h"

#include "methods/smooth_projection.h"
#include "skinfield/solve/adam.h"
#include "skinfield/solve/lbfgs.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace skinfield {
namespace {

constexpr double kLeastParameter = 0.01;  // of a' = 1/a, whose pole at 0 steps must not cross
constexpr int kLbfgsMemory = 10;          // the paper's
constexpr int kNoLimit = std::numeric_limits<int>::max();

/// What every optimiser shares: when to stop, and the record.
class Watch {
 public:
  Watch(const QuasiHarmonicOptions& options, const Progress& progress, TensorDescent& result)
      : options_(options), progress_(progress), result_(result) {
    result_.stats.status = SolveStats::Status::limit;
    result_.stats.energy = std::numeric_limits<double>::infinity();
  }

  /// Whether the step that led to this energy is the last one.
  bool ends_at(double energy, const RowMatrix& weights) {
    const auto k = static_cast<int>(result_.history.size());
    progress_.check();
    progress_("weights", static_cast<double>(k) / std::max(1, options_.max_iterations));
    result_.history.push_back(energy);
    SolveStats& stats = result_.stats;
    stats.iterations = k;
    if (k % options_.round == 0) {
      if (k > 0) {
        const double last = result_.history[static_cast<std::size_t>(k - options_.round)];
        // A round that made it worse says nothing: the next one takes smaller steps.
        if (options_.tolerance > 0 && std::abs(last - energy) <= options_.tolerance * energy) {
          stats.status = SolveStats::Status::converged;
        }
        stats.largest_change = (weights - round_begin_).cwiseAbs().maxCoeff();
      }
      round_begin_ = weights;
    }
    return stats.status == SolveStats::Status::converged || k >= options_.max_iterations || late();
  }

  /// Hands the objective's state to the result if it is the best yet.
  void keep_if_best(double energy, QuasiHarmonicObjective& objective) {
    if (!(energy < result_.stats.energy)) return;
    result_.stats.energy = energy;
    objective.exchange(result_.best);
  }

 private:
  bool late() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    return options_.time_limit_s > 0 && passed.count() > options_.time_limit_s;
  }

  const QuasiHarmonicOptions& options_;
  const Progress& progress_;
  TensorDescent& result_;
  RowMatrix round_begin_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Takes `steps` steps, or fewer; whether there may be more.
bool descend_adam(QuasiHarmonicObjective& objective, const AdamOptions& options, int steps,
                  Eigen::MatrixXd& theta, Watch& watch) {
  Adam adam(options);
  Eigen::MatrixXd gradient;
  while (adam.steps() < steps) {
    const double energy = objective.evaluate(theta);
    const bool last = watch.ends_at(energy, objective.state().weights);
    if (!last) objective.gradient(theta, gradient);
    watch.keep_if_best(energy, objective);
    if (last) return false;
    adam.step(gradient, theta);
    theta.col(0) = theta.col(0).cwiseMax(kLeastParameter);
  }
  return true;
}

/// @param bounded end where the weights that are solved for leave the simplex: past that, energy is
/// saved by negative weights, and taking them out makes extrema.
void descend_lbfgs(QuasiHarmonicObjective& objective, int max_iterations, bool bounded,
                   const Eigen::MatrixXd& start, TensorDescent& result, Watch& watch,
                   const Progress& progress) {
  // Relative to the start, so that units matter neither for the first step's length nor for when
  // L-BFGS takes an energy for a minimum.
  double unit = 0;
  bool outside = false;
  Eigen::MatrixXd gradient;
  const auto matrix = [&](const Vector& x) {
    return Eigen::Map<const Eigen::MatrixXd>(x.data(), start.rows(), start.cols());
  };
  const LbfgsObjective f = [&](const Vector& x, Vector& g) {
    progress.check();
    Eigen::MatrixXd theta = matrix(x);
    if (!theta.allFinite()) return std::numeric_limits<double>::infinity();
    // Inside the function: a refused step would hold all elements up at the first that is there.
    theta.col(0) = theta.col(0).cwiseMax(kLeastParameter);
    const double energy = objective.evaluate(theta);
    objective.gradient(theta, gradient);
    gradient.col(0) = (theta.col(0).array() > kLeastParameter).select(gradient.col(0), 0.0);
    const bool first = unit == 0;
    if (first) unit = energy > 0 ? energy : 1;
    g = gradient.reshaped() / unit;
    if (bounded && (first || energy < result.stats.energy) &&
        objective.state().solved.minCoeff() < -threshold_end) {
      outside = true;
    }
    if (first || !outside) watch.keep_if_best(energy, objective);
    return energy / unit;
  };
  LbfgsOptions options;
  options.memory = kLbfgsMemory;
  options.max_iterations = max_iterations;
  options.gradient_tolerance = 0;
  minimise_lbfgs(f, start.reshaped(), options, [&](const LbfgsState& state) {
    return watch.ends_at(state.value * unit, result.best.weights) || outside;
  });
}

}  // namespace

TensorDescent descend(QuasiHarmonicObjective& objective, const QuasiHarmonicOptions& options,
                      Eigen::MatrixXd theta, const Progress& progress) {
  TensorDescent result;
  Watch watch(options, progress, result);
  AdamOptions adam;
  adam.rate = options.rate;
  adam.beta1 = options.momentum;
  if (options.optimiser != TensorOptimiser::adam) adam.restart = options.round;
  const int adam_steps = options.optimiser == TensorOptimiser::lbfgs        ? 0
                         : options.optimiser == TensorOptimiser::adam_lbfgs ? options.adam_steps
                                                                            : kNoLimit;
  if (descend_adam(objective, adam, adam_steps, theta, watch)) {
    const int left = std::max(0, options.max_iterations - adam_steps);
    const bool bounded = options.optimiser == TensorOptimiser::adam_lbfgs;
    descend_lbfgs(objective, left, bounded, theta, result, watch, progress);
  }
  return result;
}

}  // namespace skinfield
