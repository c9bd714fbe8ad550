#include "methods/tile_kernel.h"

#include "base/vector_clones.h"

#include <cstddef>
#include <cstring>

namespace skinfield {
namespace {

using Eight = float __attribute__((vector_size(32)));
constexpr int kHalf = kTileRows / 2;  // so many sums fit the registers

}  // namespace

SKINFIELD_VECTOR_CLONES
void tile_forward(const float* R, int n, const float* F, float* residual) {
  for (int half = 0; half < 2; ++half) {
    Eight sum[kHalf];
    std::memcpy(sum, residual + half * kHalf * kLanes, sizeof sum);
    const float* r = R + half * kHalf;
    for (int k = 0; k < n; ++k, r += kTileRows) {
      Eight f;
      std::memcpy(&f, F + static_cast<std::ptrdiff_t>(k) * kLanes, sizeof f);
      for (int i = 0; i < kHalf; ++i) sum[i] += r[i] * f;
    }
    std::memcpy(residual + half * kHalf * kLanes, sum, sizeof sum);
  }
}

SKINFIELD_VECTOR_CLONES
void tile_backward(const float* R, int n, const float* residual, float* G) {
  Eight res[kTileRows];
  std::memcpy(res, residual, sizeof res);
  for (int k = 0; k < n; ++k) {
    const float* r = R + static_cast<std::ptrdiff_t>(k) * kTileRows;
    Eight sum[4] = {};
    for (int i = 0; i < kTileRows; i += 4)
      for (int q = 0; q < 4; ++q) sum[q] += r[i + q] * res[i + q];
    const Eight all = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    std::memcpy(G + static_cast<std::ptrdiff_t>(k) * kLanes, &all, sizeof all);
  }
}

SKINFIELD_VECTOR_CLONES
void add_scaled(float* y, const float* x, float a, int n) {
  for (int i = 0; i < n; ++i) y[i] += a * x[i];
}

}  // namespace skinfield
