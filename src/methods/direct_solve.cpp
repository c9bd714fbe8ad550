#include "methods/direct_solve.h"

#include "methods/reached.h"
#include "skinfield/base/parallel.h"
#include "skinfield/solve/sparse_factor.h"

#include <cmath>

namespace skinfield {
namespace {

constexpr int kMostRefinements = 8;
constexpr double kAccurate = 1e-12;  // a correction below this changes nothing
constexpr double kTolerated = 1e-6;  // above it the system was too ill-conditioned to solve
constexpr double kStalled = 0.5;     // a correction must shrink by this to be worth another

/// R = B - A X on the free rows.
void residual(const SparseRows& A, const RowMatrix& B, const RowMatrix& X, const NodeSubset& free,
              RowMatrix& R) {
  parallel_for(free.node.size(), 256, [&](std::size_t k) {
    const int i = free.node[k];
    auto row = R.row(static_cast<Eigen::Index>(k));
    if (B.size() > 0)
      row = B.row(i);
    else
      row.setZero();
    for (SparseRows::InnerIterator it(A, i); it; ++it) row -= it.value() * X.row(it.col());
  });
}

}  // namespace

DirectSolution solve_with_fixed_rows(const SparseRows& A, const RowMatrix& B,
                                     const FixedRows& fixed, const Progress& progress) {
  const NodeSubset free = free_nodes(A.rows(), fixed.node);
  DirectSolution solution;
  RowMatrix& X = solution.X;
  SolveStats& stats = solution.stats;
  X = RowMatrix::Zero(A.rows(), B.size() > 0 ? B.cols() : fixed.weights.cols());
  for (std::size_t k = 0; k < fixed.node.size(); ++k) {
    X.row(fixed.node[k]) = fixed.weights.row(static_cast<Eigen::Index>(k));
  }
  if (free.node.empty() || X.cols() == 0) return solution;
  progress.check();
  const SparseRows A_ff = restrict_to(A, free);
  SparseFactor factor;
  factor.analyse(A_ff);
  factor.factor(A_ff);
  progress("solve", 0.5);
  RowMatrix R(static_cast<Eigen::Index>(free.node.size()), X.cols());
  double before = 1e300;
  for (int step = 0; step <= kMostRefinements; ++step) {
    progress.check();
    residual(A, B, X, free, R);
    factor.solve(R);
    const double change = R.cwiseAbs().maxCoeff();
    // The first step is the solution; later ones correct its rounding, while that helps.
    if (step > 1 && !(change < kStalled * before)) break;
    for (std::size_t k = 0; k < free.node.size(); ++k) {
      X.row(free.node[k]) += R.row(static_cast<Eigen::Index>(k));
    }
    stats.iterations = step;
    stats.largest_change = change;
    if (step > 0 && change <= kAccurate) break;
    before = change;
  }
  residual(A, B, X, free, R);
  const Vector diagonal = A_ff.diagonal();
  for (Eigen::Index k = 0; k < R.rows(); ++k) {
    stats.kkt_residual = std::max(stats.kkt_residual, R.row(k).cwiseAbs().maxCoeff() / diagonal[k]);
  }
  if (!(stats.largest_change <= kTolerated)) stats.status = SolveStats::Status::limit;
  return solution;
}

}  // namespace skinfield
