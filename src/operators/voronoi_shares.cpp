#include "operators/voronoi_shares.h"

#include <cmath>
#include <vector>

namespace skinfield {
namespace {

using Tet = std::array<Vec3, 4>;

double volume(const Tet& t) {
  return std::abs((t[1] - t[0]).dot((t[2] - t[0]).cross(t[3] - t[0]))) / 6;
}

/// The prism between triangles a and b (corners matched), as three tetrahedra.
void add_prism(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, std::vector<Tet>& out) {
  out.push_back({a[0], a[1], a[2], b[2]});
  out.push_back({a[0], a[1], b[1], b[2]});
  out.push_back({a[0], b[0], b[1], b[2]});
}

/// Adds the part of t where the affine function with these corner values is not negative.
void clip(const Tet& t, const std::array<double, 4>& f, std::vector<Tet>& out) {
  std::array<int, 4> in{}, off{};
  int ins = 0, offs = 0;
  for (int i = 0; i < 4; ++i) {
    if (f[static_cast<std::size_t>(i)] >= 0)
      in[static_cast<std::size_t>(ins++)] = i;
    else
      off[static_cast<std::size_t>(offs++)] = i;
  }
  const auto at = [&](int i) -> const Vec3& { return t[static_cast<std::size_t>(i)]; };
  // Where the edge from corner i (inside) to corner o (outside) is cut.
  const auto cut = [&](int i, int o) -> Vec3 {
    const double fi = f[static_cast<std::size_t>(i)], fo = f[static_cast<std::size_t>(o)];
    return at(i) + fi / (fi - fo) * (at(o) - at(i));
  };
  switch (ins) {
    case 0:
      break;
    case 1:
      out.push_back({at(in[0]), cut(in[0], off[0]), cut(in[0], off[1]), cut(in[0], off[2])});
      break;
    case 2:
      add_prism({at(in[0]), cut(in[0], off[0]), cut(in[0], off[1])},
                {at(in[1]), cut(in[1], off[0]), cut(in[1], off[1])}, out);
      break;
    case 3:
      add_prism({at(in[0]), at(in[1]), at(in[2])},
                {cut(in[0], off[0]), cut(in[1], off[0]), cut(in[2], off[0])}, out);
      break;
    default:
      out.push_back(t);
  }
}

}  // namespace

std::array<double, 4> voronoi_shares(const std::array<Vec3, 4>& corner) {
  std::array<double, 4> share{};
  std::vector<Tet> part, cut;
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    // Relative to the corner: y is nearer to it than to e where |e|^2 - 2 y.e >= 0.
    Tet whole;
    for (std::size_t k = 0; k < 4; ++k) whole[k] = corner[k] - corner[i];
    part.assign(1, whole);
    for (std::size_t j = 0; j < 4; ++j) {
      if (j == i) continue;
      const Vec3& e = whole[j];
      cut.clear();
      for (const Tet& t : part) {
        std::array<double, 4> f{};
        for (std::size_t k = 0; k < 4; ++k) f[k] = e.squaredNorm() - 2 * t[k].dot(e);
        clip(t, f, cut);
      }
      part.swap(cut);
    }
    for (const Tet& t : part) share[i] += volume(t);
    sum += share[i];
  }
  // Exact but for rounding, which slivers can have a lot of.
  const double total = volume(corner);
  for (double& s : share) s = sum > 0 ? s * total / sum : total / 4;
  return share;
}

std::array<double, 3> voronoi_shares(const std::array<Vec3, 3>& corner) {
  std::array<double, 3> share{}, cosine{};
  const double area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm() / 2;
  for (std::size_t i = 0; i < 3; ++i)
    cosine[i] = (corner[(i + 1) % 3] - corner[i]).dot(corner[(i + 2) % 3] - corner[i]);
  for (std::size_t i = 0; i < 3; ++i) {
    if (cosine[i] > 0) continue;
    share.fill(area / 4);
    share[i] = area / 2;
    return share;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    // (|PR|^2 cot Q + |PQ|^2 cot R) / 8, with cot = cosine product / (2 area).
    share[i] = ((corner[k] - corner[i]).squaredNorm() * cosine[j] +
                (corner[j] - corner[i]).squaredNorm() * cosine[k]) /
               (16 * area);
  }
  return share;
}

}  // namespace skinfield
