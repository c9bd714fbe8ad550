#include "solve/dense_kernel.h"

#include <cstring>

// The processor's vector width is chosen when the program starts, so that one binary is fast
// everywhere. Sanitizers do not support such functions.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SKINFIELD_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define SKINFIELD_CLONES
#endif

namespace skinfield {
namespace {
using Four = double __attribute__((vector_size(32)));
}  // namespace

SKINFIELD_CLONES
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
