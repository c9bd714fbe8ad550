// Puts further vertices into flat triangles, keeping the triangulation Delaunay around them.
#pragma once

#include "skinfield/geometry/plane.h"

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace skinfield {

/// Sheets may overlap, edges may have any number of triangles, triangles any orientation.
class PlaneInsertion {
 public:
  /// Vertices and edges within `tolerance` of a place serve as they are.
  PlaneInsertion(const Points& V, const Triangles& F, const Plane& plane, double tolerance);

  /// Makes x, dropped onto the plane, a vertex of every sheet of triangles that covers it: an
  /// existing vertex serves, an edge or a triangle is split, and Lawson's flips follow. Returns the
  /// vertices; none if x lies outside.
  std::vector<int> insert(const Vec3& x);

  /// The old vertices, and the new ones behind them.
  Points vertices() const;
  /// Counterclockwise in the plane, degenerate ones as they were.
  Triangles faces() const;

 private:
  using Face = std::array<int, 3>;
  using Key = std::uint64_t;
  static Key key(int a, int b);
  double twice_area(int a, int b, int c) const;
  void link(int face);
  void unlink(int face);
  void replace(int face, const Face& corners);
  void append(const Face& corners);
  bool has_corner(int face, const std::vector<int>& vertices) const;
  int add_vertex(const Eigen::Vector2d& p);
  int split_edge(int a, int b, const Eigen::Vector2d& p);
  int split_face(int face, const Eigen::Vector2d& p);
  void flip_around(int vertex, std::vector<std::array<int, 2>> opposite);

  Points V_;
  Plane plane_;
  double tolerance_;
  std::vector<Eigen::Vector2d> p_;
  std::vector<Face> faces_;
  std::unordered_map<Key, std::vector<int>> faces_of_edge_;
};

}  // namespace skinfield
