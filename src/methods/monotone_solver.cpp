#include "methods/monotone_solver.h"

#include "methods/positive_links.h"
#include "methods/reached.h"
#include "operators/apply.h"
#include "skinfield/base/parallel.h"
#include "skinfield/operators/biharmonic.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace skinfield {
namespace {

constexpr double kRelaxation = 1.6;
constexpr int kCheckEvery = 10;
constexpr int kBalanceEvery = 20;
constexpr int kLastBalance = 400;  // penalties that change for ever keep it from converging
constexpr double kImbalance = 3;   // of the residuals, beyond which the penalty follows
constexpr double kFirstPenalty =
    300;  // of the ratio: gave the lowest energies after 200 iterations
constexpr int kDiffusions = 4;
constexpr double kLeastRatio = 0.01, kLargestRatio = 1e4;  // of the mean
constexpr double kBoundsHold = 1e-6;
constexpr int kRepairPasses = 200;
constexpr std::size_t kEdgesPerBlock = 1024;
constexpr std::size_t kRowsPerBlock = 512;

/// How the difference w_a - w_b of an edge is bound, as bits.
constexpr std::uint8_t kAtLeastZero = 1, kAtMostZero = 2;

double project(double difference, std::uint8_t bounds) {
  if (bounds & kAtLeastZero) difference = std::max(difference, 0.0);
  if (bounds & kAtMostZero) difference = std::min(difference, 0.0);
  return difference;
}

/// Means over closed neighbourhoods of `graph`.
void diffuse(const SparseRows& graph, int passes, Vector& values) {
  for (int pass = 0; pass < passes; ++pass) {
    const Vector old = values;
    for (Eigen::Index i = 0; i < graph.rows(); ++i) {
      double sum = 0;
      int count = 0;
      for (SparseRows::InnerIterator it(graph, i); it; ++it, ++count) sum += old[it.col()];
      values[i] = sum / count;
    }
  }
}

class Solver {
 public:
  Solver(const MonotoneProgram& program, const Progress& progress)
      : program_(program),
        progress_(progress),
        n_(program.K.rows()),
        m_(program.fixed.weights.cols()),
        links_(positive_links(program.K)),
        free_(free_nodes(n_, program.fixed.node)) {
    Q_ = biharmonic(program.K, program.M);
    find_edges();
    prepare_system();
  }

  MonotoneSolution run() {
    start();
    MonotoneSolution solution;
    SolveStats& stats = solution.stats;
    stats.status = SolveStats::Status::limit;
    const auto begin = std::chrono::steady_clock::now();
    RowMatrix checked = W_;
    double change_before = 1;
    for (int k = 1; k <= program_.max_iterations; ++k) {
      progress_.check();
      progress_("weights", static_cast<double>(k) / program_.max_iterations);
      iterate();
      stats.iterations = k;
      if (k % kCheckEvery == 0) {
        stats.largest_change = (W_ - checked).cwiseAbs().maxCoeff();
        checked = W_;
        // Changes that shrink by a factor q a check sum to 1 / (1 - q) times the last one.
        const double q = std::min(0.95, stats.largest_change / std::max(change_before, 1e-300));
        change_before = stats.largest_change;
        if (stats.largest_change * q / (1 - q) < program_.tolerance &&
            stats.largest_change < program_.tolerance && worst_violation() < program_.tolerance) {
          stats.status = SolveStats::Status::converged;
          break;
        }
      }
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
      if (program_.time_limit_s > 0 && passed.count() > program_.time_limit_s) break;
      if (k % kBalanceEvery == 0 && k <= kLastBalance) balance();
    }
    stats.lower_bound = lower_bound();
    stats.kkt_residual = worst_violation();
    repair();
    solution.W = W_;
    stats.energy = energy(W_);
    stats.relative_gap = stats.energy > 0 ? (stats.energy - stats.lower_bound) / stats.energy : 0;
    return solution;
  }

 private:
  struct Edge {
    int a, b;  // a < b
    double link;
  };

  void find_edges() {
    std::vector<std::int32_t> edge_at(static_cast<std::size_t>(links_.nonZeros()), -1);
    for (int a = 0; a < n_; ++a) {
      for (std::int32_t p = links_.outerIndexPtr()[a]; p < links_.outerIndexPtr()[a + 1]; ++p) {
        const int b = links_.innerIndexPtr()[p];
        if (b <= a) continue;
        edge_at[static_cast<std::size_t>(p)] = static_cast<std::int32_t>(edges_.size());
        edges_.push_back({a, b, -links_.valuePtr()[p]});
      }
    }
    bounds_.assign(edges_.size() * static_cast<std::size_t>(m_), 0);
    const auto bound = [&](int low, int high, Eigen::Index j) {
      const int a = std::min(low, high), b = std::max(low, high);
      const std::int32_t* begin = links_.innerIndexPtr() + links_.outerIndexPtr()[a];
      const std::int32_t* end = links_.innerIndexPtr() + links_.outerIndexPtr()[a + 1];
      const auto p = std::lower_bound(begin, end, b) - links_.innerIndexPtr();
      const auto e = static_cast<std::size_t>(edge_at[static_cast<std::size_t>(p)]);
      bounds_[e * static_cast<std::size_t>(m_) + static_cast<std::size_t>(j)] |=
          a == high ? kAtLeastZero : kAtMostZero;
    };
    for (Eigen::Index j = 0; j < m_; ++j) {
      const MonotoneOrder& order = program_.order[static_cast<std::size_t>(j)];
      for (const int v : order.from_above) {
        bound(v, order.up[static_cast<std::size_t>(v)], j);
        bound(order.down[static_cast<std::size_t>(v)], v, j);
      }
    }
  }

  void prepare_system() {
    free_Q_ = restrict_to(Q_, free_);
    // Q's pattern holds K's: the penalty changes values only.
    factor_.analyse(free_Q_);
    W_.setZero(n_, m_);
    for (std::size_t k = 0; k < program_.fixed.node.size(); ++k) {
      W_.row(program_.fixed.node[k]) = program_.fixed.weights.row(static_cast<Eigen::Index>(k));
    }
    RowMatrix QW;
    apply(Q_, W_, QW);
    from_fixed_.resize(free_.node.size(), m_);
    for_free([&](Eigen::Index k, Eigen::Index v) { from_fixed_.row(k) = -QW.row(v); });
  }

  template <class Body>
  void for_free(const Body& body) const {
    parallel_for(free_.node.size(), kRowsPerBlock, [&](std::size_t k) {
      body(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(free_.node[k]));
    });
  }

  void accept(const RowMatrix& X) {
    for_free([&](Eigen::Index k, Eigen::Index v) {
      auto w = W_.row(v);
      w = X.row(k);
      // All columns have the same matrix, so that the minimiser with rows that sum to 1 is the
      // free one, shifted by the same amount in every column.
      if (program_.coupled) w.array() += (1 - w.sum()) / static_cast<double>(m_);
    });
  }

  void start() {
    factor_.factor(free_Q_);
    RowMatrix X = from_fixed_;
    factor_.solve(X);
    accept(X);
    scale_links();
    set_penalty(kFirstPenalty);
    S_.resize(static_cast<Eigen::Index>(edges_.size()), m_);
    for_edges([&](std::size_t e, const Edge& edge) {
      for (Eigen::Index j = 0; j < m_; ++j) {
        S_(static_cast<Eigen::Index>(e), j) = project(W_(edge.a, j) - W_(edge.b, j), bound(e, j));
      }
    });
  }

  /// Links times the local ratio of bending to stretching of W: penalties that balance the energy
  /// in small cells near handles as well as far from them.
  void scale_links() {
    RowMatrix KW;
    apply(program_.K, W_, KW);
    Vector bending = KW.rowwise().squaredNorm().cwiseQuotient(program_.M);
    Vector stretching = Vector::Zero(n_);
    for (const Edge& edge : edges_) {
      const double energy = 0.5 * edge.link * (W_.row(edge.a) - W_.row(edge.b)).squaredNorm();
      stretching[edge.a] += energy;
      stretching[edge.b] += energy;
    }
    const double mean = bending.sum() / std::max(stretching.sum(), 1e-300);
    diffuse(links_, kDiffusions, bending);
    diffuse(links_, kDiffusions, stretching);
    Vector ratio(n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const double local = bending[i] / std::max(stretching[i], 1e-300);
      ratio[i] = mean > 0 ? std::clamp(local, kLeastRatio * mean, kLargestRatio * mean) : 1;
    }
    for (Edge& edge : edges_) {
      const double scale = 0.5 * (ratio[edge.a] + ratio[edge.b]);
      edge.link *= scale;
      links_.coeffRef(edge.a, edge.b) *= scale;
      links_.coeffRef(edge.b, edge.a) *= scale;
    }
    for (Eigen::Index i = 0; i < n_; ++i) {
      double total = 0;
      for (SparseRows::InnerIterator it(links_, i); it; ++it)
        total -= it.col() != i ? it.value() : 0;
      links_.coeffRef(i, i) = total;
    }
  }

  std::uint8_t bound(std::size_t e, Eigen::Index j) const {
    return bounds_[e * static_cast<std::size_t>(m_) + static_cast<std::size_t>(j)];
  }

  template <class Body>
  void for_edges(const Body& body) const {
    parallel_for(edges_.size(), kEdgesPerBlock, [&](std::size_t e) { body(e, edges_[e]); });
  }

  void set_penalty(double penalty) {
    penalty_ = penalty;
    SparseRows system = free_Q_;
    const SparseRows R = restrict_to(links_, free_);
    parallel_for(static_cast<std::size_t>(R.rows()), kRowsPerBlock, [&](std::size_t row) {
      std::int32_t p = system.outerIndexPtr()[row];
      for (SparseRows::InnerIterator it(R, static_cast<Eigen::Index>(row)); it; ++it) {
        while (system.innerIndexPtr()[p] < it.col()) ++p;
        system.valuePtr()[p] += penalty * it.value();
      }
    });
    factor_.factor(system);
  }

  /// sum over the edges of a free node of r_e t_e, signed: D' R T, with T = target(e, j).
  template <class Target>
  void add_targets(RowMatrix& X, const Target& target) {
    // Edge values first, then rows gather theirs: deterministic at any thread count.
    T_.resize(S_.rows(), m_);
    for_edges([&](std::size_t e, const Edge& edge) {
      for (Eigen::Index j = 0; j < m_; ++j) {
        T_(static_cast<Eigen::Index>(e), j) = penalty_ * edge.link * target(e, edge, j);
      }
    });
    if (incidence_.rows() == 0) build_incidence();
    for_free([&](Eigen::Index k, Eigen::Index v) {
      for (SparseRows::InnerIterator it(incidence_, v); it; ++it) {
        X.row(k) += it.value() * T_.row(it.col());
      }
    });
  }

  void build_incidence() {
    std::vector<Eigen::Triplet<double, std::int32_t>> entries;
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      entries.emplace_back(edges_[e].a, static_cast<std::int32_t>(e), 1.0);
      entries.emplace_back(edges_[e].b, static_cast<std::int32_t>(e), -1.0);
    }
    incidence_.resize(n_, static_cast<Eigen::Index>(edges_.size()));
    incidence_.setFromTriplets(entries.begin(), entries.end());
  }

  void iterate() {
    RowMatrix X = from_fixed_;
    add_targets(X, [&](std::size_t e, const Edge& edge, Eigen::Index j) {
      const double s = S_(static_cast<Eigen::Index>(e), j);
      // Fixed nodes' values stand on the other side of the equation.
      return 2 * project(s, bound(e, j)) - s - fixed_difference(edge, j);
    });
    factor_.solve(X);
    accept(X);
    residuals_ = parallel_reduce(
        edges_.size(), kEdgesPerBlock, Residuals(),
        [&](std::size_t begin, std::size_t end) {
          Residuals sum;
          for (std::size_t e = begin; e < end; ++e) {
            const Edge& edge = edges_[e];
            for (Eigen::Index j = 0; j < m_; ++j) {
              double& s = S_(static_cast<Eigen::Index>(e), j);
              const std::uint8_t bounds = bound(e, j);
              const double y = project(s, bounds);
              const double apart = W_(edge.a, j) - W_(edge.b, j) - y;
              s += kRelaxation * apart;
              const double moved = project(s, bounds) - y;
              if (bounds) sum.primal += edge.link * (apart - moved) * (apart - moved);
              sum.dual += edge.link * moved * moved;
            }
          }
          return sum;
        },
        [](Residuals a, const Residuals& b) {
          a.primal += b.primal;
          a.dual += b.dual;
          return a;
        });
  }

  double fixed_difference(const Edge& edge, Eigen::Index j) const {
    double d = 0;
    if (free_.position[static_cast<std::size_t>(edge.a)] < 0) d += W_(edge.a, j);
    if (free_.position[static_cast<std::size_t>(edge.b)] < 0) d -= W_(edge.b, j);
    return d;
  }

  /// The penalty follows the larger residual (Boyd et al. 2011, section 3.4.1).
  void balance() {
    if (!(residuals_.primal > 0) || !(residuals_.dual > 0)) return;
    const double ratio = std::sqrt(residuals_.primal / residuals_.dual);
    if (ratio < kImbalance && ratio > 1 / kImbalance) return;
    const double factor = std::clamp(ratio, 0.1, 10.0);
    set_penalty(penalty_ * factor);
    for_edges([&](std::size_t e, const Edge&) {
      for (Eigen::Index j = 0; j < m_; ++j) {
        double& s = S_(static_cast<Eigen::Index>(e), j);
        const double y = project(s, bound(e, j));
        s = y + (s - y) / factor;
      }
    });
  }

  double worst_violation() const {
    double worst = 0;
    for (Eigen::Index j = 0; j < m_; ++j) {
      const Vector w = W_.col(j);
      worst = std::max(worst, violation(program_.order[static_cast<std::size_t>(j)], w));
    }
    return worst;
  }

  void repair() {
    parallel_for(static_cast<std::size_t>(m_), 1, [&](std::size_t j) {
      Vector w = W_.col(static_cast<Eigen::Index>(j));
      make_monotone(program_.order[j], w, kBoundsHold, kRepairPasses);
      W_.col(static_cast<Eigen::Index>(j)) = w;
    });
  }

  double energy(const RowMatrix& W) const {
    RowMatrix KW;
    apply(program_.K, W, KW);
    return 0.5 * (KW.array().square().colwise() / program_.M.array()).sum();
  }

  /// The multipliers R (S - proj S) lie in the bounds' polar cone: the Lagrangian's minimum is a
  /// bound, and takes one solve with Q.
  double lower_bound() {
    factor_.factor(free_Q_);
    RowMatrix X = from_fixed_;
    const auto multiplier = [&](std::size_t e, const Edge&, Eigen::Index j) {
      const double s = S_(static_cast<Eigen::Index>(e), j);
      return project(s, bound(e, j)) - s;
    };
    add_targets(X, multiplier);
    factor_.solve(X);
    const RowMatrix kept = W_;
    accept(X);
    double linear = 0;
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      for (Eigen::Index j = 0; j < m_; ++j) {
        linear += T_(static_cast<Eigen::Index>(e), j) * (W_(edges_[e].a, j) - W_(edges_[e].b, j));
      }
    }
    const double bound_found = energy(W_) - linear;
    W_ = kept;
    return std::max(0.0, bound_found);
  }

  const MonotoneProgram& program_;
  const Progress& progress_;
  Eigen::Index n_, m_;
  SparseRows links_, Q_, free_Q_, incidence_;
  NodeSubset free_;
  SparseFactor factor_;
  std::vector<Edge> edges_;
  std::vector<std::uint8_t> bounds_;
  double penalty_ = 0;
  RowMatrix W_, from_fixed_, S_, T_;
  struct Residuals {
    double primal = 0, dual = 0;
  };
  Residuals residuals_;
};

}  // namespace

MonotoneSolution solve_monotone(const MonotoneProgram& program, const Progress& progress) {
  return Solver(program, progress).run();
}

}  // namespace skinfield
