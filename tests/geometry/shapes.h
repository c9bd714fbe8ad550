// Shapes that geometry tests make for themselves.
#pragma once

#include "skinfield/base/random.h"
#include "skinfield/geometry/mesh.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace skinfield_test {

using namespace skinfield;

inline Mesh make_mesh(std::initializer_list<Vec3> vertices,
                      std::initializer_list<Eigen::Vector3i> faces) {
  Mesh mesh;
  mesh.V.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  Eigen::Index i = 0;
  for (const Vec3& v : vertices) mesh.V.row(i++) = v.transpose();
  i = 0;
  for (const auto& f : faces) mesh.F.row(i++) = f.transpose();
  return mesh;
}

inline Mesh box_mesh(const Vec3& low, const Vec3& high) {
  Mesh mesh;
  mesh.V.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) mesh.V(i, k) = (i >> k & 1) ? high[k] : low[k];
  mesh.F.resize(12, 3);
  mesh.F << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6,
      2, 1, 3, 7, 1, 7, 5;
  return mesh;
}

/// A closed surface of a grid that wraps around both ways: a torus, outward oriented.
inline Mesh torus_mesh(double large, double small, int across = 48, int around = 24) {
  Mesh mesh;
  mesh.V.resize(across * around, 3);
  mesh.F.resize(across * around * 2, 3);
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < around; ++j) {
      const double a = 2 * std::numbers::pi * i / across, b = 2 * std::numbers::pi * j / around;
      const double r = large + small * std::cos(b);
      mesh.V.row(i * around + j) << r * std::cos(a), r * std::sin(a), small * std::sin(b);
      const int p = i * around + j, q = (i + 1) % across * around + j;
      const int s = i * around + (j + 1) % around, t = (i + 1) % across * around + (j + 1) % around;
      mesh.F.row((i * around + j) * 2) << p, q, t;
      mesh.F.row((i * around + j) * 2 + 1) << p, t, s;
    }
  }
  return mesh;
}

/// A closed sphere of latitude rings, with an optional bumpy radius.
inline Mesh sphere_mesh(double radius = 1, int rings = 24, double bumps = 0) {
  const int around = 2 * rings;
  Mesh mesh;
  mesh.V.resize((rings - 1) * around + 2, 3);
  const auto put = [&](Eigen::Index row, double polar, double turn) {
    const double r = radius * (1 + bumps * std::sin(3 * polar) * std::cos(4 * turn));
    mesh.V.row(row) << r * std::sin(polar) * std::cos(turn), r * std::sin(polar) * std::sin(turn),
        r * std::cos(polar);
  };
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < around; ++j)
      put((i - 1) * around + j, std::numbers::pi * i / rings, 2 * std::numbers::pi * j / around);
  const int north = (rings - 1) * around, south = north + 1;
  put(north, 0, 0);
  put(south, std::numbers::pi, 0);
  mesh.F.resize(2 * around * (rings - 1), 3);
  Eigen::Index f = 0;
  for (int j = 0; j < around; ++j) {
    const int next = (j + 1) % around, last = (rings - 2) * around;
    mesh.F.row(f++) << north, j, next;
    mesh.F.row(f++) << south, last + next, last + j;
    for (int i = 0; i + 2 < rings; ++i) {
      const int a = i * around;
      mesh.F.row(f++) << a + j, a + around + j, a + around + next;
      mesh.F.row(f++) << a + j, a + around + next, a + next;
    }
  }
  return mesh;
}

inline Mesh moebius_strip(int n) {
  Mesh strip;
  strip.V.resize(2 * n, 3);
  strip.F.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    for (int s = 0; s < 2; ++s) {
      const double r = 1 + (s ? 0.3 : -0.3) * std::cos(a / 2);
      strip.V.row(2 * i + s) << r * std::cos(a), r * std::sin(a),
          (s ? 0.3 : -0.3) * std::sin(a / 2);
    }
    const bool last = i + 1 == n;
    const int p = 2 * i, q = 2 * i + 1, r = last ? 1 : 2 * i + 2, t = last ? 0 : 2 * i + 3;
    strip.F.row(2 * i) << p, r, q;
    strip.F.row(2 * i + 1) << q, r, t;
  }
  return strip;
}

/// `count` triangles of about `size`, anywhere in the unit box and any way round.
inline Mesh random_soup(int count, double size, std::uint64_t seed) {
  Mesh mesh;
  mesh.V.resize(count * 3, 3);
  mesh.F.resize(count, 3);
  for (int f = 0; f < count; ++f) {
    Random random(seed, static_cast<std::uint64_t>(f));
    const Vec3 centre(random.uniform(), random.uniform(), random.uniform());
    for (int k = 0; k < 3; ++k) {
      mesh.V.row(3 * f + k) = (centre + size * random.direction()).transpose();
      mesh.F(f, k) = 3 * f + k;
    }
  }
  return mesh;
}

inline Points random_points(int count, double low, double high, std::uint64_t seed) {
  Points X(count, 3);
  Random random(seed, 77);
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) X(i, k) = low + (high - low) * random.uniform();
  return X;
}

inline Vec3 row(const Points& X, Eigen::Index i) { return X.row(i).transpose(); }

}  // namespace skinfield_test
