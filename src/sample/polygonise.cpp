#include "sample/polygonise.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace skinfield::sample_detail {
namespace {

using Node = std::array<int, 3>;  ///< all even or all odd: the two interleaved cubic lattices
using NodeKey = std::uint64_t;
using EdgeKey = std::pair<NodeKey, NodeKey>;  ///< inside node, outside node

constexpr int block_nodes = 16;  ///< side of a block in half steps

NodeKey key_of(const Node& n) {
  return (static_cast<NodeKey>(n[0]) << 42) | (static_cast<NodeKey>(n[1]) << 21) |
         static_cast<NodeKey>(n[2]);
}

Node node_of(NodeKey key) {
  constexpr NodeKey mask = (NodeKey{1} << 21) - 1;
  return {static_cast<int>(key >> 42), static_cast<int>((key >> 21) & mask),
          static_cast<int>(key & mask)};
}

/// The lattice in blocks; each knows the primitives that matter in it. A node's value is a
/// function of the node alone (its own block's list), so that neighbours agree on its sign.
class Lattice {
 public:
  Lattice(const ImplicitShape& shape, double step) : shape_(shape), half_(0.5 * step) {
    const Box3 box = shape.box();
    // One block of margin: nodes of faces at the border exist.
    origin_ = box.row(0).transpose() - Vec3::Constant(block_nodes * half_);
    const Vec3 size = box.row(1).transpose() - origin_;
    for (std::size_t d = 0; d < 3; ++d) {
      blocks_[d] = static_cast<int>(size[static_cast<Eigen::Index>(d)] / (block_nodes * half_)) + 2;
    }
    lists_.resize(static_cast<std::size_t>(blocks_[0] * blocks_[1] * blocks_[2]));
    active_.resize(lists_.size());
    const double radius = 0.5 * std::sqrt(3.0) * block_nodes * half_;
    parallel_for(lists_.size(), 64, [&](std::size_t b) {
      const Vec3 centre =
          origin_ + half_ * block_nodes * (corner(b).cast<double>() + Vec3::Constant(0.5));
      lists_[b] = shape_.near(centre, radius);
      // Tetrahedra reach a step beyond the block; the field's slope stays under 1.5.
      active_[b] = std::abs(shape_.at(centre)) < 1.5 * (radius + 2 * half_);
    });
  }

  std::size_t blocks() const { return lists_.size(); }
  bool active(std::size_t b) const { return active_[b]; }
  Eigen::Vector3i corner(std::size_t b) const {
    const int i = static_cast<int>(b);
    return {i / (blocks_[1] * blocks_[2]), i / blocks_[2] % blocks_[1], i % blocks_[2]};
  }
  Vec3 position(const Node& n) const { return origin_ + half_ * Vec3(n[0], n[1], n[2]); }
  double value(const Node& n) const {
    return shape_.at(position(n), lists_[block_of(n[0], n[1], n[2])]);
  }
  double value(const Vec3& x) const {
    const Eigen::Vector3i n = ((x - origin_) / half_).cast<int>();
    return shape_.at(x, lists_[block_of(n.x(), n.y(), n.z())]);
  }
  Vec3 gradient(const Vec3& x) const {
    // Tetrahedral differences: four evaluations.
    static const std::array<Vec3, 4> directions = {Vec3(1, -1, -1), Vec3(-1, -1, 1),
                                                   Vec3(-1, 1, -1), Vec3(1, 1, 1)};
    const double e = 1e-3 * half_;
    Vec3 sum = Vec3::Zero();
    for (const Vec3& d : directions) sum += d * value(Vec3(x + e * d));
    return sum / (4 * e);
  }
  /// A Newton step along the gradient, at most half a step long.
  Vec3 project(const Vec3& x) const {
    const Vec3 g = gradient(x);
    Vec3 move = g * (-value(x) / std::max(g.squaredNorm(), 0.05));
    const double length = move.norm();
    if (length > half_) move *= half_ / length;
    return x + move;
  }
  double thickness(const Vec3& x) const {
    const Eigen::Vector3i n = ((x - origin_) / half_).cast<int>();
    return shape_.thickness(x, lists_[block_of(n.x(), n.y(), n.z())]);
  }

 private:
  std::size_t block_of(int x, int y, int z) const {
    const auto clamped = [&](int n, std::size_t d) {
      return std::clamp(n / block_nodes, 0, blocks_[d] - 1);
    };
    return static_cast<std::size_t>((clamped(x, 0) * blocks_[1] + clamped(y, 1)) * blocks_[2] +
                                    clamped(z, 2));
  }

  const ImplicitShape& shape_;
  double half_;
  Vec3 origin_;
  std::array<int, 3> blocks_{};
  std::vector<std::vector<int>> lists_;
  std::vector<unsigned char> active_;
};

/// Node values of one block and a margin of two nodes, on the fly but at most once.
class BlockValues {
 public:
  BlockValues(const Lattice& lattice, std::size_t block) : lattice_(lattice) {
    const Eigen::Vector3i corner = lattice.corner(block) * block_nodes;
    for (std::size_t d = 0; d < 3; ++d) {
      low_[d] = corner[static_cast<Eigen::Index>(d)] - margin;
    }
    values_.resize(side * side * side);
    known_.resize(values_.size());
  }
  double at(const Node& n) {
    const auto i = static_cast<std::size_t>(((n[0] - low_[0]) * side + n[1] - low_[1]) * side +
                                            n[2] - low_[2]);
    if (!known_[i]) {
      values_[i] = lattice_.value(n);
      known_[i] = 1;
    }
    return values_[i];
  }

 private:
  static constexpr int margin = 2, side = block_nodes + 2 * margin + 1;
  const Lattice& lattice_;
  Node low_{};
  std::vector<double> values_;
  std::vector<unsigned char> known_;
};

/// The triangles of one tetrahedron, as edges it cuts, seen from outside counter-clockwise.
void march(const std::array<Node, 4>& tet, BlockValues& values,
           std::vector<std::array<EdgeKey, 3>>& out) {
  std::array<int, 4> in{}, outside{};
  std::size_t inside_count = 0, outside_count = 0;
  for (int c = 0; c < 4; ++c) {
    if (values.at(tet[static_cast<std::size_t>(c)]) < 0)
      in[inside_count++] = c;
    else
      outside[outside_count++] = c;
  }
  if (inside_count == 0 || outside_count == 0) return;
  const auto edge = [&](std::size_t i, std::size_t o) {
    return EdgeKey(key_of(tet[static_cast<std::size_t>(in[i])]),
                   key_of(tet[static_cast<std::size_t>(outside[o])]));
  };
  const auto point = [](const Node& n) { return Vec3(n[0], n[1], n[2]); };
  const auto middle = [&](const EdgeKey& e) -> Vec3 {
    return 0.5 * (point(node_of(e.first)) + point(node_of(e.second)));
  };
  Vec3 outward = Vec3::Zero();
  for (std::size_t o = 0; o < outside_count; ++o) {
    outward +=
        point(tet[static_cast<std::size_t>(outside[o])]) / static_cast<double>(outside_count);
  }
  for (std::size_t i = 0; i < inside_count; ++i) {
    outward -= point(tet[static_cast<std::size_t>(in[i])]) / static_cast<double>(inside_count);
  }
  const auto add = [&](const EdgeKey& a, EdgeKey b, EdgeKey c) {
    // Midpoints have the orientation that the true crossings have.
    if ((middle(b) - middle(a)).cross(middle(c) - middle(a)).dot(outward) < 0) std::swap(b, c);
    out.push_back({a, b, c});
  };
  if (inside_count == 1) {
    add(edge(0, 0), edge(0, 1), edge(0, 2));
  } else if (inside_count == 3) {
    add(edge(0, 0), edge(1, 0), edge(2, 0));
  } else {
    add(edge(0, 0), edge(0, 1), edge(1, 1));
    add(edge(0, 0), edge(1, 1), edge(1, 0));
  }
}

/// All tetrahedra of a block: around each even edge along an axis, the ring of odd nodes.
void march_block(const Lattice& lattice, std::size_t block,
                 std::vector<std::array<EdgeKey, 3>>& out) {
  BlockValues values(lattice, block);
  const Eigen::Vector3i corner = lattice.corner(block) * block_nodes;
  for (int i = 0; i < block_nodes; i += 2) {
    for (int j = 0; j < block_nodes; j += 2) {
      for (int k = 0; k < block_nodes; k += 2) {
        const Node a = {corner.x() + i, corner.y() + j, corner.z() + k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
          Node b = a;
          b[axis] += 2;
          const std::array<std::pair<int, int>, 4> ring = {{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
          for (std::size_t r = 0; r < 4; ++r) {
            Node p = a, q = a;
            p[axis] += 1;
            q[axis] += 1;
            p[u] += ring[r].first;
            p[v] += ring[r].second;
            q[u] += ring[(r + 1) % 4].first;
            q[v] += ring[(r + 1) % 4].second;
            if (std::min({p[0], p[1], p[2], q[0], q[1], q[2]}) < 0) continue;
            march({a, b, p, q}, values, out);
          }
        }
      }
    }
  }
}

/// Where the field crosses zero between two nodes, to first order and clear of both ends.
Vec3 crossing(const Lattice& lattice, const EdgeKey& edge) {
  const Node in = node_of(edge.first), out = node_of(edge.second);
  const Vec3 a = lattice.position(in), b = lattice.position(out);
  const double fa = lattice.value(in), fb = lattice.value(out);
  const double t = std::clamp(fa / (fa - fb), 0.02, 0.98);
  return a + t * (b - a);
}

/// Moves vertices toward the mean of their neighbours along the surface, and back onto it.
void relax(const Lattice& lattice, Mesh& mesh) {
  Points sum = Points::Zero(mesh.V.rows(), 3);
  Vector count = Vector::Zero(mesh.V.rows());
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      // On a closed manifold every neighbour comes up once this way.
      sum.row(mesh.F(f, c)) += mesh.V.row(mesh.F(f, (c + 1) % 3));
      count[mesh.F(f, c)] += 1;
    }
  }
  parallel_for(static_cast<std::size_t>(mesh.V.rows()), 1024, [&](std::size_t i) {
    const auto v = static_cast<Eigen::Index>(i);
    if (count[v] == 0) return;
    const Vec3 x = mesh.V.row(v), normal = lattice.gradient(x).normalized();
    Vec3 move = 0.7 * (sum.row(v).transpose() / count[v] - x);
    move -= normal * normal.dot(move);
    mesh.V.row(v) = lattice.project(x + move).transpose();
  });
}

}  // namespace

Mesh polygonise(const ImplicitShape& shape, double step, double fine_radius, double coarsest,
                const Progress& progress) {
  const Lattice lattice(shape, step);
  std::vector<std::vector<std::array<EdgeKey, 3>>> of_block(lattice.blocks());
  parallel_for(lattice.blocks(), 4, [&](std::size_t b) {
    progress.check();
    if (lattice.active(b)) march_block(lattice, b, of_block[b]);
  });

  std::vector<EdgeKey> edges;
  std::size_t faces = 0;
  for (const auto& list : of_block) {
    faces += list.size();
    for (const auto& face : list) edges.insert(edges.end(), face.begin(), face.end());
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto vertex = [&](const EdgeKey& e) {
    return static_cast<std::int32_t>(std::lower_bound(edges.begin(), edges.end(), e) -
                                     edges.begin());
  };

  Mesh mesh;
  mesh.V.resize(static_cast<Eigen::Index>(edges.size()), 3);
  parallel_for(edges.size(), 1024, [&](std::size_t i) {
    mesh.V.row(static_cast<Eigen::Index>(i)) = crossing(lattice, edges[i]).transpose();
  });
  mesh.F.resize(static_cast<Eigen::Index>(faces), 3);
  Eigen::Index f = 0;
  for (const auto& list : of_block) {
    for (const auto& face : list) {
      mesh.F.row(f++) << vertex(face[0]), vertex(face[1]), vertex(face[2]);
    }
  }
  // Half a step is about the mean edge that marching leaves.
  Vector size(mesh.V.rows());
  parallel_for(edges.size(), 1024, [&](std::size_t i) {
    const auto v = static_cast<Eigen::Index>(i);
    const double thickness = lattice.thickness(mesh.V.row(v));
    size[v] = 0.6 * step * std::clamp(thickness / fine_radius, 1.0, coarsest);
  });
  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round) {
    progress.check();
    progress("polygonise", static_cast<double>(round) / rounds);
    even_out(mesh, size);
    for (int i = 0; i < 3; ++i) relax(lattice, mesh);
  }
  return mesh;
}

}  // namespace skinfield::sample_detail
