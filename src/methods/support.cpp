#include "skinfield/methods/support.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <numeric>

namespace skinfield {
namespace {

/// The k columns with the largest entries, of those above zero; ties go to the lower column.
std::vector<int> largest(const Eigen::RowVectorXd& w, int k) {
  std::vector<int> order(static_cast<std::size_t>(w.size()));
  std::iota(order.begin(), order.end(), 0);
  const auto end = order.begin() + std::min<std::ptrdiff_t>(k, w.size());
  std::partial_sort(order.begin(), end, order.end(),
                    [&](int a, int b) { return w[a] != w[b] ? w[a] > w[b] : a < b; });
  order.erase(std::find_if(order.begin(), end, [&](int j) { return !(w[j] > 0); }), order.end());
  return order;
}

}  // namespace

std::vector<std::vector<int>> kept_support(const RowMatrix& W, const SparseRows& P,
                                           const SupportOptions& options) {
  if (options.influences < 1 || P.cols() != W.rows()) {
    throw SolveError("influences below 1, or sizes that do not fit", "kept support");
  }
  const auto vertices = static_cast<std::size_t>(P.rows());
  std::vector<std::vector<int>> top(vertices);
  parallel_for(vertices, 256, [&](std::size_t v) {
    Eigen::RowVectorXd w = Eigen::RowVectorXd::Zero(W.cols());
    for (SparseRows::InnerIterator it(P, static_cast<Eigen::Index>(v)); it; ++it) {
      w += it.value() * W.row(it.col());
    }
    top[v] = largest(w, options.influences);
  });
  RowMatrix votes = RowMatrix::Zero(W.rows(), W.cols());
  Vector ballots = Vector::Zero(W.rows());
  for (std::size_t v = 0; v < vertices; ++v) {
    for (SparseRows::InnerIterator it(P, static_cast<Eigen::Index>(v)); it; ++it) {
      ballots[it.col()] += it.value();
      for (const int j : top[v]) votes(it.col(), j) += it.value();
    }
  }
  std::vector<std::vector<int>> support(static_cast<std::size_t>(W.rows()));
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    Eigen::Index first = 0;
    W.row(i).maxCoeff(&first);
    for (int j = 0; j < W.cols(); ++j) {
      const bool agreed = votes(i, j) >= options.agreement * ballots[i] * (1 - 1e-12);
      if (agreed || j == first) support[static_cast<std::size_t>(i)].push_back(j);
    }
  }
  return support;
}

BoundedBiharmonicResult resolve_on_support(const BoundedBiharmonicProblem& problem,
                                           const RowMatrix& W, const SparseRows& P,
                                           const SupportOptions& support,
                                           BoundedBiharmonicOptions options,
                                           const Progress& progress) {
  options.support = kept_support(W, P, support);
  options.start = W;
  return bounded_biharmonic(problem, options, progress);
}

}  // namespace skinfield
