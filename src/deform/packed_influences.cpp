#include "skinfield/deform/packed_influences.h"

#include "deform/check.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <limits>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace skinfield {
namespace {

/// A transform as four columns of four.
template <class Scalar>
struct alignas(8 * sizeof(Scalar)) Matrix {
  Scalar entry[16];
};

template <class Scalar>
struct Job {
  const Scalar* in;
  Scalar* out;
  const std::array<std::uint16_t, 4>* column;
  const std::array<Scalar, 4>* weight;
  const Matrix<Scalar>* matrix;
};

template <class Scalar>
using BlendBlock = void (*)(const Job<Scalar>&, std::size_t, std::size_t);

template <class Scalar>
void blend_plain(const Job<Scalar>& job, std::size_t begin, std::size_t end) {
  using Lane = Eigen::Array<Scalar, 4, 1>;
  using Column = Eigen::Map<const Lane, Eigen::Aligned>;
  for (std::size_t i = begin; i < end; ++i) {
    const auto& w = job.weight[i];
    const auto& j = job.column[i];
    const Scalar* m[4] = {job.matrix[j[0]].entry, job.matrix[j[1]].entry, job.matrix[j[2]].entry,
                          job.matrix[j[3]].entry};
    const auto blend = [&](int c) -> Lane {
      return (Column(m[0] + 4 * c) * w[0] + Column(m[1] + 4 * c) * w[1]) +
             (Column(m[2] + 4 * c) * w[2] + Column(m[3] + 4 * c) * w[3]);
    };
    const Scalar* x = job.in + 3 * i;
    const Lane y = (blend(0) * x[0] + blend(1) * x[1]) + (blend(2) * x[2] + blend(3));
    // All four lanes at once: the fourth lands on the next vertex, which comes later. The last
    // of a block must not touch its neighbour's memory.
    if (i + 1 < end) {
      Eigen::Map<Lane>(job.out + 3 * i) = y;
    } else {
      Eigen::Map<Eigen::Array<Scalar, 3, 1>>(job.out + 3 * i) = y.template head<3>();
    }
  }
}

#if defined(__x86_64__)
// The same sums in the same order, twice as wide, and without fused multiply-add, whose rounding
// differs: every machine gives the same bytes.
#define SKINFIELD_AVX2 [[gnu::target("avx2,no-fma")]]

SKINFIELD_AVX2 inline __m256 scaled(const float* column, const float* weight) {
  return _mm256_mul_ps(_mm256_load_ps(column), _mm256_broadcast_ss(weight));
}
SKINFIELD_AVX2 inline __m256d scaled(const double* column, const double* weight) {
  return _mm256_mul_pd(_mm256_load_pd(column), _mm256_broadcast_sd(weight));
}
SKINFIELD_AVX2 inline __m128 folded(__m256 v) {
  return _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
}

SKINFIELD_AVX2 void blend_avx2(const Job<float>& job, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    const float* w = job.weight[i].data();
    const auto& j = job.column[i];
    const float* m[4] = {job.matrix[j[0]].entry, job.matrix[j[1]].entry, job.matrix[j[2]].entry,
                         job.matrix[j[3]].entry};
    __m256 pair[2];  // columns 0 and 1, columns 2 and 3
    for (int h = 0; h < 2; ++h) {
      pair[h] =
          _mm256_add_ps(_mm256_add_ps(scaled(m[0] + 8 * h, w), scaled(m[1] + 8 * h, w + 1)),
                        _mm256_add_ps(scaled(m[2] + 8 * h, w + 2), scaled(m[3] + 8 * h, w + 3)));
    }
    const float* x = job.in + 3 * i;
    pair[0] = _mm256_mul_ps(pair[0], _mm256_set_m128(_mm_set1_ps(x[1]), _mm_set1_ps(x[0])));
    pair[1] = _mm256_mul_ps(pair[1], _mm256_set_m128(_mm_set1_ps(1), _mm_set1_ps(x[2])));
    const __m128 y = _mm_add_ps(folded(pair[0]), folded(pair[1]));
    float* out = job.out + 3 * i;
    if (i + 1 < end) {
      _mm_storeu_ps(out, y);
    } else {
      alignas(16) float last[4];
      _mm_store_ps(last, y);
      std::copy(last, last + 3, out);
    }
  }
}

SKINFIELD_AVX2 void blend_avx2(const Job<double>& job, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    const double* w = job.weight[i].data();
    const auto& j = job.column[i];
    const double* m[4] = {job.matrix[j[0]].entry, job.matrix[j[1]].entry, job.matrix[j[2]].entry,
                          job.matrix[j[3]].entry};
    const double* x = job.in + 3 * i;
    __m256d column[4];
    for (int c = 0; c < 4; ++c) {
      column[c] =
          _mm256_add_pd(_mm256_add_pd(scaled(m[0] + 4 * c, w), scaled(m[1] + 4 * c, w + 1)),
                        _mm256_add_pd(scaled(m[2] + 4 * c, w + 2), scaled(m[3] + 4 * c, w + 3)));
      if (c < 3) column[c] = _mm256_mul_pd(column[c], _mm256_broadcast_sd(x + c));
    }
    const __m256d y =
        _mm256_add_pd(_mm256_add_pd(column[0], column[1]), _mm256_add_pd(column[2], column[3]));
    double* out = job.out + 3 * i;
    if (i + 1 < end) {
      _mm256_storeu_pd(out, y);
    } else {
      alignas(32) double last[4];
      _mm256_store_pd(last, y);
      std::copy(last, last + 3, out);
    }
  }
}
#undef SKINFIELD_AVX2
#endif

template <class Scalar>
BlendBlock<Scalar> best_blend() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return blend_avx2;
#endif
  return blend_plain<Scalar>;
}

}  // namespace

template <class Scalar>
PackedInfluences<Scalar> pack_influences(const SkinWeights& weights) {
  if (weights.columns() > std::numeric_limits<std::uint16_t>::max()) {
    throw InputError(std::to_string(weights.columns()) + " columns do not fit 16 bits",
                     "packed influences");
  }
  PackedInfluences<Scalar> packed;
  packed.columns = static_cast<int>(weights.columns());
  const auto n = static_cast<std::size_t>(weights.vertices());
  packed.column.assign(n, {0, 0, 0, 0});
  packed.weight.assign(n, {0, 0, 0, 0});
  parallel_for(n, deform_block, [&](std::size_t i) {
    std::size_t slot = 0;
    for (SparseRows::InnerIterator it(weights.W, static_cast<Eigen::Index>(i)); it; ++it) {
      if (it.value() == 0) continue;
      if (slot == 4) {
        throw InputError("vertex " + std::to_string(i) + " has more than four influences",
                         "packed influences", "prune the weights first");
      }
      packed.column[i][slot] = static_cast<std::uint16_t>(it.col());
      packed.weight[i][slot++] = static_cast<Scalar>(it.value());
    }
    if (slot == 0) {
      packed.column[i][0] = static_cast<std::uint16_t>(packed.columns);
      packed.weight[i][0] = 1;
    }
  });
  return packed;
}

template <class Scalar>
void linear_blend(const PackedPoints<Scalar>& V, const PackedInfluences<Scalar>& influences,
                  std::span<const Transform> columns, PackedPoints<Scalar>& deformed) {
  check_deformation(V.rows(), static_cast<Eigen::Index>(influences.weight.size()),
                    influences.columns, columns);
  if (&V == &deformed) throw InputError("source and target are one matrix", "deform");
  deformed.resize(V.rows(), 3);
  std::vector<Matrix<Scalar>> matrices(columns.size() + 1);
  for (std::size_t j = 0; j <= columns.size(); ++j) {
    const Transform T = j < columns.size() ? columns[j] : Transform(Transform::Identity());
    for (int k = 0; k < 16; ++k) {
      matrices[j].entry[k] = static_cast<Scalar>(T(k % 4, k / 4));
    }
  }
  const Job<Scalar> job{V.data(), deformed.data(), influences.column.data(),
                        influences.weight.data(), matrices.data()};
  const BlendBlock<Scalar> blend = best_blend<Scalar>();
  parallel_blocks(static_cast<std::size_t>(V.rows()), deform_block,
                  [&](std::size_t begin, std::size_t end) { blend(job, begin, end); });
}

template PackedInfluences<float> pack_influences<float>(const SkinWeights&);
template PackedInfluences<double> pack_influences<double>(const SkinWeights&);
template void linear_blend<float>(const PackedPoints<float>&, const PackedInfluences<float>&,
                                  std::span<const Transform>, PackedPoints<float>&);
template void linear_blend<double>(const PackedPoints<double>&, const PackedInfluences<double>&,
                                   std::span<const Transform>, PackedPoints<double>&);

}  // namespace skinfield
