#include "render/picture.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/render/colour.h"
#include "skinfield/render/text.h"

#include <algorithm>
#include <cmath>

namespace skinfield::render_detail {
namespace {

/// Diffuse light that reaches a little around the edge, as a large lamp's does.
double wrapped(double cosine) {
  constexpr double wrap = 0.35;
  const double x = std::max(0.0, (cosine + wrap) / (1 + wrap));
  return x * x * (3 - 2 * std::min(x, 1.0));
}

/// Discs that about cover the shape without hiding it.
double disc_radius(Eigen::Index points) {
  return std::clamp(0.9 / std::sqrt(static_cast<double>(points)), 0.0015, 0.02);
}

void check_rows(bool good, const std::string& what) {
  if (!good) throw InputError(what, "render");
}

}  // namespace

void require_drawable(const Points& V, const Triangles& F, const RenderOptions& options) {
  check_rows(V.rows() > 0, "there is nothing to draw: the mesh has no vertices");
  check_rows(V.allFinite(), "some vertex positions are not finite numbers");
  check_rows(F.rows() == 0 || (F.minCoeff() >= 0 && F.maxCoeff() < V.rows()),
             "a face names a vertex that does not exist");
  check_rows(options.normals.rows() == 0 || options.normals.rows() == V.rows(),
             "there must be as many normals as points");
  check_rows(options.samples_per_side >= 1 && options.samples_per_side <= 4,
             "samples_per_side must be from 1 to 4");
  check_rows(options.camera.up.norm() > 0, "the camera's up direction is zero");
}

double SurfacePoint::interpolate(const Vector& values) const {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += bary[c] * values[vertex[c]];
  return sum;
}

double SurfacePoint::slope(const Vector& values) const {
  const Vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], normal = e1.cross(e2);
  const double area = normal.squaredNorm();
  if (!(area > 0)) return 0;
  const Vec3 gradient = ((values[vertex[1]] - values[vertex[0]]) * e2.cross(normal) +
                         (values[vertex[2]] - values[vertex[0]]) * normal.cross(e1)) /
                        area;
  return std::hypot(gradient.dot(dx), gradient.dot(dy));
}

Picture::Picture(const Points& V, const Triangles& F, const RenderOptions& options, bool keep_hits)
    : options_(options), side_(options.samples_per_side), box_(unit_box(V)) {
  const Points unit = box_.to(V);
  SkeletonOverlay skeleton = options.skeleton;
  for (auto& [head, tail] : skeleton.bones) {
    head = box_.to(head);
    tail = box_.to(tail);
  }
  for (Vec3& dot : skeleton.dots) dot = box_.to(dot);
  constexpr double dot_radius = 0.006;
  bones_ = skeleton_shape(skeleton.bones, skeleton.dots, dot_radius, bone_of_face_);

  // The camera sees the body and the bones whole, even where a bone sticks out.
  Points seen(unit.rows() + bones_.V.rows(), 3);
  seen << unit, bones_.V;
  camera_ = fit_camera(seen, options.width, options.height, options.camera);

  if (F.rows() == 0) {
    body_ = discs(unit, options.normals, -camera_.forward, disc_radius(unit.rows()));
  } else {
    body_.V = unit;
    body_.F = F;
    body_.corner_normals = corner_normals(unit, F, options.crease);
  }
  scene_.emplace(body_.V, body_.F);
  if (bones_.F.rows() > 0) bone_scene_.emplace(bones_.V, bones_.F);

  if (!keep_hits) return;
  const auto row = static_cast<std::size_t>(camera_.width * side_ * side_);
  kept_.resize(row * static_cast<std::size_t>(camera_.height));
  parallel_for(static_cast<std::size_t>(camera_.height), 8, [&](std::size_t y) {
    options_.progress.check();
    trace_row(*scene_, static_cast<int>(y), std::span(kept_).subspan(y * row, row));
  });
}

void Picture::trace_row(const RayScene& scene, int y, std::span<Hit> hits) const {
  const std::size_t n = hits.size();
  std::vector<Vec3> directions(n);
  std::vector<RayHit> found(n);
  std::size_t i = 0;
  constexpr double far = 1e6;
  for (int x = 0; x < camera_.width; ++x) {
    for (int s = 0; s < side_ * side_; ++s, ++i) {
      const double px = x + (s % side_ + 0.5) / side_, py = y + (s / side_ + 0.5) / side_;
      directions[i] = camera_.ray_direction(px, py);
      if (!camera_.perspective) {
        found[i] = scene.first_hit(camera_.ray_origin(px, py), directions[i], 0, far);
      }
    }
  }
  if (camera_.perspective) {
    const std::vector<double> t_max(n, far);
    scene.first_hits(camera_.eye, directions, t_max, found);
  }
  for (i = 0; i < n; ++i) {
    hits[i] = {static_cast<float>(found[i].t), static_cast<float>(found[i].u),
               static_cast<float>(found[i].v), found[i].face};
  }
}

Vec3 Picture::lit(const Surface& surface, const Hit& hit, const Vec3& direction, const Vec3& base,
                  double gloss) const {
  const Eigen::Index f = hit.face;
  const auto corner = [&](int c) -> Vec3 { return surface.V.row(surface.F(f, c)); };
  const Vec3 flat = (corner(1) - corner(0)).cross(corner(2) - corner(0));
  const double u = hit.u, v = hit.v;
  const auto& N = surface.corner_normals;
  Vec3 normal =
      ((1 - u - v) * N.row(3 * f) + u * N.row(3 * f + 1) + v * N.row(3 * f + 2)).transpose();
  const Vec3 view = -direction.normalized();
  if (flat.dot(view) < 0) normal = -normal;  // both sides are drawn alike
  const double length = normal.norm();
  if (length > 0) normal /= length;

  // Two lamps that travel with the camera, and a sky brighter than the ground.
  const auto lamp = [&](double x, double y, double z) -> Vec3 {
    return (x * camera_.right + y * camera_.up - z * camera_.forward).normalized();
  };
  static const Vec3 warm(1.0, 0.97, 0.92), cool(0.86, 0.93, 1.0);
  const Vec3 key = lamp(-0.55, 0.75, 0.65), fill = lamp(0.8, 0.15, 0.55);
  const double sky = 0.5 + 0.5 * normal.dot(options_.camera.up.normalized());
  const Vec3 light = 0.66 * wrapped(normal.dot(key)) * warm +
                     0.20 * wrapped(normal.dot(fill)) * cool + (0.13 + 0.15 * sky) * cool;
  const double highlight =
      gloss * std::pow(std::max(0.0, normal.dot((key + view).normalized())), 36);
  return base.cwiseProduct(light) + Vec3::Constant(highlight);
}

Vec3 Picture::body_colour(const Hit& hit, double x, double y, const ColourFunction& colour) const {
  const Vec3 direction = camera_.ray_direction(x, y);
  SurfacePoint p;
  p.face = hit.face;
  p.bary = {1.0 - static_cast<double>(hit.u) - static_cast<double>(hit.v), hit.u, hit.v};
  for (int c = 0; c < 3; ++c) {
    const int v = body_.F(hit.face, c);
    const auto k = static_cast<std::size_t>(c);
    p.corner[k] = body_.V.row(v);
    p.vertex[k] =
        body_.vertex_source.empty() ? v : body_.vertex_source[static_cast<std::size_t>(v)];
  }
  const Vec3 normal = (p.corner[1] - p.corner[0]).cross(p.corner[2] - p.corner[0]).normalized();
  double facing = direction.dot(normal);
  // Near the silhouette a pixel covers any amount of surface; lines there stay bounded.
  const double least = 0.12 * direction.norm();
  if (std::abs(facing) < least) facing = std::copysign(least, facing);
  const double size =
      camera_.perspective ? camera_.pixel * static_cast<double>(hit.t) : camera_.pixel;
  const auto on_surface = [&](const Vec3& step) -> Vec3 {
    return size * (step - direction * (step.dot(normal) / facing));
  };
  p.dx = on_surface(camera_.right);
  p.dy = on_surface(-camera_.up);
  return lit(body_, hit, direction, colour(p), 0.05);
}

Vec3 Picture::bone_colour_at(const Hit& hit, double x, double y) const {
  const int bone = bone_of_face_[static_cast<std::size_t>(hit.face)];
  static const Vec3 dot = to_linear({250, 214, 120}), plain = to_linear({226, 231, 240});
  static const Vec3 accent = to_linear({255, 122, 40});
  const Vec3& base = bone < 0 ? dot : bone == options_.skeleton.highlighted ? accent : plain;
  return lit(bones_, hit, camera_.ray_direction(x, y), base, 0.2);
}

Image Picture::draw(const ColourFunction& colour, bool with_skeleton) const {
  Image image(camera_.width, camera_.height, options_.background);
  const int samples = side_ * side_;
  const auto row = static_cast<std::size_t>(camera_.width * samples);
  const Vec3 background = to_linear(options_.background);
  const bool bones = with_skeleton && bone_scene_.has_value();
  parallel_blocks(
      static_cast<std::size_t>(camera_.height), 8, [&](std::size_t begin, std::size_t end) {
        std::vector<Hit> traced(kept_.empty() ? row : 0), bone_hits(bones ? row : 0);
        for (std::size_t y = begin; y < end; ++y) {
          options_.progress.check();
          std::span<const Hit> hits = traced;
          if (kept_.empty()) {
            trace_row(*scene_, static_cast<int>(y), traced);
          } else {
            hits = std::span(kept_).subspan(y * row, row);
          }
          if (bones) trace_row(*bone_scene_, static_cast<int>(y), bone_hits);
          for (int x = 0; x < camera_.width; ++x) {
            Vec3 sum = Vec3::Zero();
            bool touched = false;
            for (int s = 0; s < samples; ++s) {
              const auto i = static_cast<std::size_t>(x * samples + s);
              const double px = x + (s % side_ + 0.5) / side_;
              const double py = static_cast<double>(y) + (s / side_ + 0.5) / side_;
              const Hit& hit = hits[i];
              Vec3 here = background;
              if (hit.face >= 0) {
                here = body_colour(hit, px, py, colour);
                touched = true;
              }
              if (bones && bone_hits[i].face >= 0) {
                // A bone under the skin shines through it.
                const bool behind = hit.face >= 0 && bone_hits[i].t > hit.t;
                const double opacity = behind ? 0.72 : 1.0;
                here = (1 - opacity) * here + opacity * bone_colour_at(bone_hits[i], px, py);
                touched = true;
              }
              sum += here;
            }
            if (touched) image.set(x, static_cast<int>(y), to_srgb(sum / samples));
          }
        }
      });
  if (!options_.caption.empty()) {
    const int scale = camera_.width >= 600 ? 2 : 1, border = 6 * scale;
    const std::string line = shortened(options_.caption, camera_.width - 2 * border, scale);
    const bool dark = background.sum() < 0.6;
    draw_text(image, border, camera_.height - border - (glyph_height - 1) * scale, line,
              dark ? Rgb8{225, 228, 232} : Rgb8{60, 64, 70}, scale);
  }
  return image;
}

void Picture::draw_extrema(Image& image, int column) const {
  for (const ExtremumMark& mark : options_.extrema)
    if (column < 0 || mark.column == column) draw_mark(image, mark);
}

void Picture::draw_mark(Image& image, const ExtremumMark& mark) const {
  const Vec3 at = camera_.project(box_.to(mark.position));
  const Vec3 origin = camera_.perspective ? camera_.eye : camera_.ray_origin(at.x(), at.y());
  const double depth = at.z();
  constexpr double near = 1e-3;  // a vertex lies in the triangles around it
  const bool hidden =
      scene_->first_hit(origin, camera_.ray_direction(at.x(), at.y()), 0, depth - near).face >= 0;
  const double radius = std::max(3.0, camera_.width / 160.0), rim = std::max(1.0, radius / 3);
  const Vec3 light = Vec3::Constant(0.95), dark = Vec3::Constant(0.01);
  const Vec3 &fill = mark.maximum ? light : dark, &edge = mark.maximum ? dark : light;
  const int reach = static_cast<int>(std::ceil(radius + rim)) + 1;
  for (int y = static_cast<int>(at.y()) - reach; y <= static_cast<int>(at.y()) + reach; ++y)
    for (int x = static_cast<int>(at.x()) - reach; x <= static_cast<int>(at.x()) + reach; ++x) {
      if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
      // A pixel's share of a disc, from the distance of its middle to the edge.
      const double d = std::hypot(x + 0.5 - at.x(), y + 0.5 - at.y());
      const auto share = [d](double r) { return std::clamp(r - d + 0.5, 0.0, 1.0); };
      const Vec3 below = to_linear(image.at(x, y));
      const Vec3 inside = hidden ? below : fill;
      const Vec3 ring = hidden ? fill : edge;
      const double outer = share(radius + rim), inner = share(radius);
      if (outer > 0)
        image.set(x, y, to_srgb((1 - outer) * below + (outer - inner) * ring + inner * inside));
    }
}

}  // namespace skinfield::render_detail
