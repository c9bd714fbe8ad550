#include "domain/inside_check.h"

#include "skinfield/base/error.h"

namespace skinfield {
namespace {

constexpr double weak_level = 0.3;  // winding number at handles of ribbons and thin soups
constexpr double mostly = 0.9;      // share of a soup's handle samples that half the median holds
constexpr double mostly_of_soup = 0.6;

}  // namespace

void check_has_inside(const Solid& solid, const Mesh& mesh) {
  const Solid::Facts& seen = solid.facts();
  if (seen.handle_samples == 0) return;
  if (seen.handle_samples_inside == 0)
    throw DomainError("no handle has a part inside the shape", {}, "use the surface as domain");
  // A ribbon's winding number is weak and changes along the bones; a soup's is weak everywhere.
  const bool torn = mesh.is_point_cloud() || seen.components > solid.faces().rows() / 20;
  if (!solid.has_clean() && seen.level < weak_level &&
      seen.handle_samples_inside < (torn ? mostly_of_soup : mostly) * seen.handle_samples)
    throw DomainError("the shape has no inside worth the name", {}, "use the surface as domain");
}

}  // namespace skinfield
