// The inner loops of the anisotropic stiffness, in the processor's own vector width.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skinfield {

/// Arrays with a column a quantity: entry e of column c is at [c * stride + e].
struct ElementArrays {
  const double* G;       ///< d d gradients: corner 1..d, coordinate after coordinate
  const double* volume;  ///< one column
  std::ptrdiff_t stride;
};

/// value column p = vol g_i' A g_j of the pair p = (i,j) of corners, in elements [begin, end);
/// pairs in lexicographic order. A: a column a coefficient. dimension: 2 or 3.
void pair_values(int dimension, const ElementArrays& elements, const double* A, double* value,
                 std::ptrdiff_t begin, std::ptrdiff_t end);
/// The transpose: from s, the sensitivity of each pair, to D, that of each coefficient. s begins at
/// element `begin`, and its columns are s_stride apart.
void pair_derivatives(int dimension, const ElementArrays& elements, const double* s,
                      std::ptrdiff_t s_stride, double* D, std::ptrdiff_t begin, std::ptrdiff_t end);

/// s = -<x_a - x_b, y_a - y_b> of edges [begin, end); rows of X and Y have m entries. The ends of
/// edge t are a[t * stride] and b[t * stride].
void difference_products(const std::int32_t* a, const std::int32_t* b, std::ptrdiff_t stride,
                         const double* X, const double* Y, std::ptrdiff_t m, double* s,
                         std::ptrdiff_t begin, std::ptrdiff_t end);

/// Rows [begin, end) of Y = A X, with A in compressed rows and m columns in X and Y.
void multiply_rows(const std::int32_t* start, const std::int32_t* column, const double* value,
                   const double* X, std::ptrdiff_t m, double* Y, std::ptrdiff_t begin,
                   std::ptrdiff_t end);

}  // namespace skinfield
