// What must not change bind's answer: units, place, order of vertices, threads (design.md 9).
#include "bind/fixtures.h"
#include "skinfield/base/parallel.h"
#include "skinfield/bind/handles.h"
#include "skinfield/sample/sample.h"

#include <cstring>
#include <numeric>

namespace skinfield {
namespace {

using namespace skinfield_test;

Character sample_character(std::string_view name) {
  SampleOptions options;
  options.resolution = 8000;
  Asset asset = sample_asset(make_sample(name, options));
  make_handles(asset.characters.at(0));
  return asset.characters.at(0);
}

const Character& gecko() {
  static const Character c = sample_character("gecko");
  return c;
}

/// Fewer than bind's own 16,000, so that tests can afford them: rotations cost 0.017 at 3,000 nodes
/// and 0.008 at 16,000.
constexpr int nodes = 4000;

const BindResult& gecko_result() {
  static const BindResult result = bound(gecko(), quick(nodes));
  return result;
}

/// The character with every position x -> A x + b.
Character transformed(Character c, const Eigen::Matrix3d& A, const Vec3& b) {
  const auto map = [&](const Vec3& x) { return Vec3(A * x + b); };
  c.mesh.V = ((c.mesh.V * A.transpose()).rowwise() + b.transpose()).eval();
  for (Handle& handle : c.skeleton.handles) {
    handle.point = map(handle.point);
    for (auto& [p, q] : handle.segments) p = map(p), q = map(q);
  }
  return c;
}

TEST(Invariance, ScaleAndPlaceChangeNothing) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for (double scale : {0.01, 100.0}) {
    const BindResult result = bound(transformed(gecko(), scale * I, Vec3::Zero()), quick(nodes));
    EXPECT_LE(tv(result.weights, gecko_result().weights), 1e-3) << "scale " << scale;
  }
  const BindResult result = bound(transformed(gecko(), I, {3, -7, 11}), quick(nodes));
  EXPECT_LE(tv(result.weights, gecko_result().weights), 1e-3);
}

TEST(Invariance, TheOrderOfVerticesAndFacesChangesNothing) {
  Character c = gecko();
  const auto n = static_cast<std::size_t>(c.mesh.V.rows());
  std::vector<int> place(n);  // of each old vertex
  std::iota(place.begin(), place.end(), 0);
  Random random(5);
  for (std::size_t i = n - 1; i > 0; --i)
    std::swap(place[i], place[random.below(static_cast<std::uint32_t>(i + 1))]);
  for (std::size_t v = 0; v < n; ++v)
    c.mesh.V.row(place[v]) = gecko().mesh.V.row(static_cast<Eigen::Index>(v));
  for (Eigen::Index k = 0; k < c.mesh.F.size(); ++k)
    c.mesh.F.data()[k] = place[static_cast<std::size_t>(c.mesh.F.data()[k])];
  c.mesh.F = c.mesh.F.colwise().reverse().eval();
  for (int& v : c.vertex_of_input) v = place[static_cast<std::size_t>(v)];
  const BindResult result = bound(c, quick(nodes));
  EXPECT_LE(tv(result.weights, gecko_result().weights), 1e-3);
}

TEST(Invariance, RotationsChangeLittle) {
  for (double angle : {0.3, 1.1, std::numbers::pi / 2}) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(angle, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
    const BindResult result = bound(transformed(gecko(), R, Vec3::Zero()), quick(nodes));
    EXPECT_LE(tv(result.weights, gecko_result().weights), 0.02) << "angle " << angle;
  }
}

TEST(Invariance, SameBytesForOneAndTwoThreadsAndTwoRuns) {
  for (const char* name : {"gecko", "robot", "scan"}) {
    const Character c = sample_character(name);
    SparseRows W[3];
    for (int run = 0; run < 3; ++run) {
      const ThreadLimit limit(run == 1 ? 2 : 1);
      BindOptions options = quick(1500);
      options.max_influences = 4;
      W[run] = bound(c, options).weights.W;
      W[run].makeCompressed();
    }
    for (int run = 1; run < 3; ++run) {
      ASSERT_EQ(W[run].nonZeros(), W[0].nonZeros()) << name;
      const auto count = static_cast<std::size_t>(W[0].nonZeros());
      EXPECT_EQ(std::memcmp(W[run].valuePtr(), W[0].valuePtr(), count * sizeof(double)), 0) << name;
      EXPECT_EQ(std::memcmp(W[run].innerIndexPtr(), W[0].innerIndexPtr(), count * sizeof(int)), 0)
          << name;
    }
  }
}

}  // namespace
}  // namespace skinfield
