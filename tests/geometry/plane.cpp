#include "skinfield/geometry/plane.h"

#include <gtest/gtest.h>

namespace skinfield {
namespace {

Points square() {
  Points V(4, 3);
  V << 0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0;
  return V;
}

TEST(Plane, AxesAreRightHandedAndLookForward) {
  const Points V = square();
  const Eigen::AngleAxisd turns[] = {
      Eigen::AngleAxisd(0.0, Vec3::UnitX()), Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()),
      Eigen::AngleAxisd(3.0, Vec3::UnitY()), Eigen::AngleAxisd(-1.5707963267948966, Vec3::UnitX())};
  for (const Eigen::AngleAxisd& turn : turns) {
    Points X = V * turn.toRotationMatrix().transpose();
    X.rowwise() += Eigen::RowVector3d(5, -7, 3);
    const auto plane = plane_of(X, 1e-9);
    ASSERT_TRUE(plane);
    EXPECT_LT((plane->u.cross(plane->v) - plane->n).norm(), 1e-12);
    EXPECT_GT(plane->n.z() + 1e-6 * plane->n.y(), 0);
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      const Vec3 x = X.row(i);
      EXPECT_LT((plane->from(plane->to(x)) - x).norm(), 1e-12);
      EXPECT_LT((plane->drop(x + 0.4 * plane->n) - x).norm(), 1e-12);
    }
  }
}

TEST(Plane, PlanesOfFilesKeepTheirAxes) {
  const auto front = plane_of(square(), 1e-9);
  ASSERT_TRUE(front);
  EXPECT_EQ(front->u, Vec3(1, 0, 0));
  EXPECT_EQ(front->v, Vec3(0, 1, 0));
  Points line(3, 3);
  line << 0, 0, 4, 1, 1, 4, 2, 2, 4;
  EXPECT_EQ(plane_of(line, 1e-9)->n, Vec3(0, 0, 1));
}

TEST(Plane, BentPointsHaveNone) {
  Points V = square();
  V(2, 2) = 1e-3;
  EXPECT_FALSE(plane_of(V, 1e-4));
  EXPECT_TRUE(plane_of(V, 1e-2));
  EXPECT_FALSE(plane_of(Points(0, 3), 1));
}

}  // namespace
}  // namespace skinfield
