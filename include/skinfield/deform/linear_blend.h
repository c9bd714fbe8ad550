// Linear blend skinning: x' = sum_j w_j T_j x.
#pragma once

#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/skin_weights.h"

#include <span>

namespace skinfield {

/// (n,3) deformed positions. columns: one transform a weight column, from bind space to the pose
/// (`column_transforms`). Vertices without weights stay where they are.
/// Throws InputError if V, weights and columns do not belong together.
Points linear_blend(const Points& V, const SkinWeights& weights,
                    std::span<const Transform> columns);

/// Normals under the same deformation: by the inverse transpose of each vertex's blended matrix,
/// unit length; zero normals, and those that a singular matrix destroys, are zero.
Points linear_blend_normals(const Points& N, const SkinWeights& weights,
                            std::span<const Transform> columns);

}  // namespace skinfield
