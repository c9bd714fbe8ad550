#include "domain/interior_cells.h"

#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <cmath>

namespace skinfield {

std::vector<InteriorCell> interior_cells(const Solid& solid, int depth, int tests,
                                         std::uint64_t seed, const Progress& progress) {
  const Box3 box = bounding_box(solid.vertices());
  const Vec3 middle = 0.5 * (box.row(0) + box.row(1)).transpose();
  const int dimension = solid.dimension();
  const int children = 1 << dimension;  // in the plane, cells are squares
  const double half = 0.5 * (box.row(1) - box.row(0)).maxCoeff() * (1 + 1e-9);
  std::vector<InteriorCell> level{{middle, half, false}}, cells;
  for (int d = 0; d <= depth && !level.empty(); ++d) {
    progress.check();
    std::vector<int> state(level.size());  // 0 outside, 1 whole, 2 crossed
    parallel_for(level.size(), 32, [&](std::size_t i) {
      const InteriorCell& cell = level[i];
      for (int axis = 0; axis < 3; ++axis)
        if (cell.centre[axis] + cell.half < box(0, axis) ||
            cell.centre[axis] - cell.half > box(1, axis)) {
          state[i] = 0;
          return;
        }
      // Only clean parts have a clearance that proves a cell uniform.
      if (solid.has_dirty() || d < 2) {
        state[i] = 2;
        return;
      }
      const Site site = solid.site(cell.centre);
      const bool uniform = site.clearance > std::sqrt(dimension) * cell.half;
      state[i] = !uniform ? 2 : solid.inside(site) ? 1 : 0;
    });
    std::vector<InteriorCell> finer;
    for (std::size_t i = 0; i < level.size(); ++i) {
      if (state[i] == 1) {
        cells.push_back(level[i]);
        cells.back().whole = true;
      } else if (state[i] == 2 && d == depth) {
        cells.push_back(level[i]);
      } else if (state[i] == 2) {
        const double h = 0.5 * level[i].half;
        for (int c = 0; c < children; ++c) {
          const double z = dimension == 2 ? 0 : c & 4 ? 1 : -1;
          finer.push_back(
              {level[i].centre + h * Vec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, z), h, false});
        }
      }
    }
    level = std::move(finer);
  }
  const int side = std::max(1, static_cast<int>(std::lround(std::pow(tests, 1.0 / dimension))));
  const int all = dimension == 2 ? side * side : side * side * side;
  parallel_for(cells.size(), 16, [&](std::size_t i) {
    InteriorCell& cell = cells[i];
    if (cell.whole) return;
    progress.check();
    Random random(seed, 0x10000000ull + i);
    cell.site = solid.site(cell.centre);
    int inside = 0;
    for (int k = 0; k < all; ++k) {
      const Vec3 corner(k % side, k / side % side, k / side / side);
      Vec3 in_cell = (corner + Vec3(random.uniform(), random.uniform(), random.uniform())) / side;
      if (dimension == 2) in_cell.z() = 0.5;
      const Vec3 x = cell.centre + cell.half * (2 * in_cell - Vec3::Ones());
      inside += solid.inside(solid.site_near(cell.site, x));
    }
    cell.share = static_cast<double>(inside) / all;
  });
  std::erase_if(cells, [](const InteriorCell& c) { return c.share == 0; });
  return cells;
}

}  // namespace skinfield
