#include "solve/dense_kernel.h"

#include "base/vector_clones.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace skinfield {
namespace {
using Four = double __attribute__((vector_size(32)));

#define SKINFIELD_INLINE inline __attribute__((always_inline))

// By reference: passing such vectors by value has no stable ABI without AVX.
SKINFIELD_INLINE void load(Four& v, const double* from) { std::memcpy(&v, from, sizeof v); }
SKINFIELD_INLINE void store(double* to, const Four& v) { std::memcpy(to, &v, sizeof v); }

/// y -= x on the chunks.
template <int Count>
SKINFIELD_INLINE void subtract(double* y, const int* at, const Four (&x)[Count]) {
  for (int q = 0; q < Count; ++q) {
    Four v;
    load(v, y + at[q]);
    v -= x[q];
    store(y + at[q], v);
  }
}

/// acc[r][q] = sum over k < K of a_r[k * step] * the chunk of Y's row k at at[q].
template <int Count>
SKINFIELD_INLINE void multiply(const double* const a[kKernelRows], std::ptrdiff_t step, int K,
                               const double* Y, std::ptrdiff_t stride, const int* at,
                               Four (&acc)[kKernelRows][Count]) {
  Four c[kKernelRows][Count] = {};
  const double* y[Count];
  for (int q = 0; q < Count; ++q) y[q] = Y + at[q];
  for (std::ptrdiff_t k = 0; k < K; ++k) {
    Four v[Count];
    for (int q = 0; q < Count; ++q) load(v[q], y[q] + k * stride);
    for (int r = 0; r < kKernelRows; ++r) {
      const double x = a[r][k * step];
      for (int q = 0; q < Count; ++q) c[r][q] += x * v[q];
    }
  }
  for (int r = 0; r < kKernelRows; ++r) {
    for (int q = 0; q < Count; ++q) acc[r][q] = c[r][q];
  }
}

/// y -= l x on the chunks.
template <int Count>
SKINFIELD_INLINE void eliminate(double* y, double l, const double* x, const int* at) {
  Four v[Count];
  for (int q = 0; q < Count; ++q) {
    load(v[q], x + at[q]);
    v[q] *= l;
  }
  subtract(y, at, v);
}

template <int Count>
SKINFIELD_INLINE void scale(double* y, double factor, const int* at) {
  for (int q = 0; q < Count; ++q) {
    Four v;
    load(v, y + at[q]);
    v *= factor;
    store(y + at[q], v);
  }
}

/// Calls body<Count>(at) for strips of up to three chunks; four go as two and two.
template <class Body>
SKINFIELD_INLINE void for_strips(int count, const Body& body) {
  for (int first = 0; first < count;) {
    const int left = count - first;
    if (left == 1) {
      body(std::integral_constant<int, 1>(), first);
      first += 1;
    } else if (left == 2 || left == 4) {
      body(std::integral_constant<int, 2>(), first);
      first += 2;
    } else {
      body(std::integral_constant<int, 3>(), first);
      first += 3;
    }
  }
}

/// Rows i .. i+rows of L, the first `depth` columns, in double precision.
template <class Value>
SKINFIELD_INLINE void unpack_rows(const Panel<Value>& p, int i, int rows, int depth,
                                  const double* (&a)[kKernelRows]) {
  for (int r = 0; r < kKernelRows; ++r) {
    double* to = p.scratch + static_cast<std::ptrdiff_t>(r) * p.width;
    a[r] = r < rows ? to : a[rows - 1];
    if (r >= rows) continue;
    const Value* from = p.L + static_cast<std::ptrdiff_t>(i + r) * p.width;
    for (int k = 0; k < depth; ++k) to[k] = static_cast<double>(from[k]);
  }
}

/// Columns j .. j+4 of rows [from, to), one row after the other.
template <class Value>
SKINFIELD_INLINE void unpack_columns(const Panel<Value>& p, int j, int from, int to,
                                     const double* (&a)[kKernelRows]) {
  const Value* row = p.L + static_cast<std::ptrdiff_t>(from) * p.width + j;
  double* out = p.scratch;
  for (int k = from; k < to; ++k, row += p.width, out += kKernelRows) {
    for (int r = 0; r < kKernelRows; ++r) out[r] = static_cast<double>(row[r]);
  }
  for (int r = 0; r < kKernelRows; ++r) a[r] = p.scratch + r;
}

template <class Value>
SKINFIELD_INLINE void forward(const Panel<Value>& p, const int* target, const int* at, int count) {
  const int w = p.width;
  const std::ptrdiff_t stride = p.stride;
  const double* a[kKernelRows];
  for (int i = 0; i < w; i += kKernelRows) {
    const int rows = std::min(kKernelRows, w - i);
    unpack_rows(p, i, rows, i + rows, a);
    for_strips(
        count, [&]<int Count>(std::integral_constant<int, Count>, int first)
                   __attribute__((always_inline)) {
                     const int* chunks = at + first;
                     Four acc[kKernelRows][Count];
                     multiply<Count>(a, 1, i, p.Y, stride, chunks, acc);
                     for (int r = 0; r < rows; ++r) {
                       double* y = p.Y + (i + r) * stride;
                       subtract(y, chunks, acc[r]);
                       for (int t = i; t < i + r; ++t) {
                         eliminate<Count>(y, a[r][t], p.Y + t * stride, chunks);
                       }
                       scale<Count>(y, a[r][i + r], chunks);
                     }
                   });
  }
  for (int i = w; i < p.size; i += kKernelRows) {
    const int rows = std::min(kKernelRows, p.size - i);
    unpack_rows(p, i, rows, w, a);
    for_strips(
        count, [&]<int Count>(std::integral_constant<int, Count>, int first)
                   __attribute__((always_inline)) {
                     const int* chunks = at + first;
                     Four acc[kKernelRows][Count];
                     multiply<Count>(a, 1, w, p.Y, stride, chunks, acc);
                     for (int r = 0; r < rows; ++r) {
                       subtract(p.X + target[i + r - w] * stride, chunks, acc[r]);
                     }
                   });
  }
}

template <class Value>
SKINFIELD_INLINE void backward(const Panel<Value>& p, const double* below, const int* at,
                               int count) {
  const int w = p.width;
  const std::ptrdiff_t stride = p.stride, step = static_cast<std::ptrdiff_t>(count) * kChunk;
  constexpr int kPacked[kStripChunks] = {0, kChunk, 2 * kChunk};
  const double* a[kKernelRows];
  // A slab of rows stays in the cache while all columns pass over it.
  for (int from = w; from < p.size; from += kSlab) {
    const int to = std::min(from + kSlab, p.size);
    for (int j = 0; j < w; j += kKernelRows) {
      const int columns = std::min(kKernelRows, w - j);
      unpack_columns(p, j, from, to, a);
      for_strips(
          count, [&]<int Count>(std::integral_constant<int, Count>,
                                int first) __attribute__((always_inline)) {
            Four acc[kKernelRows][Count];
            multiply<Count>(a, kKernelRows, to - from, below + (from - w) * step + first * kChunk,
                            step, kPacked, acc);
            for (int r = 0; r < columns; ++r) {
              subtract(p.Y + (j + r) * stride, at + first, acc[r]);
            }
          });
    }
  }
  for (int end = w; end > 0;) {
    const int j = (end - 1) / kKernelRows * kKernelRows, columns = end - j;
    unpack_columns(p, j, j, w, a);
    const double* triangle = p.scratch;
    for (const double*& column : a) column += static_cast<std::ptrdiff_t>(columns) * kKernelRows;
    for_strips(
        count, [&]<int Count>(std::integral_constant<int, Count>,
                              int first) __attribute__((always_inline)) {
          const int* chunks = at + first;
          Four acc[kKernelRows][Count];
          multiply<Count>(a, kKernelRows, w - end, p.Y + end * stride, stride, chunks, acc);
          for (int r = columns - 1; r >= 0; --r) {
            double* y = p.Y + (j + r) * stride;
            subtract(y, chunks, acc[r]);
            for (int t = r + 1; t < columns; ++t) {
              eliminate<Count>(y, triangle[t * kKernelRows + r], p.Y + (j + t) * stride, chunks);
            }
            scale<Count>(y, triangle[r * kKernelRows + r], chunks);
          }
        });
    end = j;
  }
}
}  // namespace

SKINFIELD_VECTOR_CLONES
void forward_panel(const Panel<double>& panel, const int* target, const int* at, int count) {
  forward(panel, target, at, count);
}

SKINFIELD_VECTOR_CLONES
void forward_panel(const Panel<float>& panel, const int* target, const int* at, int count) {
  forward(panel, target, at, count);
}

SKINFIELD_VECTOR_CLONES
void backward_panel(const Panel<double>& panel, const double* below, const int* at, int count) {
  backward(panel, below, at, count);
}

SKINFIELD_VECTOR_CLONES
void backward_panel(const Panel<float>& panel, const double* below, const int* at, int count) {
  backward(panel, below, at, count);
}

SKINFIELD_VECTOR_CLONES
int factor_strip(double* rows, int width, const double* least, StripFactor& factor) {
  for (int c = 0; c < kStrip; ++c) {
    std::fill_n(factor.column[c], kStrip, 0.0);
    factor.inverse[c] = 1;
    if (c >= width) continue;
    double& pivot = rows[c * kStrip + c];
    if (!(pivot > least[c])) return c;
    pivot = std::sqrt(pivot);
    const double inverse = 1 / pivot;
    factor.inverse[c] = inverse;
    for (int t = c + 1; t < width; ++t) {
      factor.column[c][t] = rows[t * kStrip + c] *= inverse;
    }
    for (int r = c + 1; r < width; ++r) {
      const double l = rows[r * kStrip + c];
      for (int q = 0; q < kStrip; q += kChunk) {
        Four y, x;
        load(y, rows + r * kStrip + q);
        load(x, factor.column[c] + q);
        y -= l * x;
        store(rows + r * kStrip + q, y);
      }
    }
  }
  return -1;
}

SKINFIELD_VECTOR_CLONES
void solve_strip(double* rows, const double* acc, const StripFactor& factor) {
  for (int i = 0; i < kKernelRows * kStrip; i += kChunk) {
    Four y, x;
    load(y, rows + i);
    load(x, acc + i);
    y -= x;
    store(rows + i, y);
  }
  for (int c = 0; c < kStrip; ++c) {
    Four l[kStripChunks];
    const int first = c / kChunk;
    for (int q = first; q < kStripChunks; ++q) load(l[q], factor.column[c] + q * kChunk);
    for (int r = 0; r < kKernelRows; ++r) {
      double* y = rows + r * kStrip;
      const double x = y[c] * factor.inverse[c];
      for (int q = first; q < kStripChunks; ++q) {
        Four v;
        load(v, y + q * kChunk);
        v -= x * l[q];
        store(y + q * kChunk, v);
      }
      y[c] = x;
    }
  }
}

SKINFIELD_VECTOR_CLONES
void multiply_strip(const double* const a[kKernelRows], std::ptrdiff_t step, std::ptrdiff_t K,
                    const double* Y, double* acc) {
  static_assert(kStrip == 12 && kKernelRows == 4);
  Four c00{}, c01{}, c02{}, c10{}, c11{}, c12{}, c20{}, c21{}, c22{}, c30{}, c31{}, c32{};
  const double *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  for (std::ptrdiff_t k = 0; k < K; ++k) {
    Four y0, y1, y2;
    std::memcpy(&y0, Y, sizeof y0);
    std::memcpy(&y1, Y + 4, sizeof y1);
    std::memcpy(&y2, Y + 8, sizeof y2);
    Y += kStrip;
    const double x0 = a0[k * step], x1 = a1[k * step], x2 = a2[k * step], x3 = a3[k * step];
    c00 += x0 * y0;
    c01 += x0 * y1;
    c02 += x0 * y2;
    c10 += x1 * y0;
    c11 += x1 * y1;
    c12 += x1 * y2;
    c20 += x2 * y0;
    c21 += x2 * y1;
    c22 += x2 * y2;
    c30 += x3 * y0;
    c31 += x3 * y1;
    c32 += x3 * y2;
  }
  const Four all[12] = {c00, c01, c02, c10, c11, c12, c20, c21, c22, c30, c31, c32};
  std::memcpy(acc, all, sizeof all);
}

}  // namespace skinfield
