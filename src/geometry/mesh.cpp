#include "skinfield/geometry/mesh.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace skinfield {
namespace {

std::uint64_t hash_cell(const Vec3& cell) {
  std::uint64_t h = 0x9E3779B97F4A7C15ull;
  for (int k = 0; k < 3; ++k) {
    h ^= std::bit_cast<std::uint64_t>(cell[k] + 0.0);  // + 0.0: the two zeros are one cell
    h *= 0xFF51AFD7ED558CCDull;
    h ^= h >> 32;
  }
  return h;
}

int root_of(std::vector<int>& parent, int i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

Vec3 corner(const Points& V, std::int32_t i) { return V.row(i).transpose(); }

Vec3 face_normal(const Points& V, const Triangles& F, Eigen::Index f) {
  const Vec3 a = corner(V, F(f, 0));
  return (corner(V, F(f, 1)) - a).cross(corner(V, F(f, 2)) - a);
}

}  // namespace

Box3 bounding_box(const Points& V) {
  Box3 box;
  box.row(0) = V.colwise().minCoeff();
  box.row(1) = V.colwise().maxCoeff();
  return box;
}

double diagonal(const Box3& box) { return (box.row(1) - box.row(0)).norm(); }

Points UnitBox::to(const Points& X) const { return (X.rowwise() - origin.transpose()) * scale; }

Points UnitBox::from(const Points& X) const { return (X / scale).rowwise() + origin.transpose(); }

UnitBox unit_box(const Points& V) {
  const Box3 box = bounding_box(V);
  const double side = (box.row(1) - box.row(0)).maxCoeff();
  return {box.row(0).transpose(), side > 0 ? 1 / side : 1};
}

Welded weld(const Points& V, double tolerance) {
  const int n = static_cast<int>(V.rows());
  std::vector<int> first(std::bit_ceil(static_cast<std::size_t>(n) * 2 + 1), -1);
  const std::uint64_t mask = first.size() - 1;
  std::vector<int> next, representative;  // chains of new vertices in each bucket
  Welded welded;
  welded.vertex.resize(n);
  const double limit = tolerance * tolerance;
  for (int i = 0; i < n; ++i) {
    const Vec3 x = corner(V, i);
    const Vec3 cell = tolerance > 0 ? Vec3((x / tolerance).array().floor()) : x;
    int found = -1;
    const auto search = [&](const Vec3& at) {
      for (int j = first[hash_cell(at) & mask]; j >= 0; j = next[j]) {
        const double d2 = (corner(V, representative[j]) - x).squaredNorm();
        if ((d2 == 0 || d2 < limit) && (found < 0 || j < found)) found = j;
      }
    };
    if (tolerance > 0) {
      for (int k = 0; k < 27; ++k) search(cell + Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
    } else {
      search(cell);
    }
    if (found < 0) {
      found = static_cast<int>(representative.size());
      representative.push_back(i);
      int& bucket = first[hash_cell(cell) & mask];
      next.push_back(bucket);
      bucket = found;
    }
    welded.vertex[i] = found;
  }
  welded.V.resize(static_cast<Eigen::Index>(representative.size()), 3);
  for (std::size_t j = 0; j < representative.size(); ++j)
    welded.V.row(static_cast<Eigen::Index>(j)) = V.row(representative[j]);
  return welded;
}

Components connected_components(const Triangles& F, Eigen::Index vertices) {
  std::vector<int> parent(static_cast<std::size_t>(vertices));
  std::iota(parent.begin(), parent.end(), 0);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 1; k < 3; ++k) {
      const int a = root_of(parent, F(f, 0)), b = root_of(parent, F(f, k));
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  Components components;
  components.of_face.resize(static_cast<std::size_t>(F.rows()));
  std::vector<int> number(static_cast<std::size_t>(vertices), -1);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    int& c = number[root_of(parent, F(f, 0))];
    if (c < 0) c = components.count++;
    components.of_face[f] = c;
  }
  return components;
}

Points face_normals(const Points& V, const Triangles& F) {
  Points N(F.rows(), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) N.row(f) = face_normal(V, F, f).transpose();
  return N;
}

Vector face_areas(const Points& V, const Triangles& F) {
  return face_normals(V, F).rowwise().norm() / 2;
}

Points vertex_normals(const Points& V, const Triangles& F) {
  Points N = Points::Zero(V.rows(), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vec3 n = face_normal(V, F, f);
    const double length = n.norm();
    if (!(length > 0) || !std::isfinite(length)) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3 x = corner(V, F(f, k));
      const Vec3 p = corner(V, F(f, (k + 1) % 3)) - x, q = corner(V, F(f, (k + 2) % 3)) - x;
      N.row(F(f, k)) += std::atan2(length, p.dot(q)) / length * n.transpose();
    }
  }
  for (Eigen::Index i = 0; i < N.rows(); ++i) {
    const double length = N.row(i).norm();
    if (length > 0) N.row(i) /= length;
  }
  return N;
}

Triangles boundary_faces(const Points& V, const Tetrahedra& T) {
  // Faces of a tet with positive volume, outward.
  constexpr int face[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  struct Side {
    std::array<std::int32_t, 3> key, corners;
    std::int64_t number;
  };
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(T.rows()) * 4);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    const Vec3 a = corner(V, T(t, 0)), b = corner(V, T(t, 1)) - a, c = corner(V, T(t, 2)) - a,
               d = corner(V, T(t, 3)) - a;
    const bool inverted = b.cross(c).dot(d) < 0;
    for (int s = 0; s < 4; ++s) {
      Side side;
      for (int k = 0; k < 3; ++k) side.corners[k] = T(t, face[s][inverted ? 2 - k : k]);
      side.key = side.corners;
      std::sort(side.key.begin(), side.key.end());
      side.number = t * 4 + s;
      if (side.key[0] != side.key[1] && side.key[1] != side.key[2]) sides.push_back(side);
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.number < b.number;
  });
  std::vector<Side> boundary;
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    if ((end - i) % 2 == 1) boundary.push_back(sides[i]);  // shared by two: inside
  }
  std::sort(boundary.begin(), boundary.end(),
            [](const Side& a, const Side& b) { return a.number < b.number; });
  Triangles F(static_cast<Eigen::Index>(boundary.size()), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) F(f, k) = boundary[f].corners[k];
  return F;
}

}  // namespace skinfield
