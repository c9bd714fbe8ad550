#include "methods/smooth_projection.h"

#include <algorithm>

namespace skinfield {
namespace {

constexpr double kEnd = 1e-4;  // epsilon_2; epsilon_1 is 0
constexpr double kInverse = 1 / kEnd;

// Equation 20 with epsilon_1 = 0: -x^3 / e^2 + 2 x^2 / e, beyond e the line. Without branches.
inline double threshold(double x) {
  const double c = std::clamp(x, 0.0, kEnd);
  return c * c * kInverse * (2 - c * kInverse) + std::max(x - kEnd, 0.0);
}

inline double slope(double x) {
  const double c = std::clamp(x, 0.0, kEnd);
  return c * kInverse * (4 - 3 * c * kInverse);
}

}  // namespace

void project_smoothly(double* w, Eigen::Index m) {
  double sum = 0;
  for (Eigen::Index j = 0; j < m; ++j) sum += w[j] = threshold(w[j]);
  const double scale = 1 / sum;
  for (Eigen::Index j = 0; j < m; ++j) w[j] *= scale;
}

void project_smoothly_adjoint(const double* w, double* g, Eigen::Index m) {
  double sum = 0, mean = 0;
  for (Eigen::Index j = 0; j < m; ++j) {
    const double f = threshold(w[j]);
    sum += f;
    mean += f * g[j];
  }
  mean /= sum;
  const double scale = 1 / sum;
  for (Eigen::Index j = 0; j < m; ++j) g[j] = slope(w[j]) * (g[j] - mean) * scale;
}

}  // namespace skinfield
