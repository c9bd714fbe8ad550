// Linear blend skinning at the speed of memory: four influences a vertex in packed arrays.
#pragma once

#include "skinfield/rig/skeleton.h"
#include "skinfield/weights/skin_weights.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace skinfield {

template <class Scalar>
using PackedPoints = Eigen::Matrix<Scalar, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Scalar: float or double. Unused slots have weight 0; a vertex without weights has weight 1 on
/// slot `columns`, which stands for "stays".
template <class Scalar>
struct PackedInfluences {
  std::vector<std::array<std::uint16_t, 4>> column;  ///< (n)
  std::vector<std::array<Scalar, 4>> weight;         ///< (n)
  int columns = 0;

  /// Bytes that a deformation reads and writes a vertex: position in and out, weights, columns.
  static constexpr std::size_t bytes_per_vertex() {
    return 10 * sizeof(Scalar) + 4 * sizeof(std::uint16_t);
  }
};

/// Throws InputError if a row has more than four non-zero entries (prune first) or there are more
/// than 65535 columns.
template <class Scalar>
PackedInfluences<Scalar> pack_influences(const SkinWeights& weights);

/// `deformed` gets the size of V. V and deformed must not be the same matrix.
/// Throws InputError if V, influences and columns do not belong together.
template <class Scalar>
void linear_blend(const PackedPoints<Scalar>& V, const PackedInfluences<Scalar>& influences,
                  std::span<const Transform> columns, PackedPoints<Scalar>& deformed);

}  // namespace skinfield
