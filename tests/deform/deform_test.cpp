#include "deform/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/deform/dual_quaternion.h"
#include "skinfield/deform/linear_blend.h"
#include "skinfield/deform/packed_influences.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>

namespace skinfield {
namespace {

using skinfield_test::largest;
using skinfield_test::random_points;
using skinfield_test::random_rigid;
using skinfield_test::random_simplex;
using skinfield_test::transformed;

Points unit_rows(Points N) {
  N.rowwise().normalize();
  return N;
}

TEST(Deform, ACommonRigidMotionMovesEverythingRigidly) {
  const Points V = random_points(5000, 1), N = unit_rows(random_points(5000, 2));
  const SkinWeights weights = random_simplex(5000, 6, 4, 3);
  const Transform T = random_rigid(4);
  const std::vector<Transform> columns(6, T);
  Transform turn = T;
  turn.topRightCorner<3, 1>().setZero();
  EXPECT_LT(largest(linear_blend(V, weights, columns) - transformed(T, V)), 1e-13);
  EXPECT_LT(largest(dual_quaternion(V, weights, columns) - transformed(T, V)), 1e-13);
  EXPECT_LT(largest(linear_blend_normals(N, weights, columns) - transformed(turn, N)), 1e-13);
  EXPECT_LT(largest(dual_quaternion_normals(N, weights, columns) - transformed(turn, N)), 1e-13);
}

TEST(Deform, ACommonAffineMapIsReproducedByBoth) {
  const Points V = random_points(300, 1), N = unit_rows(random_points(300, 2));
  const SkinWeights weights = random_simplex(300, 5, 3, 3);
  for (const double sign : {1.0, -1.0}) {
    Transform T = random_rigid(5);
    T.topLeftCorner<3, 3>() *= Vec3(sign * 2, 0.5, 1.5).asDiagonal();
    const std::vector<Transform> columns(5, T);
    EXPECT_LT(largest(linear_blend(V, weights, columns) - transformed(T, V)), 1e-12);
    EXPECT_LT(largest(dual_quaternion(V, weights, columns) - transformed(T, V)), 1e-12);
    const Points expected = unit_rows(N * T.topLeftCorner<3, 3>().inverse());
    EXPECT_LT(largest(linear_blend_normals(N, weights, columns) - expected), 1e-12);
    EXPECT_LT(largest(dual_quaternion_normals(N, weights, columns) - expected), 1e-12);
  }
}

TEST(DualQuaternion, OfOneInfluenceIsLinearBlend) {
  const Points V = random_points(200, 1);
  const SkinWeights weights = random_simplex(200, 4, 1, 2);
  std::vector<Transform> columns;
  for (std::uint64_t j = 0; j < 4; ++j) {
    columns.push_back(random_rigid(10 + j));
    columns.back().topLeftCorner<3, 3>() *=
        Vec3(1 + 0.3 * static_cast<double>(j), 1, 0.7).asDiagonal();
  }
  EXPECT_LT(largest(dual_quaternion(V, weights, columns) - linear_blend(V, weights, columns)),
            1e-13);
}

TEST(DualQuaternion, KeepsDistancesToACommonCentreWhereLinearBlendLosesThem) {
  const Points V = random_points(200, 1);
  const SkinWeights weights = random_simplex(200, 2, 2, 2);
  const Vec3 centre(0.3, -0.2, 0.5);
  std::vector<Transform> columns;
  for (const double angle : {0.0, 2.5}) {
    Transform T = Transform::Identity();
    T.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    T.topRightCorner<3, 1>() = centre - T.topLeftCorner<3, 3>() * centre;
    columns.push_back(T);
  }
  const auto radii = [&](const Points& X) -> Vector {
    return (X.rowwise() - centre.transpose()).rowwise().norm();
  };
  const Vector dual = radii(dual_quaternion(V, weights, columns)) - radii(V);
  const Vector linear = radii(linear_blend(V, weights, columns)) - radii(V);
  EXPECT_LT(dual.cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT(linear.minCoeff(), -0.2);
}

TEST(DualQuaternion, DoesNotDependOnTheSignOfQuaternions) {
  // Rotations by a and a + 2 pi are one matrix; close to a half turn their quaternions differ in
  // sign after rounding. The blend must be the short way round in every case.
  Points V(1, 3);
  V << 1, 0, 0;
  RowMatrix W(1, 2);
  W << 0.5, 0.5;
  for (const double a : {3.0, 3.1, 3.2, 3.3}) {
    std::vector<Transform> columns;
    for (const double angle : {a - 0.2, a + 0.2}) {
      Transform T = Transform::Identity();
      T.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
      columns.push_back(T);
    }
    const Points x = dual_quaternion(V, sparse_weights(W), columns);
    EXPECT_NEAR(x(0, 0), std::cos(a), 1e-13);
    EXPECT_NEAR(x(0, 1), std::sin(a), 1e-13);
  }
}

TEST(Deform, VerticesWithoutWeightsStay) {
  const Points V = random_points(3, 1);
  RowMatrix W = RowMatrix::Zero(3, 1);
  W(1, 0) = 1;
  const SkinWeights weights = sparse_weights(W);
  const std::vector<Transform> columns{random_rigid(3)};
  PackedPoints<double> packed;
  linear_blend<double>(V, pack_influences<double>(weights), columns, packed);
  for (const Points& x :
       {linear_blend(V, weights, columns), dual_quaternion(V, weights, columns), Points(packed)}) {
    EXPECT_EQ(x.row(0), V.row(0));
    EXPECT_EQ(x.row(2), V.row(2));
    EXPECT_GT((x.row(1) - V.row(1)).norm(), 0.1);
  }
}

TEST(PackedInfluences, DeformLikeSparseOnes) {
  const int n = 10001;
  const Points V = random_points(n, 1);
  const SkinWeights weights = random_simplex(n, 30, 4, 2);
  std::vector<Transform> columns;
  for (std::uint64_t j = 0; j < 30; ++j) columns.push_back(random_rigid(20 + j));
  const Points expected = linear_blend(V, weights, columns);
  PackedPoints<double> exact;
  linear_blend<double>(V, pack_influences<double>(weights), columns, exact);
  EXPECT_LT(largest(exact - expected), 1e-14);
  PackedPoints<float> single;
  linear_blend<float>(V.cast<float>(), pack_influences<float>(weights), columns, single);
  EXPECT_LT(largest(single.cast<double>() - expected), 2e-6);
}

TEST(PackedInfluences, RefuseFiveInfluences) {
  EXPECT_THROW(pack_influences<float>(random_simplex(5, 6, 5, 1)), InputError);
}

TEST(Deform, RefusesWhatDoesNotBelongTogether) {
  const SkinWeights weights = random_simplex(5, 2, 2, 1);
  const std::vector<Transform> columns(2, Transform::Identity()), one(1, Transform::Identity());
  EXPECT_THROW(linear_blend(random_points(4, 1), weights, columns), InputError);
  EXPECT_THROW(linear_blend(random_points(5, 1), weights, one), InputError);
  EXPECT_THROW(dual_quaternion(random_points(5, 1), weights, one), InputError);
}

TEST(Deform, IsTheSameAtAnyThreadCount) {
  const Points V = random_points(20000, 1);
  const SkinWeights weights = random_simplex(20000, 5, 4, 2);
  std::vector<Transform> columns;
  for (std::uint64_t j = 0; j < 5; ++j) columns.push_back(random_rigid(j));
  const Points linear = linear_blend(V, weights, columns);
  const Points dual = dual_quaternion(V, weights, columns);
  const ThreadLimit limit(1);
  EXPECT_EQ(linear_blend(V, weights, columns), linear);
  EXPECT_EQ(dual_quaternion(V, weights, columns), dual);
}

}  // namespace
}  // namespace skinfield
