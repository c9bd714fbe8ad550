#include "domain/smoothed_winding.h"

#include "domain/kd_tree.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/mesh.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr int block = 4;                     // fine cells along a coarse block
constexpr std::size_t most_cells = 6000000;  // memory cap; epsilon grows to meet it

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto k = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
  return values[k];
}

double quantile(const Vector& values, double q) {
  return quantile(std::vector<double>(values.data(), values.data() + values.size()), q);
}

}  // namespace

SmoothedWinding::SmoothedWinding(const Direct& winding, const Points& sources, double edge,
                                 const Points& samples, const Vector& clean, double spacing,
                                 const Progress& progress) {
  // epsilon: wide enough to close the gaps between triangles as seen from the handles.
  epsilon_ = std::max(0.4 * spacing, 0.35 * edge);
  const double widest = std::max(edge, epsilon_);
  const auto measure = [&] {
    at_samples_ = clean;
    parallel_for(static_cast<std::size_t>(samples.rows()), 16, [&](std::size_t i) {
      const auto row = static_cast<Eigen::Index>(i);
      at_samples_[row] += winding(samples.row(row).transpose(), epsilon_);
    });
  };
  for (measure();
       epsilon_ < widest && quantile(at_samples_, 0.05) < 0.5 * quantile(at_samples_, 0.5);
       measure())
    epsilon_ = std::min(1.3 * epsilon_, widest);

  Points all(sources.rows() + samples.rows(), 3);
  all << sources, samples;
  Box3 box = bounding_box(all);
  const auto lay = [&] {
    std::size_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = box(1, axis) - box(0, axis) + 6 * epsilon_;
      size_[axis] = (static_cast<int>(std::ceil(length / epsilon_)) / block + 1) * block + 1;
      cells *= static_cast<std::size_t>(size_[axis]);
    }
    return cells;
  };
  while (lay() > most_cells) epsilon_ *= 1.15;
  origin_ = box.row(0).transpose().array() - 3 * epsilon_;

  const auto point = [&](int i, int j, int k) { return Vec3(origin_ + epsilon_ * Vec3(i, j, k)); };
  const std::size_t total = index(0, 0, size_[2] - 1) +
                            static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
  winding_.assign(total, 0.f);
  level_.assign(total, 0.f);

  // Exact values at the corners of coarse blocks; within blocks away from every source the field
  // is smooth on the block's scale and trilinear interpolation serves; elsewhere exact again.
  const int nb[3] = {(size_[0] - 1) / block, (size_[1] - 1) / block, (size_[2] - 1) / block};
  const auto block_index = [&](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(nb[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(nb[0]) +
           static_cast<std::size_t>(i);
  };
  std::vector<unsigned char> near(
      block_index(0, 0, nb[2] - 1) +
          static_cast<std::size_t>(nb[0]) * static_cast<std::size_t>(nb[1]),
      0);
  for (Eigen::Index s = 0; s < sources.rows(); ++s) {
    int b[3];
    for (int axis = 0; axis < 3; ++axis)
      b[axis] = static_cast<int>((sources(s, axis) - origin_[axis]) / (epsilon_ * block));
    for (int k = std::max(0, b[2] - 1); k <= std::min(nb[2] - 1, b[2] + 1); ++k)
      for (int j = std::max(0, b[1] - 1); j <= std::min(nb[1] - 1, b[1] + 1); ++j)
        for (int i = std::max(0, b[0] - 1); i <= std::min(nb[0] - 1, b[0] + 1); ++i)
          near[block_index(i, j, k)] = 1;
  }

  Vector sample_level(samples.rows());
  const double median = quantile(at_samples_, 0.5);
  for (Eigen::Index s = 0; s < samples.rows(); ++s)
    sample_level[s] = std::min(1.0, std::max(at_samples_[s], 0.5 * median));
  const KdTree tree(samples);
  const auto level_near = [&](const Vec3& x, std::vector<Neighbour>& found, double& distance) {
    tree.nearest(x, 8, found);
    double sum = 0, weighted = 0;
    for (const Neighbour& n : found) {
      const double w = 1 / (n.distance * n.distance + 1e-12);
      sum += w;
      weighted += w * sample_level[n.index];
    }
    distance = found.empty() ? 1e300 : found.front().distance;
    return sum > 0 ? weighted / sum : 1.0;
  };

  const std::size_t corners = static_cast<std::size_t>(nb[0] + 1) *
                              static_cast<std::size_t>(nb[1] + 1) *
                              static_cast<std::size_t>(nb[2] + 1);
  parallel_for(corners, 32, [&](std::size_t c) {
    progress.check();
    const int i = static_cast<int>(c % static_cast<std::size_t>(nb[0] + 1)) * block;
    const std::size_t rest = c / static_cast<std::size_t>(nb[0] + 1);
    const int j = static_cast<int>(rest % static_cast<std::size_t>(nb[1] + 1)) * block;
    const int k = static_cast<int>(rest / static_cast<std::size_t>(nb[1] + 1)) * block;
    std::vector<Neighbour> found;
    double distance = 0;
    winding_[index(i, j, k)] = static_cast<float>(winding(point(i, j, k), epsilon_));
    level_[index(i, j, k)] = static_cast<float>(level_near(point(i, j, k), found, distance));
  });
  // Each block fills its interior and its lower faces; the grid's upper faces are only corners of
  // blocks' upper faces, which the clamped last blocks fill.
  parallel_for(near.size(), 8, [&](std::size_t b) {
    progress.check();
    const int bi = static_cast<int>(b % static_cast<std::size_t>(nb[0]));
    const std::size_t rest = b / static_cast<std::size_t>(nb[0]);
    const int bj = static_cast<int>(rest % static_cast<std::size_t>(nb[1]));
    const int bk = static_cast<int>(rest / static_cast<std::size_t>(nb[1]));
    const auto corner = [&](const std::vector<float>& v, int di, int dj, int dk) {
      return static_cast<double>(v[index((bi + di) * block, (bj + dj) * block, (bk + dk) * block)]);
    };
    const auto coarse = [&](const std::vector<float>& v, double x, double y, double z) {
      double sum = 0;
      for (int d = 0; d < 8; ++d)
        sum += corner(v, d & 1, (d >> 1) & 1, d >> 2) * ((d & 1) ? x : 1 - x) *
               (((d >> 1) & 1) ? y : 1 - y) * ((d >> 2) ? z : 1 - z);
      return static_cast<float>(sum);
    };
    const int ni = bi + 1 == nb[0] ? block + 1 : block;
    const int nj = bj + 1 == nb[1] ? block + 1 : block;
    const int nk = bk + 1 == nb[2] ? block + 1 : block;
    for (int k = 0; k < nk; ++k)
      for (int j = 0; j < nj; ++j)
        for (int i = 0; i < ni; ++i) {
          if (i % block == 0 && j % block == 0 && k % block == 0) continue;
          const std::size_t at = index(bi * block + i, bj * block + j, bk * block + k);
          const double x = double(i) / block, y = double(j) / block, z = double(k) / block;
          winding_[at] = near[b]
                             ? static_cast<float>(winding(
                                   point(bi * block + i, bj * block + j, bk * block + k), epsilon_))
                             : coarse(winding_, x, y, z);
          level_[at] = coarse(level_, x, y, z);
        }
  });
  // Near bones it is inside by decree: w >= lev (1 - d / 2 eps).
  const double reach = 2 * epsilon_;
  for (Eigen::Index s = 0; s < samples.rows(); ++s) {
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double c = (samples(s, axis) - origin_[axis]) / epsilon_;
      low[axis] = std::max(0, static_cast<int>(std::floor(c - 2)));
      high[axis] = std::min(size_[axis] - 1, static_cast<int>(std::ceil(c + 2)));
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const double d = (point(i, j, k) - samples.row(s).transpose()).norm();
          if (d >= reach) continue;
          const std::size_t at = index(i, j, k);
          winding_[at] = std::max(
              winding_[at], static_cast<float>(static_cast<double>(level_[at]) * (1 - d / reach)));
        }
  }
}

bool SmoothedWinding::locate(const Vec3& x, Cell& cell) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double c = (x[axis] - origin_[axis]) / epsilon_;
    if (!(c >= 0) || c >= size_[axis] - 1) return false;
    cell.i[axis] = static_cast<int>(c);
    cell.f[axis] = c - cell.i[axis];
  }
  return true;
}

double SmoothedWinding::blend(const std::vector<float>& v, const Cell& c) const {
  const std::size_t at = index(c.i[0], c.i[1], c.i[2]);
  const std::size_t dj = static_cast<std::size_t>(size_[0]);
  const std::size_t dk = dj * static_cast<std::size_t>(size_[1]);
  const auto along = [&](std::size_t a) {
    return (1 - c.f[0]) * static_cast<double>(v[a]) + c.f[0] * static_cast<double>(v[a + 1]);
  };
  return (1 - c.f[2]) * ((1 - c.f[1]) * along(at) + c.f[1] * along(at + dj)) +
         c.f[2] * ((1 - c.f[1]) * along(at + dk) + c.f[1] * along(at + dk + dj));
}

double SmoothedWinding::at(const Vec3& x) const {
  Cell cell;
  return locate(x, cell) ? blend(winding_, cell) : 0;
}

double SmoothedWinding::level(const Vec3& x) const {
  Cell cell;
  return locate(x, cell) ? blend(level_, cell) : 1;
}

}  // namespace skinfield
