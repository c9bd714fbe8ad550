#include "solve/free_rows.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 256;
constexpr const char* kWhere = "simplex program";

template <class Part>
double sum_rows(Eigen::Index rows, const Part& part) {
  return parallel_reduce(
      static_cast<std::size_t>(rows), kRowsPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += part(static_cast<Eigen::Index>(i));
        return sum;
      },
      std::plus<>());
}

/// Rows with few non-zeros, so that products with Q skip the zeros: optima use 2 or 3 columns.
class NonZeros {
 public:
  explicit NonZeros(const RowMatrix& Z)
      : columns_(Z.cols()),
        count_(static_cast<std::size_t>(Z.rows())),
        index_(static_cast<std::size_t>(Z.size())),
        value_(static_cast<std::size_t>(Z.size())) {
    parallel_for(count_.size(), kRowsPerBlock, [&](std::size_t i) {
      update(static_cast<Eigen::Index>(i), Z.row(static_cast<Eigen::Index>(i)).data());
    });
  }
  void update(Eigen::Index row, const double* w) {
    const auto base = static_cast<std::size_t>(row * columns_);
    int count = 0;
    for (int j = 0; j < columns_; ++j) {
      if (w[j] == 0) continue;
      index_[base + static_cast<std::size_t>(count)] = j;
      value_[base + static_cast<std::size_t>(count)] = w[j];
      ++count;
    }
    count_[static_cast<std::size_t>(row)] = count;
  }
  /// sum += q * row
  void add(Eigen::Index row, double q, double* sum) const {
    const auto base = static_cast<std::size_t>(row * columns_);
    const int count = count_[static_cast<std::size_t>(row)];
    if (count == columns_) {  // full rows need no index
      const double* value = value_.data() + base;
      for (Eigen::Index j = 0; j < columns_; ++j) sum[j] += q * value[j];
      return;
    }
    for (int t = 0; t < count; ++t) {
      const std::size_t at = base + static_cast<std::size_t>(t);
      sum[index_[at]] += q * value_[at];
    }
  }

 private:
  Eigen::Index columns_;
  std::vector<int> count_;
  std::vector<int> index_;
  std::vector<double> value_;
};

/// g = row i of Q Z - R.
void gradient_row(const SparseRows& Q, const RowMatrix& R, const NonZeros& Z, Eigen::Index i,
                  double* g) {
  for (Eigen::Index j = 0; j < R.cols(); ++j) g[j] = -R(i, j);
  for (auto p = Q.outerIndexPtr()[i]; p < Q.outerIndexPtr()[i + 1]; ++p) {
    Z.add(Q.innerIndexPtr()[p], Q.valuePtr()[p], g);
  }
}

}  // namespace

FreeRows::FreeRows(const SimplexProblem& problem, bool anchored)
    : problem_(problem), columns_(problem.columns) {
  const Eigen::Index N = problem.Q.rows();
  const FixedRows& fixed = problem.fixed;
  const auto wrong = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (problem.Q.cols() != N || !problem.Q.isCompressed()) wrong("Q is not square and compressed");
  if (columns_ < 1) wrong("there are no columns");
  if (problem.M.size() != N) wrong("M has a wrong size");
  if (problem.B.size() && (problem.B.rows() != N || problem.B.cols() != columns_)) {
    wrong("B has a wrong size");
  }
  if (problem.row_sum.size() && problem.row_sum.size() != N) wrong("row_sum has a wrong size");
  if (!problem.support.empty() && static_cast<Eigen::Index>(problem.support.size()) != N) {
    wrong("support has a wrong size");
  }
  if (static_cast<Eigen::Index>(fixed.node.size()) != fixed.weights.rows() ||
      (fixed.weights.rows() > 0 && fixed.weights.cols() != columns_)) {
    wrong("the fixed rows have a wrong size");
  }
  // position >= 0: number of the free row; < 0: -1 - number of the fixed row.
  std::vector<int> position(static_cast<std::size_t>(N), 0);
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    if (fixed.node[k] < 0 || fixed.node[k] >= N) wrong("a fixed row is out of range");
    position[static_cast<std::size_t>(fixed.node[k])] = -1 - static_cast<int>(k);
  }
  for (int i = 0; i < N; ++i) {
    int& p = position[static_cast<std::size_t>(i)];
    if (p < 0) continue;
    p = static_cast<int>(node.size());
    node.push_back(i);
  }
  if (anchored) check_components(problem, position);

  const Eigen::Index n = rows();
  row_sum = Vector::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int v = node[static_cast<std::size_t>(i)];
    if (problem.row_sum.size()) row_sum[i] = problem.row_sum[v];
    if (!(row_sum[i] >= 0) || !std::isfinite(row_sum[i])) {
      wrong("the row sum of node " + std::to_string(v) + " is negative or not finite");
    }
    if (!problem.support.empty() && problem.support[static_cast<std::size_t>(v)].empty() &&
        row_sum[i] > 0 && !boxes()) {
      wrong("node " + std::to_string(v) + " may use no column");
    }
  }

  Q.resize(n, n);
  R = RowMatrix::Zero(n, columns_);
  const std::int32_t* outer = problem.Q.outerIndexPtr();
  const std::int32_t* inner = problem.Q.innerIndexPtr();
  const double* value = problem.Q.valuePtr();
  std::int32_t* start = Q.outerIndexPtr();
  start[0] = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int v = node[static_cast<std::size_t>(i)];
    std::int32_t count = 0;
    for (auto p = outer[v]; p < outer[v + 1]; ++p) {
      count += position[static_cast<std::size_t>(inner[p])] >= 0;
    }
    start[i + 1] = start[i] + count;
  }
  Q.resizeNonZeros(start[n]);
  parallel_for(static_cast<std::size_t>(n), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    const int v = node[row];
    std::int32_t at = start[i];
    for (auto p = outer[v]; p < outer[v + 1]; ++p) {
      const int other = position[static_cast<std::size_t>(inner[p])];
      if (other >= 0) {
        Q.innerIndexPtr()[at] = other;
        Q.valuePtr()[at++] = value[p];
      } else {
        R.row(i) -= value[p] * fixed.weights.row(-1 - other);
      }
    }
    if (problem.B.size()) R.row(i) -= problem.B.row(v);
  });
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    const int v = fixed.node[k];
    const auto w = fixed.weights.row(static_cast<Eigen::Index>(k));
    for (auto p = outer[v]; p < outer[v + 1]; ++p) {
      const int other = position[static_cast<std::size_t>(inner[p])];
      if (other < 0) constant += 0.5 * value[p] * w.dot(fixed.weights.row(-1 - other));
    }
    if (problem.B.size()) constant += w.dot(problem.B.row(v));
  }
}

void FreeRows::check_components(const SimplexProblem& problem,
                                const std::vector<int>& position) const {
  const std::int32_t* outer = problem.Q.outerIndexPtr();
  const std::int32_t* inner = problem.Q.innerIndexPtr();
  std::vector<char> reached(position.size(), 0);
  std::vector<int> stack(problem.fixed.node);
  for (const int v : stack) reached[static_cast<std::size_t>(v)] = 1;
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    for (auto p = outer[v]; p < outer[v + 1]; ++p) {
      const auto w = static_cast<std::size_t>(inner[p]);
      if (reached[w] || problem.Q.valuePtr()[p] == 0) continue;
      reached[w] = 1;
      stack.push_back(inner[p]);
    }
  }
  const auto lost = std::find(reached.begin(), reached.end(), 0);
  if (lost == reached.end()) return;
  throw SolveError("the component of node " + std::to_string(lost - reached.begin()) +
                       " has no fixed row (" +
                       std::to_string(std::count(reached.begin(), reached.end(), 0)) +
                       " nodes are out of reach of every handle)",
                   kWhere, "leave such components out");
}

void FreeRows::project_row(Eigen::Index i, double* w) const {
  if (problem_.support.empty()) return project_entries(i, w, columns_);
  const auto& columns = support(i);
  std::vector<double> kept;
  kept.reserve(columns.size());
  for (const int j : columns) kept.push_back(w[j]);
  project_entries(i, kept.data(), static_cast<int>(kept.size()));
  std::fill(w, w + columns_, 0.0);
  for (std::size_t t = 0; t < columns.size(); ++t) w[columns[t]] = kept[t];
}

void FreeRows::project(const RowMatrix& S, RowMatrix& Z) const {
  Z.resizeLike(S);
  parallel_for(static_cast<std::size_t>(rows()), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    Z.row(i) = S.row(i);
    project_row(i, Z.row(i).data());
  });
}

void FreeRows::colour() const {
  const auto n = static_cast<std::size_t>(rows());
  std::vector<int> colour(n, -1), taken;
  for (std::size_t i = 0; i < n; ++i) {
    for (auto p = Q.outerIndexPtr()[i]; p < Q.outerIndexPtr()[i + 1]; ++p) {
      const int c = colour[static_cast<std::size_t>(Q.innerIndexPtr()[p])];
      if (c >= 0) taken[static_cast<std::size_t>(c)] = static_cast<int>(i);
    }
    std::size_t free = 0;
    while (free < taken.size() && taken[free] == static_cast<int>(i)) ++free;
    if (free == taken.size()) {
      taken.push_back(-1);
      colours_.emplace_back();
    }
    colour[i] = static_cast<int>(free);
    colours_[free].push_back(static_cast<int>(i));
  }
}

void FreeRows::gauss_seidel(RowMatrix& Z, int sweeps, const Progress& progress) const {
  if (rows() == 0) return;
  if (colours_.empty()) colour();
  const Vector diagonal = Q.diagonal();
  NonZeros entries(Z);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    progress.check();
    for (const std::vector<int>& same : colours_) {
      parallel_blocks(same.size(), 16, [&](std::size_t begin, std::size_t end) {
        std::vector<double> g(static_cast<std::size_t>(columns_));
        for (std::size_t t = begin; t < end; ++t) {
          const Eigen::Index i = same[t];
          if (!(diagonal[i] > 0)) continue;
          gradient_row(Q, R, entries, i, g.data());
          double* w = Z.row(i).data();
          for (int j = 0; j < columns_; ++j) w[j] -= g[static_cast<std::size_t>(j)] / diagonal[i];
          project_row(i, w);
          entries.update(i, w);
        }
      });
    }
  }
}

RowMatrix FreeRows::gradient(const RowMatrix& Z) const {
  RowMatrix G(Z.rows(), Z.cols());
  const NonZeros entries(Z);
  parallel_for(static_cast<std::size_t>(rows()), kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    gradient_row(Q, R, entries, i, G.row(i).data());
  });
  return G;
}

double FreeRows::energy(const RowMatrix& Z, const RowMatrix& G) const {
  return constant +
         0.5 * sum_rows(rows(), [&](Eigen::Index i) { return Z.row(i).dot(G.row(i) - R.row(i)); });
}

double FreeRows::kkt_residual(const RowMatrix& Z, const RowMatrix& G) const {
  const Vector diagonal = Q.diagonal();
  return parallel_reduce(
      static_cast<std::size_t>(rows()), kRowsPerBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        RowMatrix step(1, columns_);
        for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
          if (!(diagonal[i] > 0)) continue;
          step = Z.row(i) - G.row(i) / diagonal[i];
          project_row(i, step.data());
          largest = std::max(largest, (step - Z.row(i)).cwiseAbs().maxCoeff());
        }
        return largest;
      },
      [](double a, double b) { return std::max(a, b); });
}

double FreeRows::lower_bound(const RowMatrix& W, const RowMatrix& L) const {
  return constant + sum_rows(rows(), [&](Eigen::Index i) {
           // The least <L_i, w> over the row's set.
           double least = boxes() ? 0.0 : std::numeric_limits<double>::infinity();
           const auto take = [&](int j) {
             least = boxes() ? least + std::min(0.0, L(i, j)) : std::min(least, L(i, j));
           };
           if (problem_.support.empty()) {
             for (int j = 0; j < columns_; ++j) take(j);
           } else {
             for (const int j : support(i)) take(j);
           }
           const double reach = row_sum[i] > 0 ? row_sum[i] * least : 0.0;
           return reach - 0.5 * W.row(i).dot(L.row(i) + R.row(i));
         });
}

RowMatrix FreeRows::gather(const RowMatrix& W) const {
  RowMatrix result(rows(), columns_);
  for (Eigen::Index i = 0; i < rows(); ++i)
    result.row(i) = W.row(node[static_cast<std::size_t>(i)]);
  return result;
}

RowMatrix FreeRows::scatter(const RowMatrix& Z) const {
  RowMatrix W(problem_.Q.rows(), columns_);
  for (std::size_t k = 0; k < problem_.fixed.node.size(); ++k) {
    W.row(problem_.fixed.node[k]) = problem_.fixed.weights.row(static_cast<Eigen::Index>(k));
  }
  for (Eigen::Index i = 0; i < rows(); ++i) W.row(node[static_cast<std::size_t>(i)]) = Z.row(i);
  return W;
}

}  // namespace skinfield
