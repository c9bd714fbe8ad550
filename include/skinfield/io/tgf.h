// TGF skeletons: vertices, then bones.
#pragma once

#include "skinfield/io/mesh_file.h"
#include "skinfield/rig/skeleton.h"

#include <string>
#include <string_view>

namespace skinfield {

/// Reads `id x y [z] ...` lines, `#`, `a b [BE PE CE]` lines, an optional second `#`. Further
/// columns, tabs and comments after the second `#` are skipped; an edge whose five columns say
/// that it is only a pseudo- or cage edge (BE = 0) is no bone. Fills `joints` (named by their id)
/// and `bones`, in file order; handles are made by rig's rules. Throws InputError for bones that
/// name a missing vertex, repeated ids, non-finite positions, no vertices.
Skeleton parse_tgf(std::string_view bytes, const std::string& name);

/// Turns and scales joints as `asset_from` does with a mesh. Precondition: a TGF's skeleton, whose
/// joint frames are translations. Throws InputError for a useless scale.
void transform_skeleton(Skeleton& skeleton, const ReadOptions& options);

}  // namespace skinfield
