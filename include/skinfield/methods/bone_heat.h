// Bone heat: weights by heat diffusion over the surface, the bones that a vertex sees heating it
// (Baran, Popovic 2007, "Automatic rigging and animation of 3D characters", section 4). What
// Blender and Maya call automatic weights; here for comparison.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/operators/mass.h"
#include "skinfield/rig/skeleton.h"
#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

struct BoneHeatOptions {
  /// c of H = c / d^2. The paper finds that 0.22 gives transitions like those of heat in the volume
  /// and takes 1, which looks more natural.
  double heat = 1;
  MassKind mass = MassKind::barycentric;
  Vector masses;            ///< (n) > 0 in units of the mesh's area, instead of `mass`; or empty
  FixedRows paint;          ///< prescribed rows: vertices, columns are the handles
  RowMatrix start;          ///< (n,m) the values of locked columns, or empty
  std::vector<int> locked;  ///< columns kept from `start`
};

struct BoneHeatResult {
  /// (n,m) raw weights: rows sum to one; entries leave [0,1] a little where triangles are obtuse.
  /// Locked columns hold `start`, the others are as without locks: valid_weights() (polyharmonic.h)
  /// scales them to what is left.
  RowMatrix W;
  std::vector<int> unreached;  ///< vertices of components that no handle heats: zero rows
  std::int64_t heated = 0;     ///< vertices that see a handle
  SolveStats stats;            ///< energy 1/2 tr(W'KW + (W-P)' M H (W-P)), free of units
};

/// (K + M H) W = M H P on the mesh's vertices: K cotangents, M masses, H_jj = k c / d(j)^2 where
/// the nearest handles that vertex j sees lie at distance d (k of them, equal within 1e-4), and P
/// shares row j among these. A handle is seen if the segment to its nearest point lies in the
/// shape: it meets no triangle, and its middle is inside where the surface has an inside. Vertices
/// that see none get heat from their neighbours.
/// @param mesh in any units, equal positions merged. @param handles of any kind; column i is
/// handles[i].
/// @throws SolveError: no triangles, no handle, sizes do not fit.
BoneHeatResult bone_heat(const Mesh& mesh, const std::vector<Handle>& handles,
                         const BoneHeatOptions& options = {}, const Progress& progress = {});

}  // namespace skinfield
