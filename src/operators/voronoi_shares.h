// How an element is divided among its corners by nearness.
#pragma once

#include "skinfield/base/types.h"

#include <array>

namespace skinfield {

/// Volumes of the parts of a tetrahedron (corner positions) that are nearest to each corner;
/// positive, their sum is the volume.
std::array<double, 4> voronoi_shares(const std::array<Vec3, 4>& corner);
/// Mixed areas of a triangle (Meyer et al. 2003, figure 4).
std::array<double, 3> voronoi_shares(const std::array<Vec3, 3>& corner);

}  // namespace skinfield
