#include "weights/point_grid.h"

#include "skinfield/geometry/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

constexpr int max_cells = 128;  // a side: bounds the memory of flat and stringy clouds

}  // namespace

PointGrid::PointGrid(const Points& V) : V_(V) {
  const Box3 box = bounding_box(V);
  lower_ = box.row(0).transpose();
  const Vec3 extent = (box.row(1) - box.row(0)).transpose();
  const double side = extent.maxCoeff();
  const double wanted = std::clamp(std::cbrt(static_cast<double>(V.rows())), 1.0, 1.0 * max_cells);
  size_ = side > 0 ? side / wanted : 1;
  for (std::size_t k = 0; k < 3; ++k) {
    cells_[k] = static_cast<int>(extent[static_cast<Eigen::Index>(k)] / size_) + 1;
  }
  start_.assign(index(cells_[0] - 1, cells_[1] - 1, cells_[2] - 1) + 2, 0);
  std::vector<std::size_t> of(static_cast<std::size_t>(V.rows()));
  for (std::size_t i = 0; i < of.size(); ++i) {
    const auto c = cell(V.row(static_cast<Eigen::Index>(i)).transpose());
    of[i] = index(c[0], c[1], c[2]);
    ++start_[of[i] + 1];
  }
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  vertex_.resize(of.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (std::size_t i = 0; i < of.size(); ++i) {
    vertex_[static_cast<std::size_t>(next[of[i]]++)] = static_cast<int>(i);
  }
}

std::array<int, 3> PointGrid::cell(const Vec3& x) const {
  std::array<int, 3> c{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double t = std::floor((x[axis] - lower_[axis]) / size_);
    c[k] = static_cast<int>(std::clamp(t, 0.0, static_cast<double>(cells_[k] - 1)));
  }
  return c;
}

std::size_t PointGrid::index(int a, int b, int c) const {
  return (static_cast<std::size_t>(a) * static_cast<std::size_t>(cells_[1]) +
          static_cast<std::size_t>(b)) *
             static_cast<std::size_t>(cells_[2]) +
         static_cast<std::size_t>(c);
}

int PointGrid::nearest(const Vec3& x) const {
  const auto home = cell(x);
  int best = -1;
  double best_squared = std::numeric_limits<double>::infinity();
  const int last = std::max({cells_[0], cells_[1], cells_[2]});
  // What lies beyond ring r is at least r cells away from x clamped into the box, and x itself
  // is no nearer to anything in the box than its clamped self.
  for (int r = 0; r <= last; ++r) {
    for (int a = std::max(home[0] - r, 0); a <= std::min(home[0] + r, cells_[0] - 1); ++a) {
      for (int b = std::max(home[1] - r, 0); b <= std::min(home[1] + r, cells_[1] - 1); ++b) {
        const bool shell = std::abs(a - home[0]) == r || std::abs(b - home[1]) == r;
        const int step = shell || r == 0 ? 1 : 2 * r;
        for (int c = home[2] - r; c <= home[2] + r; c += step) {
          if (c < 0 || c >= cells_[2]) continue;
          const std::size_t at = index(a, b, c);
          for (int k = start_[at]; k < start_[at + 1]; ++k) {
            const int i = vertex_[static_cast<std::size_t>(k)];
            const double d = (V_.row(i).transpose() - x).squaredNorm();
            if (d < best_squared || (d == best_squared && i < best)) {
              best_squared = d;
              best = i;
            }
          }
        }
      }
    }
    if (best >= 0 && best_squared <= r * size_ * r * size_) break;
  }
  return best;
}

}  // namespace skinfield
