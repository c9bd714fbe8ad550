// The common part of all pictures: camera, visibility, light, skeleton, caption.
#pragma once

#include "render/surface.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/render/render.h"

#include <array>
#include <functional>
#include <optional>

namespace skinfield::render_detail {

/// Where a ray met the body, as colour functions see it.
struct SurfacePoint {
  int face = 0;                 ///< of the input's F; of the discs for point clouds
  std::array<int, 3> vertex{};  ///< input vertices of its corners
  std::array<double, 3> bary{};
  std::array<Vec3, 3> corner;  ///< their positions
  Vec3 dx, dy;                 ///< movement on the surface for one pixel to the right, down

  double interpolate(const Vector& values) const;
  /// Change of a linear function over the face, per pixel.
  double slope(const Vector& values) const;
};

/// Linear RGB of the unlit surface.
using ColourFunction = std::function<Vec3(const SurfacePoint&)>;

class Picture {
 public:
  /// @param keep_hits trace once, draw often (contact sheets).
  Picture(const Points& V, const Triangles& F, const RenderOptions& options, bool keep_hits);

  Image draw(const ColourFunction& colour, bool with_skeleton) const;
  /// The extrema of one column, or (-1) of all.
  void draw_extrema(Image& image, int column) const;

 private:
  struct Hit {
    float t = 0, u = 0, v = 0;
    int face = -1;
  };
  void trace_row(const RayScene& scene, int y, std::span<Hit> hits) const;
  Vec3 body_colour(const Hit& hit, double x, double y, const ColourFunction& colour) const;
  Vec3 bone_colour_at(const Hit& hit, double x, double y) const;
  void draw_mark(Image& image, const ExtremumMark& mark) const;
  Vec3 lit(const Surface& surface, const Hit& hit, const Vec3& direction, const Vec3& base,
           double gloss) const;

  const RenderOptions& options_;
  int side_;
  UnitBox box_;
  Camera camera_;
  Surface body_, bones_;
  std::vector<int> bone_of_face_;
  std::optional<RayScene> scene_, bone_scene_;
  std::vector<Hit> kept_;
};

/// Throws InputError unless V, F and the options can be drawn.
void require_drawable(const Points& V, const Triangles& F, const RenderOptions& options);

}  // namespace skinfield::render_detail
