#include "methods/smooth_projection.h"

#include "base/vector_clones.h"
#include "base/vector_lanes.h"

#include <algorithm>

namespace skinfield {
namespace {

constexpr double kEnd = threshold_end;
constexpr double kInverse = 1 / kEnd;

// Equation 20 with epsilon_1 = 0: -x^3 / e^2 + 2 x^2 / e, beyond e the line. Without branches.
SKINFIELD_INLINE double threshold(double x) {
  const double c = std::clamp(x, 0.0, kEnd);
  return c * c * kInverse * (2 - c * kInverse) + std::max(x - kEnd, 0.0);
}

SKINFIELD_INLINE double slope(double x) {
  const double c = std::clamp(x, 0.0, kEnd);
  return c * kInverse * (4 - 3 * c * kInverse);
}

/// Sums in four strands, which the compiler keeps in one register.
SKINFIELD_INLINE double total(const double (&strand)[4]) {
  return (strand[0] + strand[1]) + (strand[2] + strand[3]);
}

}  // namespace

SKINFIELD_VECTOR_CLONES
void project_smoothly(double* w, Eigen::Index m) {
  for (Eigen::Index j = 0; j < m; ++j) w[j] = threshold(w[j]);
  double sums[4] = {};
  Eigen::Index j = 0;
  for (; j + 4 <= m; j += 4) {
    for (Eigen::Index q = 0; q < 4; ++q) sums[q] += w[j + q];
  }
  double sum = total(sums);
  for (; j < m; ++j) sum += w[j];
  const double scale = 1 / sum;
  for (j = 0; j < m; ++j) w[j] *= scale;
}

SKINFIELD_VECTOR_CLONES
void project_smoothly_adjoint(const double* __restrict w, double* __restrict g, Eigen::Index m) {
  double sums[4] = {}, means[4] = {};
  Eigen::Index j = 0;
  for (; j + 4 <= m; j += 4) {
    for (Eigen::Index q = 0; q < 4; ++q) {
      const double f = threshold(w[j + q]);
      sums[q] += f;
      means[q] += f * g[j + q];
    }
  }
  double sum = total(sums), mean = total(means);
  for (; j < m; ++j) {
    const double f = threshold(w[j]);
    sum += f;
    mean += f * g[j];
  }
  mean /= sum;
  const double scale = 1 / sum;
  for (j = 0; j < m; ++j) g[j] = slope(w[j]) * (g[j] - mean) * scale;
}

}  // namespace skinfield
