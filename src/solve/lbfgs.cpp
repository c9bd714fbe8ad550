#include "skinfield/solve/lbfgs.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace skinfield {
namespace {

constexpr std::size_t kEntriesPerBlock = 2048;  // a few of them stay in the first cache
constexpr double kDecrease = 1e-4;              // of the Wolfe conditions: c1
constexpr double kCurvature = 0.9;              // c2
constexpr int kMaxTrials = 30;                  // of one line search
constexpr double kLeastCurvature = 1e-14;       // of |s| |y|: pairs below it are left out

template <class Part>
double reduce(Eigen::Index n, const Part& part, bool largest = false) {
  return parallel_reduce(
      static_cast<std::size_t>(n), kEntriesPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        return part(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
      },
      [largest](double a, double b) { return largest ? std::max(a, b) : a + b; });
}

double dot(const Vector& a, const Vector& b) {
  return reduce(a.size(), [&](Eigen::Index at, Eigen::Index count) {
    return a.segment(at, count).dot(b.segment(at, count));
  });
}

double largest(const Vector& a) {
  return reduce(
      a.size(),
      [&](Eigen::Index at, Eigen::Index count) {
        return a.segment(at, count).cwiseAbs().maxCoeff();
      },
      true);
}

/// The pairs s, y and the products that the two loops need.
class Memory {
 public:
  explicit Memory(int capacity)
      : capacity_(static_cast<std::size_t>(capacity)),
        sy_(Eigen::MatrixXd::Zero(capacity, capacity)),
        yy_(Eigen::MatrixXd::Zero(capacity, capacity)) {}

  void forget() {
    s_.clear();
    y_.clear();
    next_ = 0;
  }

  void add(Vector s, Vector y) {
    if (s_.size() < capacity_) {
      s_.emplace_back();
      y_.emplace_back();
    }
    const std::size_t slot = next_;
    next_ = (next_ + 1) % capacity_;
    s_[slot] = std::move(s);
    y_[slot] = std::move(y);
    // Columns: s_a y_new, s_new y_a, y_a y_new.
    const Eigen::MatrixXd products =
        products_with(s_[slot].size(), 3, [&](std::size_t a, Eigen::Index at, Eigen::Index count) {
          return Eigen::RowVector3d(s_[a].segment(at, count).dot(y_[slot].segment(at, count)),
                                    s_[slot].segment(at, count).dot(y_[a].segment(at, count)),
                                    y_[a].segment(at, count).dot(y_[slot].segment(at, count)));
        });
    const auto k = static_cast<Eigen::Index>(slot);
    for (Eigen::Index a = 0; a < products.rows(); ++a) {
      sy_(a, k) = products(a, 0);
      sy_(k, a) = products(a, 1);
      yy_(a, k) = yy_(k, a) = products(a, 2);
    }
  }

  /// -H g.
  Vector direction(const Vector& g) const {
    const auto filled = static_cast<Eigen::Index>(s_.size());
    if (filled == 0) return -g;
    const Eigen::MatrixXd with_g =
        products_with(g.size(), 2, [&](std::size_t a, Eigen::Index at, Eigen::Index count) {
          return Eigen::RowVector2d(s_[a].segment(at, count).dot(g.segment(at, count)),
                                    y_[a].segment(at, count).dot(g.segment(at, count)));
        });
    // q = g - sum_a alpha_a y_a, then r = gamma q + sum_a (alpha_a - beta_a) s_a.
    Vector alpha = Vector::Zero(filled), beta = Vector::Zero(filled);
    const auto newest_first = [&](Eigen::Index step) {
      return (static_cast<Eigen::Index>(next_) + 2 * filled - 1 - step) % filled;
    };
    for (Eigen::Index step = 0; step < filled; ++step) {
      const Eigen::Index a = newest_first(step);
      alpha[a] = (with_g(a, 0) - sy_.row(a).head(filled).dot(alpha)) / sy_(a, a);
    }
    const Eigen::Index newest = newest_first(0);
    const double gamma = sy_(newest, newest) / yy_(newest, newest);
    Vector shares = Vector::Zero(filled);
    for (Eigen::Index step = filled; step-- > 0;) {
      const Eigen::Index a = newest_first(step);
      beta[a] = (gamma * (with_g(a, 1) - yy_.row(a).head(filled).dot(alpha)) +
                 sy_.col(a).head(filled).dot(shares)) /
                sy_(a, a);
      shares[a] = alpha[a] - beta[a];
    }
    Vector p(g.size());
    parallel_blocks(static_cast<std::size_t>(g.size()), kEntriesPerBlock,
                    [&](std::size_t begin, std::size_t end) {
                      const auto at = static_cast<Eigen::Index>(begin);
                      const auto count = static_cast<Eigen::Index>(end - begin);
                      p.segment(at, count) = -gamma * g.segment(at, count);
                      for (Eigen::Index a = 0; a < filled; ++a) {
                        const auto slot = static_cast<std::size_t>(a);
                        p.segment(at, count) += gamma * alpha[a] * y_[slot].segment(at, count) -
                                                shares[a] * s_[slot].segment(at, count);
                      }
                    });
    return p;
  }

 private:
  /// Sums part(a, block) over the blocks, a row for every stored pair.
  template <class Part>
  Eigen::MatrixXd products_with(Eigen::Index n, int width, const Part& part) const {
    const auto rows = static_cast<Eigen::Index>(s_.size());
    return parallel_reduce(
        static_cast<std::size_t>(n), kEntriesPerBlock,
        Eigen::MatrixXd(Eigen::MatrixXd::Zero(rows, width)),
        [&](std::size_t begin, std::size_t end) {
          Eigen::MatrixXd sum(rows, width);
          for (Eigen::Index a = 0; a < rows; ++a) {
            sum.row(a) = part(static_cast<std::size_t>(a), static_cast<Eigen::Index>(begin),
                              static_cast<Eigen::Index>(end - begin));
          }
          return sum;
        },
        [](Eigen::MatrixXd a, const Eigen::MatrixXd& b) {
          a += b;
          return a;
        });
  }

  std::size_t capacity_, next_ = 0;
  std::vector<Vector> s_, y_;  ///< rings
  Eigen::MatrixXd sy_, yy_;    ///< <s_a, y_b>, <y_a, y_b> of the filled slots
};

/// A point on the line x + t p.
struct Trial {
  double t = 0, value = 0, slope = 0;
};

/// The minimiser of the cubic through two values and slopes, kept well inside the interval.
double between(const Trial& a, const Trial& b) {
  const double d1 = a.slope + b.slope - 3 * (a.value - b.value) / (a.t - b.t);
  const double square = d1 * d1 - a.slope * b.slope;
  double t = 0.5 * (a.t + b.t);
  if (square >= 0 && std::isfinite(square)) {
    const double d2 = std::copysign(std::sqrt(square), b.t - a.t);
    const double cubic = b.t - (b.t - a.t) * (b.slope + d2 - d1) / (b.slope - a.slope + 2 * d2);
    if (std::isfinite(cubic)) t = cubic;
  }
  const double low = std::min(a.t, b.t), width = std::abs(b.t - a.t);
  return std::clamp(t, low + 0.1 * width, low + 0.9 * width);
}

class Search {
 public:
  Search(const LbfgsObjective& f, const Vector& x, const Vector& p, int& evaluations)
      : f_(f), x_(x), p_(p), evaluations_(evaluations) {}

  /// Whether a point that lowers f was found: it is `point`, with its value and gradient.
  bool run(double value, double slope, double first) {
    const Trial start{0, value, slope};
    Trial low = start, high;
    bool bracketed = false;
    double t = first;
    for (int trial = 0; trial < kMaxTrials; ++trial) {
      const Trial now = at(t);
      if (!std::isfinite(now.value) || !std::isfinite(now.slope)) {
        high = {t, std::numeric_limits<double>::infinity(), 0};
        bracketed = true;
      } else if (now.value >= value || now.value > value + kDecrease * t * slope ||
                 (low.t > 0 && now.value >= low.value)) {
        high = now;
        bracketed = true;
      } else {
        keep(now);
        if (std::abs(now.slope) <= -kCurvature * slope) return true;
        if (bracketed ? now.slope * (high.t - low.t) >= 0 : now.slope >= 0) {
          high = low;
          bracketed = true;
        }
        low = now;
      }
      if (!bracketed) {
        t *= 4;
      } else if (!std::isfinite(high.value)) {
        t = low.t + 0.1 * (high.t - low.t);
      } else {
        t = between(low, high);
      }
      if (bracketed && std::abs(high.t - low.t) <= 1e-12 * std::max(high.t, low.t)) break;
    }
    return kept_;
  }

  Vector point, gradient;
  Trial best;

 private:
  Trial at(double t) {
    trial_x_ = x_ + t * p_;
    trial_g_.resize(x_.size());
    ++evaluations_;
    Trial trial{t, f_(trial_x_, trial_g_), 0};
    trial.slope = dot(trial_g_, p_);
    return trial;
  }
  void keep(const Trial& trial) {
    kept_ = true;
    best = trial;
    point.swap(trial_x_);
    gradient.swap(trial_g_);
  }

  const LbfgsObjective& f_;
  const Vector& x_;
  const Vector& p_;
  int& evaluations_;
  Vector trial_x_, trial_g_;
  bool kept_ = false;
};

}  // namespace

LbfgsResult minimise_lbfgs(const LbfgsObjective& f, Vector x, const LbfgsOptions& options,
                           const LbfgsObserver& observer) {
  if (options.memory < 1) throw SolveError("a memory below 1", "L-BFGS");
  LbfgsResult result;
  Vector g(x.size());
  result.value = f(x, g);
  ++result.evaluations;
  if (!std::isfinite(result.value) || !g.allFinite()) {
    throw SolveError("the function is not finite at the start", "L-BFGS");
  }
  result.gradient = largest(g);
  Memory memory(options.memory);
  bool fresh = true;  // no pair is stored: the length of a step is unknown
  const auto stop = [&] {
    return observer && observer({result.iterations, result.value, result.gradient, x, g});
  };
  using Status = LbfgsResult::Status;
  if (stop()) {
    result.status = Status::stopped;
  } else {
    while (true) {
      if (result.gradient <= options.gradient_tolerance) {
        result.status = Status::converged;
        break;
      }
      if (result.iterations >= options.max_iterations) break;
      Vector p = memory.direction(g);
      double slope = dot(g, p);
      if (!(slope < 0)) {
        memory.forget();
        fresh = true;
        p = -g;
        slope = -dot(g, g);
      }
      Search search(f, x, p, result.evaluations);
      const double first = fresh ? std::min(1.0, 1 / std::sqrt(-slope)) : 1.0;
      if (!search.run(result.value, slope, first)) {
        // A direction spoilt by rounding: once more along the gradient.
        if (fresh) {
          result.status = Status::stalled;
          break;
        }
        memory.forget();
        fresh = true;
        continue;
      }
      Vector s = search.point - x, y = search.gradient - g;
      const double curvature = dot(s, y);
      if (curvature > kLeastCurvature * std::sqrt(dot(s, s) * dot(y, y))) {
        memory.add(std::move(s), std::move(y));
        fresh = false;
      }
      const double before = result.value;
      x.swap(search.point);
      g.swap(search.gradient);
      result.value = search.best.value;
      result.gradient = largest(g);
      ++result.iterations;
      if (stop()) {
        result.status = Status::stopped;
        break;
      }
      const double scale = std::max({std::abs(before), std::abs(result.value), 1.0});
      if (before - result.value <= options.value_tolerance * scale && options.value_tolerance > 0) {
        result.status = Status::converged;
        break;
      }
    }
  }
  result.x = std::move(x);
  return result;
}

}  // namespace skinfield
