#include "skinfield/deform/packed_influences.h"

#include "deform/check.h"
#include "skinfield/base/parallel.h"

#include <limits>

namespace skinfield {
namespace {

template <class Scalar>
using Lane = Eigen::Array<Scalar, 4, 1>;

/// A transform as four columns of four, each one aligned vector wide.
template <class Scalar>
struct alignas(4 * sizeof(Scalar)) Matrix {
  Scalar entry[16];
  Eigen::Map<const Lane<Scalar>, Eigen::Aligned> column(int c) const {
    return Eigen::Map<const Lane<Scalar>, Eigen::Aligned>(entry + 4 * c);
  }
};

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
  const Scalar* in = V.data();
  Scalar* out = deformed.data();
  parallel_blocks(
      static_cast<std::size_t>(V.rows()), deform_block, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const auto& column = influences.column[i];
          const auto& weight = influences.weight[i];
          const Matrix<Scalar>* m[4] = {&matrices[column[0]], &matrices[column[1]],
                                        &matrices[column[2]], &matrices[column[3]]};
          const auto blend = [&](int c) -> Lane<Scalar> {
            return (m[0]->column(c) * weight[0] + m[1]->column(c) * weight[1]) +
                   (m[2]->column(c) * weight[2] + m[3]->column(c) * weight[3]);
          };
          const Scalar* x = in + 3 * i;
          const Lane<Scalar> y = (blend(0) * x[0] + blend(1) * x[1]) + (blend(2) * x[2] + blend(3));
          // All four lanes at once: the fourth lands on the next vertex, which comes later. The
          // last of a block must not touch its neighbour's memory.
          if (i + 1 < end) {
            Eigen::Map<Lane<Scalar>>(out + 3 * i) = y;
          } else {
            for (int k = 0; k < 3; ++k) out[3 * i + static_cast<std::size_t>(k)] = y[k];
          }
        }
      });
}

template PackedInfluences<float> pack_influences<float>(const SkinWeights&);
template PackedInfluences<double> pack_influences<double>(const SkinWeights&);
template void linear_blend<float>(const PackedPoints<float>&, const PackedInfluences<float>&,
                                  std::span<const Transform>, PackedPoints<float>&);
template void linear_blend<double>(const PackedPoints<double>&, const PackedInfluences<double>&,
                                   std::span<const Transform>, PackedPoints<double>&);

}  // namespace skinfield
