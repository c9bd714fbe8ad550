#include "domain/tet_handles.h"

#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace skinfield {
namespace {

constexpr double kOnHandle = 1e-6;     // of the box diagonal (design.md 4)
constexpr double kSamplesPerEdge = 2;  // of handles, in mean edges
constexpr double kLeastStep = 0.35;    // between them, of the edges of the tet there
constexpr int kMostSamples = 20000;    // of one handle

using Claims = std::vector<std::set<int>>;  // vertices of each handle

double mean_edge(const Points& V, const Tetrahedra& T) {
  double sum = 0;
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) sum += (V.row(T(t, a)) - V.row(T(t, b))).norm() / 6;
    }
  }
  return sum / static_cast<double>(std::max<Eigen::Index>(T.rows(), 1));
}

/// Vertices of tets that lie on each handle.
Claims vertices_on_handles(const Points& V, const std::vector<char>& used,
                           const std::vector<Handle>& handles, double tolerance) {
  Claims on(handles.size());
  parallel_for(handles.size(), 1, [&](std::size_t h) {
    const Handle& handle = handles[h];
    if (handle.kind == Handle::Kind::region) {
      for (const int v : handle.vertices) {
        if (v >= 0 && static_cast<std::size_t>(v) < used.size() &&
            used[static_cast<std::size_t>(v)]) {
          on[h].insert(v);
        }
      }
      return;
    }
    for (int v = 0; v < V.rows(); ++v) {
      if (!used[static_cast<std::size_t>(v)]) continue;
      if (handle_distance(handle, V.row(v).transpose()) <= tolerance) on[h].insert(v);
    }
  });
  return on;
}

/// The samples of a handle that lie in the mesh. A bone of which little is inside is sampled more
/// densely, until two fall in.
std::vector<Vec3> samples_inside(const Handle& handle, double spacing, const TetSplitter& splitter,
                                 const ClosestPointQuery& boundary, double tolerance) {
  std::vector<Vec3> inside;
  const std::size_t wanted = handle.kind == Handle::Kind::bone ? 2 : 1;
  double length = 0;
  for (const auto& [a, b] : handle.segments) length += (b - a).norm();
  for (int halvings = 0; halvings < 5; ++halvings) {
    const double step = std::max(spacing / (1 << halvings), length / kMostSamples);
    inside.clear();
    const Points X = sample_handle(handle, step);
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      const Vec3 x = X.row(i).transpose();
      if (!splitter.find(x).corner.empty()) {
        inside.push_back(x);
        continue;
      }
      // A handle on the boundary may lie a rounding error outside.
      const ClosestPoint closest = boundary.at(x, tolerance);
      if (closest.face >= 0 && !splitter.find(closest.point).corner.empty()) {
        inside.push_back(closest.point);
      }
    }
    if (inside.size() >= wanted || handle.kind != Handle::Kind::bone) break;
  }
  return inside;
}

/// The ends of a bone's segments come first: they are vertices whatever lies near them.
std::vector<Vec3> ends_first(const std::vector<Vec3>& samples, const Handle& handle) {
  std::vector<Vec3> sorted = samples;
  std::stable_partition(sorted.begin(), sorted.end(), [&](const Vec3& x) {
    return std::any_of(handle.segments.begin(), handle.segments.end(),
                       [&](const auto& s) { return s.first == x || s.second == x; });
  });
  return sorted;
}

/// Splits the mesh at one handle's samples; what it holds then. Where the tets are larger than
/// average, samples are left out: a tet cut into many has only slivers to give.
std::set<int> make_vertices(const std::vector<Vec3>& samples, const Handle& handle,
                            std::map<int, int>& holders, TetSplitter& splitter, double tolerance) {
  std::set<int> held;
  std::optional<int> last_resort;
  for (const Vec3& x : ends_first(samples, handle)) {
    const double step = kLeastStep * splitter.edge_at(x);
    const bool near = std::any_of(held.begin(), held.end(),
                                  [&](int v) { return (splitter.position(v) - x).norm() < step; });
    if (near && held.size() >= 2) continue;
    const TetSplitter::Place place = splitter.find(x);
    if (place.corner.empty()) continue;
    const int there = place.vertex();
    // Another handle's vertex that is only near is not for sharing, unless there is no other.
    if (there >= 0 && holders.contains(there) && !held.contains(there) &&
        handle_distance(handle, splitter.position(there)) > tolerance) {
      if (!last_resort) last_resort = there;
      continue;
    }
    held.insert(splitter.make_vertex(place));
  }
  if (held.empty() && last_resort) held.insert(*last_resort);
  for (const int v : held) ++holders[v];
  return held;
}

FixedRows rows_of(const Claims& on, Eigen::Index columns) {
  std::map<int, std::vector<int>> owners;
  for (std::size_t h = 0; h < on.size(); ++h) {
    for (const int v : on[h]) owners[v].push_back(static_cast<int>(h));
  }
  FixedRows fixed;
  fixed.weights = RowMatrix::Zero(static_cast<Eigen::Index>(owners.size()), columns);
  for (const auto& [v, of] : owners) {
    const auto row = static_cast<Eigen::Index>(fixed.node.size());
    fixed.node.push_back(v);
    for (const int h : of) fixed.weights(row, h) = 1.0 / static_cast<double>(of.size());
  }
  return fixed;
}

}  // namespace

TetSplit split_at_handles(const Points& V, const Tetrahedra& T,
                          const std::vector<Handle>& handles) {
  TetSplit result;
  result.V = V;
  result.T = T;
  std::vector<char> used(static_cast<std::size_t>(V.rows()), 0);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int c = 0; c < 4; ++c) used[static_cast<std::size_t>(T(t, c))] = 1;
  }
  const double tolerance = kOnHandle * diagonal(bounding_box(V));
  Claims on = vertices_on_handles(V, used, handles, tolerance);
  const auto lacks = [&](std::size_t h) {
    return on[h].empty() && handles[h].kind != Handle::Kind::region;
  };
  bool split = false;
  for (std::size_t h = 0; h < handles.size(); ++h) split |= lacks(h);
  if (split) {
    std::map<int, int> holders;
    for (const auto& list : on) {
      for (const int v : list) ++holders[v];
    }
    TetSplitter splitter(V, T);
    const ClosestPointQuery boundary(V, boundary_faces(V, T));
    const double spacing = mean_edge(V, T) / kSamplesPerEdge;
    for (std::size_t h = 0; h < handles.size(); ++h) {
      if (!lacks(h)) continue;
      const std::vector<Vec3> samples =
          samples_inside(handles[h], spacing, splitter, boundary, tolerance);
      on[h] = make_vertices(samples, handles[h], holders, splitter, tolerance);
      result.split_handles += on[h].empty() ? 0 : 1;
    }
    result.V = splitter.points();
    result.T = splitter.tets();
    result.made = splitter.made();
    // A new vertex may lie on other handles too: those that cross there.
    for (int v = static_cast<int>(V.rows()); v < splitter.vertices(); ++v) {
      for (std::size_t h = 0; h < handles.size(); ++h) {
        if (handles[h].kind != Handle::Kind::region &&
            handle_distance(handles[h], splitter.position(v)) <= tolerance) {
          on[h].insert(v);
        }
      }
    }
  }
  for (std::size_t h = 0; h < handles.size(); ++h) {
    if (on[h].empty()) result.outside.push_back(static_cast<int>(h));
  }
  result.fixed = rows_of(on, static_cast<Eigen::Index>(handles.size()));
  return result;
}

}  // namespace skinfield
