// TetGen, shielded: the only file that knows it. (Si, "TetGen, a Delaunay-based quality
// tetrahedral mesh generator", ACM TOMS 2015.)
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

#include <string>

namespace skinfield {

struct TetgenInput {
  Points V;               ///< every one a corner of a face
  Triangles F;            ///< closed, orientation does not matter
  Points inside;          ///< to become vertices, not on the surface
  double max_volume = 0;  ///< of a tet; 0: no limit
  double radius_edge = 1.5;
  double min_dihedral = 10;  ///< degrees, wanted
  double time_limit_s = 120;
};

struct TetgenOutput {
  bool good = false;
  std::string why;  ///< if not good
  Points V;         ///< the input's V first
  Tetrahedra T;     ///< positive volume
};

/// False where this build has no TetGen: then nothing is ever good.
bool have_tetgen();
TetgenOutput run_tetgen(const TetgenInput& input, const Progress& progress);

}  // namespace skinfield
