// Tetrahedra from surfaces: TetGen for closed surfaces without self-intersections; for all others
// (open, soups, self-intersecting, point clouds) an alpha wrap around them first. Both need the
// `full` profile.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/rig/skeleton.h"

#include <string>
#include <vector>

namespace skinfield {

enum class TetRoute {
  given,   ///< the tet mesh of the input, as it is
  split,   ///< the tet mesh of the input, split at handles that had no vertex
  tetgen,  ///< TetGen on the surface: its vertices are the first nodes
  wrap,    ///< TetGen on an alpha wrap of the surface
};
const char* name_of(TetRoute route);

struct TetrahedraliserOptions {
  /// About so many vertices fill the volume; coarse surfaces are refined for it, fine ones bring
  /// more.
  int nodes = 16000;
  double radius_edge = 1.5;   ///< largest circumradius to shortest edge of a tet (TetGen's q)
  double min_dihedral = 10;   ///< degrees, wanted, not guaranteed
  double time_limit_s = 120;  ///< of each try
};

struct TetStatistics {
  double volume = 0;
  double min_dihedral = 0;      ///< degrees, over all tets
  double median_dihedral = 0;   ///< of the tets' smallest angles
  std::int64_t inverted = 0;    ///< tets of negative volume
  std::int64_t degenerate = 0;  ///< tets without volume
};
TetStatistics tet_statistics(const Points& V, const Tetrahedra& T);

struct Tetrahedralisation {
  Points V;      ///< route tetgen: the input's vertices first, in order, unreferenced ones too
  Tetrahedra T;  ///< positive volume
  TetRoute route = TetRoute::tetgen;
  int handle_points = 0;       ///< inserted as vertices
  double alpha = 0;            ///< of the wrap, unit box, or 0
  double surface_volume = 0;   ///< what the tetrahedralised surface encloses
  std::string why_not_direct;  ///< why TetGen could not take the surface itself, or empty
};

/// Points on the handles to become vertices: steps of at most `spacing`, at least two a bone, only
/// those inside the closed surface (V,F) and farther from it than a fifth of the edges there (a
/// point nearer to it makes slivers). Regions are left out: their vertices are there already.
Points inside_samples(const std::vector<Handle>& handles, const Points& V, const Triangles& F,
                      double spacing);

/// @param surface in the unit box, equal positions merged; triangles or a point cloud.
/// @param handles in the unit box.
/// @throws DomainError where no route leads to tetrahedra, and in the permissive profile; the
/// remedy is the point domain.
Tetrahedralisation tetrahedralise(const Mesh& surface, const std::vector<Handle>& handles,
                                  const TetrahedraliserOptions& options = {},
                                  const Progress& progress = {});

}  // namespace skinfield
