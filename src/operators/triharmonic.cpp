#include "skinfield/operators/triharmonic.h"

#include "skinfield/operators/biharmonic.h"

namespace skinfield {

SparseRows triharmonic(const SparseRows& K, const Vector& M) {
  // (K M^-1) Q and its transpose round differently: their mean is symmetric.
  const SparseRows one_way = SparseRows(K * M.cwiseInverse().asDiagonal()) * biharmonic(K, M);
  const SparseRows other_way = one_way.transpose();
  SparseRows mean = 0.5 * (one_way + other_way);
  mean.makeCompressed();
  return mean;
}

}  // namespace skinfield
