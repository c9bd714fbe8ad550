#include "render/surface.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace skinfield::render_detail {
namespace {

double corner_angle(const Vec3& at, const Vec3& b, const Vec3& c) {
  const Vec3 p = b - at, q = c - at;
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

Vec3 any_perpendicular(const Vec3& axis) {
  const Vec3 other = std::abs(axis.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  return axis.cross(other).normalized();
}

class Builder {
 public:
  int vertex(const Vec3& p) {
    positions_.push_back(p);
    return static_cast<int>(positions_.size()) - 1;
  }
  void face(int a, int b, int c) { faces_.push_back({a, b, c}); }
  std::size_t faces() const { return faces_.size(); }

  Surface finish() const {
    Surface s;
    s.V.resize(static_cast<Eigen::Index>(positions_.size()), 3);
    s.F.resize(static_cast<Eigen::Index>(faces_.size()), 3);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      s.V.row(static_cast<Eigen::Index>(i)) = positions_[i].transpose();
    }
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      s.F.row(static_cast<Eigen::Index>(i)) << faces_[i][0], faces_[i][1], faces_[i][2];
    }
    return s;
  }

 private:
  std::vector<Vec3> positions_;
  std::vector<std::array<int, 3>> faces_;
};

/// Blender's bone shape: widest at a tenth of its length.
void add_bone(Builder& builder, const Vec3& head, const Vec3& tail, double thinnest) {
  const Vec3 axis = tail - head;
  const double length = axis.norm();
  if (!(length > 0)) return;
  const double radius = std::clamp(0.09 * length, std::min(thinnest, 0.25 * length), 0.02);
  const Vec3 a = any_perpendicular(axis / length), b = axis.cross(a) / length;
  const Vec3 middle = head + 0.12 * axis;
  const int start = builder.vertex(head), end = builder.vertex(tail);
  const std::array<int, 4> ring = {
      builder.vertex(middle + radius * a), builder.vertex(middle + radius * b),
      builder.vertex(middle - radius * a), builder.vertex(middle - radius * b)};
  for (std::size_t i = 0; i < 4; ++i) {
    const int p = ring[i], q = ring[(i + 1) % 4];
    builder.face(start, q, p);
    builder.face(end, p, q);
  }
}

void add_dot(Builder& builder, const Vec3& centre, double radius) {
  constexpr int meridians = 12, parallels = 8;
  const int north = builder.vertex(centre + radius * Vec3::UnitZ());
  int first = 0;
  for (int i = 1; i < parallels; ++i) {
    const double theta = std::numbers::pi * i / parallels;
    for (int j = 0; j < meridians; ++j) {
      const double phi = 2 * std::numbers::pi * j / meridians;
      const int v =
          builder.vertex(centre + radius * Vec3(std::sin(theta) * std::cos(phi),
                                                std::sin(theta) * std::sin(phi), std::cos(theta)));
      if (i == 1 && j == 0) first = v;
    }
  }
  const int south = builder.vertex(centre - radius * Vec3::UnitZ());
  for (int j = 0; j < meridians; ++j) {
    const int k = (j + 1) % meridians;
    builder.face(north, first + j, first + k);
    for (int i = 0; i + 2 < parallels; ++i) {
      const int row = first + i * meridians, next = row + meridians;
      builder.face(row + j, next + j, next + k);
      builder.face(row + j, next + k, row + k);
    }
    const int last = first + (parallels - 2) * meridians;
    builder.face(south, last + k, last + j);
  }
}

}  // namespace

Points corner_normals(const Points& V, const Triangles& F, double crease) {
  const Welded welded = weld(V);
  const auto vertex_of = [&](Eigen::Index f, int c) {
    return static_cast<std::size_t>(welded.vertex[static_cast<std::size_t>(F(f, c))]);
  };
  Points unit = face_normals(V, F);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const double length = unit.row(f).norm();
    if (length > 0) unit.row(f) /= length;
  }
  // Corners of every welded vertex, compressed rows.
  std::vector<std::size_t> start(static_cast<std::size_t>(welded.V.rows()) + 1, 0);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) ++start[vertex_of(f, c) + 1];
  }
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::size_t> fill(start.begin(), start.end() - 1);
  std::vector<Eigen::Index> faces(static_cast<std::size_t>(F.size()));
  std::vector<double> angle(faces.size());
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const std::size_t slot = fill[vertex_of(f, c)]++;
      faces[slot] = f;
      angle[slot] =
          corner_angle(V.row(F(f, c)), V.row(F(f, (c + 1) % 3)), V.row(F(f, (c + 2) % 3)));
    }
  }
  const double least = std::cos(crease * std::numbers::pi / 180);
  Points normals(3 * F.rows(), 3);
  parallel_for(static_cast<std::size_t>(F.rows()), 4096, [&](std::size_t i) {
    const auto f = static_cast<Eigen::Index>(i);
    for (int c = 0; c < 3; ++c) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      const std::size_t v = vertex_of(f, c);
      for (std::size_t k = start[v]; k < start[v + 1]; ++k) {
        if (unit.row(faces[k]).dot(unit.row(f)) >= least) sum += angle[k] * unit.row(faces[k]);
      }
      const double length = sum.norm();
      normals.row(3 * f + c) =
          length > 0 ? Eigen::RowVector3d(sum / length) : Eigen::RowVector3d(unit.row(f));
    }
  });
  return normals;
}

Surface discs(const Points& V, const Points& normals, const Vec3& toward_viewer, double radius) {
  constexpr int corners = 6;
  Surface s;
  const Eigen::Index n = V.rows();
  s.V.resize(corners * n, 3);
  s.F.resize((corners - 2) * n, 3);
  s.corner_normals.resize(3 * s.F.rows(), 3);
  s.vertex_source.resize(static_cast<std::size_t>(s.V.rows()));
  for (Eigen::Index i = 0; i < n; ++i) {
    Vec3 normal = toward_viewer;
    if (normals.rows() == n && normals.row(i).norm() > 0) normal = normals.row(i).normalized();
    const Vec3 a = any_perpendicular(normal), b = normal.cross(a);
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      const Eigen::Index v = corners * i + k;
      s.V.row(v) = V.row(i) + radius * (std::cos(angle) * a + std::sin(angle) * b).transpose();
      s.vertex_source[static_cast<std::size_t>(v)] = static_cast<int>(i);
    }
    const int first = static_cast<int>(corners * i);
    for (int k = 0; k + 2 < corners; ++k) {
      const Eigen::Index f = (corners - 2) * i + k;
      s.F.row(f) << first, first + k + 1, first + k + 2;
      for (int c = 0; c < 3; ++c) s.corner_normals.row(3 * f + c) = normal.transpose();
    }
  }
  return s;
}

Surface skeleton_shape(const std::vector<std::pair<Vec3, Vec3>>& bones,
                       const std::vector<Vec3>& dots, double dot_radius, std::vector<int>& part) {
  Builder builder;
  part.clear();
  for (std::size_t i = 0; i < bones.size(); ++i) {
    add_bone(builder, bones[i].first, bones[i].second, 0.6 * dot_radius);
    part.resize(builder.faces(), static_cast<int>(i));
  }
  for (const Vec3& dot : dots) {
    add_dot(builder, dot, dot_radius);
    part.resize(builder.faces(), -1);
  }
  Surface s = builder.finish();
  s.corner_normals = corner_normals(s.V, s.F, 40);
  return s;
}

}  // namespace skinfield::render_detail
