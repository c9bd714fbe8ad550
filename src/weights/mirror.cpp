#include "skinfield/weights/mirror.h"

#include "skinfield/base/error.h"
#include "skinfield/geometry/closest_point.h"
#include "weights/point_grid.h"
#include "weights/rows.h"

#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

namespace skinfield {
namespace {

bool upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
bool lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }
bool letter(char c) { return upper(c) || lower(c); }

/// `from` in lower case as `to` in the case of `like` (LEFT, Left, left).
std::string in_case(std::string_view to, std::string_view like) {
  std::string result(to);
  for (std::size_t k = 0; k < result.size(); ++k) {
    const bool up = k == 0 ? upper(like[0]) : upper(like[std::min(k, like.size() - 1)]);
    if (up) result[k] = static_cast<char>(std::toupper(static_cast<unsigned char>(result[k])));
  }
  return result;
}

std::string lower_case(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// A word with its side exchanged: l, r, left, right, or beginning with left, right (`leftarm`).
std::string other_word(std::string_view word) {
  const std::string low = lower_case(word);
  const auto starts = [&](std::string_view side) { return low.compare(0, side.size(), side) == 0; };
  const auto exchange = [&](std::string_view side, std::string_view other) {
    return in_case(other, word.substr(0, side.size())) + std::string(word.substr(side.size()));
  };
  if (low == "l") return exchange("l", "r");
  if (low == "r") return exchange("r", "l");
  if (starts("left")) return exchange("left", "right");
  if (starts("right")) return exchange("right", "left");
  return std::string(word);
}

Points finite_rows_only(const Points& X, std::vector<int>& kept) {
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    if (X.row(i).allFinite()) kept.push_back(static_cast<int>(i));
  }
  Points result(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    result.row(static_cast<Eigen::Index>(k)) = X.row(kept[k]);
  }
  return result;
}

void check_plane(const MirrorPlane& plane) {
  if (!plane.normal.allFinite() || std::abs(plane.normal.norm() - 1) > 1e-6) {
    throw InputError("the plane's normal is not a unit vector", "mirror");
  }
}

}  // namespace

std::string other_side(const std::string& name) {
  std::string result;
  for (std::size_t i = 0; i < name.size();) {
    if (!letter(name[i])) {
      result += name[i++];
      continue;
    }
    // A word: capitals that no lower case follows (IK, L), or letters up to the next capital.
    std::size_t end = i + 1;
    if (upper(name[i]) && end < name.size() && upper(name[end])) {
      while (end < name.size() && upper(name[end])) ++end;
      if (end < name.size() && lower(name[end])) --end;
    } else {
      while (end < name.size() && lower(name[end])) ++end;
    }
    result += other_word(std::string_view(name).substr(i, end - i));
    i = end;
  }
  return result;
}

std::vector<int> pair_columns(const std::vector<std::string>& names, const Points& positions,
                              const MirrorPlane& plane, double tolerance) {
  check_plane(plane);
  const std::size_t m = names.empty() ? static_cast<std::size_t>(positions.rows()) : names.size();
  if (m == 0 || (positions.rows() > 0 && static_cast<std::size_t>(positions.rows()) != m)) {
    throw InputError("one name or one position a column is needed", "mirror");
  }
  std::vector<int> partner(m, -1);
  std::map<std::string, int> place;
  for (std::size_t j = 0; j < names.size(); ++j) place.emplace(names[j], static_cast<int>(j));
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto found = place.find(other_side(names[j]));
    if (found == place.end() || found->second == static_cast<int>(j) || partner[j] >= 0) continue;
    int& back = partner[static_cast<std::size_t>(found->second)];
    if (back >= 0) continue;
    partner[j] = found->second;
    back = static_cast<int>(j);
  }

  std::vector<int> open;
  for (std::size_t j = 0; j < m; ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    if (partner[j] < 0 && row < positions.rows() && positions.row(row).allFinite()) {
      open.push_back(static_cast<int>(j));
    }
  }
  const auto nearest = [&](int j) {
    const Vec3 image = plane.reflect(positions.row(j).transpose());
    int best = -1;
    double best_distance = tolerance;
    for (const int k : open) {
      const double d = (positions.row(k).transpose() - image).norm();
      // Of columns at one place a joint on the plane is its own image.
      if (d < best_distance || (d == best_distance && (best < 0 || k == j))) {
        best_distance = d;
        best = k;
      }
    }
    return best;
  };
  std::map<int, int> wish;
  for (const int j : open) wish[j] = nearest(j);
  for (const int j : open) {
    const int k = wish[j];
    if (k >= 0 && wish[k] == j) partner[static_cast<std::size_t>(j)] = k;
  }
  for (std::size_t j = 0; j < m; ++j) {
    if (partner[j] < 0) partner[j] = static_cast<int>(j);
  }
  return partner;
}

Mirrored mirror(const SkinWeights& weights, const Mesh& mesh, const MirrorPlane& plane,
                const std::vector<int>& partner, double tolerance) {
  check_plane(plane);
  if (weights.vertices() != mesh.V.rows() ||
      static_cast<Eigen::Index>(partner.size()) != weights.columns()) {
    throw InputError("weights, mesh and partners do not belong together", "mirror");
  }
  for (std::size_t j = 0; j < partner.size(); ++j) {
    const int k = partner[j];
    if (k < 0 || k >= weights.columns() ||
        partner[static_cast<std::size_t>(k)] != static_cast<int>(j)) {
      throw InputError("column " + std::to_string(j) + " and its partner are not a pair", "mirror");
    }
  }
  Mirrored result;
  result.weights.names = weights.names;
  result.weights.W.resize(weights.vertices(), weights.columns());
  std::vector<int> kept;
  const Points finite = finite_rows_only(mesh.V, kept);
  if (finite.rows() == 0) return result;
  const PointGrid grid(finite);
  std::optional<ClosestPointQuery> surface;
  if (mesh.F.rows() > 0) surface.emplace(mesh.V, mesh.F);

  std::vector<unsigned char> matched(static_cast<std::size_t>(mesh.V.rows()), 0);
  result.weights.W = rows::build(weights.vertices(), weights.columns(), [&] {
    return [&, sum = rows::Accumulator(weights.columns())](Eigen::Index i, rows::Row& row) mutable {
      if (!mesh.V.row(i).allFinite()) return;
      const Vec3 image = plane.reflect(mesh.V.row(i).transpose());
      const int vertex = kept[static_cast<std::size_t>(grid.nearest(image))];
      const bool near = (mesh.V.row(vertex).transpose() - image).norm() <= tolerance;
      matched[static_cast<std::size_t>(i)] = near ? 1 : 0;
      const auto add = [&](Eigen::Index k, double share) {
        for (SparseRows::InnerIterator it(weights.W, k); it; ++it) {
          sum.add(partner[static_cast<std::size_t>(it.col())], share * it.value());
        }
      };
      const ClosestPoint hit = near || !surface ? ClosestPoint{} : surface->at(image);
      if (hit.face < 0) {
        add(vertex, 1);
      } else {
        for (Eigen::Index k = 0; k < 3; ++k) add(mesh.F(hit.face, k), hit.barycentric[k]);
      }
      sum.take(row);
    };
  });
  for (const unsigned char hit : matched) result.matched += hit;
  return result;
}

Mirrored symmetrise(const SkinWeights& weights, const Mesh& mesh, const MirrorPlane& plane,
                    const std::vector<int>& partner, double tolerance) {
  Mirrored result = mirror(weights, mesh, plane, partner, tolerance);
  const SparseRows image = result.weights.W;
  result.weights.W = rows::build(weights.vertices(), weights.columns(), [&] {
    return [&, sum = rows::Accumulator(weights.columns())](Eigen::Index i, rows::Row& row) mutable {
      sum.add(weights.W, i, 0.5);
      sum.add(image, i, 0.5);
      sum.take(row);
    };
  });
  return result;
}

}  // namespace skinfield
