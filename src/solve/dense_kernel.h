// The inner loops of the supernodal Cholesky.
#pragma once

#include <cstddef>

namespace skinfield {

/// Right-hand sides come in chunks of eight columns; strips of three chunks fill the registers.
constexpr int kChunk = 8;
constexpr int kStripChunks = 3;
constexpr int kStrip = kChunk * kStripChunks;
constexpr int kKernelRows = 4;

/// acc (4 x kStrip, row-major) = sum over k < K of a_i[k * step] * Y[k][0..kStrip).
void multiply_strip(const double* const a[kKernelRows], std::ptrdiff_t step, std::ptrdiff_t K,
                    const double* Y, double* acc);

/// The leading part of a strip's own triangle, kept for the rows below it.
struct StripFactor {
  double column[kStrip][kStrip];  ///< column[c][t] = L_tc for t > c, else 0
  double inverse[kStrip];         ///< 1 / L_cc
};

/// rows (kStrip x kStrip, row-major; lower triangle of a symmetric matrix) := its Cholesky factor,
/// the first `width` columns. least: what pivots must exceed. Returns the first column that
/// fails, -1 if none does.
int factor_strip(double* rows, int width, const double* least, StripFactor& factor);
/// rows (4 x kStrip, row-major) := (rows - acc) L^-T.
void solve_strip(double* rows, const double* acc, const StripFactor& factor);

/// A supernode of L and the rows of X that belong to it. Value: float or double; sums are double.
template <class Value>
struct Panel {
  const Value* L;  ///< (size, width) row-major, inverses on the diagonal; kKernelRows more follow
  int width, size;
  double* Y;  ///< the supernode's own rows of X
  double* X;
  int stride;       ///< of the rows of X and Y
  double* scratch;  ///< scratch_size(width)
};

constexpr int kSlab = 64;  // rows of a panel that stay in the second cache
inline std::size_t scratch_size(int width) {
  return static_cast<std::size_t>(kKernelRows) *
         static_cast<std::size_t>(width > kSlab ? width : kSlab);
}

/// Y := L11^-1 Y, then X[target[r]] -= L21 Y, for `count` chunks of columns that begin at
/// at[0], at[1], ...
void forward_panel(const Panel<double>& panel, const int* target, const int* at, int count);
void forward_panel(const Panel<float>& panel, const int* target, const int* at, int count);
/// Y := L11^-T (Y - L21' below). below: (size - width, 4 count) those rows of X.
void backward_panel(const Panel<double>& panel, const double* below, const int* at, int count);
void backward_panel(const Panel<float>& panel, const double* below, const int* at, int count);

}  // namespace skinfield
