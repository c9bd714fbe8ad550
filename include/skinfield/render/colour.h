// Colour maps, built in OKLab (B. Ottosson, "A perceptual color space for image processing",
// 2020) so that lightness is even by construction.
#pragma once

#include "skinfield/base/types.h"
#include "skinfield/render/image.h"

namespace skinfield {

/// Linear RGB in [0,1] of a colour given by OKLab lightness, chroma and hue (degrees), clipped.
Vec3 oklch(double lightness, double chroma, double hue);

/// Sequential map, t in [0,1] (clamped): dark blue, teal, green, light yellow; linear RGB.
Vec3 heat_colour(double t);

/// Distinct colours for bones 0, 1, 2...: the hue advances by the golden angle; linear RGB.
Vec3 bone_colour(int bone);

Vec3 to_linear(Rgb8 colour);
/// Linear RGB (clamped to [0,1]) to sRGB bytes; to_srgb(to_linear(c)) == c.
Rgb8 to_srgb(const Vec3& linear);

}  // namespace skinfield
