#include "methods/mesh_order.h"

#include "skinfield/base/error.h"

namespace skinfield {
namespace {

/// The elements of each node: those of v are list[start[v]] to list[start[v + 1]].
struct Incidence {
  std::vector<int> start, list;
};

template <class Elements>
Incidence elements_of_nodes(const Elements& E, std::size_t nodes) {
  Incidence of;
  of.start.assign(nodes + 1, 0);
  for (Eigen::Index k = 0; k < E.size(); ++k) ++of.start[static_cast<std::size_t>(E.data()[k]) + 1];
  for (std::size_t v = 0; v < nodes; ++v) of.start[v + 1] += of.start[v];
  of.list.resize(static_cast<std::size_t>(E.size()));
  std::vector<int> next(of.start.begin(), of.start.end() - 1);
  for (Eigen::Index e = 0; e < E.rows(); ++e) {
    for (Eigen::Index i = 0; i < E.cols(); ++i) {
      of.list[static_cast<std::size_t>(next[static_cast<std::size_t>(E(e, i))]++)] =
          static_cast<int>(e);
    }
  }
  return of;
}

template <class Elements>
MeshOrder order_of(const Elements& E, Eigen::Index count) {
  if (E.size() > 0 && (E.minCoeff() < 0 || E.maxCoeff() >= count)) {
    throw InputError("a vertex index is out of range", "mesh");
  }
  const auto nodes = static_cast<std::size_t>(count);
  const Incidence of = elements_of_nodes(E, nodes);
  MeshOrder order;
  order.node_place.assign(nodes, -1);
  std::vector<char> met(static_cast<std::size_t>(E.rows()), 0);
  const auto reach = [&order](int v) {
    int& place = order.node_place[static_cast<std::size_t>(v)];
    if (place >= 0) return;
    place = static_cast<int>(order.node.size());
    order.node.push_back(v);
  };
  std::size_t done = 0;
  for (std::size_t first = 0; first < nodes; ++first) {
    reach(static_cast<int>(first));
    for (; done < order.node.size(); ++done) {
      const auto v = static_cast<std::size_t>(order.node[done]);
      for (int k = of.start[v]; k < of.start[v + 1]; ++k) {
        const int e = of.list[static_cast<std::size_t>(k)];
        if (met[static_cast<std::size_t>(e)]) continue;
        met[static_cast<std::size_t>(e)] = 1;
        order.element.push_back(e);
        for (Eigen::Index i = 0; i < E.cols(); ++i) reach(E(e, i));
      }
    }
  }
  return order;
}

}  // namespace

MeshOrder breadth_first(const Tetrahedra& T, Eigen::Index nodes) { return order_of(T, nodes); }
MeshOrder breadth_first(const Triangles& F, Eigen::Index nodes) { return order_of(F, nodes); }

}  // namespace skinfield
