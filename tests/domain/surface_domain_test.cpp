#include "skinfield/domain/surface_domain.h"

#include "skinfield/base/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skinfield {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A coarse ring of ribbon with one half turn: a Moebius strip.
Mesh moebius(int n = 40) {
  Mesh mesh;
  mesh.V.resize(2 * n, 3);
  mesh.F.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * i / n;
    for (int side = 0; side < 2; ++side) {
      const double across = 0.1 * (2 * side - 1);
      const double r = 0.4 + across * std::cos(a / 2);
      mesh.V.row(2 * i + side) << 0.5 + r * std::cos(a), 0.5 + r * std::sin(a),
          across * std::sin(a / 2);
    }
    const bool last = i + 1 == n;
    const int low = last ? 1 : 2 * i + 2, high = last ? 0 : 2 * i + 3;
    mesh.F.row(2 * i) << 2 * i, 2 * i + 1, low;
    mesh.F.row(2 * i + 1) << 2 * i + 1, high, low;
  }
  return mesh;
}

Handle point(double x, double y, double z) {
  Handle handle;
  handle.kind = Handle::Kind::point;
  handle.point = Vec3(x, y, z);
  return handle;
}

Handle bone(const Vec3& a, const Vec3& b) {
  Handle handle;
  handle.segments = {{a, b}};
  return handle;
}

/// A square of two triangles in the plane z = `z`, from x = x0 on.
void add_square(Mesh& mesh, double x0, double z, double size = 0.5) {
  const auto v = static_cast<std::int32_t>(mesh.V.rows());
  const Eigen::Index f = mesh.F.rows();
  mesh.V.conservativeResize(v + 4, 3);
  mesh.V.row(v) << x0, 0, z;
  mesh.V.row(v + 1) << x0 + size, 0, z;
  mesh.V.row(v + 2) << x0 + size, size, z;
  mesh.V.row(v + 3) << x0, size, z;
  mesh.F.conservativeResize(f + 2, 3);
  mesh.F.row(f) << v, v + 1, v + 2;
  mesh.F.row(f + 1) << v, v + 2, v + 3;
}

int graph_components(const SparseRows& K) {
  std::vector<char> seen(static_cast<std::size_t>(K.rows()), 0);
  int count = 0;
  for (int i = 0; i < K.rows(); ++i) {
    if (seen[static_cast<std::size_t>(i)]) continue;
    ++count;
    std::vector<int> stack = {i};
    seen[static_cast<std::size_t>(i)] = 1;
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      for (SparseRows::InnerIterator it(K, v); it; ++it) {
        if (seen[static_cast<std::size_t>(it.col())]) continue;
        seen[static_cast<std::size_t>(it.col())] = 1;
        stack.push_back(static_cast<int>(it.col()));
      }
    }
  }
  return count;
}

void expect_good(const SurfaceDomain& domain, const Mesh& mesh) {
  const SparseRows& K = domain.stiffness();
  EXPECT_LT((K * Vector::Ones(K.rows())).cwiseAbs().maxCoeff(), 1e-9 * K.coeffs().maxCoeff());
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    for (SparseRows::InnerIterator it(K, i); it; ++it) {
      ASSERT_EQ(it.value(), K.coeff(it.col(), i));
      ASSERT_TRUE(it.col() == i ? it.value() > 0 : it.value() < 0);
    }
  }
  EXPECT_GT(domain.mass().minCoeff(), 0);
  EXPECT_NEAR(domain.mass().sum(), face_areas(mesh.V, mesh.F).sum(), 1e-9);
  const FixedRows& fixed = domain.fixed();
  EXPECT_LT((fixed.weights.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_GT(fixed.weights.colwise().sum().minCoeff(), 0);  // every handle holds something
  for (std::size_t k = 1; k < fixed.node.size(); ++k) EXPECT_LT(fixed.node[k - 1], fixed.node[k]);
  // Every vertex of the mesh is found on the domain.
  const Interpolation self = domain.at(mesh.V, {});
  const Points back = self.P * domain.nodes();
  EXPECT_LT((back - mesh.V).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT(((self.P * Vector::Ones(self.P.cols())).array() - 1).abs().maxCoeff(), 1e-12);
}

TEST(SurfaceDomain, MoebiusStrip) {
  const Mesh mesh = moebius();
  const SurfaceDomain domain(mesh, {point(0.9, 0.5, 0), point(0.1, 0.5, 0), point(0.5, 0.9, 0)});
  expect_good(domain, mesh);
  EXPECT_EQ(graph_components(domain.stiffness()), 1);
  EXPECT_GT(domain.nodes().rows(), 2000);  // refined
}

TEST(SurfaceDomain, PlanarSheetWithBonesInIt) {
  Mesh mesh;
  add_square(mesh, 0, 0, 1.0);
  const SurfaceDomain domain(
      mesh, {bone({0.1, 0.5, 0}, {0.5, 0.5, 0}), bone({0.5, 0.5, 0}, {0.9, 0.5, 0})});
  expect_good(domain, mesh);
  const FixedRows& fixed = domain.fixed();
  for (const int v : fixed.node) EXPECT_LT(std::abs(domain.nodes()(v, 1) - 0.5), 0.05);
  EXPECT_GT(fixed.weights.col(0).sum(), 10);
  EXPECT_GT(fixed.weights.col(1).sum(), 10);
}

TEST(SurfaceDomain, TouchingSheetsAreJoinedAndOthersAreNot) {
  Mesh mesh;
  add_square(mesh, 0, 0);
  add_square(mesh, 0.495, 0.003);  // overlaps the first by a strip
  const std::vector<Handle> handles = {point(0.1, 0.2, 0), point(0.9, 0.2, 0)};
  EXPECT_EQ(graph_components(SurfaceDomain(mesh, handles).stiffness()), 1);
  add_square(mesh, 0, 0.4);
  const SurfaceDomain domain(mesh, handles);
  expect_good(domain, mesh);
  EXPECT_EQ(graph_components(domain.stiffness()), 2);
}

TEST(SurfaceDomain, DegenerateAndNonManifoldTriangles) {
  Mesh mesh;
  add_square(mesh, 0, 0, 1.0);
  const Eigen::Index f = mesh.F.rows();
  mesh.V.conservativeResize(6, 3);
  mesh.V.row(4) << 0.5, 0.5, 0.5;  // a fin on the diagonal
  mesh.V.row(5) << 7, 7, 7;        // in no triangle
  mesh.F.conservativeResize(f + 3, 3);
  mesh.F.row(f) << 0, 2, 4;
  mesh.F.row(f + 1) << 0, 0, 2;
  mesh.F.row(f + 2) << 0, 2, 0;
  const SurfaceDomain domain(mesh, {point(0.1, 0.1, 0), point(0.9, 0.9, 0)});
  EXPECT_EQ(graph_components(domain.stiffness()), 1);
  EXPECT_TRUE(domain.nodes().allFinite());
  EXPECT_LT(domain.nodes().maxCoeff(), 2);
}

TEST(SurfaceDomain, BoneInsideATubeHoldsARing) {
  Mesh mesh;
  const int n = 24, rings = 12;
  mesh.V.resize(n * rings, 3);
  mesh.F.resize(2 * n * (rings - 1), 3);
  Eigen::Index f = 0;
  for (int r = 0; r < rings; ++r) {
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * kPi * i / n;
      mesh.V.row(r * n + i) << 0.1 * std::cos(angle), 0.1 * std::sin(angle), r / (rings - 1.0);
      if (r + 1 == rings) continue;
      const int a = r * n + i, b = r * n + (i + 1) % n;
      mesh.F.row(f++) << a, b, a + n;
      mesh.F.row(f++) << b, b + n, a + n;
    }
  }
  const SurfaceDomain domain(mesh,
                             {bone({0, 0, 0.1}, {0, 0, 0.3}), bone({0, 0, 0.7}, {0, 0, 0.9})});
  expect_good(domain, mesh);
  int quadrant[4] = {0, 0, 0, 0};
  for (const int v : domain.fixed().node) {
    ++quadrant[2 * (domain.nodes()(v, 0) > 0) + (domain.nodes()(v, 1) > 0)];
  }
  for (const int count : quadrant) EXPECT_GT(count, 0);
}

TEST(SurfaceDomain, RefusesWhatHasNoSurfaceOrHandle) {
  Mesh mesh;
  add_square(mesh, 0, 0);
  EXPECT_THROW(SurfaceDomain(mesh, {}), DomainError);
  mesh.F.row(0) << 1, 1, 1;
  mesh.F.row(1) << 2, 2, 3;
  EXPECT_THROW(SurfaceDomain(mesh, {point(0, 0, 0)}), DomainError);
}

}  // namespace
}  // namespace skinfield
