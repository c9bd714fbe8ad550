#include "solve/ordering.h"

#include "solve/supernodes.h"
#include "support/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace skinfield {
namespace {

std::vector<int> as_given(const SparseRows& A) {
  std::vector<int> order(static_cast<std::size_t>(A.rows()));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

void expect_good_order(const SparseRows& A, const std::vector<int>& order) {
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, as_given(A));
  EXPECT_LT(analyse_supernodes(A, order).values, analyse_supernodes(A, as_given(A)).values);
}

TEST(Ordering, OfMinimumDegreePermutesWithLessFill) {
  const SparseRows Q = skinfield_test::grid_program(11, 3).Q;
  expect_good_order(Q, minimum_degree_order(Q));
}

TEST(Ordering, OfNestedDissectionPermutesWithLessFill) {
  const SparseRows Q = skinfield_test::grid_program(11, 3).Q;
  const std::vector<int> order = nested_dissection_order(Q);
  if (order.empty()) GTEST_SKIP() << "this build has no METIS";
  expect_good_order(Q, order);
  EXPECT_EQ(order, nested_dissection_order(Q));
}

TEST(Ordering, OfWhatHasNoLinks) {
  SparseRows A(4, 4);
  A.setIdentity();
  A.makeCompressed();
  const std::vector<int> order = nested_dissection_order(A);
  if (!order.empty()) {
    EXPECT_EQ(analyse_supernodes(A, order).old_of_new.size(), 4U);
  }
}

}  // namespace
}  // namespace skinfield
