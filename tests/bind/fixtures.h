// Characters made by code, and what every bound one must satisfy.
#pragma once

#include "domain/fixtures.h"
#include "skinfield/bind/bind.h"
#include "skinfield/bind/handles.h"
#include "skinfield/io/io.h"
#include "skinfield/weights/operations.h"
#include "skinfield/weights/statistics.h"

#include <gtest/gtest.h>

namespace skinfield_test {

/// As a reader makes it from a mesh and TGF bones: equal positions merged, a column a handle.
inline Character character(const Mesh& input, const std::vector<Handle>& handles) {
  Character c;
  c.name = "test";
  c.mesh = input;
  const Welded welded = weld(input.V);
  c.mesh.V = welded.V;
  c.vertex_of_input = welded.vertex;
  for (Eigen::Index i = 0; i < c.mesh.F.size(); ++i)
    c.mesh.F.data()[i] = welded.vertex[static_cast<std::size_t>(c.mesh.F.data()[i])];
  c.skeleton.source = Skeleton::Source::tgf;
  c.skeleton.handles = handles;
  c.skeleton.columns = static_cast<int>(handles.size());
  for (int h = 0; h < c.skeleton.columns; ++h) {
    Handle& handle = c.skeleton.handles[static_cast<std::size_t>(h)];
    if (handle.name.empty()) handle.name = "bone_" + std::to_string(h);
    c.skeleton.column.push_back(h);
    c.skeleton.column_names.push_back(handle.name);
  }
  return c;
}

inline BindOptions quick(int nodes = 1000) {
  BindOptions options;
  options.nodes = nodes;
  return options;
}

inline BindOptions field(int points = 500) {
  BindOptions options = quick();
  options.method = Method::geometric_fields;
  options.field_points = points;
  return options;
}

/// The first character of a file, with a skeleton.
inline Character read_case(const std::filesystem::path& mesh, const Skeleton& skeleton) {
  Asset asset = read_asset(mesh);
  Character c = std::move(asset.characters.front());
  give_skeleton(c, skeleton);
  make_handles(c);
  return c;
}
inline Character read_case(const std::filesystem::path& mesh, const std::filesystem::path& tgf) {
  return read_case(mesh, read_skeleton(tgf));
}

/// Every input vertex has a row on the simplex, and the report agrees.
inline void expect_valid(const BindResult& result, const Character& c) {
  ASSERT_EQ(result.weights.W.rows(), static_cast<Eigen::Index>(c.vertex_of_input.size()));
  for (Eigen::Index i = 0; i < result.weights.W.rows(); ++i) {
    double sum = 0;
    for (SparseRows::InnerIterator it(result.weights.W, i); it; ++it) {
      ASSERT_TRUE(std::isfinite(it.value())) << "row " << i;
      ASSERT_GE(it.value(), 0) << "row " << i;
      sum += it.value();
    }
    ASSERT_NEAR(sum, 1, 1e-9) << "row " << i;
  }
  EXPECT_EQ(result.report.rows, result.weights.W.rows());
  EXPECT_LT(result.report.row_sum_error, 1e-9);
  EXPECT_EQ(result.report.negative, 0);
  EXPECT_EQ(result.report.non_finite, 0);
}

inline BindResult bound(const Character& c, const BindOptions& options = quick()) {
  BindResult result = bind(c, options);
  expect_valid(result, c);
  return result;
}

inline double tv(const SkinWeights& a, const SkinWeights& b) { return compare(a, b).mean; }

/// The rows [begin, end).
inline SkinWeights rows_of(const SkinWeights& weights, Eigen::Index begin, Eigen::Index end) {
  return {SparseRows(weights.W.middleRows(begin, end - begin)), weights.names};
}

/// A bar along x from 0 to 1 of width 0.2, and bones of equal length end to end in it.
inline Mesh bar() { return fine_box({0, 0, 0}, {1, 0.2, 0.2}, {20, 4, 4}); }
inline std::vector<Handle> bar_bones(int count = 3) {
  std::vector<Handle> bones;
  const double step = 0.9 / count;
  for (int b = 0; b < count; ++b)
    bones.push_back(bone({0.05 + b * step, 0.1, 0.1}, {0.05 + (b + 1) * step, 0.1, 0.1}));
  return bones;
}

/// Three bones end to end from 0 to 1.
inline std::vector<Handle> three_along_x(double y = 0, double z = 0) {
  return {bone({0.02, y, z}, {0.33, y, z}), bone({0.33, y, z}, {0.67, y, z}),
          bone({0.67, y, z}, {0.98, y, z})};
}

/// A strip in the plane z = 0.
inline Mesh flat_strip() {
  Mesh mesh;
  const int n = 20;
  mesh.V.resize(2 * (n + 1), 3);
  mesh.F.resize(2 * n, 3);
  for (int i = 0; i <= n; ++i) {
    mesh.V.row(2 * i) << i / 20.0, -0.1, 0;
    mesh.V.row(2 * i + 1) << i / 20.0, 0.1, 0;
  }
  for (int i = 0; i < n; ++i) {
    mesh.F.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    mesh.F.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  return mesh;
}

/// Four bones around a circle of radius 1.
inline std::vector<Handle> ring_of_bones() {
  std::vector<Handle> ring;
  for (int k = 0; k < 4; ++k) {
    const double a = k * std::numbers::pi / 2, b = a + 0.9 * std::numbers::pi / 2;
    ring.push_back(bone({std::cos(a), std::sin(a), 0}, {std::cos(b), std::sin(b), 0}));
  }
  return ring;
}

}  // namespace skinfield_test
