#include "picturing.h"

#include "posing.h"

#include "skinfield/geometry/plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield::cli {

void add_picture_options(CLI::App& verb, RenderOptions& render) {
  verb.add_option("--width", render.width, "Pixels")
      ->check(number(16, 16384))
      ->capture_default_str();
  verb.add_option("--height", render.height, "Pixels")
      ->check(number(16, 16384))
      ->capture_default_str();
  verb.add_option("--yaw", render.camera.yaw,
                  "Degrees around the up axis (flat shapes are seen from the front)")
      ->check(number(-1e6, 1e6))
      ->capture_default_str();
  verb.add_option("--pitch", render.camera.pitch, "Degrees downward")
      ->check(number(-90, 90))
      ->capture_default_str();
  verb.add_option("--caption", render.caption, "A line of text at the lower border");
}

const std::vector<std::string>& picture_option_names() {
  static const std::vector<std::string> names{"--width", "--height", "--yaw", "--pitch",
                                              "--caption"};
  return names;
}

void look_at_plane(const CLI::App& verb, const Asset& asset, CameraOptions& camera) {
  if (verb.count("--yaw") + verb.count("--pitch") > 0) return;
  Points V(0, 3);
  for (const Character& c : asset.characters) {
    V.conservativeResize(V.rows() + c.mesh.V.rows(), 3);
    V.bottomRows(c.mesh.V.rows()) = c.mesh.V;
  }
  if (V.rows() < 3) return;
  const auto plane = plane_of(V, 1e-6 * diagonal(bounding_box(V)));
  if (!plane) return;
  const Vec3 n = turn_to_world(asset, 0) * plane->n;
  constexpr double degree = std::numbers::pi / 180;
  camera.pitch = std::asin(std::clamp(n.y(), -1.0, 1.0)) / degree;
  camera.yaw = std::atan2(n.x(), n.z()) / degree;
  camera.field_of_view = 0;
}

}  // namespace skinfield::cli
