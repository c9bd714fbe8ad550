// The turns of the penalty: soft, stiff, soft, each soft one balanced by the one before.
#include "solve/alternation.h"
#include "solve/penalty.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {
constexpr double kBalanced = 0.8;                   // primal over dual residual
constexpr double kFarBelow = 0.3, kFarAbove = 3.3;  // imbalances that do not wait
}  // namespace

void Alternation::compare_residuals() {
  const double primal = distance(W_, Z_), dual = distance(Z_, previous_);
  if (!(primal > 0 && dual > 0)) return;
  log_ratio_ += std::log(primal / dual);
  ++ratios_;
  if (primal_.size() == 0) primal_ = dual_ = Vector::Zero(free_.rows());
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    const auto size = static_cast<Eigen::Index>(end - begin);
    primal_[i] += (W_.segment(begin, size) - Z_.segment(begin, size)).squaredNorm();
    dual_[i] += (Z_.segment(begin, size) - previous_.segment(begin, size)).squaredNorm();
  });
}

/// A soft penalty settles what lies far from the handles, a stiff one the rows where weights leave
/// zero; taking turns needs half the iterations of any one penalty, or of one raised step by step.
void Alternation::turn(int it) {
  if (!stiff_ && ratios_ > 0) balance();
  stiff_ = !stiff_;
  turn_at_ = it - 1 + (stiff_ ? kStiffTurn : kSoftTurn);
  raise_penalty(!stiff_ ? soft_ : turned_ ? kStiff : kFirstStiff);
  turned_ = turned_ || stiff_;
}

bool Alternation::far_off() const {
  const double factor = imbalance();
  return factor < kFarBelow || factor > kFarAbove;
}

double Alternation::imbalance() const {
  const double ratio = std::exp(log_ratio_ / ratios_) / kBalanced;
  // The first few iterations overrate it.
  return std::clamp(turned_ ? ratio * ratio : ratio, 0.2, 5.0);
}

/// Residual balancing (He, Yang, Wang 2000; Wohlberg 2017): all rows in the norm of the penalty,
/// then row by row. The former may go on for as many turns as a far-off scale takes.
void Alternation::balance() {
  const double factor = imbalance();
  if (!turned_ || factor > 2 || factor < 0.4) soft_ *= factor;
  balance_rows(free_, std::move(primal_), std::move(dual_), balance_);
  primal_ = dual_ = Vector();
  log_ratio_ = 0;
  ratios_ = 0;
}

void Alternation::raise_penalty(double factor) {
  Vector Z;
  project(S_, Z);
  const Vector before = d_;
  d_ = factor * first_.cwiseProduct(balance_);
  for_rows([&](Eigen::Index i, std::int64_t begin, std::int64_t end) {
    for (auto e = begin; e < end; ++e) {
      // S - Z is the multiplier divided by the penalty.
      S_[e] = Z[e] + (S_[e] - Z[e]) * (before[i] / d_[i]);
      weight_[e] = d_[i];
    }
  });
  factor_.factor(free_.Q, d_, storage_);
  anderson_.forget();
  shrink();
  checks_ = 0;
  moved_ = std::numeric_limits<double>::infinity();
}

}  // namespace skinfield
