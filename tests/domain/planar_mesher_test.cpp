#include "skinfield/domain/planar_mesher.h"

#include "domain/fixtures.h"
#include "skinfield/base/error.h"
#include "skinfield/operators/stiffness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

using namespace skinfield_test;

using Loop = std::vector<std::pair<double, double>>;

void add_loop(Mesh& mesh, const Loop& loop, int shape = 0) {
  const auto first = static_cast<std::int32_t>(mesh.V.rows());
  const auto n = static_cast<std::int32_t>(loop.size());
  const Eigen::Index e = mesh.outline.E.rows();
  mesh.V.conservativeResize(first + n, 3);
  mesh.outline.E.conservativeResize(e + n, 2);
  for (std::int32_t k = 0; k < n; ++k) {
    const auto& [x, y] = loop[static_cast<std::size_t>(k)];
    mesh.V.row(first + k) << x, y, 0;
    mesh.outline.E.row(e + k) << first + k, first + (k + 1) % n;
    mesh.outline.shape.push_back(shape);
  }
}

Loop box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

double area(const PlanarMesh& mesh) { return element_volumes(mesh.V, mesh.F).sum(); }

double smallest_angle(const PlanarMesh& mesh) {
  double least = 180;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 a = mesh.V.row(mesh.F(f, c)), b = mesh.V.row(mesh.F(f, (c + 1) % 3)),
                 d = mesh.V.row(mesh.F(f, (c + 2) % 3));
      least = std::min(least, std::atan2((b - a).cross(d - a).norm(), (b - a).dot(d - a)) * 180 /
                                  std::numbers::pi);
    }
  }
  return least;
}

class PlanarMesher : public testing::Test {
 protected:
  void SetUp() override {
    if (!can_mesh_outlines()) GTEST_SKIP() << "the permissive profile has no mesher";
  }
};

TEST_F(PlanarMesher, KeepsAreaPointsAndHoles) {
  Mesh mesh;
  add_loop(mesh, box(0, 0, 1, 1));
  add_loop(mesh, box(0.3, 0.3, 0.6, 0.7));
  add_loop(mesh, box(0.4, 0.4, 0.5, 0.5));  // an island in the hole
  for (const int nodes : {0, 500, 3000}) {
    const PlanarMesh out = mesh_outline(mesh, {}, {.nodes = nodes});
    EXPECT_EQ(Points(out.V.topRows(12)), mesh.V);
    EXPECT_NEAR(area(out), 1 - 0.12 + 0.01, 1e-12);
    EXPECT_EQ(out.crossings, 0);
    EXPECT_EQ(connected_components(out.F, out.V.rows()).count, 2);
    if (nodes == 0) {
      EXPECT_EQ(out.V.rows(), 12);
    } else {
      EXPECT_NEAR(static_cast<double>(out.V.rows()), nodes, 0.11 * nodes);
      EXPECT_GT(smallest_angle(out), 20);
    }
    for (Eigen::Index f = 0; f < out.F.rows(); ++f) {
      const Eigen::RowVector3d c =
          (out.V.row(out.F(f, 0)) + out.V.row(out.F(f, 1)) + out.V.row(out.F(f, 2))) / 3;
      const bool hole = c.x() > 0.3 && c.x() < 0.6 && c.y() > 0.3 && c.y() < 0.7;
      const bool island = c.x() > 0.4 && c.x() < 0.5 && c.y() > 0.4 && c.y() < 0.5;
      EXPECT_TRUE(!hole || island);
      const Vec3 a = out.V.row(out.F(f, 0)), b = out.V.row(out.F(f, 1)), d = out.V.row(out.F(f, 2));
      EXPECT_GT((b - a).cross(d - a).z(), 0);  // counterclockwise
    }
  }
}

TEST_F(PlanarMesher, ShapesUniteAndEachIsEvenOdd) {
  Mesh mesh;
  add_loop(mesh, box(0, 0, 2, 2), 0);
  add_loop(mesh, box(1, 1, 3, 3), 1);  // overlaps: united, with two crossings
  const PlanarMesh united = mesh_outline(mesh, {}, {.nodes = 0});
  EXPECT_NEAR(area(united), 7, 1e-12);
  EXPECT_EQ(united.crossings, 2);
  mesh.outline.shape.assign(8, 0);
  EXPECT_NEAR(area(mesh_outline(mesh, {}, {.nodes = 0})), 6, 1e-12);
  // A pentagram crosses itself: even-odd leaves its middle out.
  Mesh star;
  Loop points;
  for (int k = 0; k < 5; ++k) {
    const double a = 2 * std::numbers::pi * (2 * k % 5) / 5;
    points.emplace_back(std::cos(a), std::sin(a));
  }
  add_loop(star, points);
  const PlanarMesh pentagram = mesh_outline(star, {}, {.nodes = 400});
  EXPECT_EQ(pentagram.crossings, 5);
  const double inner = 0.5 * (3 - std::sqrt(5.0));  // radius of the middle pentagon
  const double tip =
      inner * std::sin(std::numbers::pi / 5) * (1 - inner * std::cos(std::numbers::pi / 5));
  EXPECT_NEAR(area(pentagram), 5 * tip, 1e-9);
  for (Eigen::Index f = 0; f < pentagram.F.rows(); ++f) {
    const Vec3 c = (pentagram.V.row(pentagram.F(f, 0)) + pentagram.V.row(pentagram.F(f, 1)) +
                    pentagram.V.row(pentagram.F(f, 2))) /
                   3;
    EXPECT_GT(c.norm(), inner * std::cos(std::numbers::pi / 5) * 0.999);
  }
}

TEST_F(PlanarMesher, HandlesBecomeVerticesAndEdges) {
  Mesh mesh;
  add_loop(mesh, box(0, 0, 2, 1));
  const std::vector<Handle> handles{bone({0.31, 0.5, 0.4}, {1.27, 0.63, 0}),
                                    bone({1.27, 0.63, 0}, {2.6, 0.7, 0}),  // leaves the box
                                    point_handle({0.2, 0.2, 0}), point_handle({5, 5, 0}),
                                    bone({5, 5, 0}, {6, 6, 0})};
  const PlanarMesh out = mesh_outline(mesh, handles, {.nodes = 800});
  EXPECT_NEAR(area(out), 2, 1e-12);
  EXPECT_LE(out.V.col(0).maxCoeff(), 2);
  const auto nearest = [&](double x, double y) {
    return (out.V.rowwise() - Eigen::RowVector3d(x, y, 0)).rowwise().norm().minCoeff();
  };
  EXPECT_LT(nearest(0.31, 0.5), 1e-15);
  EXPECT_LT(nearest(1.27, 0.63), 1e-15);
  EXPECT_LT(nearest(0.2, 0.2), 1e-15);
  // The bone is a chain of edges: no gap along it longer than a few edges of the mesh.
  std::vector<double> along;
  const Vec3 a(0.31, 0.5, 0), b(1.27, 0.63, 0);
  for (Eigen::Index i = 0; i < out.V.rows(); ++i) {
    const Vec3 x = out.V.row(i);
    const double t = (x - a).dot(b - a) / (b - a).squaredNorm();
    if (t >= 0 && t <= 1 && (a + t * (b - a) - x).norm() < 1e-9) along.push_back(t);
  }
  std::sort(along.begin(), along.end());
  ASSERT_GE(along.size(), 10u);
  for (std::size_t k = 1; k < along.size(); ++k) {
    EXPECT_LT((along[k] - along[k - 1]) * (b - a).norm(), 0.15);
  }
}

TEST_F(PlanarMesher, AnyPlaneAndTheSameBytes) {
  Mesh mesh;
  add_loop(mesh, box(0, 0, 1, 0.7));
  mesh.V *= Eigen::AngleAxisd(1.0, Vec3(1, 2, 2) / 3).toRotationMatrix().transpose();
  const PlanarMesh one = mesh_outline(mesh, {}, {.nodes = 700});
  const PlanarMesh two = mesh_outline(mesh, {}, {.nodes = 700});
  EXPECT_EQ(one.V, two.V);
  EXPECT_EQ(one.F, two.F);
  EXPECT_NEAR(area(one), 0.7, 1e-12);
}

TEST_F(PlanarMesher, SharpCornersAndTouchingLoopsEnd) {
  Mesh needle;
  add_loop(needle, {{0, 0}, {1, 0}, {1, 0.01}});
  EXPECT_NEAR(area(mesh_outline(needle, {}, {.nodes = 300})), 0.005, 1e-12);
  // Two squares that share a corner, in one loop that passes it twice.
  Mesh bow;
  add_loop(bow, {{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 1}, {0, 1}});
  bow.outline.E = bow.outline.E.unaryExpr([](std::int32_t v) { return v == 6 ? 2 : v; });
  EXPECT_NEAR(area(mesh_outline(bow, {}, {.nodes = 300})), 2, 1e-12);
}

TEST_F(PlanarMesher, RefusesWhatHasNoInside) {
  Mesh flat;
  add_loop(flat, {{0, 0}, {1, 0}, {2, 0}});
  EXPECT_THROW(mesh_outline(flat, {}), DomainError);
  Mesh bent;
  add_loop(bent, box(0, 0, 1, 1));
  bent.V(2, 2) = 0.1;
  EXPECT_THROW(mesh_outline(bent, {}), DomainError);
}

TEST(PlanarMesherOfPermissive, SaysWhatToDo) {
  if (can_mesh_outlines()) GTEST_SKIP() << "this build has the mesher";
  try {
    mesh_outline({}, {});
    FAIL();
  } catch (const DomainError& error) {
    EXPECT_NE(error.remedy().find("OBJ"), std::string::npos);
  }
}

}  // namespace
}  // namespace skinfield
