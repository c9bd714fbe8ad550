// Which nodes of a tet mesh the handles hold, after splits where a handle had none.
#pragma once

#include "domain/tet_splitter.h"
#include "skinfield/rig/skeleton.h"
#include "skinfield/solve/simplex_qp.h"

#include <vector>

namespace skinfield {

struct TetSplit {
  Points V;
  Tetrahedra T;
  std::vector<TetSplitter::Place> made;  ///< what the new vertices were made from
  FixedRows fixed;
  int split_handles = 0;
  std::vector<int> outside;  ///< handles without a fixed row
};

/// design.md 4. @param T tets with volume, corners by distinct positions. Vertices of no tet hold
/// nothing.
TetSplit split_at_handles(const Points& V, const Tetrahedra& T, const std::vector<Handle>& handles);

}  // namespace skinfield
