#include "solve/simplex_face.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/solve/sparse_factor.h"

#include <vector>

namespace skinfield {
namespace {

constexpr std::size_t kRowsPerBlock = 256;

/// The free entries of Z: one variable each, but for a row's pivot.
struct Variables {
  std::vector<int> start, column;  ///< of row i: [start[i], start[i+1])
  std::vector<int> pivot;          ///< of row i

  explicit Variables(const RowMatrix& Z) {
    start.push_back(0);
    for (Eigen::Index i = 0; i < Z.rows(); ++i) {
      Eigen::Index largest = 0;
      Z.row(i).maxCoeff(&largest);
      pivot.push_back(static_cast<int>(largest));
      for (int j = 0; j < Z.cols(); ++j) {
        if (Z(i, j) > 0 && j != largest) column.push_back(j);
      }
      start.push_back(static_cast<int>(column.size()));
    }
  }
  int begin(Eigen::Index row) const { return start[static_cast<std::size_t>(row)]; }
  int end(Eigen::Index row) const { return start[static_cast<std::size_t>(row) + 1]; }
  int column_of(int variable) const { return column[static_cast<std::size_t>(variable)]; }
  int pivot_of(Eigen::Index row) const { return pivot[static_cast<std::size_t>(row)]; }

  /// <e_j - e_p, e_l - e_q>: how columns of two rows meet when their pivots p, q give way.
  int meet(Eigen::Index i, int a, Eigen::Index k, int b) const {
    const int j = column_of(a), l = column_of(b), p = pivot_of(i), q = pivot_of(k);
    return (j == l) - (j == q) - (p == l) + (p == q);
  }
};

template <class Visit>
void for_entries(const SparseRows& Q, const Variables& v, Eigen::Index i, int a,
                 const Visit& visit) {
  for (SparseRows::InnerIterator it(Q, i); it; ++it) {
    for (int b = v.begin(it.col()); b < v.end(it.col()); ++b) {
      const int times = v.meet(i, a, it.col(), b);
      if (times != 0) visit(b, times * it.value());
    }
  }
}

/// The energy's Hessian in the variables.
SparseRows reduced(const SparseRows& Q, const Variables& v) {
  const auto n = static_cast<Eigen::Index>(v.column.size());
  SparseRows H(n, n);
  std::int32_t* start = H.outerIndexPtr();
  start[0] = 0;
  const auto rows = static_cast<std::size_t>(Q.rows());
  parallel_for(rows, kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    for (int a = v.begin(i); a < v.end(i); ++a) {
      std::int32_t count = 0;
      for_entries(Q, v, i, a, [&](int, double) { ++count; });
      start[a + 1] = count;
    }
  });
  for (Eigen::Index a = 0; a < n; ++a) start[a + 1] += start[a];
  H.resizeNonZeros(start[n]);
  parallel_for(rows, kRowsPerBlock, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    for (int a = v.begin(i); a < v.end(i); ++a) {
      std::int32_t at = start[a];
      for_entries(Q, v, i, a, [&](int b, double value) {
        H.innerIndexPtr()[at] = b;
        H.valuePtr()[at++] = value;
      });
    }
  });
  return H;
}

}  // namespace

RowMatrix face_step(const FreeRows& free, const RowMatrix& Z, const RowMatrix& G) {
  RowMatrix step = RowMatrix::Zero(Z.rows(), Z.cols());
  const Variables v(Z);
  if (v.column.empty()) return step;
  const SparseRows H = reduced(free.Q, v);
  RowMatrix b(H.rows(), 1);
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    for (int a = v.begin(i); a < v.end(i); ++a) {
      b(a, 0) = G(i, v.pivot_of(i)) - G(i, v.column_of(a));
    }
  }
  SparseFactor factor;
  factor.analyse(H);
  try {
    factor.factor(H);
  } catch (const SolveError&) {
    // Slivers can cost H its last digits; a shorter step is still one that lowers the energy.
    factor.factor(H, 1e-10 * H.diagonal());
  }
  factor.solve(b);
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    for (int a = v.begin(i); a < v.end(i); ++a) {
      step(i, v.column_of(a)) = b(a, 0);
      step(i, v.pivot_of(i)) -= b(a, 0);
    }
  }
  return step;
}

}  // namespace skinfield
