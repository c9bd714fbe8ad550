// An order of nodes and elements in which neighbours lie close in memory: what walks along the
// elements of a large mesh is bound by memory.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

struct MeshOrder {
  std::vector<int> node, element;  ///< old numbers in the new order
  std::vector<int> node_place;     ///< the new number of an old node
};

/// Breadth first from the first node of each component. @throws InputError if an element names a
/// node that does not exist.
MeshOrder breadth_first(const Tetrahedra& T, Eigen::Index nodes);
MeshOrder breadth_first(const Triangles& F, Eigen::Index nodes);

}  // namespace skinfield
