// Weights reflected in a plane: from one half of a character to the other, or made symmetric.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/weights/skin_weights.h"

namespace skinfield {

struct MirrorPlane {
  Vec3 normal = Vec3::UnitX();  ///< unit
  double offset = 0;            ///< the plane is normal . x = offset
  Vec3 reflect(const Vec3& x) const { return x - 2 * (normal.dot(x) - offset) * normal; }
};

/// The name of the other side, or the same name: `Arm.L`, `l_arm`, `LeftArm`, `arm-left`, `FootL`
/// and the like; sides are whole words (`Leg` has none), case is kept.
std::string other_side(const std::string& name);

/// partner[j] of every column; partner[partner[j]] = j. By name where `other_side` names another
/// column, else by position: the mutually nearest columns to each other's reflections within
/// `tolerance`; columns that find nobody are their own partner.
/// names: (m) or empty; positions: (m,3) of joints or handles (rows that are not finite are left
/// out), or no rows. Throws InputError if both are absent or sizes differ.
std::vector<int> pair_columns(const std::vector<std::string>& names, const Points& positions,
                              const MirrorPlane& plane, double tolerance);

struct Mirrored {
  SkinWeights weights;
  Eigen::Index matched = 0;  ///< vertices whose reflection is a vertex within the tolerance
};
/// Row i = the row at the reflection of vertex i, columns exchanged by `partner`. The reflection
/// is the nearest vertex if it is within `tolerance`, else the nearest point of mesh.F
/// (interpolated), else (no faces) the nearest vertex. On a mesh whose vertices are symmetric,
/// mirroring twice is the identity. Throws InputError if sizes do not fit.
Mirrored mirror(const SkinWeights& weights, const Mesh& mesh, const MirrorPlane& plane,
                const std::vector<int>& partner, double tolerance);

/// Half the weights, half their mirror image.
Mirrored symmetrise(const SkinWeights& weights, const Mesh& mesh, const MirrorPlane& plane,
                    const std::vector<int>& partner, double tolerance);

}  // namespace skinfield
