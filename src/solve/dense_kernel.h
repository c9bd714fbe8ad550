// The one inner loop of the supernodal Cholesky.
#pragma once

#include <cstddef>

namespace skinfield {

/// Right-hand sides and columns are handled in strips of this width.
constexpr int kStrip = 12;
constexpr int kKernelRows = 4;

/// acc (4 x 12, row-major) = sum over k < K of a_i[k * step] * Y[k][0..12).
void multiply_strip(const double* const a[kKernelRows], std::ptrdiff_t step, std::ptrdiff_t K,
                    const double* Y, double* acc);

}  // namespace skinfield
