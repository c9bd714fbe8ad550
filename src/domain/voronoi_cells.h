// Visible neighbours and the ray-cast Voronoi finite-volume Laplacian (findings A 2 to 4).
#pragma once

#include "domain/kd_tree.h"
#include "domain/point_sampling.h"

#include <cstdint>
#include <vector>

namespace skinfield {

struct VoronoiCells {
  SparseRows K;  ///< (N,N)
  Vector M;      ///< (N)
  std::int64_t rays = 0;
};

/// (N) lists of the nearest visible nodes, nearest first.
std::vector<std::vector<Neighbour>> visible_neighbours(const Solid& solid,
                                                       const SampledNodes& nodes,
                                                       const KdTree& tree, int candidates,
                                                       int wanted, const Progress& progress);

VoronoiCells voronoi_cells(const Solid& solid, const SampledNodes& nodes,
                           const std::vector<std::vector<Neighbour>>& neighbours, int directions,
                           std::uint64_t seed, const Progress& progress);

}  // namespace skinfield
