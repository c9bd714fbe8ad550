// An octree of the shape's interior: cells wholly inside, and cells that the surface crosses.
#pragma once

#include "skinfield/domain/solid.h"

#include <vector>

namespace skinfield {

struct InteriorCell {
  Vec3 centre;
  double half;       ///< half the side
  bool whole;        ///< wholly inside: points in it need no test
  double share = 1;  ///< estimated share of it that is inside
  Site site = {};    ///< at the centre of a crossed cell
};

/// Cells down to a side of box / 2^depth; crossed leaves get `tests` stratified inside tests.
std::vector<InteriorCell> interior_cells(const Solid& solid, int depth, int tests,
                                         std::uint64_t seed, const Progress& progress);

}  // namespace skinfield
