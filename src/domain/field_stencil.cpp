#include "skinfield/domain/field_stencil.h"

#include <algorithm>

namespace skinfield {

bool make_stencil(const KernelField& field, const FieldConditions& conditions, const Site& from,
                  std::span<const Vec3> wanted, FieldStencil& stencil,
                  const std::vector<std::int32_t>* seen) {
  thread_local FieldConditions::View view;
  thread_local std::vector<Vec3> places;
  places.assign(wanted.begin(), wanted.end());
  stencil.twin.assign(wanted.size(), -1);
  stencil.blend.assign(wanted.size(), 0);
  for (std::size_t q = 0; q < wanted.size(); ++q) {
    Vec3 p;
    if (!conditions.wall(wanted[q], p, stencil.blend[q])) continue;
    stencil.twin[q] = static_cast<int>(places.size());
    places.push_back(p);
  }
  double spread = 0;
  for (const Vec3& x : places) spread = std::max(spread, (x - from.x).norm());
  if (seen)
    stencil.node = *seen;
  else
    field.see(from, field.radius() + spread, stencil.node);
  if (stencil.node.empty()) return false;
  const std::size_t n = stencil.node.size();
  stencil.phi.resize(places.size() * n);
  stencil.place.resize(places.size());
  thread_local LocalPoints local;
  field.gather(stencil.node, from.x, local);
  conditions.look(from, conditions.radii().lagrange + spread, view);
  for (std::size_t q = 0; q < places.size(); ++q) {
    field.weights(local, places[q] - from.x, stencil.phi.data() + q * n);
    conditions.at(view, places[q], stencil.place[q]);
  }
  return true;
}

}  // namespace skinfield
