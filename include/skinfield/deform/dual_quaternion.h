// Dual quaternion skinning (Kavan, Collins, Zara, O'Sullivan: "Geometric skinning with approximate
// dual quaternion blending", ACM Transactions on Graphics 27(4), 2008, section 4).
#pragma once

#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/skin_weights.h"

#include <span>

namespace skinfield {

/// (n,3) deformed positions. Each transform is split into rotation times stretch (polar
/// decomposition); the stretches are blended linearly and applied first, then the blended dual
/// quaternion of rotations and translations. Signs are chosen against the quaternion of the
/// largest weight (ties: the lowest column), so that the sign of a rotation's quaternion does
/// not matter. With one influence it is that transform. Vertices without weights stay.
/// Throws InputError if V, weights and columns do not belong together.
Points dual_quaternion(const Points& V, const SkinWeights& weights,
                       std::span<const Transform> columns);

/// Unit normals: the inverse transpose of the blended stretch, then the blended rotation.
Points dual_quaternion_normals(const Points& N, const SkinWeights& weights,
                               std::span<const Transform> columns);

}  // namespace skinfield
