#include "operators/element_kernels.h"

#include "base/vector_clones.h"
#include "base/vector_lanes.h"

#include <algorithm>

namespace skinfield {
namespace {

using Four = double __attribute__((vector_size(32)));

/// Where the coefficient (r,c) of a symmetric tensor stands (equation 15: column after column).
template <int D>
constexpr int coefficient(int r, int c) {
  const int low = std::min(r, c), high = std::max(r, c);
  return low * D - low * (low - 1) / 2 + high - low;
}

template <int D, class Lanes>
SKINFIELD_INLINE void load_gradients(Lanes (&g)[D][D], const double* G, std::ptrdiff_t stride) {
  for (int i = 0; i < D; ++i) {
    for (int r = 0; r < D; ++r) load(g[i][r], G + (i * D + r) * stride);
  }
}

/// One element a lane. Pointers are at the first of them.
template <int D, class Lanes>
SKINFIELD_INLINE void values_of(const double* G, const double* volume, std::ptrdiff_t stride,
                                const double* A, double* value) {
  Lanes g[D][D], a[D * (D + 1) / 2], vol, k[D][D];
  load_gradients<D>(g, G, stride);
  for (int c = 0; c < D * (D + 1) / 2; ++c) load(a[c], A + c * stride);
  load(vol, volume);
  for (int j = 0; j < D; ++j) {
    Lanes Ag[D];
    for (int r = 0; r < D; ++r) {
      Ag[r] = a[coefficient<D>(r, 0)] * g[j][0];
      for (int c = 1; c < D; ++c) Ag[r] += a[coefficient<D>(r, c)] * g[j][c];
    }
    for (int i = 0; i <= j; ++i) {
      Lanes sum = g[i][0] * Ag[0];
      for (int r = 1; r < D; ++r) sum += g[i][r] * Ag[r];
      k[i][j] = k[j][i] = vol * sum;
    }
  }
  // Corner 0's gradient is minus the sum of the others'.
  std::ptrdiff_t p = 0;
  for (int j = 0; j < D; ++j) {
    Lanes sum = -k[0][j];
    for (int i = 1; i < D; ++i) sum -= k[i][j];
    store(value + p++ * stride, sum);
  }
  for (int i = 0; i < D; ++i) {
    for (int j = i + 1; j < D; ++j) store(value + p++ * stride, k[i][j]);
  }
}

template <int D, class Lanes>
SKINFIELD_INLINE void derivatives_of(const double* G, const double* volume, std::ptrdiff_t stride,
                                     const double* s, std::ptrdiff_t s_stride, double* result) {
  Lanes g[D][D], vol, with_0[D], d[D * (D + 1) / 2] = {};
  load_gradients<D>(g, G, stride);
  load(vol, volume);
  for (int i = 0; i < D; ++i) load(with_0[i], s + i * s_stride);
  std::ptrdiff_t p = D;
  for (int i = 0; i < D; ++i) {
    for (int j = i; j < D; ++j) {
      // k_0j = -sum_i g_i' A g_j brings the pairs with corner 0 to those among the others.
      Lanes weight = -with_0[i];
      if (i != j) {
        Lanes own;
        load(own, s + p++ * s_stride);
        weight += own - with_0[j];
      }
      weight *= vol;
      for (int r = 0; r < D; ++r) {
        const Lanes wgi = weight * g[i][r], wgj = weight * g[j][r];
        d[coefficient<D>(r, r)] += wgi * g[j][r];
        for (int c = 0; c < r; ++c) d[coefficient<D>(r, c)] += wgi * g[j][c] + wgj * g[i][c];
      }
    }
  }
  for (int c = 0; c < D * (D + 1) / 2; ++c) store(result + c * stride, d[c]);
}

template <int D>
SKINFIELD_INLINE void values_in(const ElementArrays& of, const double* A, double* value,
                                std::ptrdiff_t begin, std::ptrdiff_t end) {
  std::ptrdiff_t e = begin;
  for (; e + 4 <= end; e += 4) {
    values_of<D, Four>(of.G + e, of.volume + e, of.stride, A + e, value + e);
  }
  for (; e < end; ++e) {
    values_of<D, double>(of.G + e, of.volume + e, of.stride, A + e, value + e);
  }
}

template <int D>
SKINFIELD_INLINE void derivatives_in(const ElementArrays& of, const double* s,
                                     std::ptrdiff_t s_stride, double* result, std::ptrdiff_t begin,
                                     std::ptrdiff_t end) {
  std::ptrdiff_t e = begin;
  for (; e + 4 <= end; e += 4) {
    derivatives_of<D, Four>(of.G + e, of.volume + e, of.stride, s + (e - begin), s_stride,
                            result + e);
  }
  for (; e < end; ++e) {
    derivatives_of<D, double>(of.G + e, of.volume + e, of.stride, s + (e - begin), s_stride,
                              result + e);
  }
}

/// sum += (xa - xb) (ya - yb)
SKINFIELD_INLINE void add_product(Four& sum, const double* xa, const double* xb, const double* ya,
                                  const double* yb) {
  Four a, b, c, d;
  load(a, xa);
  load(b, xb);
  load(c, ya);
  load(d, yb);
  sum += (a - b) * (c - d);
}

/// <x_a - x_b, y_a - y_b> of rows of m entries.
SKINFIELD_INLINE double difference_product(const double* xa, const double* xb, const double* ya,
                                           const double* yb, std::ptrdiff_t m) {
  Four sum{}, more{};
  std::ptrdiff_t j = 0;
  for (; j + 8 <= m; j += 8) {
    add_product(sum, xa + j, xb + j, ya + j, yb + j);
    add_product(more, xa + j + 4, xb + j + 4, ya + j + 4, yb + j + 4);
  }
  for (; j + 4 <= m; j += 4) add_product(sum, xa + j, xb + j, ya + j, yb + j);
  sum += more;
  double total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; j < m; ++j) total += (xa[j] - xb[j]) * (ya[j] - yb[j]);
  return total;
}

/// y (chunks of four columns) = sum over the entries of one row of value * X's row.
template <int Chunks>
SKINFIELD_INLINE void row_chunks(const std::int32_t* column, const double* value,
                                 std::ptrdiff_t count, const double* X, std::ptrdiff_t m,
                                 double* y) {
  Four sum[Chunks] = {};
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double* x = X + column[k] * m;
    for (int q = 0; q < Chunks; ++q) {
      Four v;
      load(v, x + 4 * q);
      sum[q] += value[k] * v;
    }
  }
  for (int q = 0; q < Chunks; ++q) store(y + 4 * q, sum[q]);
}

}  // namespace

SKINFIELD_VECTOR_CLONES
void pair_values(int dimension, const ElementArrays& elements, const double* A, double* value,
                 std::ptrdiff_t begin, std::ptrdiff_t end) {
  if (dimension == 3) return values_in<3>(elements, A, value, begin, end);
  values_in<2>(elements, A, value, begin, end);
}

SKINFIELD_VECTOR_CLONES
void pair_derivatives(int dimension, const ElementArrays& elements, const double* s,
                      std::ptrdiff_t s_stride, double* D, std::ptrdiff_t begin,
                      std::ptrdiff_t end) {
  if (dimension == 3) return derivatives_in<3>(elements, s, s_stride, D, begin, end);
  derivatives_in<2>(elements, s, s_stride, D, begin, end);
}

SKINFIELD_VECTOR_CLONES
void difference_products(const std::int32_t* a, const std::int32_t* b, std::ptrdiff_t stride,
                         const double* X, const double* Y, std::ptrdiff_t m, double* s,
                         std::ptrdiff_t begin, std::ptrdiff_t end) {
  for (std::ptrdiff_t t = begin; t < end; ++t) {
    const std::ptrdiff_t ra = a[t * stride] * m, rb = b[t * stride] * m;
    s[t] = -difference_product(X + ra, X + rb, Y + ra, Y + rb, m);
  }
}

SKINFIELD_VECTOR_CLONES
void multiply_rows(const std::int32_t* start, const std::int32_t* column, const double* value,
                   const double* X, std::ptrdiff_t m, double* Y, std::ptrdiff_t begin,
                   std::ptrdiff_t end) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const std::int32_t* at = column + start[i];
    const double* of = value + start[i];
    const std::ptrdiff_t count = start[i + 1] - start[i];
    double* y = Y + i * m;
    std::ptrdiff_t j = 0;
    for (; j + 16 <= m; j += 16) row_chunks<4>(at, of, count, X + j, m, y + j);
    for (; j + 4 <= m; j += 4) row_chunks<1>(at, of, count, X + j, m, y + j);
    for (; j < m; ++j) {
      double sum = 0;
      for (std::ptrdiff_t k = 0; k < count; ++k) sum += of[k] * X[at[k] * m + j];
      y[j] = sum;
    }
  }
}

}  // namespace skinfield
