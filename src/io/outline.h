// Outlines as files give them: made sound, or refused with a word.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <string>
#include <vector>

namespace skinfield {

/// `outline` over the merged vertices V: segments without a length go, those that a shape has twice
/// cancel, polylines that do not close go. Nothing is left where V is not flat (1e-6 of the
/// diagonal). What goes is said in `warnings`.
Outline sound_outline(const Outline& outline, const std::vector<int>& merged, const Points& V,
                      std::vector<std::string>& warnings);

}  // namespace skinfield
