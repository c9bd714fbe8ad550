#include "skinfield/geometry/diagnosis.h"

#include "geometry/edges.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"
#include "skinfield/geometry/plane.h"
#include "skinfield/geometry/ray_scene.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace skinfield {
namespace {

constexpr double kFlat = 1e-6;     // of the diagonal: out of the plane
constexpr double kSliver = 1e-12;  // twice the area over the squared longest edge

Points finite_rows(const Points& V) {
  Points kept(V.rows(), 3);
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < V.rows(); ++i)
    if (V.row(i).allFinite()) kept.row(n++) = V.row(i);
  return kept.topRows(n);
}

Vec3 corner(const Points& V, std::int32_t i) { return V.row(i).transpose(); }

bool is_degenerate(const Points& V, const Triangles& F, Eigen::Index f) {
  if (!has_three_corners(F, f)) return true;
  const Vec3 a = corner(V, F(f, 0)), b = corner(V, F(f, 1)), c = corner(V, F(f, 2));
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return !((b - a).cross(c - a).norm() > kSliver * longest);
}

/// Whether the open segment p-q passes strictly through the inside of triangle a, b, c.
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double above = n.dot(p - a), below = n.dot(q - a);
  const double noise = 1e-12 * n.norm() * ((q - p).norm() + (p - a).norm());
  if (!((above > noise && below < -noise) || (above < -noise && below > noise))) return false;
  const Vec3 d = q - p, pa = a - p, pb = b - p, pc = c - p;
  const double u = pb.cross(pc).dot(d), v = pc.cross(pa).dot(d), w = pa.cross(pb).dot(d);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

void count_edges(const Triangles& F, Diagnosis& d) {
  for_each_edge(F, [&](std::span<const HalfEdge> around) {
    d.boundary_edges += around.size() == 1;
    d.nonmanifold_edges += around.size() > 2;
    d.inconsistent_edges += around.size() == 2 && around[0].forward == around[1].forward;
  });
}

std::int64_t count_duplicates(const Triangles& F) {
  std::vector<std::array<std::int32_t, 3>> keys;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (!has_three_corners(F, f)) continue;
    keys.push_back({F(f, 0), F(f, 1), F(f, 2)});
    std::sort(keys.back().begin(), keys.back().end());
  }
  const auto total = static_cast<std::int64_t>(keys.size());
  std::sort(keys.begin(), keys.end());
  return total - (std::unique(keys.begin(), keys.end()) - keys.begin());
}

/// All faces, or `samples` of them at random.
std::vector<int> choose_faces(Eigen::Index faces, int samples, std::uint64_t seed) {
  std::vector<int> chosen(static_cast<std::size_t>(faces));
  std::iota(chosen.begin(), chosen.end(), 0);
  if (samples >= faces) return chosen;
  Random random(seed);
  const int count = std::max(samples, 0);
  for (int i = 0; i < count; ++i)
    std::swap(chosen[i], chosen[i + random.below(static_cast<std::uint32_t>(chosen.size()) - i)]);
  chosen.resize(static_cast<std::size_t>(count));
  return chosen;
}

using Pairs = std::vector<std::pair<int, int>>;

/// An edge and those chosen faces that have it.
struct Probe {
  int low, high;
  std::vector<int> faces;
};

std::vector<Probe> find_probes(const Triangles& F, const std::vector<int>& chosen) {
  std::vector<char> is_chosen(static_cast<std::size_t>(F.rows()), 0);
  for (const int f : chosen) is_chosen[f] = 1;
  std::vector<Probe> probes;
  for_each_edge(F, [&](std::span<const HalfEdge> around) {
    Probe probe{around[0].low, around[0].high, {}};
    for (const HalfEdge& edge : around)
      if (is_chosen[edge.face]) probe.faces.push_back(edge.face);
    if (!probe.faces.empty()) probes.push_back(std::move(probe));
  });
  return probes;
}

bool share_corner(const Triangles& F, int f, int g) {
  for (int i = 0; i < 3; ++i)
    if ((F.row(g).array() == F(f, i)).any()) return true;
  return false;
}

/// Pairs of a probe's faces and those that its edge pierces, without such that share a corner.
void find_pierced(const RayScene& scene, const Points& V, const Triangles& F, const Probe& probe,
                  std::vector<int>& along, Pairs& pairs) {
  const Vec3 p = corner(V, probe.low), q = corner(V, probe.high);
  scene.faces_along(p, q, along);
  for (const int g : along) {
    if (!pierces(p, q, corner(V, F(g, 0)), corner(V, F(g, 1)), corner(V, F(g, 2)))) continue;
    for (const int f : probe.faces)
      if (!share_corner(F, f, g)) pairs.emplace_back(std::min(f, g), std::max(f, g));
  }
}

void count_intersections(const Points& V, const Triangles& F, const DiagnosisOptions& options,
                         const Progress& progress, Diagnosis& d) {
  const std::vector<int> faces = choose_faces(F.rows(), options.intersection_samples, options.seed);
  if (faces.empty()) return;
  const RayScene scene(V, F);
  const std::vector<Probe> probes = find_probes(F, faces);
  Pairs pairs = parallel_reduce(
      probes.size(), 256, Pairs(),
      [&](std::size_t begin, std::size_t end) {
        progress.check();
        Pairs part;
        std::vector<int> along;
        for (std::size_t i = begin; i < end; ++i) find_pierced(scene, V, F, probes[i], along, part);
        return part;
      },
      [](Pairs all, const Pairs& part) {
        all.insert(all.end(), part.begin(), part.end());
        return all;
      });
  std::sort(pairs.begin(), pairs.end());
  d.intersecting_pairs_sampled = std::unique(pairs.begin(), pairs.end()) - pairs.begin();
  d.intersection_faces_tested = static_cast<std::int64_t>(faces.size());
  d.self_intersecting = d.intersecting_pairs_sampled > 0;
}

}  // namespace

Diagnosis diagnose(const Mesh& mesh, const DiagnosisOptions& options, const Progress& progress) {
  Diagnosis d;
  d.vertices = mesh.V.rows();
  d.faces = mesh.F.rows();
  d.tets = mesh.T.rows();
  const Points finite = finite_rows(mesh.V);
  d.non_finite_vertices = mesh.V.rows() - finite.rows();
  if (finite.rows() > 0) {
    d.box = bounding_box(finite);
    d.planar = plane_of(finite, kFlat * diagonal(d.box)).has_value();
  }
  const Welded welded = weld(mesh.V);
  d.merged_vertices = welded.V.rows();
  Triangles F = mesh.F;
  for (Eigen::Index i = 0; i < F.size(); ++i) F.data()[i] = welded.vertex[F.data()[i]];
  if (!mesh.is_point_cloud()) {
    std::vector<char> used(static_cast<std::size_t>(mesh.V.rows()), 0);
    for (Eigen::Index i = 0; i < mesh.F.size(); ++i) used[mesh.F.data()[i]] = 1;
    for (Eigen::Index i = 0; i < mesh.T.size(); ++i) used[mesh.T.data()[i]] = 1;
    const Segments& E = mesh.outline.E;
    for (Eigen::Index i = 0; i < E.size(); ++i) used[E.data()[i]] = 1;
    d.unreferenced_vertices = std::count(used.begin(), used.end(), 0);
  }
  progress.check();

  d.components = connected_components(F, welded.V.rows()).count;
  count_edges(F, d);
  d.duplicate_faces = count_duplicates(F);
  const Vec3 centre = d.box.colwise().mean().transpose();
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    d.degenerate_faces += is_degenerate(welded.V, F, f);
    const Vec3 a = corner(welded.V, F(f, 0)) - centre, b = corner(welded.V, F(f, 1)) - centre,
               c = corner(welded.V, F(f, 2)) - centre;
    const double area = (b - a).cross(c - a).norm() / 2;
    if (!std::isfinite(area)) continue;
    d.area += area;
    d.volume += a.cross(b).dot(c) / 6;
  }
  d.watertight = d.faces > d.degenerate_faces && d.boundary_edges == 0 && d.nonmanifold_edges == 0;
  progress.check();
  count_intersections(welded.V, F, options, progress, d);
  return d;
}

}  // namespace skinfield
