#include "skinfield/solve/adam.h"

#include "skinfield/base/parallel.h"

#include <cmath>
#include <limits>

namespace skinfield {

void Adam::step(const Eigen::MatrixXd& gradient, Eigen::MatrixXd& x) {
  if (gradient.size() == 0) return;
  if (steps_ == 0) {
    const double rms = std::sqrt(gradient.squaredNorm() / static_cast<double>(gradient.size()));
    floor_ = std::max(options_.epsilon * rms, std::numeric_limits<double>::min());
  }
  if (since_restart_ == 0) {
    mean_.setZero(gradient.rows(), gradient.cols());
    square_.setZero(gradient.rows(), gradient.cols());
  }
  ++steps_;
  ++since_restart_;
  const double b1 = options_.beta1, b2 = options_.beta2;
  const double unbias1 = 1 / (1 - std::pow(b1, since_restart_));
  const double unbias2 = 1 / (1 - std::pow(b2, since_restart_));
  const double step = rate_ * unbias1, floor = floor_;
  const auto size = static_cast<std::size_t>(gradient.size());
  parallel_blocks(size, 8192, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Eigen::Index>(begin);
    const auto count = static_cast<Eigen::Index>(end - begin);
    const auto part = [&](auto& A) { return Eigen::Map<Eigen::ArrayXd>(A.data() + first, count); };
    const Eigen::Map<const Eigen::ArrayXd> g(gradient.data() + first, count);
    auto mean = part(mean_), square = part(square_), to = part(x);
    mean = b1 * mean + (1 - b1) * g;
    square = b2 * square + (1 - b2) * g.square();
    to -= step * mean / ((unbias2 * square).sqrt() + floor);
  });
  if (options_.restart > 0 && since_restart_ == options_.restart) {
    since_restart_ = 0;
    rate_ *= options_.decay;
  }
}

}  // namespace skinfield
