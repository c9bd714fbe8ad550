#include "skinfield/solve/adam.h"

#include "base/vector_clones.h"
#include "skinfield/base/parallel.h"

#include <cmath>
#include <limits>

namespace skinfield {
namespace {

struct Step {
  double keep_mean, keep_square, add_mean, add_square;
  double length, unbias_square, floor;
};

SKINFIELD_VECTOR_CLONES
void take(const Step& step, const double* __restrict gradient, double* __restrict mean,
          double* __restrict square, double* __restrict x, std::size_t count) {
  const Step s = step;
  for (std::size_t i = 0; i < count; ++i) {
    const double g = gradient[i];
    mean[i] = s.keep_mean * mean[i] + s.add_mean * g;
    square[i] = s.keep_square * square[i] + s.add_square * g * g;
    x[i] -= s.length * mean[i] / (std::sqrt(s.unbias_square * square[i]) + s.floor);
  }
}

}  // namespace

void Adam::step(const Eigen::MatrixXd& gradient, Eigen::MatrixXd& x) {
  if (gradient.size() == 0) return;
  if (steps_ == 0) {
    const double rms = std::sqrt(gradient.squaredNorm() / static_cast<double>(gradient.size()));
    floor_ = std::max(options_.epsilon * rms, std::numeric_limits<double>::min());
  }
  if (steps_ == 0) {
    mean_.setZero(gradient.rows(), gradient.cols());
    square_.setZero(gradient.rows(), gradient.cols());
  }
  ++steps_;
  ++since_restart_;
  const double b1 = options_.beta1, b2 = options_.beta2;
  // After a restart nothing is kept of the moments.
  const Step step{.keep_mean = since_restart_ == 1 ? 0 : b1,
                  .keep_square = since_restart_ == 1 ? 0 : b2,
                  .add_mean = 1 - b1,
                  .add_square = 1 - b2,
                  .length = rate_ / (1 - std::pow(b1, since_restart_)),
                  .unbias_square = 1 / (1 - std::pow(b2, since_restart_)),
                  .floor = floor_};
  parallel_blocks(static_cast<std::size_t>(gradient.size()), 8192,
                  [&](std::size_t begin, std::size_t end) {
                    take(step, gradient.data() + begin, mean_.data() + begin,
                         square_.data() + begin, x.data() + begin, end - begin);
                  });
  if (options_.restart > 0 && since_restart_ == options_.restart) {
    since_restart_ = 0;
    rate_ *= options_.decay;
  }
}

}  // namespace skinfield
