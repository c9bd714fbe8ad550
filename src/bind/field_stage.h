// Binding by a geometric field: no domain of nodes, the field itself is evaluated.
#pragma once

#include "bind/conditions.h"
#include "bind/solved_domain.h"

namespace skinfield {

/// Solves for `solved.field` and the rows of the mesh's own vertices; fills the report. With
/// BindOptions::resume the solve goes on from there; `saved` (or null) takes the state to save.
/// @throws DomainError where the shape has no inside or nothing binds it; InputError where the
/// saved field is of another shape or other handles.
void solve_field(const BindOptions& options, const Conditions& conditions, SolvedDomain& solved,
                 BindReport& report, FieldFile* saved, const Progress& progress);

}  // namespace skinfield
