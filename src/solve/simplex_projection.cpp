#include "skinfield/solve/simplex_qp.h"

#include <algorithm>

namespace skinfield {

void project_to_simplex(double* w, int m, double s) {
  if (m <= 0) return;
  if (!(s > 0)) {
    std::fill(w, w + m, 0.0);
    return;
  }
  // Michelot's active set: the threshold only rises, each pass drops at least one entry, and so
  // m passes are enough; the cap holds whatever rounding does.
  double threshold = 0;
  for (int j = 0; j < m; ++j) threshold += w[j];
  threshold = (threshold - s) / m;
  int active = m;
  for (int pass = 0; pass < m; ++pass) {
    double sum = 0;
    int count = 0;
    for (int j = 0; j < m; ++j) {
      const bool in = w[j] > threshold;
      sum += in ? w[j] : 0.0;
      count += in;
    }
    if (count == 0 || count == active) break;
    active = count;
    threshold = (sum - s) / count;
  }
  double total = 0;
  for (int j = 0; j < m; ++j) {
    w[j] = w[j] > threshold ? w[j] - threshold : 0.0;
    total += w[j];
  }
  // Large inputs leave rounding in the sum: one rescaling makes the row exact to the last bits.
  if (total > 0) {
    const double scale = s / total;
    for (int j = 0; j < m; ++j) w[j] *= scale;
  } else {
    std::fill(w, w + m, s / m);
  }
}

void project_to_box(double* w, int m, double s) {
  for (int j = 0; j < m; ++j) w[j] = std::clamp(w[j], 0.0, std::max(s, 0.0));
}

}  // namespace skinfield
