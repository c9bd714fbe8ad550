// Solid shapes, their damage, and handles, for the tests of domains and of bind.
#pragma once

#include "geometry/shapes.h"
#include "skinfield/rig/skeleton.h"

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace skinfield_test {

inline Handle bone(const Vec3& a, const Vec3& b, std::string name = {}) {
  Handle handle;
  handle.name = std::move(name);
  handle.segments = {{a, b}};
  return handle;
}

inline Handle point_handle(const Vec3& x, std::string name = {}) {
  Handle handle;
  handle.kind = Handle::Kind::point;
  handle.name = std::move(name);
  handle.point = x;
  return handle;
}

/// Both meshes, the second's vertices after the first's.
inline Mesh together(const Mesh& a, const Mesh& b) {
  Mesh mesh;
  mesh.V.resize(a.V.rows() + b.V.rows(), 3);
  mesh.V << a.V, b.V;
  mesh.F.resize(a.F.rows() + b.F.rows(), 3);
  mesh.F << a.F, (b.F.array() + static_cast<std::int32_t>(a.V.rows())).matrix();
  return mesh;
}

inline Mesh moved(Mesh mesh, const Vec3& by) {
  mesh.V.rowwise() += by.transpose();
  return mesh;
}

inline Mesh turned_inside_out(Mesh mesh) {
  mesh.F.col(1).swap(mesh.F.col(2));
  return mesh;
}

/// The surface of the filled cells of a grid with planes at xs, ys, zs; vertices are shared.
inline Mesh voxel_mesh(const std::vector<double>& xs, const std::vector<double>& ys,
                       const std::vector<double>& zs,
                       const std::function<bool(const Vec3& centre)>& filled) {
  const int n[3] = {static_cast<int>(xs.size()) - 1, static_cast<int>(ys.size()) - 1,
                    static_cast<int>(zs.size()) - 1};
  const auto solid = [&](int i, int j, int k) {
    if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) return false;
    const auto middle = [](const std::vector<double>& s, int c) {
      return 0.5 * (s[static_cast<std::size_t>(c)] + s[static_cast<std::size_t>(c) + 1]);
    };
    return filled(Vec3(middle(xs, i), middle(ys, j), middle(zs, k)));
  };
  std::map<std::array<int, 3>, int> number;
  std::vector<Vec3> vertices;
  std::vector<Eigen::Vector3i> faces;
  const auto vertex = [&](const std::array<int, 3>& c) {
    const auto [it, fresh] = number.try_emplace(c, static_cast<int>(vertices.size()));
    if (fresh)
      vertices.emplace_back(xs[static_cast<std::size_t>(c[0])], ys[static_cast<std::size_t>(c[1])],
                            zs[static_cast<std::size_t>(c[2])]);
    return it->second;
  };
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        if (!solid(i, j, k)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> beside{i, j, k};
            beside[static_cast<std::size_t>(axis)] += side ? 1 : -1;
            if (solid(beside[0], beside[1], beside[2])) continue;
            int quad[4];
            for (int q = 0; q < 4; ++q) {
              std::array<int, 3> c{i, j, k};
              c[static_cast<std::size_t>(axis)] += side;
              // Counter-clockwise around +axis: (0,0) (1,0) (1,1) (0,1) in the next two axes.
              c[static_cast<std::size_t>((axis + 1) % 3)] += q == 1 || q == 2;
              c[static_cast<std::size_t>((axis + 2) % 3)] += q >= 2;
              quad[q] = vertex(c);
            }
            if (!side) std::swap(quad[1], quad[3]);
            faces.emplace_back(quad[0], quad[1], quad[2]);
            faces.emplace_back(quad[0], quad[2], quad[3]);
          }
      }
  Mesh mesh;
  mesh.V.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    mesh.V.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
  for (std::size_t f = 0; f < faces.size(); ++f)
    mesh.F.row(static_cast<Eigen::Index>(f)) = faces[f].transpose();
  return mesh;
}

/// low, ..., high in `parts` equal parts.
inline std::vector<double> steps(double low, double high, int parts) {
  std::vector<double> s;
  for (int i = 0; i <= parts; ++i) s.push_back(low + (high - low) * i / parts);
  return s;
}

/// A box whose sides are cut into `parts` squares' worth of triangles along each axis.
inline Mesh fine_box(const Vec3& low, const Vec3& high, const Eigen::Vector3i& parts) {
  return voxel_mesh(steps(low[0], high[0], parts[0]), steps(low[1], high[1], parts[1]),
                    steps(low[2], high[2], parts[2]), [](const Vec3&) { return true; });
}

/// Two prongs of width 0.1 and height 1 on a foot 0.2 high, `gap` apart.
inline Mesh fork_mesh(double gap) {
  std::vector<double> xs = steps(0, 0.1, 3);
  for (double x : steps(0.1 + gap, 0.2 + gap, 3)) xs.push_back(x);
  return voxel_mesh(xs, steps(0, 1, 20), steps(0, 0.1, 3),
                    [gap](const Vec3& x) { return x[1] < 0.2 || x[0] < 0.1 || x[0] > 0.1 + gap; });
}

/// One bone a prong and one in the foot.
inline std::vector<Handle> fork_bones(double gap) {
  return {bone({0.05, 0.2, 0.05}, {0.05, 0.95, 0.05}, "left"),
          bone({0.15 + gap, 0.2, 0.05}, {0.15 + gap, 0.95, 0.05}, "right"),
          bone({0.03, 0.08, 0.05}, {0.17 + gap, 0.08, 0.05}, "foot")};
}

/// Every face with corners of its own, `removed` of them gone, corners moved by up to `jitter`.
inline Mesh soup_of(const Mesh& mesh, double removed, double jitter, std::uint64_t seed) {
  std::vector<int> kept;
  for (int f = 0; f < mesh.F.rows(); ++f)
    if (Random(seed, static_cast<std::uint64_t>(f)).uniform() >= removed) kept.push_back(f);
  Mesh soup;
  soup.V.resize(static_cast<Eigen::Index>(3 * kept.size()), 3);
  soup.F.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<Eigen::Index>(3 * i) + c;
      Random random(seed + 1, static_cast<std::uint64_t>(v));
      soup.V.row(v) = mesh.V.row(mesh.F(kept[i], c)) +
                      jitter * random.uniform() * random.direction().transpose();
      soup.F(static_cast<Eigen::Index>(i), c) = static_cast<std::int32_t>(v);
    }
  return soup;
}

/// Every face twice.
inline Mesh doubled(Mesh mesh) {
  const Triangles F = mesh.F;
  mesh.F.resize(2 * F.rows(), 3);
  mesh.F << F, F;
  return mesh;
}

inline Mesh randomly_flipped(Mesh mesh, std::uint64_t seed) {
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f)
    if (Random(seed, static_cast<std::uint64_t>(f)).uniform() < 0.5)
      std::swap(mesh.F(f, 1), mesh.F(f, 2));
  return mesh;
}

/// Points on the sphere with outward normals.
inline Mesh sphere_cloud(double radius, int count, bool normals) {
  Mesh cloud;
  cloud.V.resize(count, 3);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
    cloud.V.row(i) << radius * r * std::cos(golden * i), radius * r * std::sin(golden * i),
        radius * z;
  }
  if (normals) cloud.N = cloud.V / radius;
  return cloud;
}

}  // namespace skinfield_test
