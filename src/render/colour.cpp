#include "skinfield/render/colour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield {

Vec3 oklch(double lightness, double chroma, double hue) {
  const double angle = hue * std::numbers::pi / 180;
  const double a = chroma * std::cos(angle), b = chroma * std::sin(angle);
  const auto cubed = [](double x) { return x * x * x; };
  const double l = cubed(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cubed(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cubed(lightness - 0.0894841775 * a - 1.2914855480 * b);
  const Vec3 rgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                 -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                 -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
  return rgb.cwiseMax(0.0).cwiseMin(1.0);
}

Vec3 heat_colour(double t) {
  t = std::clamp(t, 0.0, 1.0);
  const double hue = 278 - 178 * t * (0.75 + 0.25 * t);
  const double chroma = 0.10 + 0.07 * t;
  return oklch(0.33 + 0.61 * t, chroma, hue);
}

Vec3 bone_colour(int bone) {
  constexpr double golden_angle = 137.50776405003785;
  const double hue = std::fmod(25 + golden_angle * bone, 360.0);
  const std::array<double, 3> lightness = {0.70, 0.82, 0.60};
  return oklch(lightness[static_cast<std::size_t>(bone % 3)], 0.135, hue);
}

Vec3 to_linear(Rgb8 colour) {
  Vec3 linear;
  for (int c = 0; c < 3; ++c) {
    const double s = colour[static_cast<std::size_t>(c)] / 255.0;
    linear[c] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return linear;
}

Rgb8 to_srgb(const Vec3& linear) {
  Rgb8 colour{};
  for (int c = 0; c < 3; ++c) {
    const double x = std::clamp(linear[c], 0.0, 1.0);
    const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    colour[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255 * s));
  }
  return colour;
}

}  // namespace skinfield
