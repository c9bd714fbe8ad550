#include "methods/quasi_harmonic_objective.h"

#include "methods/smooth_projection.h"
#include "operators/apply.h"
#include "skinfield/base/parallel.h"

#include <chrono>
#include <utility>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 512;

/// Adds the wall seconds of its life to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  double& sum_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

template <class Body>
void for_each_row(const std::vector<int>& nodes, const Body& body) {
  parallel_for(nodes.size(), kRowsPerBlock, [&](std::size_t k) {
    body(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(nodes[k]));
  });
}

SparseRows rows_of(const SparseRows& K, const std::vector<int>& nodes) {
  SparseRows rows(static_cast<Eigen::Index>(nodes.size()), K.cols());
  rows.reserve(K.nonZeros());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    rows.startVec(k);
    for (SparseRows::InnerIterator it(K, nodes[static_cast<std::size_t>(k)]); it; ++it) {
      rows.insertBack(k, it.col()) = it.value();
    }
  }
  rows.finalize();
  return rows;
}

}  // namespace

QuasiHarmonicObjective::QuasiHarmonicObjective(const AnisotropicStiffness& stiffness,
                                               const Vector& M, const FixedRows& fixed,
                                               TensorModel model, Vector share, bool project)
    : stiffness_(stiffness),
      inverse_mass_(M.cwiseInverse()),
      share_(std::move(share)),
      model_(std::move(model)),
      project_(project),
      K_(stiffness.isotropic()) {
  // Every link that an element makes counts, since A can give weight to any of them.
  SparseRows graph = K_;
  graph.coeffs().setOnes();
  NodeSubset reached = reached_nodes(graph, fixed.node);
  unreached_ = std::move(reached.left_out);
  std::vector<char> is_fixed(reached.position.size(), 0);
  for (const int v : fixed.node) is_fixed[static_cast<std::size_t>(v)] = 1;
  std::vector<int> row(reached.position.size(), -1);
  for (const int v : reached.node) {
    if (is_fixed[static_cast<std::size_t>(v)]) continue;
    row[static_cast<std::size_t>(v)] = static_cast<int>(free_.size());
    free_.push_back(v);
  }

  const auto n = static_cast<Eigen::Index>(free_.size());
  free_K_.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    free_K_.startVec(i);
    const int v = free_[static_cast<std::size_t>(i)];
    for (std::int32_t p = K_.outerIndexPtr()[v]; p < K_.outerIndexPtr()[v + 1]; ++p) {
      const int to = K_.innerIndexPtr()[p];
      if (is_fixed[static_cast<std::size_t>(to)]) {
        links_.push_back({static_cast<int>(i), to, p});
      } else {
        free_K_.insertBack(i, row[static_cast<std::size_t>(to)]) = 0;
        source_.push_back(p);
      }
    }
  }
  free_K_.finalize();
  factor_.analyse(free_K_);
  isotropic_free_rows_ = rows_of(K_, free_);

  state_.solved.setZero(K_.rows(), fixed.weights.cols());
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    state_.solved.row(fixed.node[k]) = fixed.weights.row(static_cast<Eigen::Index>(k));
  }
  state_.weights = state_.solved;
  if (share_.size() > 0) state_.weights.array().colwise() *= share_.array();
  adjoint_.setZero(K_.rows(), fixed.weights.cols());
}

double QuasiHarmonicObjective::evaluate(const Eigen::MatrixXd& theta) {
  tensors(model_, theta, state_.tensors);
  stiffness_.assemble(state_.tensors, K_);
  fill_system();
  {
    const Stopwatch watch(linear_seconds_);
    factor_.factor(free_K_);
  }

  // Equation 17.
  solution_.setZero(static_cast<Eigen::Index>(free_.size()), state_.solved.cols());
  for (const Link& link : links_) {
    solution_.row(link.row) -= K_.valuePtr()[link.value] * state_.solved.row(link.node);
  }
  solve();
  accept_solution();

  const SparseRows& K = stiffness_.isotropic();
  residual_.resize(K.rows(), state_.weights.cols());
  const double energy = parallel_reduce(
      static_cast<std::size_t>(residual_.rows()), kRowsPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        multiply(K, state_.weights, residual_, begin, end);
        double sum = 0;
        for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
          sum += inverse_mass_[i] * residual_.row(i).squaredNorm();
          residual_.row(i) *= inverse_mass_[i];
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
  return energy / 2;
}

void QuasiHarmonicObjective::solve() {
  const Stopwatch watch(linear_seconds_);
  factor_.solve(solution_);
}

void QuasiHarmonicObjective::fill_system() {
  const double* from = K_.valuePtr();
  double* to = free_K_.valuePtr();
  parallel_for(source_.size(), 8192, [&](std::size_t k) { to[k] = from[source_[k]]; });
}

void QuasiHarmonicObjective::accept_solution() {
  for_each_row(free_, [&](Eigen::Index k, Eigen::Index v) {
    auto p = state_.weights.row(v);
    p = state_.solved.row(v) = solution_.row(k);
    if (project_) project_smoothly(p.data(), p.size());
    if (share_.size() > 0) p *= share_[v];
  });
}

void QuasiHarmonicObjective::gradient(const Eigen::MatrixXd& theta, Eigen::MatrixXd& result) {
  // dE/dP = K M^-1 K P (equation 19), back through the projection on the free rows.
  parallel_blocks(free_.size(), kRowsPerBlock, [&](std::size_t begin, std::size_t end) {
    multiply(isotropic_free_rows_, residual_, solution_, begin, end);
    for (std::size_t k = begin; k < end; ++k) {
      const auto v = static_cast<Eigen::Index>(free_[k]);
      auto z = solution_.row(static_cast<Eigen::Index>(k));
      if (share_.size() > 0) z *= share_[v];
      if (project_) project_smoothly_adjoint(state_.solved.row(v).data(), z.data(), z.size());
    }
  });
  solve();
  // dE = -tr(Z' dK W), with Z zero on the rows that are not free.
  for_each_row(free_, [&](Eigen::Index k, Eigen::Index v) { adjoint_.row(v) = -solution_.row(k); });
  stiffness_.derivative(adjoint_, state_.solved, result);
  to_parameters(model_, theta, result);
}

void QuasiHarmonicObjective::exchange(State& other) {
  if (other.solved.size() == 0) other = state_;  // what is never written: the fixed rows
  std::swap(state_, other);
}

}  // namespace skinfield
