// Counter-based random numbers: Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy
// as 1, 2, 3", SC 2011). The value depends only on (seed, stream, position), so that parallel
// loops give the same numbers at any thread count: give every item its own stream.
#pragma once

#include "skinfield/base/types.h"

#include <array>
#include <cstdint>

namespace skinfield {

/// The Philox4x32-10 block function: 128 random bits for a counter under a key.
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key);

class Random {
 public:
  /// @param seed the user's seed. @param stream one per item and purpose, e.g. a node's index.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint32_t bits();
  /// Uniform in [0,1) with 53 bits.
  double uniform();
  /// Uniform integer in [0,n), n > 0.
  std::uint32_t below(std::uint32_t n);
  /// Standard normal (Box-Muller).
  double normal();
  /// Uniform on the unit sphere, or on the unit circle in the plane z = 0.
  Vec3 direction(int dimension = 3);

 private:
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;
};

}  // namespace skinfield
