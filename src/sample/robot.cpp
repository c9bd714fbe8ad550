// A walking robot from closed parts that overlap where they join; shoulder pads, antenna ball,
// backpack and feet float. Surface methods such as bone heat find no way from part to part.
#include "sample/rig_builder.h"
#include "sample/solids.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield::sample_detail {
namespace {

const Vec3 x_axis = Vec3::UnitX(), y_axis = Vec3::UnitY(), z_axis = Vec3::UnitZ();
const Vec3 blue(0.055, 0.20, 0.42), white(0.72, 0.74, 0.76), dark(0.055, 0.06, 0.075),
    orange(0.85, 0.26, 0.03), glow(0.15, 0.75, 0.80);

Skeleton make_rig() {
  RigBuilder rig;
  rig.joint("root", "", {0, 0.92, 0});
  rig.joint("spine", "root", {0, 1.04, 0});
  rig.joint("chest", "spine", {0, 1.17, 0});
  rig.joint("neck", "chest", {0, 1.42, 0});
  rig.joint("head", "neck", {0, 1.52, 0});
  rig.joint("antenna", "head", {0.09, 1.76, -0.02});
  rig.tail("antenna", {0.105, 1.90, -0.03});
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    rig.joint("arm_upper" + end, "chest", {0.25 * side, 1.35, 0});
    rig.joint("arm_lower" + end, "arm_upper" + end, {0.31 * side, 1.09, 0});
    rig.joint("hand" + end, "arm_lower" + end, {0.34 * side, 0.83, 0.03});
    rig.tail("hand" + end, {0.345 * side, 0.71, 0.05});
  }
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    rig.joint("leg_upper" + end, "root", {0.11 * side, 0.87, 0});
    rig.joint("leg_lower" + end, "leg_upper" + end, {0.12 * side, 0.49, 0.01});
    rig.joint("foot" + end, "leg_lower" + end, {0.12 * side, 0.09, -0.02});
    rig.tail("foot" + end, {0.12 * side, 0.05, 0.15});
  }
  return rig.finish();
}

class Assembly {
 public:
  Assembly(SampleCharacter& robot, double edge) : robot_(robot), solids_(edge) {}

  void box(const std::string& name, const Vec3& centre, const Vec3& size, double radius,
           const Vec3& colour) {
    solids_.rounded_box(centre, 0.5 * size, radius);
    close(name, colour);
  }
  void ball(const std::string& name, const Vec3& centre, double radius, const Vec3& colour) {
    box(name, centre, Vec3::Constant(2 * radius), radius, colour);
  }
  void cylinder(const std::string& name, const Vec3& a, double radius_a, const Vec3& b,
                double radius_b, const Vec3& colour) {
    solids_.cylinder(a, radius_a, b, radius_b, 0.25 * std::min(radius_a, radius_b));
    close(name, colour);
  }
  void finish() {
    robot_.mesh = solids_.finish();
    robot_.colours.resize(robot_.mesh.V.rows(), 3);
    for (const SamplePart& part : robot_.parts) {
      for (int f = part.face_begin; f < part.face_end; ++f) {
        for (int c = 0; c < 3; ++c) {
          robot_.colours.row(robot_.mesh.F(f, c)) = part.colour.transpose();
        }
      }
    }
  }

 private:
  void close(const std::string& name, const Vec3& colour) {
    robot_.parts.push_back({name, begin_, solids_.faces(), colour});
    begin_ = solids_.faces();
  }

  SampleCharacter& robot_;
  SolidBuilder solids_;
  int begin_ = 0;
};

void build(Assembly& parts) {
  parts.box("pelvis", {0, 0.92, 0}, {0.34, 0.15, 0.22}, 0.045, blue);
  parts.cylinder("waist", {0, 0.95, 0}, 0.095, {0, 1.16, 0}, 0.085, dark);
  parts.box("torso", {0, 1.26, 0}, {0.44, 0.30, 0.27}, 0.07, white);
  parts.box("core", {0, 1.28, 0.125}, {0.15, 0.12, 0.06}, 0.028, glow);
  parts.cylinder("neck", {0, 1.38, 0}, 0.055, {0, 1.53, 0}, 0.05, dark);
  parts.box("skull", {0, 1.63, 0}, {0.31, 0.25, 0.27}, 0.09, white);
  parts.box("visor", {0, 1.64, 0.105}, {0.24, 0.09, 0.09}, 0.04, glow);
  parts.cylinder("antenna", {0.088, 1.735, -0.02}, 0.013, {0.1, 1.86, -0.027}, 0.010, dark);
  parts.ball("antenna_ball", {0.105, 1.91, -0.03}, 0.032, orange);
  parts.box("backpack", {0, 1.27, -0.225}, {0.28, 0.24, 0.13}, 0.05, blue);
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    const auto at = [&](double x, double y, double z) { return Vec3(x * side, y, z); };
    parts.ball("shoulder" + end, at(0.25, 1.35, 0), 0.085, dark);
    parts.box("pad" + end, at(0.285, 1.475, 0), {0.17, 0.05, 0.20}, 0.024, orange);
    parts.cylinder("arm_upper" + end, at(0.258, 1.32, 0), 0.058, at(0.316, 1.06, 0), 0.05, white);
    parts.cylinder("arm_lower" + end, at(0.308, 1.12, -0.003), 0.06, at(0.342, 0.82, 0.03), 0.07,
                   blue);
    parts.box("hand" + end, at(0.345, 0.765, 0.04), {0.085, 0.15, 0.13}, 0.036, dark);
    parts.cylinder("leg_upper" + end, at(0.108, 0.90, 0), 0.085, at(0.12, 0.44, 0.01), 0.07, white);
    parts.box("leg_lower" + end, at(0.12, 0.335, -0.005), {0.16, 0.36, 0.18}, 0.06, blue);
    parts.box("foot" + end, at(0.12, 0.065, 0.045), {0.17, 0.13, 0.33}, 0.05, dark);
  }
  parts.finish();
}

SamplePose show_pose(const Skeleton& skeleton) {
  PoseBuilder pose(skeleton);
  pose.turn("spine", y_axis, 12).turn("chest", y_axis, 10).turn("chest", z_axis, -5);
  pose.turn("neck", z_axis, 8).turn("head", y_axis, -18).turn("head", x_axis, -8);
  pose.turn("antenna", z_axis, -25);
  pose.turn("arm_upper_right", z_axis, -95).turn("arm_upper_right", x_axis, -15);
  pose.turn("arm_lower_right", z_axis, -75).turn("hand_right", z_axis, 20);
  pose.turn("arm_upper_left", x_axis, 30).turn("arm_lower_left", x_axis, -65);
  pose.turn("leg_upper_left", x_axis, -48).turn("leg_lower_left", x_axis, 62);
  pose.turn("foot_left", x_axis, -8);
  pose.turn("leg_upper_right", x_axis, 14).turn("leg_lower_right", x_axis, 10);
  pose.turn("foot_right", x_axis, 12);
  return pose.finish();
}

SamplePose walk(const Skeleton& skeleton, double phase) {
  PoseBuilder pose(skeleton);
  const double angle = 2 * std::numbers::pi * phase;
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    const double swing = side * std::sin(angle);
    const double knee = std::max(0.0, side * std::cos(angle));
    pose.turn("leg_upper" + end, x_axis, -26 * swing - 12 * knee);
    pose.turn("leg_lower" + end, x_axis, 8 + 44 * knee);
    pose.turn("foot" + end, x_axis, 10 * swing - 12 * knee);
    pose.turn("arm_upper" + end, x_axis, 28 * swing);
    pose.turn("arm_lower" + end, x_axis, -22 - 12 * swing * side);
  }
  pose.turn("spine", y_axis, 6 * std::sin(angle)).turn("chest", y_axis, 5 * std::sin(angle));
  pose.turn("head", y_axis, -9 * std::sin(angle)).turn("neck", x_axis, 3 * std::cos(2 * angle));
  pose.turn("antenna", z_axis, 14 * std::sin(2 * angle));
  return pose.move_root({0, 0.015 * std::cos(2 * angle) - 0.015, 0}).finish();
}

}  // namespace

SampleCharacter make_robot(int resolution) {
  SampleCharacter robot;
  robot.name = "robot";
  robot.skeleton = make_rig();
  // Faces times edge length squared, measured at 16,000 faces.
  constexpr double faces_edge_squared = 9.87;
  Assembly parts(robot, std::sqrt(faces_edge_squared / resolution));
  build(parts);
  robot.demo_pose = show_pose(robot.skeleton);
  robot.animation =
      make_loop("walk", 1.6, 24, [&](double phase) { return walk(robot.skeleton, phase); });
  return robot;
}

}  // namespace skinfield::sample_detail
