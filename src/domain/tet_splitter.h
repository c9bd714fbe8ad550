// Makes points vertices of a tet mesh by splitting tets, faces and edges. Never inverts a tet,
// keeps the volume and the shape, and leaves no thin tets behind: points very near to a face, an
// edge or a vertex go onto it.
#pragma once

#include "domain/tet_locator.h"

#include <array>
#include <vector>

namespace skinfield {

class TetSplitter {
 public:
  /// Where a point falls: corners of a tet, one (a vertex) to four, and their shares.
  struct Place {
    std::vector<int> corner;  ///< empty: outside
    std::vector<double> share;
    int vertex() const { return corner.size() == 1 ? corner.front() : -1; }
  };

  TetSplitter(const Points& V, const Tetrahedra& T);

  Place find(const Vec3& x) const;
  /// Splits what the place lies in; no splits since it was found. Returns the vertex there.
  int make_vertex(const Place& place);

  /// The mean edge, before any split, of the tet that holds x; 0 outside.
  double edge_at(const Vec3& x) const;

  Vec3 position(int vertex) const { return V_[static_cast<std::size_t>(vertex)]; }
  Vec3 position(const Place& place) const;
  int vertices() const { return static_cast<int>(V_.size()); }
  /// The mesh as it is now: the vertices and tets there were come first.
  Points points() const;
  Tetrahedra tets() const;
  /// What the new vertices were made from, in order.
  const std::vector<Place>& made() const { return made_; }

 private:
  using Tet = std::array<int, 4>;
  std::array<Vec3, 4> corners(const Tet& tet) const;
  void replace_by_children(int tet, const std::vector<int>& corner, int vertex);

  TetLocator locator_;        // of the tets at first: each holds its descendants
  std::vector<double> edge_;  // mean edge of each tet at first
  std::vector<Vec3> V_;
  std::vector<Tet> T_;
  std::vector<int> root_;                      // of each tet
  std::vector<std::vector<int>> descendants_;  // of each tet at first
  std::vector<std::vector<int>> around_;       // tets of each vertex
  std::vector<Place> made_;
};

}  // namespace skinfield
