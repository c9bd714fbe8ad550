// Splits the long edges of a triangle mesh; the shape stays.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

/// Splits edges longer than `h` at their middles, and the triangles to fit, until there are none or
/// `most_vertices` are reached. The vertices there were come first; closed meshes stay closed.
void split_long_edges(Points& V, Triangles& F, double h, Eigen::Index most_vertices);

}  // namespace skinfield
