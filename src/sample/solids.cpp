#include "sample/solids.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace skinfield::sample_detail {
namespace {

/// Positions of grid lines along one side: dense in the rounded ends.
std::vector<double> grid_lines(double half, double radius, double edge) {
  const double inner = half - radius;
  const int bend = std::max(2, static_cast<int>(std::lround(0.8 * radius / edge)));
  const int straight = inner > 0 ? std::max(1, static_cast<int>(std::lround(2 * inner / edge))) : 0;
  std::vector<double> lines;
  for (int i = 0; i < bend; ++i) {
    // Equal angles on the rounded edge.
    lines.push_back(-inner - radius * std::tan(0.25 * std::numbers::pi * (bend - i) / bend));
  }
  for (int i = 0; i <= straight; ++i) {
    lines.push_back(straight ? inner * (2.0 * i / straight - 1) : 0.0);
  }
  for (int i = 1; i <= bend; ++i) {
    lines.push_back(inner + radius * std::tan(0.25 * std::numbers::pi * i / bend));
  }
  return lines;
}

}  // namespace

void SolidBuilder::rounded_box(const Vec3& centre, const Vec3& half_size, double radius) {
  std::array<std::vector<double>, 3> lines;
  for (std::size_t d = 0; d < 3; ++d) {
    lines[d] = grid_lines(half_size[static_cast<Eigen::Index>(d)], radius, edge_);
  }
  const Vec3 inner = half_size - Vec3::Constant(radius);
  std::map<std::array<int, 3>, int> known;
  const auto vertex = [&](const std::array<int, 3>& index) {
    const auto [it, fresh] = known.try_emplace(index, vertices());
    if (fresh) {
      Vec3 p;
      for (std::size_t d = 0; d < 3; ++d) {
        p[static_cast<Eigen::Index>(d)] = lines[d][static_cast<std::size_t>(index[d])];
      }
      const Vec3 core = p.cwiseMax(-inner).cwiseMin(inner);
      positions_.push_back(centre + core + radius * (p - core).normalized());
    }
    return it->second;
  };
  for (std::size_t d = 0; d < 3; ++d) {
    const std::size_t u = (d + 1) % 3, v = (d + 2) % 3;
    for (const bool upper : {false, true}) {
      for (int i = 0; i + 1 < static_cast<int>(lines[u].size()); ++i) {
        for (int j = 0; j + 1 < static_cast<int>(lines[v].size()); ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> index{};
            index[d] = upper ? static_cast<int>(lines[d].size()) - 1 : 0;
            index[u] = i + a;
            index[v] = j + b;
            return vertex(index);
          };
          std::array<int, 4> quad = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (!upper) std::swap(quad[1], quad[3]);
          faces_.push_back({quad[0], quad[1], quad[2]});
          faces_.push_back({quad[0], quad[2], quad[3]});
        }
      }
    }
  }
}

void SolidBuilder::cylinder(const Vec3& a, double radius_a, const Vec3& b, double radius_b,
                            double rim) {
  // A profile (distance along the axis, radius) from the centre of one cap to that of the other.
  const Vec3 axis = b - a;
  const double length = axis.norm();
  const Vec3 along = axis / length;
  const Vec3 side =
      along.cross(std::abs(along.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitZ()).normalized();
  const Vec3 other = along.cross(side);
  std::vector<std::pair<double, double>> profile;
  const auto run = [&](double z0, double r0, double z1, double r1) {
    const int steps =
        std::max(1, static_cast<int>(std::lround(std::hypot(z1 - z0, r1 - r0) / edge_)));
    for (int i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      profile.emplace_back(z0 + t * (z1 - z0), r0 + t * (r1 - r0));
    }
  };
  const int bend = std::max(2, static_cast<int>(std::lround(1.6 * rim / edge_)));
  const auto round = [&](double z, double r, double first) {
    for (int i = 0; i < bend; ++i) {
      const double angle = first + 0.5 * std::numbers::pi * i / bend;
      profile.emplace_back(z - rim * std::cos(angle), r + rim * std::sin(angle));
    }
  };
  run(0, 0, 0, radius_a - rim);
  round(rim, radius_a - rim, 0);
  run(rim, radius_a, length - rim, radius_b);
  round(length - rim, radius_b - rim, 0.5 * std::numbers::pi);
  run(length, radius_b - rim, length, 0);

  const int around = std::max(
      8,
      static_cast<int>(std::lround(2 * std::numbers::pi * std::max(radius_a, radius_b) / edge_)));
  const int bottom = vertices();
  positions_.push_back(a);
  for (std::size_t ring = 1; ring < profile.size(); ++ring) {
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      positions_.push_back(a + profile[ring].first * along +
                           profile[ring].second *
                               (std::cos(angle) * side + std::sin(angle) * other));
    }
  }
  const int top = vertices();
  positions_.push_back(b);
  const int rings = static_cast<int>(profile.size()) - 1;
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around, last = bottom + 1 + (rings - 1) * around;
    faces_.push_back({bottom, bottom + 1 + next, bottom + 1 + k});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      const int low = bottom + 1 + ring * around, high = low + around;
      faces_.push_back({low + k, low + next, high + next});
      faces_.push_back({low + k, high + next, high + k});
    }
    faces_.push_back({top, last + k, last + next});
  }
}

Mesh SolidBuilder::finish() const {
  Mesh mesh;
  mesh.V.resize(vertices(), 3);
  mesh.F.resize(faces(), 3);
  for (int i = 0; i < vertices(); ++i) {
    mesh.V.row(i) = positions_[static_cast<std::size_t>(i)].transpose();
  }
  for (int f = 0; f < faces(); ++f) {
    const auto& face = faces_[static_cast<std::size_t>(f)];
    mesh.F.row(f) << face[0], face[1], face[2];
  }
  return mesh;
}

}  // namespace skinfield::sample_detail
