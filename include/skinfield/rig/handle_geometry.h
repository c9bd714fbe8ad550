// Handles as point sets: samples, distances, and how much of one lies inside a shape.
#pragma once

#include "skinfield/geometry/winding_number.h"
#include "skinfield/rig/skeleton.h"

#include <functional>
#include <utility>
#include <vector>

namespace skinfield {

/// Is a point inside the shape? Thread-safe.
using InsideTest = std::function<bool(const Vec3&)>;

/// Inside where the winding number exceeds `level`. Refers to `winding`, which must outlive it.
InsideTest inside_test(const WindingNumber& winding, double level = 0.5);

/// (k,3) points of a bone, each segment's both ends and between them steps of at most `spacing`,
/// an end that an earlier segment of the handle has given left out; the point of a point handle.
/// A region's points are its vertices: rows of V. Throws InputError if spacing <= 0, if a region
/// names a vertex outside V.
Points sample_handle(const Handle& handle, double spacing, const Points& V = {});

/// Distance of x to the nearest point of the handle; infinite for a region without V. `closest`,
/// if given, becomes that point (and stays as it is where there is none).
double handle_distance(const Handle& handle, const Vec3& x, const Points& V = {},
                       Vec3* closest = nullptr);

enum class HandlePlace { inside, partly, outside };
const char* to_string(HandlePlace place);

struct HandleInside {
  HandlePlace place = HandlePlace::outside;
  std::vector<std::pair<Vec3, Vec3>> segments;  ///< a bone's inside parts, in order
  double fraction = 0;                          ///< of a bone's length; 0 or 1 for points
};

/// Each segment is tested at `samples` + 1 places and bisected where the answer changes, so gaps
/// shorter than length / samples can be missed. A bone that only ends on the surface is inside.
/// Regions lie on the shape: inside. Precondition: samples >= 1.
HandleInside inside_part(const Handle& handle, const InsideTest& inside, int samples = 64);
HandlePlace classify_handle(const Handle& handle, const WindingNumber& winding, double level = 0.5);

}  // namespace skinfield
