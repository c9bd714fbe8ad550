#include "skinfield/domain/tetrahedraliser.h"

#include "domain/alpha_wrap.h"
#include "domain/surface_refinement.h"
#include "domain/tetgen_mesher.h"
#include "geometry/edges.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/geometry/winding_number.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace skinfield {
namespace {

constexpr const char* kRemedy = "use --domain points, which takes any mesh";
constexpr double kWrapOffset = 1.0 / 30;  // of alpha (findings: closed in 17 of 17)
constexpr double kLongEdge = 1.5;         // of the edges inside, from which on surface edges split
// Box diagonal over alpha, coarse to fine: closed gaps open up, until the wrap comes out hollow.
constexpr std::array<double, 8> kWrapFineness{10, 14, 20, 28, 40, 56, 75, 100};
constexpr std::array<double, 3> kSheetFineness{7, 5, 3};

struct CleanSurface {
  Points V;
  Triangles F;
  std::vector<int> vertex;     ///< of the input, for each row of V
  std::string why_not_closed;  ///< empty if TetGen may take it
};

/// Faces with an area, each once; referenced vertices only.
CleanSurface clean(const Mesh& mesh) {
  CleanSurface result;
  const Vector area = face_areas(mesh.V, mesh.F);
  std::set<std::array<int, 3>> seen;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    std::array<int, 3> key{mesh.F(f, 0), mesh.F(f, 1), mesh.F(f, 2)};
    std::sort(key.begin(), key.end());
    if (area[f] > 0 && seen.insert(key).second) kept.push_back(f);
  }
  std::vector<int> number(static_cast<std::size_t>(mesh.V.rows()), -1);
  result.F.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (int c = 0; c < 3; ++c) number[static_cast<std::size_t>(mesh.F(kept[i], c))] = 0;
  }
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<int>(result.vertex.size());
    result.vertex.push_back(static_cast<int>(v));
  }
  result.V.resize(static_cast<Eigen::Index>(result.vertex.size()), 3);
  for (std::size_t i = 0; i < result.vertex.size(); ++i) {
    result.V.row(static_cast<Eigen::Index>(i)) = mesh.V.row(result.vertex[i]);
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      result.F(static_cast<Eigen::Index>(i), c) =
          number[static_cast<std::size_t>(mesh.F(kept[i], c))];
    }
  }
  std::int64_t open = 0;
  for_each_edge(result.F, [&](std::span<const HalfEdge> edge) { open += edge.size() % 2; });
  if (result.F.rows() == 0) {
    result.why_not_closed = "there are no triangles";
  } else if (open > 0) {
    result.why_not_closed = "the surface is open at " + std::to_string(open) + " edges";
  }
  return result;
}

double signed_volume(const Points& V, const Triangles& F) {
  double six = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    six += V.row(F(f, 0)).dot(Vec3(V.row(F(f, 1))).cross(Vec3(V.row(F(f, 2)))));
  }
  return six / 6;
}

double mean_edge(const Points& V, const Triangles& F) {
  double sum = 0;
  std::int64_t count = 0;
  for_each_edge(F, [&](std::span<const HalfEdge> edge) {
    sum += (V.row(edge.front().low) - V.row(edge.front().high)).norm();
    ++count;
  });
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// TetGen on a closed surface, with the handles' samples inside it.
TetgenOutput mesh_closed(const Points& V, const Triangles& F, const std::vector<Handle>& handles,
                         const TetrahedraliserOptions& options, const Progress& progress,
                         int& handle_points) {
  // n vertices have about 5 n tets around them; refinement leaves them at half the largest volume
  // on average.
  const double volume = std::abs(signed_volume(V, F));
  TetgenInput input;
  input.V = V;
  input.F = F;
  input.max_volume = 2 * volume / (5.0 * std::max(options.nodes, 1));
  input.radius_edge = options.radius_edge;
  input.min_dihedral = options.min_dihedral;
  input.time_limit_s = options.time_limit_s;
  // A regular tet of volume v has edges of (6 sqrt(2) v)^(1/3).
  const double inner_edge = std::cbrt(6 * std::numbers::sqrt2 * input.max_volume / 2);
  // TetGen keeps the surface as it is: where that is coarse, tets would be flat.
  split_long_edges(input.V, input.F, kLongEdge * inner_edge, std::max(options.nodes, 1));
  input.inside = inside_samples(handles, input.V, input.F,
                                0.5 * std::min(mean_edge(input.V, input.F), inner_edge));
  handle_points = static_cast<int>(input.inside.rows());
  TetgenOutput output = run_tetgen(input, progress);
  if (!output.good && output.why.find("longer") == std::string::npos && input.inside.rows() > 0) {
    // Some surfaces go through only without prescribed points; the domain then splits at handles.
    input.inside.resize(0, 3);
    TetgenOutput again = run_tetgen(input, progress);
    if (again.good) {
      handle_points = 0;
      output = std::move(again);
    }
  }
  return output;
}

/// How many of the points a closed outward surface holds.
std::int64_t count_inside(const Mesh& closed, const Points& X) {
  if (X.rows() == 0) return 0;
  const WindingNumber winding(closed.V, closed.F);
  return (winding.at(X).array() > 0.5).count();
}

struct ChosenWrap {
  AlphaWrap wrap;
  double alpha = 0;
  double volume = 0;
  std::int64_t holds = 0;  ///< of the handles' samples
};

/// Alpha as small as it may be: gaps between limbs stay open, but the wrap is not hollow. A wrap
/// turns hollow where it can slip through the holes: it loses its volume and the handles in it.
/// Nor shall it have more vertices than asked for. Sheets, which are hollow at once, take the
/// finest of the coarser wraps that holds the handles.
ChosenWrap search_wrap(const Mesh& mesh, const Points& probes, Eigen::Index most_vertices,
                       double time_limit_s, const Progress& progress) {
  constexpr double least_volume = 0.5, least_inside = 0.85, hollow = 0.5;
  const double size = diagonal(bounding_box(mesh.V));
  std::int64_t inside = 0;
  const auto wrapped = [&](double fineness) {
    progress("wrap", fineness / kWrapFineness.back());
    const double alpha = size / fineness;
    ChosenWrap made{alpha_wrap(mesh, alpha, alpha * kWrapOffset, time_limit_s, progress), alpha, 0,
                    0};
    if (!made.wrap.good) return made;
    made.volume = std::abs(signed_volume(made.wrap.surface.V, made.wrap.surface.F));
    made.holds = count_inside(made.wrap.surface, probes);
    return made;
  };
  const auto share = [](std::int64_t part, std::int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 1.0;
  };
  ChosenWrap chosen = wrapped(kWrapFineness.front());
  if (!chosen.wrap.good) return chosen;
  if (share(chosen.holds, probes.rows()) < hollow) {
    for (const double fineness : kSheetFineness) {
      ChosenWrap coarser = wrapped(fineness);
      if (!coarser.wrap.good || share(coarser.holds, probes.rows()) < hollow) continue;
      return coarser;
    }
  }
  for (std::size_t k = 1; k < kWrapFineness.size(); ++k) {
    inside = std::max(inside, chosen.holds);
    ChosenWrap next = wrapped(kWrapFineness[k]);
    if (!next.wrap.good || next.volume < least_volume * chosen.volume ||
        share(next.holds, inside) < least_inside || next.wrap.surface.V.rows() > most_vertices) {
      break;
    }
    chosen = std::move(next);
  }
  return chosen;
}

}  // namespace

const char* name_of(TetRoute route) {
  switch (route) {
    case TetRoute::given:
      return "given";
    case TetRoute::split:
      return "split";
    case TetRoute::tetgen:
      return "tetgen";
    case TetRoute::wrap:
      return "wrap";
  }
  return "";
}

Points inside_samples(const std::vector<Handle>& handles, const Points& V, const Triangles& F,
                      double spacing) {
  constexpr double least_clearance = 0.2;  // of the closest face's mean edge
  const WindingNumber winding(V, F);
  const ClosestPointQuery closest(V, F);
  const auto fits = [&](const Vec3& x) {
    if (!(winding.at(x) > 0.5)) return false;
    const ClosestPoint c = closest.at(x);
    double edges = 0;
    for (int k = 0; k < 3; ++k) {
      edges += (V.row(F(c.face, k)) - V.row(F(c.face, (k + 1) % 3))).norm() / 3;
    }
    return c.distance > least_clearance * edges;
  };
  std::vector<std::vector<Vec3>> kept(handles.size());
  parallel_for(handles.size(), 1, [&](std::size_t h) {
    const Handle& handle = handles[h];
    if (handle.kind == Handle::Kind::region) return;
    const std::size_t wanted = handle.kind == Handle::Kind::bone ? 2 : 1;
    // A bone that is mostly outside, or grazes the surface, is sampled more densely.
    double step = spacing;
    for (int halvings = 0; halvings < 4; ++halvings, step /= 2) {
      kept[h].clear();
      const Points X = sample_handle(handle, step);
      for (Eigen::Index i = 0; i < X.rows(); ++i) {
        const Vec3 x = X.row(i).transpose();
        if (fits(x)) kept[h].push_back(x);
      }
      if (kept[h].size() >= wanted) break;
    }
  });
  std::vector<Vec3> all;
  for (const auto& list : kept) all.insert(all.end(), list.begin(), list.end());
  Points X(static_cast<Eigen::Index>(all.size()), 3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    X.row(static_cast<Eigen::Index>(i)) = all[i].transpose();
  }
  // Handles that meet or run along each other: points much nearer than the spacing become one.
  return weld(X, 0.1 * spacing).V;
}

Tetrahedralisation tetrahedralise(const Mesh& surface, const std::vector<Handle>& handles,
                                  const TetrahedraliserOptions& options, const Progress& progress) {
  constexpr const char* where = "tetrahedra";
  if (!have_tetgen()) {
    throw DomainError("this build makes no tetrahedra: its profile is permissive", where, kRemedy);
  }
  Tetrahedralisation result;
  CleanSurface closed = clean(surface);
  result.why_not_direct = closed.why_not_closed;
  if (result.why_not_direct.empty()) {
    progress("tetgen", 0);
    TetgenOutput made =
        mesh_closed(closed.V, closed.F, handles, options, progress, result.handle_points);
    if (made.good) {
      result.route = TetRoute::tetgen;
      result.surface_volume = std::abs(signed_volume(closed.V, closed.F));
      // The surface's own numbers first, unreferenced vertices in their places.
      const Eigen::Index n = surface.V.rows(), referenced = closed.V.rows();
      const auto renumber = [&](std::int32_t v) {
        return v < referenced
                   ? static_cast<std::int32_t>(closed.vertex[static_cast<std::size_t>(v)])
                   : static_cast<std::int32_t>(v - referenced + n);
      };
      result.V.resize(n + made.V.rows() - referenced, 3);
      result.V << surface.V, made.V.bottomRows(made.V.rows() - referenced);
      result.T = made.T.unaryExpr(renumber);
      return result;
    }
    result.why_not_direct = "TetGen: " + made.why;
  }
  Points probes(0, 3);
  {
    std::vector<Points> each;
    Eigen::Index rows = 0;
    for (const Handle& handle : handles) {
      if (handle.kind == Handle::Kind::region) continue;
      each.push_back(sample_handle(handle, 0.02));
      rows += each.back().rows();
    }
    probes.resize(rows, 3);
    rows = 0;
    for (const Points& X : each) {
      probes.middleRows(rows, X.rows()) = X;
      rows += X.rows();
    }
  }
  Mesh soup;
  soup.V = closed.F.rows() > 0 ? closed.V : surface.V;
  soup.F = closed.F;
  const ChosenWrap chosen =
      search_wrap(soup, probes, options.nodes, options.time_limit_s, progress);
  if (!chosen.wrap.good) {
    throw DomainError("no tetrahedra: " + result.why_not_direct +
                          "; the wrap around it failed: " + chosen.wrap.why,
                      where, kRemedy);
  }
  progress("tetgen", 0);
  const Mesh& wrapped = chosen.wrap.surface;
  TetgenOutput made =
      mesh_closed(wrapped.V, wrapped.F, handles, options, progress, result.handle_points);
  if (!made.good) {
    throw DomainError(
        "no tetrahedra: " + result.why_not_direct + "; TetGen on the wrap around it: " + made.why,
        where, kRemedy);
  }
  result.route = TetRoute::wrap;
  result.alpha = chosen.alpha;
  result.surface_volume = std::abs(signed_volume(wrapped.V, wrapped.F));
  result.V = std::move(made.V);
  result.T = std::move(made.T);
  return result;
}

TetStatistics tet_statistics(const Points& V, const Tetrahedra& T) {
  TetStatistics s;
  std::vector<double> smallest(static_cast<std::size_t>(T.rows()), 0);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    Vec3 x[4];
    for (int c = 0; c < 4; ++c) x[c] = V.row(T(t, c)).transpose();
    const double six = (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]);
    s.volume += std::abs(six) / 6;
    s.inverted += six < 0;
    s.degenerate += !(six != 0);
    // The dihedral angle at edge ab is the angle between c and d seen along it.
    double least = std::numbers::pi;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        int rest[2], count = 0;
        for (int k = 0; k < 4; ++k) {
          if (k != a && k != b) rest[count++] = k;
        }
        const Vec3 along = x[b] - x[a];
        const Vec3 p = along.cross(x[rest[0]] - x[a]), q = along.cross(x[rest[1]] - x[a]);
        least = std::min(least, std::atan2(p.cross(q).norm(), p.dot(q)));
      }
    }
    smallest[static_cast<std::size_t>(t)] = least * 180 / std::numbers::pi;
  }
  if (!smallest.empty()) {
    s.min_dihedral = *std::min_element(smallest.begin(), smallest.end());
    const auto middle = smallest.begin() + static_cast<std::ptrdiff_t>(smallest.size() / 2);
    std::nth_element(smallest.begin(), middle, smallest.end());
    s.median_dihedral = *middle;
  }
  return s;
}

}  // namespace skinfield
