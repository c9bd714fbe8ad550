#include "skinfield/render/camera.h"

#include "skinfield/geometry/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield {

Vec3 Camera::ray_origin(double x, double y) const {
  if (perspective) return eye;
  return eye + right * ((x - 0.5 * width) * pixel) - up * ((y - 0.5 * height) * pixel);
}

Vec3 Camera::ray_direction(double x, double y) const {
  if (!perspective) return forward;
  return forward + right * ((x - 0.5 * width) * pixel) - up * ((y - 0.5 * height) * pixel);
}

Vec3 Camera::project(const Vec3& point) const {
  const Vec3 d = point - eye;
  const double depth = d.dot(forward), unit = perspective ? depth * pixel : pixel;
  return {0.5 * width + d.dot(right) / unit, 0.5 * height - d.dot(up) / unit, depth};
}

Camera fit_camera(const Points& V, int width, int height, const CameraOptions& options) {
  constexpr double degrees = std::numbers::pi / 180;
  Camera camera;
  camera.width = width;
  camera.height = height;

  // The front: z where y is up, -y where z is up, as modelling programs have it.
  const Vec3 top = options.up.normalized();
  Vec3 front = std::abs(top.z()) > 0.9 ? Vec3(-Vec3::UnitY()) : Vec3(Vec3::UnitZ());
  front = (front - top * top.dot(front)).normalized();
  const Vec3 side = top.cross(front);
  const double yaw = options.yaw * degrees, pitch = options.pitch * degrees;
  const Vec3 from =
      std::cos(pitch) * (std::cos(yaw) * front + std::sin(yaw) * side) + std::sin(pitch) * top;
  camera.forward = -from;
  camera.right = (std::cos(yaw) * side - std::sin(yaw) * front).normalized();
  camera.up = camera.right.cross(camera.forward);

  const Box3 box = bounding_box(V);
  const Vec3 centre = 0.5 * (box.row(0) + box.row(1)).transpose();
  const double size = std::max(diagonal(box), 1e-12);
  Points local(V.rows(), 3);  // in the camera's axes, around the centre
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    const Vec3 d = V.row(i).transpose() - centre;
    local.row(i) << d.dot(camera.right), d.dot(camera.up), d.dot(camera.forward);
  }
  const double free = 2 * options.margin * std::min(width, height);
  const double half_width = 0.5 * std::max(1.0, width - free);
  const double half_height = 0.5 * std::max(1.0, height - free);
  const Eigen::RowVector3d low = local.colwise().minCoeff(), high = local.colwise().maxCoeff();

  camera.perspective = options.field_of_view > 0;
  double x = 0.5 * (low.x() + high.x()), y = 0.5 * (low.y() + high.y());
  if (!camera.perspective) {
    camera.pixel = std::max({0.5 * (high.x() - low.x()) / half_width,
                             0.5 * (high.y() - low.y()) / half_height, 1e-9 * size});
    camera.eye = centre + camera.right * x + camera.up * y + camera.forward * (low.z() - size);
    return camera;
  }
  camera.pixel = 2 * std::tan(0.5 * options.field_of_view * degrees) / height;
  // The four sides of the view are planes through the eye: each pair bounds a coordinate of the
  // eye and its depth, so the nearest eye that sees everything has a closed form per axis.
  const auto fit_axis = [&](int axis, double tangent, double& position) {
    double plus = -1e300, minus = -1e300;  // max of +-c - tangent * depth
    for (Eigen::Index i = 0; i < local.rows(); ++i) {
      plus = std::max(plus, local(i, axis) - tangent * local(i, 2));
      minus = std::max(minus, -local(i, axis) - tangent * local(i, 2));
    }
    position = 0.5 * (plus - minus);
    return -0.5 * (plus + minus) / tangent;  // largest depth of the eye
  };
  const double depth =
      std::min({fit_axis(0, half_width * camera.pixel, x),
                fit_axis(1, half_height * camera.pixel, y), low.z() - 1e-3 * size});
  camera.eye = centre + camera.right * x + camera.up * y + camera.forward * depth;
  return camera;
}

}  // namespace skinfield
