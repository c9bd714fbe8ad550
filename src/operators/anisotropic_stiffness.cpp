#include "skinfield/operators/anisotropic_stiffness.h"

#include "operators/element_kernels.h"
#include "operators/elements.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <utility>

namespace skinfield {
namespace {

constexpr std::size_t kElementsPerBlock = 2048;
constexpr std::size_t kEdgesPerBlock = 2048;
constexpr std::size_t kRowsPerBlock = 1024;

Eigen::Matrix3d triangle_frame(const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 n = (b - a).cross(c - a).normalized();
  Eigen::Index least = 0, most = 0;
  n.cwiseAbs().minCoeff(&least);
  n.cwiseAbs().maxCoeff(&most);
  if (n[most] < 0) n = -n;  // one frame whichever way round the corners are listed
  const Vec3 axis = Vec3::Unit(least);
  Eigen::Matrix3d frame;
  frame.col(0) = (axis - n * n.dot(axis)).normalized();
  frame.col(1) = n.cross(frame.col(0));
  frame.col(2) = n;
  return frame;
}

}  // namespace

template <class Elements>
void AnisotropicStiffness::build(const Points& V, const Elements& E) {
  constexpr int D = Elements::ColsAtCompileTime - 1;
  if (E.size() > 0 && (E.minCoeff() < 0 || E.maxCoeff() >= V.rows())) {
    throw InputError("a vertex index is out of range", "mesh");
  }
  dimension_ = D;
  volume_.resize(E.rows());
  G_.setZero(E.rows(), D * D);
  corner_ = E;
  if (D == 2) frame_.assign(static_cast<std::size_t>(E.rows()), Eigen::Matrix3d::Identity());
  parallel_for(static_cast<std::size_t>(E.rows()), kElementsPerBlock, [&](std::size_t row) {
    const auto e = static_cast<Eigen::Index>(row);
    const Element<D + 1> one = element(V, E, e);
    volume_[e] = one.volume;
    if (one.volume == 0) return;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    if (D == 2) axes = frame_[row] = triangle_frame(V.row(E(e, 0)), V.row(E(e, 1)), V.row(E(e, 2)));
    for (int i = 0; i < D; ++i) {
      for (int r = 0; r < D; ++r) G_(e, i * D + r) = one.G.row(i + 1).dot(axes.col(r));
    }
  });
  build_edges();
  build_pattern(V.rows());
  Eigen::MatrixXd identity = Eigen::MatrixXd::Zero(E.rows(), coefficients());
  for (int r = 0, k = 0; r < D; k += D - r++) identity.col(k).setOnes();
  assemble(identity, K_);
}

AnisotropicStiffness::AnisotropicStiffness(const Points& V, const Tetrahedra& T) { build(V, T); }
AnisotropicStiffness::AnisotropicStiffness(const Points& V, const Triangles& F) { build(V, F); }

const Eigen::Matrix3d& AnisotropicStiffness::frame(Eigen::Index e) const {
  static const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  return frame_.empty() ? identity : frame_[static_cast<std::size_t>(e)];
}

void AnisotropicStiffness::build_edges() {
  const Eigen::Index elements = volume_.size();
  const std::int32_t nodes = corner_.size() > 0 ? corner_.maxCoeff() + 1 : 0;
  const auto visit_pairs = [&](const auto& visit) {
    std::int32_t slot = 0;
    for (int i = 0; i <= dimension_; ++i) {
      for (int j = i + 1; j <= dimension_; ++j) {
        for (Eigen::Index e = 0; e < elements; ++e, ++slot) {
          if (volume_[e] == 0) continue;
          visit(std::min(corner_(e, i), corner_(e, j)), std::max(corner_(e, i), corner_(e, j)),
                slot);
        }
      }
    }
  };
  // Buckets by the lower node, then a small sort in each.
  std::vector<std::int32_t> start(static_cast<std::size_t>(nodes) + 1, 0);
  visit_pairs([&](std::int32_t a, std::int32_t, std::int32_t) {
    ++start[static_cast<std::size_t>(a) + 1];
  });
  for (std::size_t i = 0; i + 1 < start.size(); ++i) start[i + 1] += start[i];
  std::vector<std::pair<std::int32_t, std::int32_t>> bucket(static_cast<std::size_t>(start.back()));
  std::vector<std::int32_t> next(start.begin(), start.end() - 1);
  visit_pairs([&](std::int32_t a, std::int32_t b, std::int32_t slot) {
    bucket[static_cast<std::size_t>(next[static_cast<std::size_t>(a)]++)] = {b, slot};
  });
  parallel_for(static_cast<std::size_t>(nodes), kRowsPerBlock, [&](std::size_t a) {
    std::sort(bucket.begin() + start[a], bucket.begin() + start[a + 1]);
  });
  edge_of_slot_.assign(static_cast<std::size_t>(elements * coefficients()), -1);
  slot_.reserve(bucket.size());
  for (std::int32_t a = 0; a < nodes; ++a) {
    for (std::int32_t t = start[static_cast<std::size_t>(a)];
         t < start[static_cast<std::size_t>(a) + 1]; ++t) {
      const auto [b, slot] = bucket[static_cast<std::size_t>(t)];
      if (edges_.empty() || edges_.back().a != a || edges_.back().b != b) {
        edges_.push_back({a, b, 0, 0});
        first_.push_back(static_cast<std::int32_t>(slot_.size()));
      }
      edge_of_slot_[static_cast<std::size_t>(slot)] = static_cast<std::int32_t>(edges_.size()) - 1;
      slot_.push_back(slot);
    }
  }
  first_.push_back(static_cast<std::int32_t>(slot_.size()));
  std::replace(edge_of_slot_.begin(), edge_of_slot_.end(), -1,
               static_cast<std::int32_t>(edges_.size()));
}

void AnisotropicStiffness::build_pattern(Eigen::Index nodes) {
  const auto n = static_cast<std::size_t>(nodes);
  std::vector<std::int32_t> below(n, 0), above(n, 0);
  for (const Edge& edge : edges_) {
    ++above[static_cast<std::size_t>(edge.a)];
    ++below[static_cast<std::size_t>(edge.b)];
  }
  K_.resize(nodes, nodes);
  std::int32_t* start = K_.outerIndexPtr();
  start[0] = 0;
  for (std::size_t i = 0; i < n; ++i) start[i + 1] = start[i] + below[i] + 1 + above[i];
  K_.resizeNonZeros(start[n]);
  diagonal_.resize(n);
  std::vector<std::int32_t> next_below(n), next_above(n);
  for (std::size_t i = 0; i < n; ++i) {
    next_below[i] = start[i];
    diagonal_[i] = start[i] + below[i];
    next_above[i] = diagonal_[i] + 1;
    K_.innerIndexPtr()[diagonal_[i]] = static_cast<std::int32_t>(i);
  }
  // Edges ascend by both nodes, and so do the entries of every row.
  for (Edge& edge : edges_) {
    edge.upper = next_above[static_cast<std::size_t>(edge.a)]++;
    edge.lower = next_below[static_cast<std::size_t>(edge.b)]++;
    K_.innerIndexPtr()[edge.upper] = edge.b;
    K_.innerIndexPtr()[edge.lower] = edge.a;
  }
}

void AnisotropicStiffness::assemble(const Eigen::MatrixXd& A, SparseRows& K) const {
  Vector value(elements() * coefficients());
  const ElementArrays arrays{G_.data(), volume_.data(), elements()};
  parallel_blocks(static_cast<std::size_t>(elements()), kElementsPerBlock,
                  [&](std::size_t begin, std::size_t end) {
                    pair_values(dimension_, arrays, A.data(), value.data(),
                                static_cast<std::ptrdiff_t>(begin),
                                static_cast<std::ptrdiff_t>(end));
                  });
  double* out = K.valuePtr();
  const double* in = value.data();
  parallel_for(edges_.size(), kEdgesPerBlock, [&](std::size_t t) {
    double sum = 0;
    for (std::int32_t s = first_[t]; s < first_[t + 1]; ++s) {
      sum += in[slot_[static_cast<std::size_t>(s)]];
    }
    out[edges_[t].upper] = out[edges_[t].lower] = sum;
  });
  const std::int32_t* start = K.outerIndexPtr();
  parallel_for(diagonal_.size(), kRowsPerBlock, [&](std::size_t i) {
    double sum = 0;
    for (std::int32_t p = start[i]; p < diagonal_[i]; ++p) sum -= out[p];
    for (std::int32_t p = diagonal_[i] + 1; p < start[i + 1]; ++p) sum -= out[p];
    out[diagonal_[i]] = sum;
  });
}

void AnisotropicStiffness::derivative(const RowMatrix& X, const RowMatrix& Y,
                                      Eigen::MatrixXd& D) const {
  // tr(X' K Y) = - sum over edges of k_ab <x_a - x_b, y_a - y_b>, since K 1 = 0: far fewer products
  // than gradients in every element would take.
  const std::ptrdiff_t m = X.cols();
  std::vector<double> s(edges_.size() + 1, 0.0);  // the last: for elements without edges
  constexpr auto stride = static_cast<std::ptrdiff_t>(sizeof(Edge) / sizeof(std::int32_t));
  parallel_blocks(edges_.size(), kEdgesPerBlock, [&](std::size_t begin, std::size_t end) {
    difference_products(&edges_.data()->a, &edges_.data()->b, stride, X.data(), Y.data(), m,
                        s.data(), static_cast<std::ptrdiff_t>(begin),
                        static_cast<std::ptrdiff_t>(end));
  });
  D.resize(elements(), coefficients());
  const ElementArrays arrays{G_.data(), volume_.data(), elements()};
  parallel_blocks(static_cast<std::size_t>(elements()), kElementsPerBlock,
                  [&](std::size_t begin, std::size_t end) {
                    const auto count = static_cast<std::ptrdiff_t>(end - begin);
                    Vector of_slot(count * coefficients());
                    for (int p = 0; p < coefficients(); ++p) {
                      double* to = of_slot.data() + p * count;
                      const std::int32_t* edge = edge_of_slot_.data() + p * elements() + begin;
                      for (std::ptrdiff_t e = 0; e < count; ++e) {
                        to[e] = s[static_cast<std::size_t>(edge[e])];
                      }
                    }
                    pair_derivatives(dimension_, arrays, of_slot.data(), count, D.data(),
                                     static_cast<std::ptrdiff_t>(begin),
                                     static_cast<std::ptrdiff_t>(end));
                  });
}

Points AnisotropicStiffness::gradient(const Vector& x) const {
  Points result(elements(), 3);
  parallel_for(static_cast<std::size_t>(elements()), kElementsPerBlock, [&](std::size_t row) {
    const auto e = static_cast<Eigen::Index>(row);
    Vec3 local = Vec3::Zero();
    for (int i = 0; i < dimension_; ++i) {
      const double rise = x[corner_(e, i + 1)] - x[corner_(e, 0)];
      for (int r = 0; r < dimension_; ++r) local[r] += rise * G_(e, i * dimension_ + r);
    }
    result.row(e) = (frame(e) * local).transpose();
  });
  return result;
}

Vector AnisotropicStiffness::divergence(const Points& q) const {
  Vector result = Vector::Zero(K_.rows());
  for (Eigen::Index e = 0; e < elements(); ++e) {
    const Vec3 local = volume_[e] * (frame(e).transpose() * q.row(e).transpose());
    for (int i = 0; i < dimension_; ++i) {
      double flow = 0;
      for (int r = 0; r < dimension_; ++r) flow += G_(e, i * dimension_ + r) * local[r];
      result[corner_(e, i + 1)] += flow;
      result[corner_(e, 0)] -= flow;
    }
  }
  return result;
}

}  // namespace skinfield
