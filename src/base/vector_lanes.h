// Loads and stores of the compiler's vectors, for kernels that are inlined into functions of
// several vector widths.
#pragma once

#include <cstring>

#define SKINFIELD_INLINE inline __attribute__((always_inline))

namespace skinfield {

// By reference: passing such vectors by value has no stable ABI without AVX.
template <class Lanes>
SKINFIELD_INLINE void load(Lanes& v, const double* from) {
  std::memcpy(&v, from, sizeof v);
}
template <class Lanes>
SKINFIELD_INLINE void store(double* to, const Lanes& v) {
  std::memcpy(to, &v, sizeof v);
}

}  // namespace skinfield
