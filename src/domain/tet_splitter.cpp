#include "domain/tet_splitter.h"

#include <algorithm>

namespace skinfield {
namespace {

// Smaller shares go: the point moves by at most this part of an edge, and no child is thinner than
// this part of its parent.
constexpr double kLeastShare = 0.05;
constexpr double kOutside = -1e-9;

}  // namespace

TetSplitter::TetSplitter(const Points& V, const Tetrahedra& T)
    : locator_(V, T),
      root_(static_cast<std::size_t>(T.rows())),
      descendants_(static_cast<std::size_t>(T.rows())),
      around_(static_cast<std::size_t>(V.rows())) {
  for (Eigen::Index i = 0; i < V.rows(); ++i) V_.emplace_back(V.row(i).transpose());
  for (int t = 0; t < T.rows(); ++t) {
    T_.push_back({T(t, 0), T(t, 1), T(t, 2), T(t, 3)});
    root_[static_cast<std::size_t>(t)] = t;
    descendants_[static_cast<std::size_t>(t)].push_back(t);
    for (const int v : T_.back()) around_[static_cast<std::size_t>(v)].push_back(t);
    double edges = 0;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) edges += (V.row(T(t, a)) - V.row(T(t, b))).norm() / 6;
    }
    edge_.push_back(edges);
  }
}

double TetSplitter::edge_at(const Vec3& x) const {
  const TetLocator::Place place = locator_.find(x);
  return place.tet < 0 ? 0 : edge_[static_cast<std::size_t>(place.tet)];
}

std::array<Vec3, 4> TetSplitter::corners(const Tet& tet) const {
  return {position(tet[0]), position(tet[1]), position(tet[2]), position(tet[3])};
}

Vec3 TetSplitter::position(const Place& place) const {
  Vec3 x = Vec3::Zero();
  for (std::size_t k = 0; k < place.corner.size(); ++k) {
    x += place.share[k] * position(place.corner[k]);
  }
  return x;
}

TetSplitter::Place TetSplitter::find(const Vec3& x) const {
  int best = -1;
  double depth = kOutside;
  Barycentric b = Barycentric::Zero();
  locator_.candidates(x, 1e-12, [&](int first) {
    for (const int t : descendants_[static_cast<std::size_t>(first)]) {
      const Barycentric here = barycentric_in(corners(T_[static_cast<std::size_t>(t)]), x);
      const double least = here.minCoeff();
      if (!here.allFinite() || !(least >= kOutside)) continue;
      if (best < 0 || least > depth || (least == depth && t < best)) {
        best = t;
        depth = least;
        b = here;
      }
    }
  });
  Place place;
  if (best < 0) return place;
  double sum = 0;
  for (int c = 0; c < 4; ++c) {
    if (b[c] < kLeastShare) continue;
    place.corner.push_back(T_[static_cast<std::size_t>(best)][static_cast<std::size_t>(c)]);
    place.share.push_back(b[c]);
    sum += b[c];
  }
  for (double& share : place.share) share /= sum;
  return place;
}

int TetSplitter::make_vertex(const Place& place) {
  if (place.corner.size() == 1) return place.corner.front();
  const auto vertex = static_cast<int>(V_.size());
  V_.push_back(position(place));
  around_.emplace_back();
  made_.push_back(place);
  // Every tet that has all the corners: one, those at a face, those around an edge.
  std::vector<int> having;
  for (const int t : around_[static_cast<std::size_t>(place.corner.front())]) {
    const Tet& tet = T_[static_cast<std::size_t>(t)];
    const bool all = std::all_of(place.corner.begin(), place.corner.end(), [&](int v) {
      return std::find(tet.begin(), tet.end(), v) != tet.end();
    });
    if (all) having.push_back(t);
  }
  for (const int t : having) replace_by_children(t, place.corner, vertex);
  return vertex;
}

/// A child for each corner, which the new vertex stands in for: the same orientation, and together
/// the same volume.
void TetSplitter::replace_by_children(int tet, const std::vector<int>& corner, int vertex) {
  const Tet parent = T_[static_cast<std::size_t>(tet)];
  const int root = root_[static_cast<std::size_t>(tet)];
  for (std::size_t k = 0; k < corner.size(); ++k) {
    Tet child = parent;
    std::replace(child.begin(), child.end(), corner[k], vertex);
    if (k == 0) {
      T_[static_cast<std::size_t>(tet)] = child;
      auto& old = around_[static_cast<std::size_t>(corner[0])];
      old.erase(std::find(old.begin(), old.end(), tet));
      around_[static_cast<std::size_t>(vertex)].push_back(tet);
      continue;
    }
    const auto fresh = static_cast<int>(T_.size());
    T_.push_back(child);
    root_.push_back(root);
    descendants_[static_cast<std::size_t>(root)].push_back(fresh);
    for (const int v : child) around_[static_cast<std::size_t>(v)].push_back(fresh);
  }
}

Points TetSplitter::points() const {
  Points V(static_cast<Eigen::Index>(V_.size()), 3);
  for (std::size_t i = 0; i < V_.size(); ++i) {
    V.row(static_cast<Eigen::Index>(i)) = V_[i].transpose();
  }
  return V;
}

Tetrahedra TetSplitter::tets() const {
  Tetrahedra T(static_cast<Eigen::Index>(T_.size()), 4);
  for (std::size_t t = 0; t < T_.size(); ++t) {
    for (int c = 0; c < 4; ++c) {
      T(static_cast<Eigen::Index>(t), c) = T_[t][static_cast<std::size_t>(c)];
    }
  }
  return T;
}

}  // namespace skinfield
