// CGAL's alpha wrap, shielded: the only file that knows it. (Portaneri, Rouxel-Labbe, Hemmer,
// Cohen-Steiner, Alliez, "Alpha wrapping with an offset", SIGGRAPH 2022.)
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

#include <string>

namespace skinfield {

struct AlphaWrap {
  bool good = false;
  std::string why;  ///< if not good
  Mesh surface;     ///< closed, 2-manifold, free of self-intersections, outward
};

/// False where this build has no CGAL: then nothing is ever good.
bool have_alpha_wrap();
/// Wraps triangles, or the bare points where there are none. Holes narrower than alpha are closed,
/// and so are gaps. The result strictly contains the input, `offset` away from it.
AlphaWrap alpha_wrap(const Mesh& mesh, double alpha, double offset, double time_limit_s,
                     const Progress& progress);

}  // namespace skinfield
