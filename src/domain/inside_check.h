// Does a shape have an inside that volumes' weights can live in? The first rung of the ladder.
#pragma once

#include "skinfield/domain/solid.h"

namespace skinfield {

/// For a solid made with samples of its handles; without any samples it says nothing.
/// @throws DomainError where no sample lies inside, or the inside is too weak to be one (ribbons).
void check_has_inside(const Solid& solid, const Mesh& mesh);

}  // namespace skinfield
