// What holds of the solution that the alternation ends with.
#include "solve/alternation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {
constexpr int kCertifySteps = 5, kCertifyRounds = 4;
constexpr double kSmallGap = 1e-4;  // relative: good enough a certificate
}  // namespace

void Alternation::full_step(const RowMatrix& S, RowMatrix& Z, RowMatrix& W) {
  progress_.check();
  free_.project(S, Z);
  W = d_.asDiagonal() * (2 * Z - S) + free_.R;
  factor_.solve(W);
}

bool Alternation::complete() {
  RowMatrix Z, W;
  full_step(full(S_), Z, W);
  ColumnSets missed(free_.rows(), free_.columns());
  double outside = 0;
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    for (int j = 0; j < W.cols(); ++j) {
      if (std::abs(W(i, j)) <= 0.5 * options_.tolerance || sets_.has(i, j)) continue;
      outside = std::max(outside, std::abs(W(i, j)));
      missed.add(i, j);
    }
  }
  if (outside <= options_.tolerance) return true;
  ColumnSets more = around(missed, 1);
  more.join(sets_);
  anderson_.remap(reactivate(std::move(more)));
  return false;
}

double Alternation::certify(double energy) {
  RowMatrix S = full(S_), Z, W;
  // L := D (2Z - S - W), which is Q W - R where (Q + D) W = D (2Z - S) + R holds. One step of
  // refinement brings back the digits that single-precision panels cost.
  const auto bound = [&] {
    const auto multipliers = [&](const RowMatrix& at) -> RowMatrix {
      return d_.asDiagonal() * (2 * Z - S - at);
    };
    RowMatrix correction = multipliers(W) - free_.gradient(W);
    factor_.solve(correction);
    const RowMatrix refined = W + correction;
    return free_.lower_bound(refined, multipliers(refined));
  };
  // Entries outside the active rows have no multipliers yet; plain steps build them up.
  double lower = -std::numeric_limits<double>::infinity();
  for (int round = 0; round < kCertifyRounds; ++round) {
    for (int k = 0; k < (round == 0 ? 1 : kCertifySteps); ++k) {
      full_step(S, Z, W);
      S += kRelaxation * (W - Z);
    }
    full_step(S, Z, W);
    const double gap = energy - lower;
    lower = std::max(lower, bound());
    if (energy - lower < kSmallGap * std::abs(energy) || energy - lower > 0.5 * gap) break;
  }
  return lower;
}

}  // namespace skinfield
