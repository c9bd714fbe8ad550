#include "methods/monotone_order.h"

#include <algorithm>
#include <queue>
#include <tuple>
#include <utility>

namespace skinfield {
namespace {

/// Priority flood from the fixed nodes, highest key first. `key` is levelled on the way: what a
/// flood reaches only from below sinks to the level it came from.
void flood(const SparseRows& graph, const std::vector<char>& fixed, Vector& key,
           std::vector<int>& parent, std::vector<int>& order) {
  using Entry =
      std::tuple<double, int, int>;  // key, minus the turn, node: first come, first served
  std::priority_queue<Entry> queue;
  parent.assign(fixed.size(), -1);
  std::vector<char> seen = fixed;
  int turn = 0;
  for (int v = 0; v < static_cast<int>(fixed.size()); ++v) {
    if (fixed[static_cast<std::size_t>(v)]) queue.emplace(key[v], turn--, v);
  }
  while (!queue.empty()) {
    const int v = std::get<2>(queue.top());
    queue.pop();
    for (SparseRows::InnerIterator it(graph, v); it; ++it) {
      const int to = static_cast<int>(it.col());
      if (seen[static_cast<std::size_t>(to)]) continue;
      seen[static_cast<std::size_t>(to)] = 1;
      parent[static_cast<std::size_t>(to)] = v;
      key[to] = std::min(key[to], key[v]);
      order.push_back(to);
      queue.emplace(key[to], turn--, to);
    }
  }
}

}  // namespace

MonotoneOrder monotone_order(const SparseRows& graph, const Vector& u,
                             const std::vector<char>& fixed) {
  MonotoneOrder result;
  Vector key = u;
  flood(graph, fixed, key, result.up, result.from_above);
  // The second flood sees what the first has levelled: the function that comes out fits both sets
  // of bounds, so that there always is one.
  key = -key;
  flood(graph, fixed, key, result.down, result.from_below);
  return result;
}

double violation(const MonotoneOrder& order, const Eigen::Ref<const Vector>& w) {
  double worst = 0;
  for (const int v : order.from_above) {
    const auto i = static_cast<std::size_t>(v);
    worst = std::max({worst, w[v] - w[order.up[i]], w[order.down[i]] - w[v]});
  }
  return worst;
}

double make_monotone(const MonotoneOrder& order, Eigen::Ref<Vector> w, double tolerance,
                     int passes) {
  double worst = violation(order, w);
  for (int pass = 0; pass < passes && worst > tolerance; ++pass) {
    for (const int v : order.from_above) {
      w[v] = std::min(w[v], w[order.up[static_cast<std::size_t>(v)]]);
    }
    for (const int v : order.from_below) {
      w[v] = std::max(w[v], w[order.down[static_cast<std::size_t>(v)]]);
    }
    worst = violation(order, w);
  }
  return worst;
}

}  // namespace skinfield
