// The best domain that stands for a character: the ladder of design.md 3, from the top.
#pragma once

#include "bind/conditions.h"
#include "bind/solved_domain.h"
#include "skinfield/rig/handle_geometry.h"

namespace skinfield {

/// Fills `solved.domain` (null on the rungs of nearest handles) and `solved.rung`; each rung that
/// does not stand leaves a warning. @throws OptionError for masses that the domain cannot take;
/// DomainError only where tetrahedra were asked for and cannot be had.
void build_domain(const BindOptions& options, const Character& character,
                  const Conditions& conditions, SolvedDomain& solved, BindReport& report,
                  const Progress& progress);

/// The mesh's own vertices as nodes, for methods that need no domain.
void use_own_vertices(const Conditions& conditions, SolvedDomain& solved);

void describe_domain(const SolvedDomain& solved, BindReport& report);

/// Whether a point of the unit box is in the shape that the domain fills; empty where none does.
/// Refers to `solved`.
InsideTest inside_test(const SolvedDomain& solved);

}  // namespace skinfield
