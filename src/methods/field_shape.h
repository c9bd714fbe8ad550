// The shape that a geometric field lives in: a body in space, or an area of a plane.
#pragma once

#include "skinfield/domain/solid.h"
#include "skinfield/geometry/plane.h"
#include "skinfield/methods/geometric_fields.h"

#include <optional>

namespace skinfield {

/// A flat shape (triangles, an outline, loose segments in one plane) and its handles are laid into
/// the plane z = 0; anything else stays as it is.
struct LaidShape {
  Mesh mesh;
  std::vector<Handle> handles;
  std::optional<Plane> plane;  ///< where the flat shape came from

  LaidShape(const Mesh& mesh, const std::vector<Handle>& handles);
};

/// (n,3) points or directions of the shape's own space in the coordinates of its field.
Points laid_points(const std::optional<Plane>& plane, const Points& X);
Points laid_directions(const std::optional<Plane>& plane, const Points& N);

/// How many points the finest level has.
int wanted_points(const GeometricFieldsOptions& options, int dimension);

/// @throws DomainError, InputError as GeometricField.
Solid make_field_solid(const LaidShape& shape, const PaintedVertices& paint,
                       const GeometricFieldsOptions& options, const Progress& progress);

}  // namespace skinfield
