#include "methods/convex_field.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr int check_every = 5;
constexpr int first_powers = 12, later_powers = 4;
constexpr double eigenvalue_margin = 1.05;  // power iterations come from below

}  // namespace

SolveStats minimise_convex(const FieldRows& rows, const FieldRows& held_out,
                           const std::vector<char>& bound, const ConvexOptions& options,
                           double& eigenvalue, FloatRows& F, const Progress& progress) {
  const Eigen::Index n = F.rows(), m = F.cols();
  std::vector<int> column;
  for (std::size_t j = 0; j < bound.size(); ++j)
    if (bound[j]) column.push_back(static_cast<int>(j));
  Vector D = rows.majorant();
  // Points that no row uses do not move.
  const double least = 1e-9 * std::max(D.maxCoeff(), 1e-300);
  D = D.cwiseMax(least);
  Vector v(n);
  for (Eigen::Index i = 0; i < n; ++i)
    v[i] = Random(1, static_cast<std::uint64_t>(i)).uniform() - 0.5;
  const double estimate =
      rows.largest_eigenvalue(D, eigenvalue > 0 ? later_powers : first_powers, v, progress);
  eigenvalue = std::min(1.0, std::max(estimate, eigenvalue));
  const double step = 1 / std::min(1.0, eigenvalue_margin * eigenvalue);

  SolveStats stats;
  stats.status = SolveStats::Status::limit;
  FloatRows Y = F, G;
  double t = 1, held = held_out.energy(F, nullptr, progress);
  FloatRows best = F;
  const auto probe = [&]() -> RowMatrix {
    return options.probe ? options.probe(F) : RowMatrix(F.cast<double>());
  };
  RowMatrix checked = probe();
  double best_held = held;
  for (int k = 0; k < options.max_steps; ++k) {
    if (options.stop && options.stop()) break;
    stats.energy = rows.energy(Y, &G, progress);
    ++stats.iterations;
    const double t_next = 0.5 * (1 + std::sqrt(1 + 4 * t * t));
    const auto momentum = static_cast<float>((t - 1) / t_next);
    // <Y - F_new, F_new - F> in D's norm.
    const double against = parallel_reduce(
        static_cast<std::size_t>(n), 512, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double part = 0;
          std::vector<double> w(column.size());
          for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
            const double size = step / D[i];
            for (std::size_t c = 0; c < column.size(); ++c)
              w[c] = static_cast<double>(Y(i, column[c])) -
                     size * static_cast<double>(G(i, column[c]));
            project_to_simplex(w.data(), static_cast<int>(w.size()));
            double restart = 0;
            for (std::size_t c = 0; c < column.size(); ++c) {
              const auto to = static_cast<float>(w[c]);
              const float change = to - F(i, column[c]);
              restart += static_cast<double>(Y(i, column[c]) - to) * static_cast<double>(change);
              F(i, column[c]) = to;
              Y(i, column[c]) = to + momentum * change;
            }
            part += D[i] * restart;
          }
          return part;
        },
        [](double a, double b) { return a + b; });
    t = t_next;
    if (against > 0) {
      Y = F;
      t = 1;
    }
    if (stats.iterations % check_every != 0) continue;
    // Training energy always falls; samples that took no part say whether that means anything.
    const double now = held_out.energy(F, nullptr, progress);
    RowMatrix weights = probe();
    stats.largest_change = weights.size() > 0 ? (weights - checked).cwiseAbs().maxCoeff() : 0;
    checked = std::move(weights);
    const double gain = (best_held - now) / std::max(best_held, 1e-300);
    if (now < best_held) {
      best_held = now;
      best = F;
    }
    if (stats.largest_change < options.tolerance) {
      stats.status = SolveStats::Status::converged;
      break;
    }
    // Further passes would fit these samples alone.
    if (gain < options.held_out_gain) break;
  }
  if (held_out.energy(F, nullptr, progress) > best_held && m > 0) F = best;
  return stats;
}

void certify(const FieldRows& rows, const std::vector<char>& bound, const FloatRows& F,
             SolveStats& stats, const Progress& progress) {
  FloatRows G;
  stats.energy = rows.energy(F, &G, progress);
  double room = 0;
  for (Eigen::Index i = 0; i < F.rows(); ++i) {
    double along = 0, least = 1e300;
    for (Eigen::Index j = 0; j < F.cols(); ++j) {
      if (!bound[static_cast<std::size_t>(j)]) continue;
      along += static_cast<double>(F(i, j)) * static_cast<double>(G(i, j));
      least = std::min(least, static_cast<double>(G(i, j)));
    }
    room += along - least;
  }
  stats.lower_bound = std::max(0.0, stats.energy - room);
  stats.relative_gap = stats.energy > 0 ? (stats.energy - stats.lower_bound) / stats.energy : 0;
}

}  // namespace skinfield
