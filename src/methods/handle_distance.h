// How far the elements of a mesh are from the nearest handle.
#pragma once

#include "skinfield/base/types.h"
#include "skinfield/operators/anisotropic_stiffness.h"

#include <vector>

namespace skinfield {

/// Straight distance from each element's centre (rows) to the nearest of the nodes.
Vector straight_distance(const Points& centres, const Points& V, const std::vector<int>& nodes);

/// Distance inside the domain from the nodes, by the heat method (Crane, Weischedel, Wardetzky
/// 2013, "Geodesics in heat"): (N), zero at the nodes and wherever no element path leads.
/// M: (N) masses. edge: a typical edge's length, whose square is the time of diffusion.
Vector heat_distance(const AnisotropicStiffness& stiffness, const Vector& M, double edge,
                     const std::vector<int>& nodes);

}  // namespace skinfield
