#include "skinfield/sample/sample.h"

#include "sample/rig_builder.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace skinfield {
namespace {

constexpr std::array<std::string_view, 3> names = {"gecko", "robot", "scan"};
constexpr int default_resolution = 16000;

double squared_distance(const Vec3& x, const Handle& handle) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : handle.segments) {
    const Vec3 axis = b - a;
    const double t = std::clamp((x - a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (x - a - t * axis).squaredNorm());
  }
  return best;
}

}  // namespace

namespace sample_detail {

SampleCharacter make_scan(SampleCharacter gecko, std::uint64_t seed) {
  SampleCharacter scan = std::move(gecko);
  scan.name = "scan";
  const Mesh whole = std::move(scan.mesh);
  const Points colours = std::move(scan.colours);
  const auto faces = static_cast<std::size_t>(whole.F.rows());

  // The faces with the smallest random numbers go, so that their count is exact.
  std::vector<std::uint64_t> lot(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    Random random(seed, 2 * f);
    const std::uint64_t high = random.bits();
    lot[f] = (high << 32) | random.bits();
  }
  std::vector<std::size_t> kept(faces);
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  std::sort(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(lot[a], a) > std::pair(lot[b], b);
  });
  kept.resize(faces - faces * 3 / 10);
  std::sort(kept.begin(), kept.end());

  const auto count = static_cast<Eigen::Index>(kept.size());
  scan.mesh = Mesh{};
  scan.mesh.V.resize(3 * count, 3);
  scan.mesh.F.resize(count, 3);
  scan.colours.resize(3 * count, 3);
  constexpr double tremble = 0.15;  // standard deviation over the face's mean edge
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto f = static_cast<Eigen::Index>(kept[static_cast<std::size_t>(i)]);
    double edge = 0;
    for (int c = 0; c < 3; ++c) {
      edge += (whole.V.row(whole.F(f, c)) - whole.V.row(whole.F(f, (c + 1) % 3))).norm() / 3;
    }
    Random random(seed, 2 * static_cast<std::uint64_t>(f) + 1);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Index v = 3 * i + c;
      for (int d = 0; d < 3; ++d) {
        scan.mesh.V(v, d) = whole.V(whole.F(f, c), d) + tremble * edge * random.normal();
      }
      scan.colours.row(v) = colours.row(whole.F(f, c));
      scan.mesh.F(i, c) = static_cast<std::int32_t>(v);
    }
  }
  scan.parts = {{"scan", 0, static_cast<int>(count), Vec3::Ones()}};
  return scan;
}

}  // namespace sample_detail

std::span<const std::string_view> sample_names() { return names; }

SampleCharacter make_sample(std::string_view name, const SampleOptions& options) {
  const int resolution = options.resolution == 0 ? default_resolution : options.resolution;
  if (resolution < 500 || resolution > 2000000) {
    throw InputError("a resolution of " + std::to_string(resolution) + " triangles", "sample",
                     "choose 500 to 2000000");
  }
  if (name == "gecko") return sample_detail::make_gecko(resolution, options.progress);
  if (name == "robot") return sample_detail::make_robot(resolution);
  if (name == "scan") {
    return sample_detail::make_scan(sample_detail::make_gecko(resolution, options.progress),
                                    options.seed);
  }
  throw InputError("there is no sample named \"" + std::string(name) + "\"", "sample",
                   "choose gecko, robot or scan");
}

std::vector<Transform> sample_transforms(const Skeleton& skeleton, const SamplePose& pose) {
  if (pose.rotation.size() != skeleton.joints.size()) {
    throw InputError("the pose is not made for this skeleton", "sample");
  }
  // Parents come before their children in the samples' skeletons.
  std::vector<Transform> world(skeleton.joints.size()), columns(skeleton.joints.size());
  for (std::size_t j = 0; j < world.size(); ++j) {
    const Joint& joint = skeleton.joints[j];
    Transform local = joint.local_rest;
    local.topLeftCorner<3, 3>() *= pose.rotation[j].toRotationMatrix();
    if (joint.parent < 0) {
      local.topRightCorner<3, 1>() += pose.root_movement;
      world[j] = local;
    } else {
      world[j] = world[static_cast<std::size_t>(joint.parent)] * local;
    }
    columns[j] = world[j] * joint.inverse_bind;
  }
  return columns;
}

Pose to_pose(const SamplePose& pose) {
  Pose result;
  for (const Eigen::Quaterniond& rotation : pose.rotation) {
    JointPose joint;
    joint.rotation = rotation;
    result.joints.push_back(joint);
  }
  if (!result.joints.empty()) result.joints.front().translation = pose.root_movement;
  return result;
}

std::vector<int> nearest_handle(const Points& V, const Skeleton& skeleton) {
  const auto n = static_cast<std::size_t>(V.rows());
  std::vector<int> nearest(n, 0);
  parallel_for(n, 512, [&](std::size_t v) {
    const Vec3 x = V.row(static_cast<Eigen::Index>(v));
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t h = 0; h < skeleton.handles.size(); ++h) {
      const double d = squared_distance(x, skeleton.handles[h]);
      if (d < best) {
        best = d;
        nearest[v] = static_cast<int>(h);
      }
    }
  });
  std::vector<int> count(skeleton.handles.size(), 0);
  for (const int h : nearest) ++count[static_cast<std::size_t>(h)];
  for (std::size_t h = 0; h < count.size(); ++h) {
    if (count[h] > 0) continue;
    // A bone deep inside: the closest vertex that its owner can spare.
    std::size_t chosen = n;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < n; ++v) {
      if (count[static_cast<std::size_t>(nearest[v])] < 2) continue;
      const double d = squared_distance(V.row(static_cast<Eigen::Index>(v)), skeleton.handles[h]);
      if (d < best) {
        best = d;
        chosen = v;
      }
    }
    if (chosen == n) continue;
    --count[static_cast<std::size_t>(nearest[chosen])];
    nearest[chosen] = static_cast<int>(h);
    count[h] = 1;
  }
  return nearest;
}

}  // namespace skinfield
