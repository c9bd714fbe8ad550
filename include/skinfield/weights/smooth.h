// Smoothing of weights along the edges of a mesh.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/weights/skin_weights.h"

namespace skinfield {

struct SmoothOptions {
  int steps = 1;
  double strength = 0.5;         ///< in [0,1]: share of the neighbours' mean in a step
  std::vector<int> locked = {};  ///< columns that keep their values
  std::vector<bool> keep = {};   ///< (n) vertices that keep their rows, or empty
};
/// Each step: w_i <- (1 - strength) w_i + strength * mean of the rows of i's neighbours along the
/// edges of mesh.F and mesh.T. Locked columns keep their values and the others share what is left
/// of the row. Rows on the simplex stay on it. Vertices without neighbours stay.
/// Throws InputError for sizes or options out of range, Cancelled.
SkinWeights smooth(const SkinWeights& weights, const Mesh& mesh, const SmoothOptions& options,
                   const Progress& progress = {});

}  // namespace skinfield
