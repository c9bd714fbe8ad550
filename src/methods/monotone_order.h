// Which neighbours bound a node so that a function has no local extrema.
#pragma once

#include "skinfield/base/types.h"

#include <vector>

namespace skinfield {

/// For every free node a neighbour that it must not exceed and one that it must not fall below;
/// both lead, step by step, to fixed nodes. Fixed nodes have none (-1).
struct MonotoneOrder {
  std::vector<int> up, down;
  /// Free nodes, each after its up (down) neighbour.
  std::vector<int> from_above, from_below;
};

/// Where u has no extremum at a free node, its highest and lowest neighbour. Elsewhere the ones
/// over which a flood from the fixed nodes first reaches it, so that bounds always fit together.
/// graph: rows list neighbours, its values are not used. Every node must be joined to a fixed one.
MonotoneOrder monotone_order(const SparseRows& graph, const Vector& u,
                             const std::vector<char>& fixed);

/// Moves values of w by no more than it takes until all bounds hold up to `tolerance`, in at most
/// `passes` passes; returns the largest violation left.
double make_monotone(const MonotoneOrder& order, Eigen::Ref<Vector> w, double tolerance,
                     int passes);

/// The largest violation of a bound.
double violation(const MonotoneOrder& order, const Eigen::Ref<const Vector>& w);

}  // namespace skinfield
