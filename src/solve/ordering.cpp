#include "solve/ordering.h"

#include <Eigen/OrderingMethods>

#include <cstdint>

#ifdef SKINFIELD_HAVE_METIS
#include <metis.h>
#endif

namespace skinfield {

std::vector<int> minimum_degree_order(const SparseRows& A) {
  using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>;
  const Eigen::Map<const Columns> view(A.rows(), A.cols(), A.nonZeros(), A.outerIndexPtr(),
                                       A.innerIndexPtr(), A.valuePtr());
  Columns pattern = view;
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, std::int32_t> order;
  Eigen::internal::minimum_degree_ordering(pattern, order);
  return {order.indices().begin(), order.indices().end()};
}

#ifdef SKINFIELD_HAVE_METIS

std::vector<int> nested_dissection_order(const SparseRows& A) {
  auto n = static_cast<idx_t>(A.rows());
  std::vector<idx_t> start{0}, neighbour;
  start.reserve(static_cast<std::size_t>(n) + 1);
  neighbour.reserve(static_cast<std::size_t>(A.nonZeros()));
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    for (SparseRows::InnerIterator it(A, i); it; ++it) {
      if (it.col() != i) neighbour.push_back(static_cast<idx_t>(it.col()));
    }
    start.push_back(static_cast<idx_t>(neighbour.size()));
  }
  std::vector<idx_t> old_of_new(static_cast<std::size_t>(n)), new_of_old(old_of_new.size());
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const int status = METIS_NodeND(&n, start.data(), neighbour.data(), nullptr, options,
                                  old_of_new.data(), new_of_old.data());
  if (status != METIS_OK) return {};
  return {old_of_new.begin(), old_of_new.end()};
}

#else

std::vector<int> nested_dissection_order(const SparseRows& /*A*/) { return {}; }

#endif

}  // namespace skinfield
