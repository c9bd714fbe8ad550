#include "solve/dense_kernel.h"

#include "base/vector_lanes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace skinfield {
namespace {
using Four = double __attribute__((vector_size(32)));
using Eight = double __attribute__((vector_size(64)));

template <class Vec>
constexpr int kLanes = sizeof(Vec) / sizeof(double);

/// Where vector q of a row begins, of the chunks that begin at at[0], at[1], ...
template <class Vec>
SKINFIELD_INLINE int place(const int* at, int q) {
  constexpr int kPerChunk = kChunk / kLanes<Vec>;
  return at[q / kPerChunk] + q % kPerChunk * kLanes<Vec>;
}

/// y -= x on the chunks.
template <class Vec, int Count>
SKINFIELD_INLINE void subtract(double* y, const int* at, const Vec (&x)[Count]) {
  for (int q = 0; q < Count; ++q) {
    Vec v;
    load(v, y + place<Vec>(at, q));
    v -= x[q];
    store(y + place<Vec>(at, q), v);
  }
}

/// acc[r][q] = sum over k < K of a_r[k * step] * vector q of Y's row k.
template <class Vec, int Count>
SKINFIELD_INLINE void multiply(const double* const a[kKernelRows], std::ptrdiff_t step, int K,
                               const double* Y, std::ptrdiff_t stride, const int* at,
                               Vec (&acc)[kKernelRows][Count]) {
  Vec c[kKernelRows][Count] = {};
  const double* y[Count];
  for (int q = 0; q < Count; ++q) y[q] = Y + place<Vec>(at, q);
  for (std::ptrdiff_t k = 0; k < K; ++k) {
    Vec v[Count];
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
template <class Vec, int Count>
SKINFIELD_INLINE void eliminate(double* y, double l, const double* x, const int* at) {
  Vec v[Count];
  for (int q = 0; q < Count; ++q) {
    load(v[q], x + place<Vec>(at, q));
    v[q] *= l;
  }
  subtract(y, at, v);
}

template <class Vec, int Count>
SKINFIELD_INLINE void scale(double* y, double factor, const int* at) {
  for (int q = 0; q < Count; ++q) {
    Vec v;
    load(v, y + place<Vec>(at, q));
    v *= factor;
    store(y + place<Vec>(at, q), v);
  }
}

/// Calls body<vectors>(first chunk) for strips of as many chunks as the registers hold the sums of:
/// three of wide vectors (four chunks go as two and two), one of narrow ones.
template <class Vec, class Body>
SKINFIELD_INLINE void for_strips(int count, const Body& body) {
  constexpr int kPerChunk = kChunk / kLanes<Vec>;
  if constexpr (kPerChunk > 1) {
    for (int q = 0; q < count; ++q) body(std::integral_constant<int, kPerChunk>(), q);
  } else {
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
}

/// Asks for `count` values of a panel before they are needed: they come from main memory, and the
/// processor guesses poorly where the next row lies. May ask for what is beyond the last panel.
template <class Value>
SKINFIELD_INLINE void prefetch(const Value* values, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kLine = 64 / sizeof(Value);
  for (std::ptrdiff_t k = 0; k < count; k += kLine) __builtin_prefetch(values + k);
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

template <class Vec, class Value>
SKINFIELD_INLINE void forward(const Panel<Value>& p, const int* target, const int* at, int count) {
  const int w = p.width;
  const std::ptrdiff_t stride = p.stride;
  const double* a[kKernelRows];
  for (int i = 0; i < w; i += kKernelRows) {
    const int rows = std::min(kKernelRows, w - i);
    unpack_rows(p, i, rows, i + rows, a);
    for_strips<Vec>(
        count, [&]<int Count>(std::integral_constant<int, Count>, int first)
                   __attribute__((always_inline)) {
                     const int* chunks = at + first;
                     Vec acc[kKernelRows][Count];
                     multiply<Vec, Count>(a, 1, i, p.Y, stride, chunks, acc);
                     for (int r = 0; r < rows; ++r) {
                       double* y = p.Y + (i + r) * stride;
                       subtract(y, chunks, acc[r]);
                       for (int t = i; t < i + r; ++t) {
                         eliminate<Vec, Count>(y, a[r][t], p.Y + t * stride, chunks);
                       }
                       scale<Vec, Count>(y, a[r][i + r], chunks);
                     }
                   });
  }
  const std::ptrdiff_t block = static_cast<std::ptrdiff_t>(kKernelRows) * w;
  for (int i = w; i < p.size; i += kKernelRows) {
    const int rows = std::min(kKernelRows, p.size - i);
    prefetch(p.L + static_cast<std::ptrdiff_t>(i) * w + block, block);
    unpack_rows(p, i, rows, w, a);
    for_strips<Vec>(
        count, [&]<int Count>(std::integral_constant<int, Count>, int first)
                   __attribute__((always_inline)) {
                     const int* chunks = at + first;
                     Vec acc[kKernelRows][Count];
                     multiply<Vec, Count>(a, 1, w, p.Y, stride, chunks, acc);
                     for (int r = 0; r < rows; ++r) {
                       subtract(p.X + target[i + r - w] * stride, chunks, acc[r]);
                     }
                   });
  }
}

template <class Vec, class Value>
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
      constexpr std::ptrdiff_t kShare = static_cast<std::ptrdiff_t>(kSlab) * kKernelRows;
      prefetch(p.L + static_cast<std::ptrdiff_t>(to) * w + j / kKernelRows * kShare, kShare);
      unpack_columns(p, j, from, to, a);
      for_strips<Vec>(
          count, [&]<int Count>(std::integral_constant<int, Count>,
                                int first) __attribute__((always_inline)) {
            Vec acc[kKernelRows][Count];
            multiply<Vec, Count>(a, kKernelRows, to - from,
                                 below + (from - w) * step + first * kChunk, step, kPacked, acc);
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
    for_strips<Vec>(
        count, [&]<int Count>(std::integral_constant<int, Count>,
                              int first) __attribute__((always_inline)) {
          const int* chunks = at + first;
          Vec acc[kKernelRows][Count];
          multiply<Vec, Count>(a, kKernelRows, w - end, p.Y + end * stride, stride, chunks, acc);
          for (int r = columns - 1; r >= 0; --r) {
            double* y = p.Y + (j + r) * stride;
            subtract(y, chunks, acc[r]);
            for (int t = r + 1; t < columns; ++t) {
              eliminate<Vec, Count>(y, triangle[t * kKernelRows + r], p.Y + (j + t) * stride,
                                    chunks);
            }
            scale<Vec, Count>(y, triangle[r * kKernelRows + r], chunks);
          }
        });
    end = j;
  }
}
template <class Vec>
SKINFIELD_INLINE int factor_triangle(double* rows, int width, const double* least,
                                     StripFactor& factor) {
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
    const int first = c / kLanes<Vec> * kLanes<Vec>;  // the columns before it are done
    for (int r = c + 1; r < width; ++r) {
      const double l = rows[r * kStrip + c];
      for (int q = first; q <= r; q += kLanes<Vec>) {
        Vec y, x;
        load(y, rows + r * kStrip + q);
        load(x, factor.column[c] + q);
        y -= l * x;
        store(rows + r * kStrip + q, y);
      }
    }
  }
  return -1;
}

template <class Vec>
SKINFIELD_INLINE void solve_rows(double* rows, const double* acc, const StripFactor& factor) {
  constexpr int kVectors = kStrip / kLanes<Vec>;
  for (int i = 0; i < kKernelRows * kStrip; i += kLanes<Vec>) {
    Vec y, x;
    load(y, rows + i);
    load(x, acc + i);
    y -= x;
    store(rows + i, y);
  }
  for (int c = 0; c < kStrip; ++c) {
    Vec l[kVectors];
    const int first = c / kLanes<Vec>;
    for (int q = first; q < kVectors; ++q) load(l[q], factor.column[c] + q * kLanes<Vec>);
    for (int r = 0; r < kKernelRows; ++r) {
      double* y = rows + r * kStrip;
      const double x = y[c] * factor.inverse[c];
      for (int q = first; q < kVectors; ++q) {
        Vec v;
        load(v, y + q * kLanes<Vec>);
        v -= x * l[q];
        store(y + q * kLanes<Vec>, v);
      }
      y[c] = x;
    }
  }
}

/// Columns [first, first + 3 lanes) of multiply_strip's result.
template <class Vec>
SKINFIELD_INLINE void multiply_columns(const double* const a[kKernelRows], std::ptrdiff_t step,
                                       std::ptrdiff_t K, const double* Y, double* acc) {
  Vec c00{}, c01{}, c02{}, c10{}, c11{}, c12{}, c20{}, c21{}, c22{}, c30{}, c31{}, c32{};
  static_assert(kKernelRows == 4);
  const double *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  for (std::ptrdiff_t k = 0; k < K; ++k) {
    Vec y0, y1, y2;
    load(y0, Y);
    load(y1, Y + kLanes<Vec>);
    load(y2, Y + 2 * kLanes<Vec>);
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
  const Vec all[kKernelRows][3] = {
      {c00, c01, c02}, {c10, c11, c12}, {c20, c21, c22}, {c30, c31, c32}};
  for (int r = 0; r < kKernelRows; ++r) std::memcpy(acc + r * kStrip, all[r], sizeof all[r]);
}

template <class Vec>
SKINFIELD_INLINE void multiply_all(const double* const a[kKernelRows], std::ptrdiff_t step,
                                   std::ptrdiff_t K, const double* Y, double* acc) {
  for (int first = 0; first < kStrip; first += 3 * kLanes<Vec>) {
    multiply_columns<Vec>(a, step, K, Y + first, acc + first);
  }
}

// Every kernel is compiled for vectors of 512, 256 and 128 bits; the processor's are chosen when
// the program starts. Not target_clones: wide vectors want other tiles than narrow ones.
#if defined(__x86_64__)
#define SKINFIELD_WIDE __attribute__((target("avx512f,avx512vl,avx512dq,avx2,fma")))
#define SKINFIELD_NARROW __attribute__((target("avx2,fma")))
#else
#define SKINFIELD_WIDE
#define SKINFIELD_NARROW
#endif

enum class Width { plain, narrow, wide };

Width processor_width() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    return Width::wide;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Width::narrow;
#endif
  return Width::plain;
}

const Width kWidth = processor_width();

// body<Vec> for each width, and the function that chooses. `parameters` and `arguments` are lists
// that bring their own parentheses.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define SKINFIELD_KERNEL(result, name, body, parameters, arguments)                 \
  namespace {                                                                       \
  SKINFIELD_WIDE result name##_wide parameters { return body<Eight> arguments; }    \
  SKINFIELD_NARROW result name##_narrow parameters { return body<Four> arguments; } \
  result name##_plain parameters { return body<Four> arguments; }                   \
  }                                                                                 \
  result name parameters {                                                          \
    return kWidth == Width::wide     ? name##_wide arguments                        \
           : kWidth == Width::narrow ? name##_narrow arguments                      \
                                     : name##_plain arguments;                      \
  }
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace

SKINFIELD_KERNEL(void, forward_panel, forward,
                 (const Panel<double>& panel, const int* target, const int* at, int count),
                 (panel, target, at, count))
SKINFIELD_KERNEL(void, forward_panel, forward,
                 (const Panel<float>& panel, const int* target, const int* at, int count),
                 (panel, target, at, count))
SKINFIELD_KERNEL(void, backward_panel, backward,
                 (const Panel<double>& panel, const double* below, const int* at, int count),
                 (panel, below, at, count))
SKINFIELD_KERNEL(void, backward_panel, backward,
                 (const Panel<float>& panel, const double* below, const int* at, int count),
                 (panel, below, at, count))
SKINFIELD_KERNEL(int, factor_strip, factor_triangle,
                 (double* rows, int width, const double* least, StripFactor& factor),
                 (rows, width, least, factor))
SKINFIELD_KERNEL(void, solve_strip, solve_rows,
                 (double* rows, const double* acc, const StripFactor& factor), (rows, acc, factor))
SKINFIELD_KERNEL(void, multiply_strip, multiply_all,
                 (const double* const a[kKernelRows], std::ptrdiff_t step, std::ptrdiff_t K,
                  const double* Y, double* acc),
                 (a, step, K, Y, acc))

}  // namespace skinfield
