#include "domain/region_samples.h"

#include "domain/disk_grid.h"
#include "skinfield/geometry/normals.h"

#include <algorithm>

namespace skinfield {
namespace {

constexpr double kInward = 1e-4;      // of the unit box: from the surface to where it is seen
constexpr double kApart = 0.5;        // of h
constexpr double kProbeDepth = 1e-3;  // of the unit box

/// Six times the volume that the triangles enclose, negative where they face inward.
double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const Vec3 a = mesh.V.row(mesh.F(f, 0)), b = mesh.V.row(mesh.F(f, 1)),
               c = mesh.V.row(mesh.F(f, 2));
    sum += a.dot(b.cross(c));
  }
  return sum;
}

}  // namespace

Vec3 moved_inside(const Solid& solid, const Vec3& x, const Vec3& n) {
  for (const double step : {-kInward, kInward})
    if (solid.inside(Vec3(x + step * n))) return x + step * n;
  return x;
}

std::vector<Vec3> region_samples(const Solid& solid, const Handle& region, const SizeField& size) {
  std::vector<Vec3> samples;
  DiskGrid taken(kApart * size.low(), region.vertices.size());
  for (const int v : region.vertices) {
    const Vec3 n = solid.normals().rows() > v ? Vec3(solid.normals().row(v)) : Vec3(Vec3::Zero());
    const Vec3 x = moved_inside(solid, solid.vertices().row(v), n);
    if (solid.kind_of_vertex(v) == Solid::PartKind::passenger && !solid.inside(x)) continue;
    const double radius = kApart * size.at(x);
    if (taken.conflicts(x, radius, 1)) continue;
    taken.add(x, radius, true);
    samples.push_back(x);
  }
  return samples;
}

Points probe_regions(const Mesh& mesh, const std::vector<Handle>& handles) {
  std::vector<int> vertices;
  for (const Handle& handle : handles)
    if (handle.kind == Handle::Kind::region)
      vertices.insert(vertices.end(), handle.vertices.begin(), handle.vertices.end());
  if (vertices.empty()) return Points(0, 3);
  Points probes = mesh.V(vertices, Eigen::all);
  const Points normals = mesh.is_point_cloud() ? mesh.N : vertex_normals(mesh.V, mesh.F);
  if (normals.rows() == 0) return probes;
  const double inward = signed_volume(mesh) < 0 ? kProbeDepth : -kProbeDepth;
  return probes + inward * normals(vertices, Eigen::all);
}

}  // namespace skinfield
