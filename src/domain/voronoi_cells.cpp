#include "domain/voronoi_cells.h"

#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

constexpr double cap = 1.6;           // of h: a cell reaches no further
constexpr double largest_cell = 1.5;  // of h^3: blocked cells overlap, so clip (findings A)

/// Directions spread evenly over the sphere (Fibonacci lattice).
Eigen::Matrix<double, 3, Eigen::Dynamic> fibonacci_sphere(int n) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> D(3, n);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < n; ++i) {
    const double z = 1 - (2.0 * i + 1) / n;
    const double r = std::sqrt(1 - z * z);
    D.col(i) = Vec3(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return D;
}

Eigen::Matrix3d random_rotation(Random& random) {
  Eigen::Quaterniond q(random.normal(), random.normal(), random.normal(), random.normal());
  return q.normalized().toRotationMatrix();
}

struct Facet {
  int neighbour;
  double area;
};

}  // namespace

std::vector<std::vector<Neighbour>> visible_neighbours(const Solid& solid,
                                                       const SampledNodes& nodes,
                                                       const KdTree& tree, int candidates,
                                                       int wanted, const Progress& progress) {
  std::vector<std::vector<Neighbour>> all(static_cast<std::size_t>(nodes.X.rows()));
  parallel_blocks(all.size(), 64, [&](std::size_t begin, std::size_t end) {
    progress.check();
    std::vector<Neighbour> found;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(nodes.sites[i].x, candidates + 1, found);
      for (const Neighbour& n : found) {
        if (n.index == static_cast<int>(i)) continue;
        if (static_cast<int>(all[i].size()) == wanted) break;
        if (!solid.blocked(nodes.sites[i], nodes.sites[static_cast<std::size_t>(n.index)]))
          all[i].push_back(n);
      }
    }
  });
  return all;
}

VoronoiCells voronoi_cells(const Solid& solid, const SampledNodes& nodes,
                           const std::vector<std::vector<Neighbour>>& neighbours, int directions,
                           std::uint64_t seed, const Progress& progress) {
  const auto n = static_cast<std::size_t>(nodes.X.rows());
  const auto D = fibonacci_sphere(directions);
  const double solid_angle = 4 * std::numbers::pi / directions;
  std::vector<std::vector<Facet>> facets(n);
  VoronoiCells cells;
  cells.M = Vector::Zero(static_cast<Eigen::Index>(n));
  std::vector<std::int64_t> rays((n + 31) / 32, 0);

  parallel_blocks(n, 32, [&](std::size_t begin, std::size_t end) {
    progress.check();
    const auto count = static_cast<std::size_t>(directions);
    std::vector<float> dx(count), dy(count), dz(count), nearest(count);
    std::vector<std::int32_t> who(count);
    std::vector<Vec3> direction(count);
    std::vector<double> t(count);
    std::vector<unsigned char> hit(count);
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, 0x60000000ull + i);
      const Eigen::Matrix3d R = random_rotation(random);
      const double h = nodes.spacing[static_cast<Eigen::Index>(i)];
      const float limit = static_cast<float>(cap * h);
      for (std::size_t d = 0; d < count; ++d) {
        direction[d] = R * D.col(static_cast<Eigen::Index>(d));
        dx[d] = static_cast<float>(direction[d][0]);
        dy[d] = static_cast<float>(direction[d][1]);
        dz[d] = static_cast<float>(direction[d][2]);
        nearest[d] = limit;
        who[d] = -1;
      }
      // t to the bisector plane with neighbour j: |e|^2 / (2 d.e), e = x_j - x_i.
      const Vec3& x = nodes.sites[i].x;
      for (std::size_t j = 0; j < neighbours[i].size(); ++j) {
        if (0.5 * neighbours[i][j].distance >= static_cast<double>(limit)) break;
        const Vec3 e = nodes.sites[static_cast<std::size_t>(neighbours[i][j].index)].x - x;
        const double squared = e.squaredNorm();
        const float ex = static_cast<float>(2 * e[0] / squared);
        const float ey = static_cast<float>(2 * e[1] / squared);
        const float ez = static_cast<float>(2 * e[2] / squared);
        const auto id = static_cast<std::int32_t>(j);
        for (std::size_t d = 0; d < count; ++d) {
          const float inverse = dx[d] * ex + dy[d] * ey + dz[d] * ez;
          const bool closer = inverse * nearest[d] > 1.f;
          nearest[d] = closer ? 1.f / inverse : nearest[d];
          who[d] = closer ? id : who[d];
        }
      }
      for (std::size_t d = 0; d < count; ++d) t[d] = static_cast<double>(nearest[d]);
      solid.reach(nodes.sites[i], direction, t, hit);
      rays[i / 32] += directions;

      double volume = 0;
      std::vector<double> area(neighbours[i].size(), 0);
      for (std::size_t d = 0; d < count; ++d) {
        volume += solid_angle * t[d] * t[d] * t[d] / 3;
        if (hit[d] || who[d] < 0) continue;
        const auto& neighbour = neighbours[i][static_cast<std::size_t>(who[d])];
        const Vec3 e = nodes.sites[static_cast<std::size_t>(neighbour.index)].x - x;
        const double cosine = direction[d].dot(e) / neighbour.distance;
        area[static_cast<std::size_t>(who[d])] += solid_angle * t[d] * t[d] / cosine;
      }
      cells.M[static_cast<Eigen::Index>(i)] =
          std::clamp(volume, 1e-9 * h * h * h, largest_cell * h * h * h);
      for (std::size_t j = 0; j < area.size(); ++j)
        if (area[j] > 0) facets[i].push_back({neighbours[i][j].index, area[j]});
    }
  });
  for (std::int64_t r : rays) cells.rays += r;

  // w_ij = (A_ij + A_ji) / (2 |x_i - x_j|): symmetric and positive.
  using Entry = Eigen::Triplet<double, std::int32_t>;
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < n; ++i)
    for (const Facet& f : facets[i]) {
      const double distance =
          (nodes.sites[i].x - nodes.sites[static_cast<std::size_t>(f.neighbour)].x).norm();
      const double w = 0.5 * f.area / distance;
      const auto a = static_cast<std::int32_t>(i), b = static_cast<std::int32_t>(f.neighbour);
      entries.emplace_back(a, b, -w);
      entries.emplace_back(b, a, -w);
    }
  cells.K.resize(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  cells.K.setFromTriplets(entries.begin(), entries.end());
  Vector diagonal = Vector::Zero(static_cast<Eigen::Index>(n));
  for (Eigen::Index i = 0; i < cells.K.rows(); ++i)
    for (SparseRows::InnerIterator it(cells.K, i); it; ++it) diagonal[i] -= it.value();
  SparseRows D0(cells.K.rows(), cells.K.cols());
  D0.reserve(Eigen::VectorXi::Constant(cells.K.rows(), 1));
  for (Eigen::Index i = 0; i < D0.rows(); ++i) D0.insert(i, i) = diagonal[i];
  cells.K += D0;
  cells.K.makeCompressed();
  return cells;
}

}  // namespace skinfield
