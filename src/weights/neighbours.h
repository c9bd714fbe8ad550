// The neighbours of every vertex along the edges of a mesh.
#pragma once

#include "skinfield/geometry/mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace skinfield {

struct Neighbours {
  std::vector<std::int32_t> start, vertex;  ///< of i: vertex[start[i]] .. , sorted, each once
  std::span<const std::int32_t> of(Eigen::Index i) const {
    const auto k = static_cast<std::size_t>(i);
    return {vertex.data() + start[k], vertex.data() + start[k + 1]};
  }
};

/// Edges of mesh.F and mesh.T. Throws InputError if an index is out of range.
Neighbours neighbours(const Mesh& mesh);

}  // namespace skinfield
