#include "skinfield/domain/field_conditions.h"

#include "domain/fixtures.h"
#include "skinfield/base/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

using namespace skinfield_test;

double sum_of(const Prescribed& p) {
  double sum = 0;
  for (const auto& [column, value] : p.value) sum += value;
  return sum;
}

double value_of(const Prescribed& p, int column) {
  double sum = 0;
  for (const auto& [c, value] : p.value) sum += c == column ? value : 0;
  return sum;
}

Prescribed at(const FieldConditions& conditions, const Solid& solid, const Vec3& from,
              const Vec3& x) {
  FieldConditions::View view;
  conditions.look(solid.site(from), 0.5, view);
  Prescribed p;
  conditions.at(view, x, p);
  EXPECT_NEAR(p.free + sum_of(p), 1, 1e-14);
  EXPECT_GE(p.free, 0);
  return p;
}

Points middle() { return Points::Constant(1, 3, 0.1); }

TEST(FieldConditions, BumpIsOneAtZeroAndFlatAtBothEnds) {
  EXPECT_EQ(bump(0, 0.1), 1);
  EXPECT_EQ(bump(0.1, 0.1), 0);
  EXPECT_EQ(bump(1, 0.1), 0);
  EXPECT_EQ(bump(0.01, 0), 0);
  // w'(t) = 1/2 at t = 1/2: distance epsilon / sqrt 2.
  EXPECT_NEAR(bump(0.1 / std::sqrt(2.0), 0.1), 0.5, 1e-12);
  double last = 1;
  for (int k = 1; k <= 100; ++k) {
    const double w = bump(0.001 * k, 0.1);
    EXPECT_LE(w, last);
    last = w;
  }
  for (const double d : {1e-3, 0.0999}) EXPECT_NEAR(bump(d, 0.1), d < 0.05 ? 1 : 0, 1e-30);
}

TEST(FieldConditions, HandlesHaveTheirOwnValueExactly) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 0.3, 0.3});
  const std::vector<Handle> handles{bone({0.1, 0.15, 0.15}, {0.4, 0.15, 0.15}),
                                    point_handle({0.8, 0.1, 0.1})};
  const Solid solid(box, middle());
  FieldConditions conditions(solid, box, handles, {}, false);
  conditions.set_radii({0.05, 0.05, 0});
  for (const double x : {0.1, 0.17, 0.4}) {
    const Prescribed p = at(conditions, solid, {x, 0.15, 0.15}, {x, 0.15, 0.15});
    EXPECT_EQ(p.free, 0);
    EXPECT_EQ(value_of(p, 0), 1);
  }
  EXPECT_EQ(value_of(at(conditions, solid, {0.8, 0.1, 0.1}, {0.8, 0.1, 0.1}), 1), 1);
  EXPECT_EQ(at(conditions, solid, {0.6, 0.15, 0.15}, {0.6, 0.15, 0.15}).free, 1);
}

TEST(FieldConditions, OverlappingHandlesShareTheClosestOnesBump) {
  // The paper's example: two bumps of 1/2 become 1/4 each.
  const Mesh box = box_mesh({0, 0, 0}, {1, 0.3, 0.3});
  const double epsilon = 0.1, d = epsilon / std::sqrt(2.0);
  const std::vector<Handle> handles{point_handle({0.5 - d, 0.15, 0.15}),
                                    point_handle({0.5 + d, 0.15, 0.15})};
  const Solid solid(box, middle());
  FieldConditions conditions(solid, box, handles, {}, false);
  conditions.set_radii({epsilon, epsilon, 0});
  const Prescribed p = at(conditions, solid, {0.5, 0.15, 0.15}, {0.5, 0.15, 0.15});
  EXPECT_NEAR(value_of(p, 0), 0.25, 1e-12);
  EXPECT_NEAR(value_of(p, 1), 0.25, 1e-12);
  EXPECT_NEAR(p.free, 0.5, 1e-12);
}

TEST(FieldConditions, ABoneDoesNotBleedThroughAWall) {
  const double gap = 0.004;
  const Mesh fork = fork_mesh(gap);
  // A bone 0.003 inside the left prong's inner wall.
  const std::vector<Handle> handles{bone({0.097, 0.3, 0.05}, {0.097, 0.9, 0.05}),
                                    fork_bones(gap)[1]};
  const Solid solid(fork, Points::Constant(1, 3, 0.05));
  FieldConditions conditions(solid, fork, handles, {}, false);
  conditions.set_radii({0.05, 0.05, 0});
  const Vec3 own(0.09, 0.6, 0.05), across(0.1 + gap + 0.002, 0.6, 0.05);
  EXPECT_GT(value_of(at(conditions, solid, own, own), 0), 0.5);
  EXPECT_EQ(value_of(at(conditions, solid, across, across), 0), 0);
}

TEST(FieldConditions, PartsOutsideTheShapeBindNothing) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 0.3, 0.3});
  const std::vector<Handle> handles{bone({0.8, 0.15, 0.15}, {1.5, 0.15, 0.15}),
                                    bone({0.5, 0.6, 0.15}, {0.5, 0.9, 0.15})};
  const Solid solid(box, middle());
  const FieldConditions conditions(solid, box, handles, {}, false);
  EXPECT_EQ(conditions.bound(), (std::vector<char>{1, 0}));
  ASSERT_EQ(conditions.segments().size(), 1u);
  EXPECT_NEAR(conditions.segments()[0].second[0], 1, 1e-6);
}

TEST(FieldConditions, PaintIsHardAndGoesBeforeHandles) {
  const Mesh box = fine_box({0, 0, 0}, {1, 0.3, 0.3}, {10, 3, 3});
  const std::vector<Handle> handles{bone({0.1, 0.01, 0.15}, {0.9, 0.01, 0.15}),
                                    point_handle({0.8, 0.2, 0.2})};
  PaintedVertices paint;
  for (int v = 0; v < box.V.rows(); ++v)
    if (box.V(v, 1) == 0 && box.V(v, 0) > 0.35 && box.V(v, 0) < 0.65) paint.vertex.push_back(v);
  paint.weights.resize(static_cast<Eigen::Index>(paint.vertex.size()), 2);
  paint.weights.col(0).setConstant(0.25);
  paint.weights.col(1).setConstant(0.75);
  const Solid solid(box, Points::Constant(1, 3, 0.15));
  FieldConditions conditions(solid, box, handles, paint, false);
  conditions.set_radii({0.05, 0.05, 0});
  for (const int v : paint.vertex) {
    const Vec3 x = box.V.row(v).transpose();
    const Prescribed p = at(conditions, solid, x + Vec3(0, 1e-5, 0), x);
    EXPECT_NEAR(p.free, 0, 1e-12);
    EXPECT_NEAR(value_of(p, 0), 0.25, 1e-12);
    EXPECT_NEAR(value_of(p, 1), 0.75, 1e-12);
  }
  // Between painted corners too; beyond the radius not.
  const Vec3 between(0.52, 0, 0.13);
  EXPECT_NEAR(value_of(at(conditions, solid, between + Vec3(0, 1e-5, 0), between), 1), 0.75, 1e-12);
  const Vec3 deep(0.5, 0.2, 0.15);
  EXPECT_EQ(at(conditions, solid, deep, deep).free, 1);
  PaintedVertices wrong = paint;
  wrong.vertex[0] = 100000;
  EXPECT_THROW(FieldConditions(solid, box, handles, wrong, false), InputError);
  wrong = paint;
  wrong.weights.conservativeResize(wrong.weights.rows(), 1);
  EXPECT_THROW(FieldConditions(solid, box, handles, wrong, false), InputError);
}

TEST(FieldConditions, WallsInsideAnotherPartAreNone) {
  const Mesh boxes =
      together(box_mesh({0, 0, 0}, {0.6, 0.3, 0.3}), box_mesh({0.4, 0.01, 0.01}, {1, 0.29, 0.29}));
  Points handles(2, 3);
  handles << 0.2, 0.15, 0.15, 0.8, 0.15, 0.15;
  const Solid solid(boxes, handles);
  FieldConditions conditions(solid, boxes, {bone({0.2, 0.15, 0.15}, {0.8, 0.15, 0.15})}, {}, true);
  conditions.set_radii({0.02, 0.02, 0.05});
  Vec3 p;
  double weight = 0;
  EXPECT_FALSE(conditions.wall({0.41, 0.15, 0.15}, p, weight));
  EXPECT_TRUE(conditions.wall({0.02, 0.15, 0.15}, p, weight));
  EXPECT_NEAR(p[0], 0, 1e-12);
  EXPECT_NEAR(weight, bump(0.02, 0.05), 1e-9);
}

}  // namespace
}  // namespace skinfield
