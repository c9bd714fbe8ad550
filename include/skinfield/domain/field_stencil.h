// A geometric field at places seen from one site: what the energy's rows and evaluation are made
// of (geometric fields, section 5.3: places beside a sample use only points that it sees).
#pragma once

#include "skinfield/domain/field_conditions.h"
#include "skinfield/domain/kernel_field.h"

#include <span>

namespace skinfield {

/// At place q: alpha_hat = value + free * sum_k phi(q,k) f(node[k]). Wanted places come first; with
/// zero Neumann (equation 9) wanted place q is (1 - blend[q]) alpha_hat(q) + blend[q]
/// alpha_hat(twin[q]), twin[q] being the closest point of the wall.
struct FieldStencil {
  std::vector<std::int32_t> node;
  std::vector<float> phi;  ///< (places, node.size()), rows sum to one
  std::vector<Prescribed> place;
  std::vector<int> twin;      ///< (wanted) -1: none
  std::vector<double> blend;  ///< (wanted)

  const float* row(std::size_t q) const { return phi.data() + q * node.size(); }
};

/// False if `from` sees no point. `seen`: use these points instead of looking, or null.
bool make_stencil(const KernelField& field, const FieldConditions& conditions, const Site& from,
                  std::span<const Vec3> wanted, FieldStencil& stencil,
                  const std::vector<std::int32_t>* seen = nullptr);

}  // namespace skinfield
