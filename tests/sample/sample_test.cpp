#include "skinfield/sample/sample.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/winding_number.h"
#include "skinfield/io/gltf_animation.h"
#include "skinfield/rig/handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace skinfield {
namespace {

SampleCharacter fresh(std::string_view name, std::uint64_t seed = 0) {
  SampleOptions options;
  options.resolution = 8000;
  options.seed = seed;
  return make_sample(name, options);
}

/// Made once for all tests.
const SampleCharacter& small(std::string_view name) {
  static std::map<std::string, SampleCharacter, std::less<>> made;
  const auto found = made.find(name);
  if (found != made.end()) return found->second;
  return made.emplace(std::string(name), fresh(name)).first->second;
}

/// Directed edges that do not have exactly one partner in the other direction.
int unpaired_edges(const Triangles& F) {
  std::map<std::pair<int, int>, int> uses;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) ++uses[{F(f, c), F(f, (c + 1) % 3)}];
  }
  return static_cast<int>(std::count_if(uses.begin(), uses.end(), [&](const auto& edge) {
    const auto partner = uses.find({edge.first.second, edge.first.first});
    return edge.second != 1 || partner == uses.end();
  }));
}

double smallest_angle(const Points& V, const Triangles& F) {
  double smallest = 10;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 a = V.row(F(f, c)), b = V.row(F(f, (c + 1) % 3)), d = V.row(F(f, (c + 2) % 3));
      smallest = std::min(smallest, std::atan2((b - a).cross(d - a).norm(), (b - a).dot(d - a)));
    }
  }
  return smallest * 57.29577951;
}

TEST(Gecko, IsOneClosedManifoldSphere) {
  const SampleCharacter& gecko = small("gecko");
  const Mesh& mesh = gecko.mesh;
  EXPECT_EQ(unpaired_edges(mesh.F), 0);
  EXPECT_EQ(connected_components(mesh.F, mesh.V.rows()).count, 1);
  EXPECT_EQ(2 * mesh.V.rows() - mesh.F.rows(), 4);  // Euler characteristic 2: no tunnels
  EXPECT_GT(smallest_angle(mesh.V, mesh.F), 1.0);
  EXPECT_NEAR(static_cast<double>(mesh.F.rows()), 8000, 1600);
}

TEST(Gecko, HoldsItsBonesInside) {
  const SampleCharacter& gecko = small("gecko");
  EXPECT_GE(gecko.skeleton.handles.size(), 30u);
  EXPECT_LE(gecko.skeleton.handles.size(), 45u);
  for (const Joint& joint : gecko.skeleton.joints) {
    EXPECT_NEAR(winding_number_direct(gecko.mesh.V, gecko.mesh.F, joint.position), 1, 1e-6)
        << joint.name;
    for (const JointTip& tip : joint.tips) {
      EXPECT_NEAR(winding_number_direct(gecko.mesh.V, gecko.mesh.F, tip.position), 1, 1e-6)
          << tip.name;
    }
  }
  EXPECT_NEAR(winding_number_direct(gecko.mesh.V, gecko.mesh.F, Vec3(0, 1, 0)), 0, 1e-6);
}

TEST(Gecko, HasFourSeparateToesAFoot) {
  const SampleCharacter& gecko = small("gecko");
  int toes = 0;
  std::vector<Vec3> tips;
  for (const Joint& joint : gecko.skeleton.joints) {
    if (joint.name.find("_toe_") == std::string::npos) continue;
    ++toes;
    ASSERT_EQ(joint.tips.size(), 1u);
    tips.push_back(joint.tips.front().position);
  }
  EXPECT_EQ(toes, 16);
  // Between the tips of two toes of a foot there is air.
  for (std::size_t i = 0; i + 1 < tips.size(); ++i) {
    if (i % 4 == 3) continue;
    const Vec3 between = 0.5 * (tips[i] + tips[i + 1]);
    EXPECT_LT(std::abs(winding_number_direct(gecko.mesh.V, gecko.mesh.F, between)), 1e-6) << i;
  }
}

TEST(Robot, IsMadeOfClosedPartsThatOverlapAndFloat) {
  const SampleCharacter& robot = small("robot");
  EXPECT_GE(robot.parts.size(), 20u);
  EXPECT_LE(robot.parts.size(), 30u);
  EXPECT_EQ(unpaired_edges(robot.mesh.F), 0);
  EXPECT_EQ(connected_components(robot.mesh.F, robot.mesh.V.rows()).count,
            static_cast<int>(robot.parts.size()));
  std::vector<Triangles> faces;
  int next = 0;
  for (const SamplePart& part : robot.parts) {
    EXPECT_EQ(part.face_begin, next);
    next = part.face_end;
    faces.push_back(robot.mesh.F.middleRows(part.face_begin, part.face_end - part.face_begin));
  }
  EXPECT_EQ(next, robot.mesh.F.rows());
  int overlapping = 0, alone = 0;
  for (std::size_t a = 0; a < faces.size(); ++a) {
    std::set<std::size_t> met;
    for (std::size_t b = 0; b < faces.size(); ++b) {
      const WindingNumber inside(robot.mesh.V, faces[b]);
      for (Eigen::Index f = 0; f < faces[a].rows(); f += 3) {
        if (a != b && inside.at(Vec3(robot.mesh.V.row(faces[a](f, 0)))) > 0.5) met.insert(b);
      }
    }
    overlapping += static_cast<int>(met.size());
    if (met.empty()) ++alone;
  }
  EXPECT_GE(overlapping, 20);  // ordered pairs with a vertex of the one in the other
  EXPECT_GE(alone, 4);         // these hold no vertex in any other part
}

TEST(Robot, EveryPartIsOrientedOutward) {
  const SampleCharacter& robot = small("robot");
  for (const SamplePart& part : robot.parts) {
    double volume = 0;
    for (int f = part.face_begin; f < part.face_end; ++f) {
      const Vec3 a = robot.mesh.V.row(robot.mesh.F(f, 0)), b = robot.mesh.V.row(robot.mesh.F(f, 1)),
                 c = robot.mesh.V.row(robot.mesh.F(f, 2));
      volume += a.dot(b.cross(c)) / 6;
    }
    EXPECT_GT(volume, 0) << part.name;
  }
  for (const Joint& joint : robot.skeleton.joints) {
    EXPECT_GT(winding_number_direct(robot.mesh.V, robot.mesh.F, joint.position), 0.99)
        << joint.name;
  }
}

TEST(Scan, LosesThirtyPercentOfTheFacesAndTearsTheRest) {
  const SampleCharacter &gecko = small("gecko"), &scan = small("scan");
  const auto faces = static_cast<std::size_t>(gecko.mesh.F.rows());
  EXPECT_EQ(static_cast<std::size_t>(scan.mesh.F.rows()), faces - faces * 3 / 10);
  EXPECT_EQ(scan.mesh.V.rows(), 3 * scan.mesh.F.rows());
  EXPECT_EQ(weld(scan.mesh.V).V.rows(), scan.mesh.V.rows());
  EXPECT_NE(fresh("scan", 1).mesh.V, scan.mesh.V);
  const Box3 a = bounding_box(gecko.mesh.V), b = bounding_box(scan.mesh.V);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 0.05 * diagonal(a));
}

TEST(Sample, IsTheSameAtAnyThreadCount) {
  const SampleCharacter& many = small("scan");
  const ThreadLimit one(1);
  const SampleCharacter single = fresh("scan");
  EXPECT_EQ(many.mesh.V, single.mesh.V);
  EXPECT_EQ(many.mesh.F, single.mesh.F);
  EXPECT_EQ(sample_glb(many), sample_glb(single));
}

TEST(Sample, PosesKeepBoneLengthsAndTheRestPoseIsTheIdentity) {
  for (const std::string_view name : {"gecko", "robot"}) {
    const SampleCharacter& sample = small(name);
    SamplePose rest = sample.demo_pose;
    std::fill(rest.rotation.begin(), rest.rotation.end(), Eigen::Quaterniond::Identity());
    for (const Transform& T : sample_transforms(sample.skeleton, rest)) {
      EXPECT_LT((T - Transform::Identity()).norm(), 1e-12);
    }
    const std::vector<Transform> posed = sample_transforms(sample.skeleton, sample.demo_pose);
    double largest = 0;
    for (std::size_t j = 0; j < posed.size(); ++j) {
      const Eigen::Matrix3d R = posed[j].topLeftCorner<3, 3>();
      EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-9);
      largest = std::max(largest, (posed[j] - Transform::Identity()).norm());
      // A joint is where its parent takes it: bones stay connected.
      const Joint& joint = sample.skeleton.joints[j];
      if (joint.parent < 0) continue;
      const auto p = static_cast<std::size_t>(joint.parent);
      EXPECT_LT(((posed[j] - posed[p]) * joint.position.homogeneous()).norm(), 1e-9) << joint.name;
    }
    EXPECT_GT(largest, 0.5);
  }
}

TEST(Sample, AnimationIsAMovingLoop) {
  for (const std::string_view name : sample_names()) {
    const SampleCharacter& sample = small(name);
    const SampleAnimation& animation = sample.animation;
    ASSERT_EQ(animation.time.size(), animation.key.size());
    EXPECT_EQ(animation.time.front(), 0);
    EXPECT_GE(animation.time.back(), 1.5);
    EXPECT_TRUE(std::is_sorted(animation.time.begin(), animation.time.end()));
    double moved = 0;
    for (std::size_t j = 0; j < sample.skeleton.joints.size(); ++j) {
      const auto angle = [&](std::size_t k) {
        return animation.key.front().rotation[j].angularDistance(animation.key[k].rotation[j]);
      };
      EXPECT_LT(angle(animation.key.size() - 1), 1e-7);
      moved = std::max(moved, angle(animation.key.size() / 3));
    }
    EXPECT_GT(moved, 0.1);
  }
}

TEST(Sample, EveryHandleOwnsAVertexInThePlaceholder) {
  for (const std::string_view name : sample_names()) {
    const SampleCharacter& sample = small(name);
    const std::vector<int> owner = nearest_handle(sample.mesh.V, sample.skeleton);
    EXPECT_EQ(std::set<int>(owner.begin(), owner.end()).size(), sample.skeleton.handles.size())
        << name;
  }
}

TEST(Sample, GlbHasTheContainersLengths) {
  const std::vector<std::uint8_t> glb = sample_glb(small("robot"));
  const auto word = [&](std::size_t at) {
    return static_cast<std::size_t>(glb[at]) | static_cast<std::size_t>(glb[at + 1]) << 8 |
           static_cast<std::size_t>(glb[at + 2]) << 16 |
           static_cast<std::size_t>(glb[at + 3]) << 24;
  };
  ASSERT_GT(glb.size(), 28u);
  EXPECT_EQ(word(0), 0x46546C67u);
  EXPECT_EQ(word(8), glb.size());
  EXPECT_EQ(word(12) + word(20 + word(12)) + 28, glb.size());
}

TEST(Sample, GlbReadsBackAsTheSameCharacter) {
  for (const std::string_view name : sample_names()) {
    const SampleCharacter& sample = small(name);
    Asset asset = sample_asset(sample);
    ASSERT_EQ(asset.characters.size(), 1u);
    Character& read = asset.characters.front();
    EXPECT_TRUE(asset.warnings.empty());
    EXPECT_EQ(read.mesh.F.rows(), sample.mesh.F.rows());
    EXPECT_EQ(static_cast<Eigen::Index>(read.vertex_of_input.size()), sample.mesh.V.rows());
    EXPECT_EQ(read.parts.size(), sample.parts.size());
    EXPECT_LT((bounding_box(read.mesh.V) - bounding_box(sample.mesh.V)).norm(), 1e-6);

    // The placeholder's weights name every joint, so that rig's rules find the very same bones.
    ASSERT_TRUE(read.weights.has_value());
    std::vector<bool> used(sample.skeleton.joints.size(), false);
    for (Eigen::Index v = 0; v < read.weights->W.rows(); ++v) {
      for (SparseRows::InnerIterator it(read.weights->W, v); it; ++it) {
        if (it.value() > 0) used[static_cast<std::size_t>(it.col())] = true;
      }
    }
    make_joint_handles(read.skeleton, {}, used);
    ASSERT_EQ(read.skeleton.handles.size(), sample.skeleton.handles.size());
    for (std::size_t h = 0; h < read.skeleton.handles.size(); ++h) {
      const Handle &a = read.skeleton.handles[h], &b = sample.skeleton.handles[h];
      EXPECT_EQ(a.name, b.name);
      ASSERT_EQ(a.segments.size(), b.segments.size()) << b.name;
      for (std::size_t s = 0; s < a.segments.size(); ++s) {
        EXPECT_LT((a.segments[s].first - b.segments[s].first).norm(), 1e-6) << b.name;
        EXPECT_LT((a.segments[s].second - b.segments[s].second).norm(), 1e-6) << b.name;
      }
    }
    // Both ways of posing agree.
    const std::vector<Transform> ours = sample_transforms(sample.skeleton, sample.demo_pose);
    const std::vector<Transform> theirs =
        column_transforms(read.skeleton, to_pose(sample.demo_pose));
    ASSERT_EQ(ours.size(), theirs.size());
    for (std::size_t j = 0; j < ours.size(); ++j) EXPECT_LT((ours[j] - theirs[j]).norm(), 1e-5);
  }
}

TEST(Sample, AnimationReadsBackAndLoops) {
  const SampleCharacter& sample = small("gecko");
  const Asset asset = sample_asset(sample);
  const std::vector<GltfAnimation> animations = gltf_animations(asset);
  ASSERT_EQ(animations.size(), 1u);
  EXPECT_NEAR(animations[0].end, sample.animation.time.back(), 1e-6);
  for (const std::size_t key : {std::size_t{0}, std::size_t{7}}) {
    const std::vector<Transform> ours =
        sample_transforms(sample.skeleton, sample.animation.key[key]);
    const std::vector<Transform> theirs =
        joint_skinning_transforms(asset, 0, &animations[0], sample.animation.time[key]);
    ASSERT_EQ(ours.size(), theirs.size());
    for (std::size_t j = 0; j < ours.size(); ++j) EXPECT_LT((ours[j] - theirs[j]).norm(), 1e-4);
  }
}

TEST(Sample, RefusesWhatItCannotMake) {
  EXPECT_THROW(make_sample("dragon"), InputError);
  EXPECT_THROW(make_sample("gecko", {.resolution = 10, .seed = 0, .progress = {}}), InputError);
  SampleOptions stopped;
  stopped.progress.cancelled = [] { return true; };
  EXPECT_THROW(make_sample("gecko", stopped), Cancelled);
}

}  // namespace
}  // namespace skinfield
