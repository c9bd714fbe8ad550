#include "methods/mesh_order.h"

#include "skinfield/base/error.h"
#include "support/box_tets.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace skinfield {
namespace {

TEST(MeshOrder, IsBreadthFirst) {
  const Mesh mesh = skinfield_test::box_tets(6, 3, 3, 0.1);
  const Eigen::Index n = mesh.V.rows() + 1;  // one node without an element
  const MeshOrder order = breadth_first(mesh.T, n);
  ASSERT_EQ(order.node.size(), static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < order.node.size(); ++i) {
    EXPECT_EQ(order.node_place[static_cast<std::size_t>(order.node[i])], static_cast<int>(i));
  }
  std::vector<int> element = order.element;
  std::sort(element.begin(), element.end());
  for (std::size_t e = 0; e < element.size(); ++e) EXPECT_EQ(element[e], static_cast<int>(e));
  EXPECT_EQ(element.size(), static_cast<std::size_t>(mesh.T.rows()));
  EXPECT_EQ(order.node.front(), 0);
  Tetrahedra wrong = mesh.T;
  wrong(0, 0) = static_cast<std::int32_t>(n);
  EXPECT_THROW(breadth_first(wrong, n), InputError);
}

}  // namespace
}  // namespace skinfield
