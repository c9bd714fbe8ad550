// A camera that looks at a shape from a yaw and a pitch and fits it into the picture.
#pragma once

#include "skinfield/base/types.h"

namespace skinfield {

struct CameraOptions {
  double yaw = 35;            ///< degrees around `up`; 0 looks at the front (+z where y is up)
  double pitch = 20;          ///< degrees; positive looks down
  double field_of_view = 28;  ///< degrees of the picture's height; 0 = orthographic
  double margin = 0.05;       ///< free border, as a share of the picture's smaller side
  Vec3 up = Vec3::UnitY();    ///< any non-zero direction; z-up files pass UnitZ
};

/// Picture coordinates run from (0,0), the upper left corner, to (width, height).
struct Camera {
  Vec3 eye = Vec3::Zero();
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY(), forward = -Vec3::UnitZ();  ///< orthonormal
  bool perspective = true;
  double pixel = 1;  ///< size of a pixel: at distance 1 (perspective), everywhere (orthographic)
  int width = 1, height = 1;

  Vec3 ray_origin(double x, double y) const;
  /// Its component along `forward` is 1, so that ray parameters are depths.
  Vec3 ray_direction(double x, double y) const;
  /// Picture x, y and depth of a point.
  Vec3 project(const Vec3& point) const;
};

/// All points (n >= 1, finite) inside the picture less its margin, as large as possible.
Camera fit_camera(const Points& V, int width, int height, const CameraOptions& options = {});

}  // namespace skinfield
