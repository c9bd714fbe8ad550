// A leopard gecko: one closed surface around 41 joints, with four thin toes a foot.
#include "sample/polygonise.h"
#include "sample/rig_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace skinfield::sample_detail {
namespace {

constexpr double turn = 2 * std::numbers::pi;

struct SpineJoint {
  const char* name;
  const char* parent;
  Vec3 position;
};

const std::array<SpineJoint, 13>& spine() {
  static const std::array<SpineJoint, 13> joints = {{
      {"root", "", {0, 0.082, -0.065}},
      {"spine_01", "root", {0, 0.086, -0.010}},
      {"spine_02", "spine_01", {0, 0.088, 0.045}},
      {"spine_03", "spine_02", {0, 0.090, 0.100}},
      {"spine_04", "spine_03", {0, 0.092, 0.155}},
      {"neck", "spine_04", {0, 0.097, 0.205}},
      {"head", "neck", {0, 0.103, 0.250}},
      {"tail_01", "root", {0, 0.076, -0.120}},
      {"tail_02", "tail_01", {0.008, 0.068, -0.175}},
      {"tail_03", "tail_02", {0.024, 0.059, -0.232}},
      {"tail_04", "tail_03", {0.036, 0.049, -0.292}},
      {"tail_05", "tail_04", {0.034, 0.039, -0.350}},
      {"tail_06", "tail_05", {0.014, 0.030, -0.405}},
  }};
  return joints;
}

const Vec3 head_end(0, 0.095, 0.372), tail_end(-0.030, 0.022, -0.462);

constexpr int toes = 4;
constexpr int fewest_faces = 8000;  ///< fewer would lose the toes

/// A left leg; the right one is its mirror image.
struct Leg {
  const char* name;
  const char* parent;
  Vec3 shoulder, elbow, wrist, palm;
  std::array<double, toes> toe_direction;  ///< degrees from forward to the outside
  std::array<double, toes> toe_length;
  double thickness;
};

const std::array<Leg, 2>& legs() {
  static const std::array<Leg, 2> list = {{
      {"leg_front",
       "spine_04",
       {0.040, 0.082, 0.150},
       {0.112, 0.078, 0.128},
       {0.146, 0.028, 0.168},
       {0.154, 0.016, 0.186},
       {-32, 5, 42, 82},
       {0.040, 0.048, 0.048, 0.040},
       1.0},
      {"leg_back",
       "root",
       {0.036, 0.074, -0.070},
       {0.110, 0.076, -0.030},
       {0.148, 0.028, -0.084},
       {0.158, 0.016, -0.068},
       {-18, 20, 58, 100},
       {0.042, 0.052, 0.052, 0.042},
       1.15},
  }};
  return list;
}

Vec3 mirrored(Vec3 x, double side) {
  x.x() *= side;
  return x;
}

struct Toe {
  Vec3 base, tip;
};

Toe toe_of(const Leg& leg, int t, double side) {
  const auto i = static_cast<std::size_t>(t);
  const double angle = leg.toe_direction[i] * turn / 360;
  const Vec3 direction(std::sin(angle), 0, std::cos(angle));
  Toe toe;
  toe.base = mirrored(leg.palm + 0.014 * direction - Vec3(0, 0.002, 0), side);
  toe.tip = mirrored(leg.palm + (0.014 + leg.toe_length[i]) * direction - Vec3(0, 0.006, 0), side);
  return toe;
}

std::string leg_name(const Leg& leg, double side) {
  return std::string(leg.name) + (side > 0 ? "_left" : "_right");
}

Skeleton make_rig() {
  RigBuilder rig;
  for (const SpineJoint& joint : spine()) rig.joint(joint.name, joint.parent, joint.position);
  rig.tail("head", head_end);
  const Vec3& last = spine().back().position;
  rig.tail("tail_06", last + 0.88 * (tail_end - last));
  for (const Leg& leg : legs()) {
    for (const double side : {1.0, -1.0}) {
      const std::string name = leg_name(leg, side);
      rig.joint(name + "_upper", leg.parent, mirrored(leg.shoulder, side));
      rig.joint(name + "_lower", name + "_upper", mirrored(leg.elbow, side));
      rig.joint(name + "_foot", name + "_lower", mirrored(leg.wrist, side));
      for (int t = 0; t < toes; ++t) {
        const Toe toe = toe_of(leg, t, side);
        const std::string joint = name + "_toe_" + std::to_string(t + 1);
        rig.joint(joint, name + "_foot", toe.base);
        rig.tail(joint, toe.base + 0.8 * (toe.tip - toe.base));
      }
    }
  }
  return rig.finish();
}

const Vec3 left_eye(0.036, 0.122, 0.296);
constexpr double eye_radius = 0.0165;

ImplicitShape make_shape() {
  ImplicitShape shape;
  // Trunk.
  shape.ellipsoid({0, 0.080, -0.068}, {0.043, 0.037, 0.075}, 0.01);
  shape.ellipsoid({0, 0.081, 0.005}, {0.054, 0.043, 0.080}, 0.03);
  shape.ellipsoid({0, 0.082, 0.070}, {0.056, 0.045, 0.080}, 0.03);
  shape.ellipsoid({0, 0.087, 0.140}, {0.049, 0.041, 0.070}, 0.03);
  shape.capsule({0, 0.092, 0.170}, 0.034, {0, 0.100, 0.250}, 0.030, 0.03);
  // Head: skull, cheeks, snout, chin.
  shape.ellipsoid({0, 0.103, 0.278}, {0.050, 0.034, 0.048}, 0.025);
  shape.ellipsoid({0, 0.096, 0.328}, {0.034, 0.026, 0.058}, 0.025);
  shape.ellipsoid({0, 0.086, 0.305}, {0.040, 0.018, 0.060}, 0.020);
  // Tail: thick in the middle, where a gecko keeps its fat.
  const std::array<double, 7> radius = {0.029, 0.032, 0.034, 0.029, 0.021, 0.013, 0.007};
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3& from = spine()[7 + i].position;
    const Vec3& to = i < 5 ? spine()[8 + i].position : tail_end;
    shape.capsule(from, radius[i], to, radius[i + 1], i == 0 ? 0.03 : 0.004);
  }
  for (const Leg& leg : legs()) {
    for (const double side : {1.0, -1.0}) {
      const double r = leg.thickness;
      const Vec3 shoulder = mirrored(leg.shoulder, side), elbow = mirrored(leg.elbow, side);
      const Vec3 wrist = mirrored(leg.wrist, side), palm = mirrored(leg.palm, side);
      shape.capsule(shoulder, 0.023 * r, elbow, 0.0165 * r, 0.024);
      shape.capsule(elbow, 0.0165 * r, wrist, 0.0115 * r, 0.004);
      shape.capsule(wrist, 0.0118 * r, palm, 0.0125 * r, 0.005);
      shape.ellipsoid(palm, Vec3(0.019, 0.011, 0.019) * r, 0.010);
      for (int t = 0; t < toes; ++t) {
        const Toe toe = toe_of(leg, t, side);
        shape.capsule(toe.base, 0.0074, toe.tip, 0.0062, 0.006);
        shape.ellipsoid(toe.tip, {0.0096, 0.0068, 0.0096}, 0.004);
      }
    }
  }
  for (const double side : {1.0, -1.0}) {
    const Vec3 eye = mirrored(left_eye, side);
    shape.ellipsoid(eye - Vec3(0.004 * side, 0, 0), Vec3::Constant(1.15 * eye_radius), 0.012);
    shape.ellipsoid(eye, Vec3::Constant(eye_radius), 0.002);
  }
  return shape;
}

/// A wave-like pattern without a lattice's regularity, about -1..1.
double mottle(const Vec3& x) {
  const double a = std::sin(170 * x.z() + 1.7 * std::sin(120 * x.x() + 0.9));
  const double b = std::sin(150 * x.x() + 1.9 * std::sin(97 * x.z() + 30 * x.y()) + 0.6);
  return 0.5 * (a + b);
}

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Sand-yellow with brown spots, pale below, a banded tail, dark eyes.
Vec3 skin_colour(const Vec3& x) {
  const Vec3 sand(0.80, 0.47, 0.10), brown(0.14, 0.06, 0.025), pale(0.86, 0.74, 0.52);
  const double on_tail = smooth_step(-0.10, -0.15, x.z());
  const double bands = smooth_step(-0.1, 0.35, std::sin(105 * x.z() + 0.8));
  const double spots = smooth_step(0.22, 0.55, mottle(x));
  const double reach = std::abs(x.x());
  const double trunk = 1 - smooth_step(0.10, 0.15, reach);
  const double dark = (1 - on_tail) * spots * (0.45 + 0.55 * trunk) + on_tail * 0.9 * bands;
  const double top =
      smooth_step(0.045, 0.085, x.y() + 0.045 * on_tail + 0.06 * smooth_step(0.06, 0.10, reach));
  Vec3 colour = pale + top * (sand + dark * (brown - sand) - pale);
  for (const double side : {1.0, -1.0}) {
    const Vec3 eye = mirrored(left_eye, side);
    const double d = (x - eye - Vec3(0.006 * side, 0.002, 0.002)).norm();
    colour += smooth_step(0.0148, 0.0128, d) * (Vec3(0.012, 0.010, 0.012) - colour);
  }
  return colour;
}

const Vec3 x_axis = Vec3::UnitX(), y_axis = Vec3::UnitY(), z_axis = Vec3::UnitZ();

SamplePose show_pose(const Skeleton& skeleton) {
  PoseBuilder pose(skeleton);
  const std::array<const char*, 4> back = {"spine_01", "spine_02", "spine_03", "spine_04"};
  for (const char* joint : back) pose.turn(joint, y_axis, 9);
  pose.turn("neck", y_axis, -16).turn("neck", x_axis, -14);
  pose.turn("head", y_axis, -20).turn("head", x_axis, -10);
  for (int i = 1; i <= 6; ++i) {
    pose.turn("tail_0" + std::to_string(i), y_axis, 4.0 + 7.0 * i);
    pose.turn("tail_0" + std::to_string(i), x_axis, 5.0);
  }
  pose.turn("leg_front_left_upper", z_axis, 34).turn("leg_front_left_upper", y_axis, -30);
  pose.turn("leg_front_left_lower", z_axis, 38).turn("leg_front_left_foot", x_axis, -22);
  for (int t = 1; t <= toes; ++t) {
    const std::string toe = "leg_front_left_toe_" + std::to_string(t);
    pose.turn(toe, y_axis, 12.0 * (t - 2.5)).turn(toe, z_axis, 25);
  }
  pose.turn("leg_front_right_upper", y_axis, -14).turn("leg_front_right_lower", y_axis, 20);
  pose.turn("leg_back_left_upper", y_axis, 26).turn("leg_back_left_lower", y_axis, -10);
  pose.turn("leg_back_right_upper", y_axis, 24).turn("leg_back_right_lower", y_axis, -22);
  return pose.finish();
}

/// Diagonal legs swing together; the trunk bends toward the leg in front.
SamplePose walk(const Skeleton& skeleton, double phase) {
  PoseBuilder pose(skeleton);
  const auto wave = [&](double shift) { return std::sin(turn * (phase - shift)); };
  for (int i = 1; i <= 4; ++i) {
    pose.turn("spine_0" + std::to_string(i), y_axis, 6 * wave(0.08 * i));
  }
  pose.turn("neck", y_axis, -7 * wave(0.30)).turn("head", y_axis, -8 * wave(0.36));
  for (int i = 1; i <= 6; ++i) {
    pose.turn("tail_0" + std::to_string(i), y_axis, -(5 + 1.6 * i) * wave(0.10 * i));
  }
  for (const Leg& leg : legs()) {
    for (const double side : {1.0, -1.0}) {
      const bool front = leg.shoulder.z() > 0;
      const double shift = front == (side > 0) ? 0.0 : 0.5;
      const std::string name = leg_name(leg, side);
      const double lift = std::max(0.0, wave(shift - 0.25));  // while the leg comes forward
      pose.turn(name + "_upper", y_axis, -side * 22 * wave(shift));
      pose.turn(name + "_upper", z_axis, side * 20 * lift);
      pose.turn(name + "_lower", y_axis, side * (front ? 16 : -16) * wave(shift));
      pose.turn(name + "_foot", y_axis, side * 10 * wave(shift));
      for (int t = 1; t <= toes; ++t) {
        pose.turn(name + "_toe_" + std::to_string(t), z_axis, -side * 22 * lift);
      }
    }
  }
  const double bob = 0.004 * std::cos(2 * turn * phase);
  return pose.move_root({0.006 * wave(0.1), bob, 0}).finish();
}

}  // namespace

SampleCharacter make_gecko(int resolution, const Progress& progress) {
  SampleCharacter gecko;
  gecko.name = "gecko";
  gecko.skeleton = make_rig();
  // Faces times step squared, measured at 16,000 faces.
  constexpr double faces_step_squared = 0.888;
  const double step = std::sqrt(faces_step_squared / std::max(resolution, fewest_faces));
  gecko.mesh = polygonise(make_shape(), step, 0.012, 1.8, progress);
  gecko.colours.resize(gecko.mesh.V.rows(), 3);
  for (Eigen::Index v = 0; v < gecko.mesh.V.rows(); ++v) {
    gecko.colours.row(v) = skin_colour(gecko.mesh.V.row(v)).transpose();
  }
  gecko.parts = {{"gecko", 0, static_cast<int>(gecko.mesh.F.rows()), Vec3::Ones()}};
  gecko.demo_pose = show_pose(gecko.skeleton);
  gecko.animation =
      make_loop("walk", 2.0, 24, [&](double phase) { return walk(gecko.skeleton, phase); });
  return gecko;
}

}  // namespace skinfield::sample_detail
