// Classification of a surface's components for Solid: clean, dirty, passenger (findings E 1, 2).
#pragma once

#include "skinfield/domain/solid.h"

namespace skinfield {

/// Faces with a repeated index, zero area, or the same corners as an earlier face are dropped.
struct CleanedFaces {
  Triangles F;
  int degenerate = 0, duplicate = 0;
};
CleanedFaces drop_degenerate_and_duplicate(const Points& V, const Triangles& F);

struct PartsOfSolid {
  Triangles F;  ///< cavities and inside-out shells turned as needed
  std::vector<int> component_of_face;
  std::vector<Solid::PartKind> kind;  ///< of each component
  std::vector<int> self_winding;      ///< per face: k_f = max(0, round v_f)
  int turned = 0;                     ///< faces of inside-out closed components turned
};
PartsOfSolid classify_parts(const Points& V, const Triangles& F, const Points& handle_samples,
                            double accuracy, const Progress& progress);

}  // namespace skinfield
