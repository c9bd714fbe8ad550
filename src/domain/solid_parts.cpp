#include "domain/solid_parts.h"

#include "skinfield/base/parallel.h"
#include "skinfield/geometry/winding_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_set>

namespace skinfield {
namespace {

constexpr double off_integer = 0.15;       // |v_f - round v_f| above this: the face does not close
constexpr double dirty_area_alone = 0.25;  // share of such area that makes a component dirty
constexpr double dirty_area_together = 0.15;
constexpr int faces_sampled = 2000;  // per component, enough for a share of area

struct Part {
  std::vector<int> faces;
  double volume = 0;
  double dirty_share = 1;
  bool overlaps_itself = false;
};

Triangles rows_of(const Triangles& F, const std::vector<int>& rows) {
  Triangles G(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i)
    G.row(static_cast<Eigen::Index>(i)) = F.row(rows[i]);
  return G;
}

double signed_volume(const Points& V, const Triangles& F, const std::vector<int>& faces) {
  const Vec3 o = V.row(F(faces.front(), 0)).transpose();
  double six = 0;
  for (int f : faces) {
    const Vec3 a = V.row(F(f, 0)).transpose() - o;
    const Vec3 b = V.row(F(f, 1)).transpose() - o;
    const Vec3 c = V.row(F(f, 2)).transpose() - o;
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

/// v_f = w(centroid, without f) - 1/2: an integer on every face of a closed surface.
double excess_winding(const WindingNumber& winding, const Points& V, const Triangles& F, int f) {
  const Vec3 a = V.row(F(f, 0)).transpose();
  const Vec3 b = V.row(F(f, 1)).transpose();
  const Vec3 c = V.row(F(f, 2)).transpose();
  const Vec3 n = (b - a).cross(c - a);
  const double size = std::sqrt(n.norm());
  // The face's own solid angle jumps at its plane: step off it and subtract what it adds there.
  const Vec3 x = (a + b + c) / 3 + n.normalized() * (1e-3 * size);
  return winding.at(x) - solid_angle_fraction(a, b, c, x) - 0.5;
}

/// Share of the area whose excess winding is not an integer.
void measure(const Points& V, const Triangles& F, double accuracy, Part& part) {
  const int n = static_cast<int>(part.faces.size());
  if (n < 4) return;  // nothing closed has fewer faces
  const Triangles G = rows_of(F, part.faces);
  const WindingNumber winding(V, G, {.accuracy = accuracy});
  const int step = std::max(1, n / faces_sampled);
  const int samples = (n + step - 1) / step;
  std::vector<double> v(static_cast<std::size_t>(samples));
  parallel_for(static_cast<std::size_t>(samples), 64, [&](std::size_t i) {
    v[i] = excess_winding(winding, V, G, static_cast<int>(i) * step);
  });
  const Vector area = face_areas(V, G);
  double total = 0, dirty = 0;
  for (int i = 0; i < samples; ++i) {
    const double a = area[Eigen::Index{i} * step];
    const double value = v[static_cast<std::size_t>(i)];
    total += a;
    if (std::abs(value - std::round(value)) > off_integer) dirty += a;
    if (std::round(value) != 0) part.overlaps_itself = true;
  }
  part.dirty_share = total > 0 ? dirty / total : 1;
}

/// Which parts link others through shared space: a vertex of one inside another.
bool touches(const Points& V, const Triangles& F, const Part& a, const WindingNumber& inside_b,
             const Box3& box_b) {
  const std::size_t step = std::max<std::size_t>(1, a.faces.size() / 400);
  for (std::size_t i = 0; i < a.faces.size(); i += step)
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3 x = V.row(F(a.faces[i], corner)).transpose();
      if ((x.transpose().array() < box_b.row(0).array()).any() ||
          (x.transpose().array() > box_b.row(1).array()).any())
        continue;
      if (std::abs(inside_b.at(x)) > 0.5) return true;
    }
  return false;
}

Box3 box_of(const Points& V, const Triangles& F, const Part& part) {
  Box3 box;
  box.row(0).setConstant(1e300);
  box.row(1).setConstant(-1e300);
  for (int f : part.faces)
    for (int corner = 0; corner < 3; ++corner) {
      box.row(0) = box.row(0).cwiseMin(V.row(F(f, corner)));
      box.row(1) = box.row(1).cwiseMax(V.row(F(f, corner)));
    }
  return box;
}

int find(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i)
    i = parent[static_cast<std::size_t>(i)] =
        parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
  return i;
}

/// Components of the graph of overlapping parts, without the ones left out.
int count_groups(const std::vector<std::vector<int>>& overlaps, const std::vector<char>& out) {
  std::vector<int> parent(overlaps.size());
  std::iota(parent.begin(), parent.end(), 0);
  int groups = 0;
  for (std::size_t i = 0; i < overlaps.size(); ++i) groups += out[i] ? 0 : 1;
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    if (out[i]) continue;
    for (int j : overlaps[i]) {
      if (out[static_cast<std::size_t>(j)]) continue;
      const int a = find(parent, static_cast<int>(i)), b = find(parent, j);
      if (a != b) parent[static_cast<std::size_t>(a)] = b, --groups;
    }
  }
  return groups;
}

}  // namespace

CleanedFaces drop_degenerate_and_duplicate(const Points& V, const Triangles& F) {
  CleanedFaces cleaned;
  std::vector<int> kept;
  kept.reserve(static_cast<std::size_t>(F.rows()));
  struct Hash {
    std::size_t operator()(const std::array<int, 3>& k) const {
      std::uint64_t h = 1469598103934665603ull;
      for (int v : k) h = (h ^ static_cast<std::uint32_t>(v)) * 1099511628211ull;
      return static_cast<std::size_t>(h ^ (h >> 29));
    }
  };
  std::unordered_set<std::array<int, 3>, Hash> seen;
  seen.reserve(static_cast<std::size_t>(F.rows()) * 2);
  for (int f = 0; f < F.rows(); ++f) {
    const Vec3 a = V.row(F(f, 0)).transpose();
    const Vec3 b = V.row(F(f, 1)).transpose();
    const Vec3 c = V.row(F(f, 2)).transpose();
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (!((b - a).cross(c - a).norm() > 1e-12 * longest)) {
      ++cleaned.degenerate;
      continue;
    }
    std::array<int, 3> key{F(f, 0), F(f, 1), F(f, 2)};
    std::sort(key.begin(), key.end());
    if (!seen.insert(key).second) {
      ++cleaned.duplicate;
      continue;
    }
    kept.push_back(f);
  }
  cleaned.F = rows_of(F, kept);
  return cleaned;
}

PartsOfSolid classify_parts(const Points& V, const Triangles& F, const Points& handle_samples,
                            double accuracy, const Progress& progress) {
  PartsOfSolid result;
  result.F = F;
  const Components components = connected_components(F, V.rows());
  result.component_of_face = components.of_face;
  std::vector<Part> parts(static_cast<std::size_t>(components.count));
  for (int f = 0; f < F.rows(); ++f)
    parts[static_cast<std::size_t>(components.of_face[static_cast<std::size_t>(f)])]
        .faces.push_back(f);
  for (Part& part : parts) {
    progress.check();
    part.volume = signed_volume(V, F, part.faces);
    measure(V, F, accuracy, part);
  }

  // Findings E 1: each component alone, then the failing ones together.
  result.kind.assign(parts.size(), Solid::PartKind::clean);
  Part together;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i].dirty_share > dirty_area_alone) {
      result.kind[i] = Solid::PartKind::dirty;
      together.faces.insert(together.faces.end(), parts[i].faces.begin(), parts[i].faces.end());
    }
  if (!together.faces.empty()) {
    std::sort(together.faces.begin(), together.faces.end());
    measure(V, F, accuracy, together);
    if (together.dirty_share <= dirty_area_together)
      std::fill(result.kind.begin(), result.kind.end(), Solid::PartKind::clean);
  }

  // Closed parts, largest first. An inward-oriented one is a cavity and joins the smallest part
  // around it; with none around, it is inside out and is turned.
  struct Closed {
    std::vector<int> members;  // components: the part and its cavities
    double volume;
  };
  std::vector<int> order;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (result.kind[i] == Solid::PartKind::clean && parts[i].dirty_share <= dirty_area_alone)
      order.push_back(static_cast<int>(i));
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::abs(parts[static_cast<std::size_t>(a)].volume) >
           std::abs(parts[static_cast<std::size_t>(b)].volume);
  });
  std::vector<Closed> closed;
  std::vector<WindingNumber> winding;
  std::vector<Box3> box;
  for (int i : order) {
    Part& part = parts[static_cast<std::size_t>(i)];
    if (part.volume < 0) {
      int around = -1;
      const Vec3 x = V.row(F(part.faces.front(), 0)).transpose();
      for (int c = static_cast<int>(closed.size()) - 1; c >= 0 && around < 0; --c)
        if (winding[static_cast<std::size_t>(c)].at(x) > 0.5) around = c;
      if (around >= 0) {
        closed[static_cast<std::size_t>(around)].members.push_back(i);
        continue;
      }
      for (int f : part.faces) std::swap(result.F(f, 1), result.F(f, 2));
      part.volume = -part.volume;
      result.turned += static_cast<int>(part.faces.size());
    }
    closed.push_back({{i}, part.volume});
    winding.emplace_back(V, rows_of(result.F, part.faces), WindingNumberOptions{accuracy});
    box.push_back(box_of(V, result.F, part));
  }

  // Findings E 2: drop what no handle needs, unless it joins parts that are needed.
  if (closed.size() > 1 && handle_samples.rows() > 0) {
    const Vector all = WindingNumber(V, result.F, {.accuracy = accuracy}).at(handle_samples);
    Vector w = all;
    std::vector<std::vector<int>> overlaps(closed.size());
    for (std::size_t a = 0; a < closed.size(); ++a) {
      progress.check();
      for (std::size_t b = a + 1; b < closed.size(); ++b) {
        if ((box[a].row(0).array() > box[b].row(1).array()).any() ||
            (box[b].row(0).array() > box[a].row(1).array()).any())
          continue;
        const Part& pa = parts[static_cast<std::size_t>(closed[a].members[0])];
        const Part& pb = parts[static_cast<std::size_t>(closed[b].members[0])];
        if (touches(V, F, pa, winding[b], box[b]) || touches(V, F, pb, winding[a], box[a])) {
          overlaps[a].push_back(static_cast<int>(b));
          overlaps[b].push_back(static_cast<int>(a));
        }
      }
    }
    std::vector<char> out(closed.size(), 0);
    int left = static_cast<int>(closed.size());
    for (std::size_t c = 0; c < closed.size() && left > 1; ++c) {
      std::vector<int> faces;
      for (int member : closed[c].members) {
        const auto& more = parts[static_cast<std::size_t>(member)].faces;
        faces.insert(faces.end(), more.begin(), more.end());
      }
      const Vector own =
          WindingNumber(V, rows_of(result.F, faces), {.accuracy = accuracy}).at(handle_samples);
      bool needed = false;
      bool any_inside = false;
      for (Eigen::Index s = 0; s < w.size(); ++s)
        if (w[s] >= 0.5) {
          any_inside = true;
          if (w[s] - own[s] < 0.5) needed = true;
        }
      if (needed || !any_inside) continue;
      // A joint between two others keeps them one body.
      std::vector<char> without = out;
      without[c] = 1;
      if (count_groups(overlaps, without) > count_groups(overlaps, out)) continue;
      out = without;
      --left;
      w -= own;
      for (int member : closed[c].members)
        result.kind[static_cast<std::size_t>(member)] = Solid::PartKind::passenger;
    }
  }

  result.self_winding.assign(static_cast<std::size_t>(F.rows()), 0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (result.kind[i] != Solid::PartKind::clean || !parts[i].overlaps_itself) continue;
    progress.check();
    const Triangles G = rows_of(result.F, parts[i].faces);
    const WindingNumber own(V, G, {.accuracy = accuracy});
    parallel_for(parts[i].faces.size(), 64, [&](std::size_t k) {
      const double v = excess_winding(own, V, G, static_cast<int>(k));
      result.self_winding[static_cast<std::size_t>(parts[i].faces[k])] =
          std::max(0, static_cast<int>(std::lround(v)));
    });
  }
  return result;
}

}  // namespace skinfield
