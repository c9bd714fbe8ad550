// Binding by a geometric field: no domain of nodes, the field itself is evaluated.
#pragma once

#include "bind/conditions.h"
#include "bind/solved_domain.h"

namespace skinfield {

/// Solves for `solved.field` and the rows of the mesh's own vertices; fills the report. With
/// BindOptions::resume the solve goes on from there; `saved` (or null) takes the state to save,
/// with the skeleton.
/// False, with a warning, where the shape has no inside or nothing binds it there.
/// @throws DomainError instead, if a field is to be saved or resumed; InputError where the saved
/// field is of another shape or other handles.
bool solve_field(const BindOptions& options, const Skeleton& skeleton, const Conditions& conditions,
                 SolvedDomain& solved, BindReport& report, FieldFile* saved,
                 const Progress& progress);

/// What stands in for a field on the rungs below: bounded biharmonic weights on the surface, with
/// the same limits.
BindOptions options_below_field(const BindOptions& options);

}  // namespace skinfield
