// What the two domains on triangles share: refinement, the nodes that handles hold, evaluation.
#pragma once

#include "domain/kd_tree.h"
#include "skinfield/domain/domain.h"
#include "skinfield/geometry/closest_point.h"

#include <map>
#include <vector>

namespace skinfield {

/// Splits every edge longer than h at its middle, once; triangles are cut to fit (no hanging
/// vertices), new vertices follow the old ones. Returns whether there were any.
bool split_long_edges(Points& V, Triangles& F, double h);

/// The distance of nodes where `nodes` equilateral triangles' corners cover an area.
double node_distance(double area, int nodes);

/// Repeats split_long_edges until V has about `nodes` rows. Throws Cancelled.
void refine_to(Points& V, Triangles& F, int nodes, double area, const Progress& progress);

/// Component of every vertex; vertices of no triangle have -1.
std::vector<int> parts_of(const Triangles& F, Eigen::Index vertices);

/// Of every handle that is `wanted`, the nodes nearest to its samples that they see, and the ring
/// around them. Where several handles claim a node the nearest get it, in equal shares; one that
/// would lose all its nodes shares them.
/// @param node_of_vertex of region handles' vertices, -1: none. @param mesh_V their positions.
FixedRows nearest_visible_rows(const Points& V, const Triangles& F, const KdTree& tree,
                               const std::vector<Handle>& handles, const std::vector<char>& wanted,
                               const std::vector<int>& node_of_vertex, const Points& mesh_V,
                               double h);

/// (n,nodes): barycentric on the closest triangle, n rows of X.
SparseRows barycentric_rows(const ClosestPointQuery& query, const Triangles& F, const Points& X,
                            Eigen::Index nodes);

/// Fixed rows from the handles that own each node (ascending): 1/k each.
FixedRows shared_rows(const std::map<int, std::vector<int>>& owners, Eigen::Index columns);

}  // namespace skinfield
