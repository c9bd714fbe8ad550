#include "methods/field_shape.h"

#include "domain/planar_boundary.h"
#include "skinfield/base/error.h"
#include "skinfield/domain/point_domain.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr double flat_within = 1e-6;  // of the diagonal, as Diagnosis has it
constexpr double probe_depth = 1e-3;  // of painted places, into the shape; unit box
constexpr double volume_share = 0.1;  // of their box that shapes fill, about
constexpr double area_share = 0.5;
constexpr int fewest_points = 16;

/// Places that say where inside is: along handles, and a little way in from painted vertices and
/// regions' ones.
Points probes_of(const LaidShape& shape, const PaintedVertices& paint) {
  const Mesh& mesh = shape.mesh;
  const Points along = probe_handles(shape.handles, 0.005);
  std::vector<int> vertices = paint.vertex;
  for (const int v : vertices)
    if (v < 0 || v >= mesh.V.rows())
      throw InputError("painted vertex " + std::to_string(v) + " does not exist");
  Points regions(0, 3), normals;
  if (shape.plane) {
    for (const Handle& h : shape.handles)
      if (h.kind == Handle::Kind::region)
        vertices.insert(vertices.end(), h.vertices.begin(), h.vertices.end());
    if (!vertices.empty()) {
      const PlanarBoundary boundary = planar_boundary(mesh, along);
      normals = boundary_normals(boundary.V, boundary.closed, boundary.open);
    }
  } else {
    regions = probe_regions(mesh, shape.handles);
    normals = mesh.is_point_cloud() ? mesh.N : vertex_normals(mesh.V, mesh.F);
  }
  Points painted = mesh.V(vertices, Eigen::all);
  if (normals.rows() > 0) painted -= probe_depth * normals(vertices, Eigen::all);
  // Painted places say like handles where inside is, and that their part is no passenger.
  Points probes(along.rows() + regions.rows() + painted.rows(), 3);
  probes << along, regions, painted;
  return probes;
}

}  // namespace

Points laid_points(const std::optional<Plane>& plane, const Points& X) {
  if (!plane) return X;
  Points laid = Points::Zero(X.rows(), 3);
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    laid.row(i).head<2>() = plane->to(X.row(i).transpose()).transpose();
  return laid;
}

Points laid_directions(const std::optional<Plane>& plane, const Points& N) {
  if (!plane) return N;
  Points laid = Points::Zero(N.rows(), 3);
  laid.col(0) = N * plane->u;
  laid.col(1) = N * plane->v;
  return laid;
}

LaidShape::LaidShape(const Mesh& given, const std::vector<Handle>& given_handles)
    : mesh(given), handles(given_handles) {
  const bool has_sides =
      given.F.rows() > 0 || !given.outline.empty() || given.outline.loose.rows() > 0;
  if (given.T.rows() > 0 || given.V.rows() == 0 || !has_sides) return;
  plane = plane_of(given.V, flat_within * diagonal(bounding_box(given.V)));
  if (!plane) return;
  mesh.V = laid_points(plane, given.V);
  mesh.N.resize(0, 3);
  const auto lay = [&](Vec3& x) { x << plane->to(x), 0; };
  for (Handle& handle : handles) {
    lay(handle.point);
    for (auto& [a, b] : handle.segments) lay(a), lay(b);
  }
}

int wanted_points(const GeometricFieldsOptions& options, int dimension) {
  if (options.points > 0) return std::max(options.points, fewest_points);
  const bool convex = options.solver == GeometricFieldsOptions::Solver::convex;
  if (dimension == 2) return convex ? 1 << 13 : 1 << 14;
  return convex ? 1 << 14 : 1 << 16;
}

Solid make_field_solid(const LaidShape& shape, const PaintedVertices& paint,
                       const GeometricFieldsOptions& options, const Progress& progress) {
  if (shape.mesh.V.rows() == 0) throw DomainError("the mesh has no vertices");
  const Box3 box = bounding_box(shape.mesh.V);
  const Eigen::RowVector3d side = box.row(1) - box.row(0);
  const bool planar = shape.plane.has_value();
  const double points = wanted_points(options, planar ? 2 : 3);
  const double spacing = planar ? std::sqrt(area_share * std::max(side[0] * side[1], 1e-6) / points)
                                : std::cbrt(volume_share * std::max(side.prod(), 1e-6) / points);
  return Solid(shape.mesh, probes_of(shape, paint),
               {.spacing = spacing,
                .visibility = options.visibility,
                .inside_from = options.winding_low,
                .planar = planar},
               progress);
}

}  // namespace skinfield
