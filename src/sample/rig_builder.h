// Writing down a joint tree by names, and what the samples' makers are called.
#pragma once

#include "skinfield/sample/sample.h"

#include <map>
#include <string>

namespace skinfield::sample_detail {

class RigBuilder {
 public:
  /// Joints come in the order of these calls; the first one is the root (no parent name).
  void joint(const std::string& name, const std::string& parent, const Vec3& position);
  /// Where a leaf bone ends.
  void tail(const std::string& joint, const Vec3& position);
  /// Columns, handles (a segment to every child, leaves to their tail), rest transforms.
  Skeleton finish() const;

 private:
  Skeleton skeleton_;
  std::map<std::string, int> index_;
};

/// Rotations by joint name, for poses that name what they move.
class PoseBuilder {
 public:
  explicit PoseBuilder(const Skeleton& skeleton);
  /// Turns the joint by degrees around a rest-space axis, after what it was turned before.
  /// Throws InputError for a name that the skeleton does not have.
  PoseBuilder& turn(const std::string& joint, const Vec3& axis, double degrees);
  PoseBuilder& move_root(const Vec3& by);
  SamplePose finish() const { return pose_; }

 private:
  std::map<std::string, std::size_t> index_;
  SamplePose pose_;
};

/// `steps` + 1 keys of a loop; pose(phase) with phase in [0,1).
template <class Pose>
SampleAnimation make_loop(const std::string& name, double seconds, int steps, const Pose& pose) {
  SampleAnimation animation;
  animation.name = name;
  for (int i = 0; i <= steps; ++i) {
    animation.time.push_back(seconds * i / steps);
    animation.key.push_back(pose(static_cast<double>(i % steps) / steps));
  }
  return animation;
}

SampleCharacter make_gecko(int resolution, const Progress& progress);
SampleCharacter make_robot(int resolution);
/// Removes 30% of the faces and gives the rest corners of their own that tremble.
SampleCharacter make_scan(SampleCharacter gecko, std::uint64_t seed);

}  // namespace skinfield::sample_detail
