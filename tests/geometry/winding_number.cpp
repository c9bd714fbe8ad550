#include "skinfield/geometry/winding_number.h"

#include "geometry/shapes.h"
#include "skinfield/base/parallel.h"

#include <gtest/gtest.h>

using namespace skinfield_test;

namespace {

double largest_error(const Mesh& mesh, const Points& X, double accuracy) {
  const WindingNumber w(mesh.V, mesh.F, {accuracy});
  double error = 0;
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    error = std::max(error,
                     std::abs(w.at(row(X, i)) - winding_number_direct(mesh.V, mesh.F, row(X, i))));
  return error;
}

/// Points within `spread` of the surface, half on either side.
Points near_surface(const Mesh& mesh, double spread, int count) {
  Points X(count, 3);
  for (int i = 0; i < count; ++i) {
    Random random(5, static_cast<std::uint64_t>(i));
    const Eigen::Index f = random.below(static_cast<std::uint32_t>(mesh.F.rows()));
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    X.row(i) = (1 - u - v) * mesh.V.row(mesh.F(f, 0)) + u * mesh.V.row(mesh.F(f, 1)) +
               v * mesh.V.row(mesh.F(f, 2)) + spread * random.direction().transpose();
  }
  return X;
}

TEST(WindingNumber, DirectSumOfAClosedMeshIsAnInteger) {
  const Mesh torus = torus_mesh(1, 0.4);
  const Points X = random_points(200, -1.6, 1.6, 1);
  int inside = 0;
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const double w = winding_number_direct(torus.V, torus.F, row(X, i));
    EXPECT_NEAR(w, std::round(w), 1e-9);
    inside += w > 0.5;
  }
  EXPECT_GT(inside, 10);
  EXPECT_NEAR(winding_number_direct(torus.V, torus.F, {1, 0, 0}), 1, 1e-12);
  EXPECT_NEAR(winding_number_direct(torus.V, torus.F, {0, 0, 0}), 0, 1e-12);
}

TEST(WindingNumber, FastAgreesWithDirectNearAndFar) {
  for (const Mesh& mesh : {torus_mesh(1, 0.4, 96, 48), sphere_mesh(1, 40, 0.2)}) {
    EXPECT_LT(largest_error(mesh, near_surface(mesh, 0.02, 400), 2), 1e-2);
    EXPECT_LT(largest_error(mesh, random_points(200, -2, 2, 3), 2), 1e-2);
    EXPECT_LT(largest_error(mesh, random_points(100, -2, 2, 4), 6), 1e-3);
  }
}

TEST(WindingNumber, FastAgreesWithDirectOnSoups) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Mesh soup = random_soup(700, 0.02 + 0.05 * static_cast<double>(seed), seed);
    EXPECT_LT(largest_error(soup, random_points(100, -0.2, 1.2, seed), 2), 2e-2) << seed;
    EXPECT_LT(largest_error(soup, random_points(100, -0.2, 1.2, seed), 5), 1e-3) << seed;
  }
}

TEST(WindingNumber, ErrorFallsWithAccuracyAsSecondOrderShould) {
  const Mesh mesh = torus_mesh(1, 0.4, 96, 48);
  const Points X = random_points(200, -1.5, 1.5, 9);
  EXPECT_LT(largest_error(mesh, X, 6), 0.15 * largest_error(mesh, X, 2));
}

TEST(WindingNumber, NestedAndFlippedShellsAddUp) {
  Mesh two = box_mesh({-1, -1, -1}, {1, 1, 1});
  const Mesh inner = box_mesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  two.V.conservativeResize(16, 3);
  two.V.bottomRows(8) = inner.V;
  two.F.conservativeResize(24, 3);
  two.F.bottomRows(12) = inner.F.array() + 8;
  EXPECT_NEAR(WindingNumber(two.V, two.F).at(Vec3(0.1, 0.2, 0.3)), 2, 1e-9);
  EXPECT_NEAR(WindingNumber(two.V, two.F).at(Vec3(0.7, 0.2, 0.3)), 1, 1e-9);
  two.F.bottomRows(12).col(0).swap(two.F.bottomRows(12).col(1));
  EXPECT_NEAR(WindingNumber(two.V, two.F).at(Vec3(0.1, 0.2, 0.3)), 0, 1e-9);
}

TEST(WindingNumber, InvariantUnderScaleAndRotation) {
  const Mesh mesh = random_soup(500, 0.1, 3);
  const Points X = random_points(50, 0, 1, 3);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const WindingNumber w(mesh.V, mesh.F);
  const WindingNumber scaled(1e6 * mesh.V, mesh.F);
  const WindingNumber turned(mesh.V * turn.transpose(), mesh.F);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    EXPECT_NEAR(scaled.at(Vec3(1e6 * row(X, i))), w.at(row(X, i)), 1e-9);
    EXPECT_NEAR(turned.at(Vec3(turn * row(X, i))), w.at(row(X, i)), 2e-2);
  }
}

TEST(WindingNumber, PointsStandForTheirTriangles) {
  const Mesh mesh = sphere_mesh(1, 60);
  const Vector area = face_areas(mesh.V, mesh.F);
  Points C(mesh.F.rows(), 3);
  for (Eigen::Index f = 0; f < C.rows(); ++f)
    C.row(f) = (mesh.V.row(mesh.F(f, 0)) + mesh.V.row(mesh.F(f, 1)) + mesh.V.row(mesh.F(f, 2))) / 3;
  const WindingNumber points(C, face_normals(mesh.V, mesh.F).rowwise().normalized(), area);
  const WindingNumber triangles(mesh.V, mesh.F);
  for (const double r : {0.0, 0.5, 0.8, 1.2, 3.0}) {
    const Vec3 x(r * 0.6, 0, r * 0.8);
    EXPECT_NEAR(points.at(x), triangles.at(x), 1e-2) << r;
    EXPECT_NEAR(points.at(x), r < 1 ? 1 : 0, 1e-2) << r;
  }
}

TEST(WindingNumber, SmoothedIsItsFormula) {
  const Mesh mesh = torus_mesh(1, 0.4);
  const Points N = face_normals(mesh.V, mesh.F) / 2;
  const WindingNumber w(mesh.V, mesh.F);
  const Points X = random_points(60, -1.5, 1.5, 8);
  for (const double epsilon : {0.05, 0.2, 1.0}) {
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      double direct = 0;
      for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
        const Vec3 c =
            (row(mesh.V, mesh.F(f, 0)) + row(mesh.V, mesh.F(f, 1)) + row(mesh.V, mesh.F(f, 2))) /
                3 -
            row(X, i);
        direct += row(N, f).dot(c) / std::pow(c.squaredNorm() + epsilon * epsilon, 1.5);
      }
      EXPECT_NEAR(w.smoothed(row(X, i), epsilon), direct / (4 * std::numbers::pi), 1e-2);
    }
  }
  EXPECT_NEAR(w.smoothed({1, 0, 0}, 1e-3), 1, 2e-2);
}

TEST(WindingNumber, ManyPointsAreTheSameBytesAtAnyThreadCount) {
  const Mesh mesh = random_soup(300, 0.1, 4);
  const Points X = random_points(1000, 0, 1, 4);
  const WindingNumber w(mesh.V, mesh.F);
  const Vector all = w.at(X);
  const ThreadLimit one(1);
  EXPECT_EQ(all, w.at(X));
  EXPECT_EQ(all[17], w.at(row(X, 17)));
}

TEST(WindingNumber, NothingAndNonsenseGiveZero) {
  EXPECT_EQ(WindingNumber(Points(0, 3), Triangles(0, 3)).at(Vec3(1, 2, 3)), 0);
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, std::nan("")}},
                        {{0, 1, 2}, {0, 0, 1}, {0, 1, 3}});
  EXPECT_EQ(WindingNumber(mesh.V, mesh.F).at(Vec3(1, 2, 3)), 0);
}

TEST(WindingNumber, OnTheSurfaceItIsFinite) {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const WindingNumber w(box.V, box.F);
  for (const Vec3& x : {Vec3(0, 0, 0), Vec3(0.5, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.3, 0.2, 0)}) {
    EXPECT_GE(w.at(x), -1e-9);
    EXPECT_LE(w.at(x), 1 + 1e-9);
  }
}

}  // namespace
