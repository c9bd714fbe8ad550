// The rungs below a proper domain, and what they share: any mesh gets weights.
#pragma once

#include "skinfield/bind/bind.h"

namespace skinfield {

/// The handles, scaled to the unit box, and their columns.
struct ScaledCharacter {
  Mesh mesh;
  std::vector<Handle> handles;
  UnitBox box;
};
ScaledCharacter scale_to_unit_box(const Character& character);

/// Each point takes its nearest handle's column: the nearest that it sees if `visible`, else the
/// nearest at all. Rows over handles.
RowMatrix nearest_handle_weights(const Mesh& mesh, const std::vector<Handle>& handles,
                                 const Points& X, const Points& normals, bool visible,
                                 std::vector<Fill>& fill);

}  // namespace skinfield
