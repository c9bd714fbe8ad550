// What is inside, and what sees what: the shape as the mesh-free domains need it, for clean closed
// surfaces, overlapping parts, clothes, soups and point clouds alike (findings: "Visibility on
// dirty and overlapping input"). One implementation for all mesh-free domains.
//
// Components are clean (nearly closed) or dirty. Clean parts block by a signed count of crossings,
// so that a segment inside overlapping solids is free and one that leaves the shape is not. Dirty
// triangles never block; a smoothed winding number on a grid does. Passengers (clothes, shells)
// are closed parts that no handle needs: they take no part.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"

#include <memory>
#include <span>
#include <vector>

namespace skinfield {

struct SolidOptions {
  /// Expected distance between nodes, unit-box units: sets the scale of the smoothed grid.
  double spacing = 0.02;
  double accuracy = 2.0;  ///< of the fast winding number
  /// counted: the rules above. any_hit: every triangle blocks, clothes and torn parts included, and
  /// inside is where the winding number of all of them reaches `inside_from` (the geometric-fields
  /// paper's rule, for comparisons). none: nothing blocks, inside as counted (what the paper's
  /// figure 5 compares with). Point clouds have no triangles that any_hit could hit: counted.
  enum class Visibility { counted, any_hit, none };
  Visibility visibility = Visibility::counted;
  double inside_from = 0.1;
  /// The mesh lies in z = 0 and bounds an area there, by its triangles' rim, its outline or loose
  /// segments: these take the place of triangles, and winding numbers are those of the plane.
  bool planar = false;
};

/// A place with what visibility tests need to know about it.
struct Site {
  Vec3 x = Vec3::Zero();
  double winding = 0;    ///< of the clean parts
  double clearance = 0;  ///< distance to the nearest clean triangle: nothing blocks within
};

/// Immutable; thread-safe for queries. Positions in the unit box.
class Solid {
 public:
  enum class PartKind : unsigned char { clean, dirty, passenger };

  /// @param mesh triangles, or a point cloud with normals. Equal positions are merged by the
  ///   caller. Degenerate and duplicate faces are left out; orientation is repaired where it is
  ///   inconsistent.
  /// @param handle_samples (k,3) points on the handles, which say where inside is.
  /// @throws Cancelled
  Solid(const Mesh& mesh, const Points& handle_samples, const SolidOptions& options = {},
        const Progress& progress = {});
  ~Solid();
  Solid(Solid&&) noexcept;
  Solid& operator=(Solid&&) noexcept;

  Site site(const Vec3& x) const;
  std::vector<Site> sites(const Points& X) const;
  /// The site at x, a short way from a known one: counts crossings instead of evaluating the
  /// winding number (ten times faster; exact for closed parts). Its clearance is a lower bound.
  Site site_near(const Site& known, const Vec3& x) const;
  /// Sets the clearance to the exact distance.
  void measure_clearance(Site& site) const;
  bool inside(const Site& a) const;
  bool inside(const Vec3& x) const { return inside(site(x)); }
  /// Winding number of clean parts and the smoothed one of dirty parts together.
  double winding(const Site& a) const;

  /// Is the way from a to b blocked?
  bool blocked(const Site& a, const Site& b) const;
  /// blocked[i] != 0 where the way from a to b[i] is.
  void blocked(const Site& a, std::span<const Site> b, std::span<unsigned char> blocked) const;
  /// Shortens t[i] to where the ray from a along unit directions[i] is blocked; hit[i] says so.
  void reach(const Site& a, std::span<const Vec3> directions, std::span<double> t,
             std::span<unsigned char> hit) const;

  PartKind kind_of_vertex(int vertex) const;
  /// The component of the surface that the vertex belongs to, -1 if none.
  int component_of_vertex(int vertex) const;
  bool has_clean() const;
  bool has_dirty() const;
  /// 2 if planar, else 3.
  int dimension() const;
  /// The surface after repair and without passengers (the faces that bound the solid). Of a planar
  /// one the segments (a, b, b), the inside to the left of a-b.
  const Triangles& faces() const;
  /// The mesh's, and behind them places where a planar one's outline crosses itself.
  const Points& vertices() const;
  /// Unit normals of the mesh's vertices, outward after repair (n,3).
  const Points& normals() const;

  struct Facts {
    int components = 0, clean = 0, dirty = 0, passengers = 0;
    int flipped_faces = 0, duplicate_faces = 0;
    double level = 1;    ///< winding number that counts as fully inside
    double epsilon = 0;  ///< width of the smoothed grid, 0 if there is none
    int handle_samples_inside = 0, handle_samples = 0;
  };
  const Facts& facts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skinfield
