// What a GeometricField owns, and how it is read.
#pragma once

#include "skinfield/domain/field_stencil.h"
#include "skinfield/domain/interior_sampler.h"
#include "skinfield/geometry/plane.h"
#include "skinfield/methods/geometric_fields.h"

#include <optional>

namespace skinfield {

/// alpha (m) at the stencil's wanted place q: convex (f itself) or softplus and normalised (4.2).
class FieldReader {
 public:
  FieldReader(const FloatRows& F, const std::vector<char>& bound, bool softplus)
      : F_(F), bound_(bound), softplus_(softplus) {}
  void at(const FieldStencil& stencil, std::size_t q, double* alpha) const;

 private:
  void hat(const FieldStencil& stencil, std::size_t q, double share, double* alpha) const;
  const FloatRows& F_;
  const std::vector<char>& bound_;
  bool softplus_;
};

struct GeometricField::Impl {
  Mesh mesh;
  std::vector<Handle> handles;
  PaintedVertices paint;
  std::optional<Plane> plane;  // of a flat shape, which is laid into z = 0
  Solid solid;
  std::optional<InteriorSampler> sampler;
  std::optional<FieldConditions> conditions;
  std::optional<KernelField> kernel;
  FloatRows F;
  bool softplus = false;

  /// The row of a point in or on the solid; false where it must be filled from elsewhere.
  bool row(const Vec3& x, const Vec3& normal, double* alpha) const;
  /// The kernel without visibility; the nearest point's value where none is within its radius.
  void row_without_rays(const Vec3& x, double* alpha) const;
  /// A site from which x looks into the solid.
  bool look_from(const Vec3& x, const Vec3& normal, Site& site) const;
};

}  // namespace skinfield
