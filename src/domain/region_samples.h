// Regions (sets of vertices) as handles of the point domain and of fields.
#pragma once

#include "domain/point_sampling.h"
#include "skinfield/domain/solid.h"

namespace skinfield {

/// A little inside from a point of the surface with normal n, where the surface can see it; x
/// itself where neither side is inside.
Vec3 moved_inside(const Solid& solid, const Vec3& x, const Vec3& n);

/// The vertices of a region, moved inside, about half a node's distance apart: a dense mesh has
/// more than the nodes could tell apart. Vertices of passengers are left out.
std::vector<Vec3> region_samples(const Solid& solid, const Handle& region, const SizeField& size);

}  // namespace skinfield
