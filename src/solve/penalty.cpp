#include "solve/penalty.h"

#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 256;
constexpr double kFloor = 0.01;  // of the mean energy density: far from handles it is nearly zero
constexpr double kFactor = 3.0;
constexpr double kBalanced = 0.6;  // primal over dual residual
constexpr double kRange = 10;      // of the rows' factors: what does not move at all has no ratio

/// Means over closed neighbourhoods of `graph`.
void diffuse(const SparseRows& graph, int passes, Vector& values) {
  for (int pass = 0; pass < passes; ++pass) {
    const Vector old = values;
    parallel_for(static_cast<std::size_t>(graph.rows()), kRowsPerBlock, [&](std::size_t row) {
      const auto i = static_cast<Eigen::Index>(row);
      double sum = 0;
      const auto begin = graph.outerIndexPtr()[i], end = graph.outerIndexPtr()[i + 1];
      for (auto p = begin; p < end; ++p) sum += old[graph.innerIndexPtr()[p]];
      if (end > begin) values[i] = sum / (end - begin);
    });
  }
}

double median(Vector values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Vector local_penalty(const SimplexProblem& problem, const FreeRows& free, const RowMatrix& X,
                     const RowMatrix& Z, const Vector& landscape) {
  const Vector& M = problem.M;
  const bool factored = problem.K.rows() == problem.Q.rows();
  Vector q(M.size());
  if (factored) {
    const RowMatrix all = free.scatter(X);
    parallel_for(static_cast<std::size_t>(q.size()), kRowsPerBlock, [&](std::size_t row) {
      const auto i = static_cast<Eigen::Index>(row);
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(all.cols());
      for (SparseRows::InnerIterator it(problem.K, i); it; ++it) {
        sum += it.value() * all.row(it.col());
      }
      q[i] = sum.squaredNorm() / M[i];
    });
  } else {
    q.setZero();
    const RowMatrix G = free.gradient(Z);
    for (Eigen::Index i = 0; i < free.rows(); ++i) {
      q[free.node[static_cast<std::size_t>(i)]] = std::abs(Z.row(i).dot(G.row(i)));
    }
  }
  Vector mass = M;
  double energy = q.sum(), weight = 0;
  for (Eigen::Index i = 0; i < free.rows(); ++i) {
    weight += M[free.node[static_cast<std::size_t>(i)]] * Z.row(i).squaredNorm();
  }
  const SparseRows& graph = factored ? problem.K : problem.Q;
  const int passes = factored ? 6 : 3;  // Q's graph reaches twice as far
  diffuse(graph, passes, q);
  diffuse(graph, passes, mass);
  const double middle = median(M);
  double density = weight > 0 ? energy / weight : 0;
  // Nothing to go by (a start of zero energy): the softest scale that still regularises.
  if (!(density > 0)) density = 1e-6 * free.Q.diagonal().sum() / M.sum();
  if (!(density > 0)) density = 1;
  Vector reach = Vector::Zero(M.size());
  for (Eigen::Index i = 0; i < landscape.size(); ++i) {
    reach[free.node[static_cast<std::size_t>(i)]] = std::abs(landscape[i]);
  }
  diffuse(graph, passes, reach);
  Vector d(free.rows());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const int v = free.node[static_cast<std::size_t>(i)];
    double floor = kFloor * density;
    if (reach[v] > 0) floor = std::min(floor, 1 / reach[v]);
    d[i] =
        kFactor * std::max(floor, q[v] / mass[v]) * std::max(M[v], 0.2 * std::min(middle, mass[v]));
  }
  return d;
}

void balance_rows(const FreeRows& free, Vector primal, Vector dual, Vector& scale) {
  diffuse(free.Q, 1, primal);
  diffuse(free.Q, 1, dual);
  // Rows without any residual keep what they have.
  const double least = 1e-30 * (primal.sum() + dual.sum());
  if (!(least > 0)) return;
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    const double ratio = (primal[i] + least) / (dual[i] + least) / (kBalanced * kBalanced);
    scale[i] = std::clamp(scale[i] * std::clamp(ratio, 1 / kRange, kRange), 1 / kRange, kRange);
  }
}

}  // namespace skinfield
