#include "methods/positive_links.h"

#include <algorithm>
#include <cmath>

namespace skinfield {

SparseRows positive_links(const SparseRows& K) {
  SparseRows L = K;
  double sum = 0;
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    for (SparseRows::InnerIterator it(K, i); it; ++it)
      sum += it.col() != i ? std::abs(it.value()) : 0;
  }
  const auto count = static_cast<double>(std::max<Eigen::Index>(1, K.nonZeros() - K.rows()));
  const double least = 1e-3 * sum / count;
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    double total = 0;
    for (SparseRows::InnerIterator it(L, i); it; ++it) {
      if (it.col() == i) continue;
      it.valueRef() = -std::max(-it.value(), least);
      total -= it.value();
    }
    L.coeffRef(i, i) = total;
  }
  return L;
}

}  // namespace skinfield
