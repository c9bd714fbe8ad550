#include "domain/surface_refinement.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace skinfield {
namespace {

class Pass {
 public:
  Pass(const Points& V, double h) : V_(V), h_(h) {}

  /// The vertex at the middle of an edge, -1 if it is short enough.
  int middle(int a, int b) {
    if ((V_.row(a) - V_.row(b)).norm() <= h_) return -1;
    const auto [at, fresh] = middles_.try_emplace(std::minmax(a, b), 0);
    if (fresh) {
      at->second = static_cast<int>(V_.rows() + static_cast<Eigen::Index>(added_.size()));
      added_.emplace_back((V_.row(a) + V_.row(b)) / 2);
    }
    return at->second;
  }

  void split(std::array<int, 3> corner) {
    std::array<int, 3> mid{};  // mid[c] lies opposite to corner[c]
    for (std::size_t c = 0; c < 3; ++c) mid[c] = middle(corner[(c + 1) % 3], corner[(c + 2) % 3]);
    const auto cuts = std::count_if(mid.begin(), mid.end(), [](int v) { return v >= 0; });
    if (cuts == 0) {
      add(corner[0], corner[1], corner[2]);
    } else if (cuts == 3) {
      for (std::size_t c = 0; c < 3; ++c) add(corner[c], mid[(c + 2) % 3], mid[(c + 1) % 3]);
      add(mid[0], mid[1], mid[2]);
    } else {
      // Turned so that edge 0 is the one cut, or the one whole.
      std::size_t turn = 0;
      while ((mid[turn] >= 0) != (cuts == 1)) ++turn;
      std::rotate(corner.begin(), corner.begin() + static_cast<std::ptrdiff_t>(turn), corner.end());
      std::rotate(mid.begin(), mid.begin() + static_cast<std::ptrdiff_t>(turn), mid.end());
      if (cuts == 1) {
        add(corner[0], corner[1], mid[0]);
        add(corner[0], mid[0], corner[2]);
      } else {
        add(corner[0], mid[2], mid[1]);
        add_quad(mid[2], corner[1], corner[2], mid[1]);
      }
    }
  }

  bool apply(Points& V, Triangles& F) const {
    if (added_.empty()) return false;
    const Eigen::Index n = V.rows();
    V.conservativeResize(n + static_cast<Eigen::Index>(added_.size()), 3);
    for (std::size_t i = 0; i < added_.size(); ++i) {
      V.row(n + static_cast<Eigen::Index>(i)) = added_[i];
    }
    F.resize(static_cast<Eigen::Index>(faces_.size()), 3);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      F.row(static_cast<Eigen::Index>(f)) = faces_[f];
    }
    return true;
  }

 private:
  void add(int a, int b, int c) { faces_.emplace_back(a, b, c); }
  /// Along the shorter diagonal.
  void add_quad(int a, int b, int c, int d) {
    if ((position(a) - position(c)).norm() <= (position(b) - position(d)).norm()) {
      add(a, b, c);
      add(a, c, d);
    } else {
      add(a, b, d);
      add(b, c, d);
    }
  }
  Eigen::RowVector3d position(int v) const {
    return v < V_.rows() ? Eigen::RowVector3d(V_.row(v))
                         : added_[static_cast<std::size_t>(v - V_.rows())];
  }

  const Points& V_;
  double h_;
  std::map<std::pair<int, int>, int> middles_;
  std::vector<Eigen::RowVector3d> added_;
  std::vector<Eigen::RowVector3i> faces_;
};

}  // namespace

void split_long_edges(Points& V, Triangles& F, double h, Eigen::Index most_vertices) {
  bool any = true;
  while (any && V.rows() < most_vertices) {
    Pass pass(V, h);
    for (Eigen::Index f = 0; f < F.rows(); ++f) pass.split({F(f, 0), F(f, 1), F(f, 2)});
    any = pass.apply(V, F);
  }
}

}  // namespace skinfield
