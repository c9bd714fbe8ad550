#include "skinfield/render/render.h"

#include "render/picture.h"
#include "skinfield/base/error.h"
#include "skinfield/render/colour.h"
#include "skinfield/render/text.h"

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

using render_detail::Picture;
using render_detail::require_drawable;
using render_detail::SurfacePoint;

const Vec3 no_weight = Vec3::Constant(0.32);  ///< grey, linear

Vec3 heat_at(const SurfacePoint& p, const Vector& weight) {
  const double w = p.interpolate(weight);
  if (!std::isfinite(w)) return no_weight;
  const Vec3 base = heat_colour(w);
  const int level = std::clamp(static_cast<int>(std::lround(10 * w)), 1, 9);
  const double slope = p.slope(weight), width = level == 5 ? 1.3 : 0.65;  // pixels, halved
  // Lines nearer than three pixels would hide the colours; the middle one stays.
  const bool line = std::abs(w - 0.1 * level) < width * slope && (level == 5 || slope < 0.1 / 3);
  // Dark lines on the light half of the map, light ones on the dark half.
  return !line ? base : w > 0.45 ? Vec3(0.22 * base) : Vec3(0.45 * base + Vec3::Constant(0.33));
}

/// Blended bone colours (n,3); grey where a row holds nothing usable.
Points dominant_colours(const SparseRows& W) {
  Points colours(W.rows(), 3);
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    Vec3 sum = Vec3::Zero();
    double total = 0;
    for (SparseRows::InnerIterator it(W, i); it; ++it) {
      if (!(it.value() > 0) || !std::isfinite(it.value())) continue;
      sum += it.value() * bone_colour(static_cast<int>(it.col()));
      total += it.value();
    }
    colours.row(i) = (total > 0 ? Vec3(sum / total) : no_weight).transpose();
  }
  return colours;
}

Vec3 blended(const SurfacePoint& p, const Points& colours) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c) sum += p.bary[c] * colours.row(p.vertex[c]).transpose();
  return sum;
}

void require_rows(Eigen::Index rows, const Points& V, const char* what) {
  if (rows == V.rows()) return;
  throw InputError(std::string(what) + " has " + std::to_string(rows) + " rows for " +
                       std::to_string(V.rows()) + " vertices",
                   "render");
}

Vec3 transformed(const Transform& T, const Vec3& x) {
  return T.topLeftCorner<3, 3>() * x + T.topRightCorner<3, 1>();
}

struct Grid {
  int columns = 1, rows = 1, tile_width = 1, tile_height = 1, label_height = 1, gap = 1;
};

/// Height over width of the shape as the camera sees it.
double apparent_aspect(const Points& V, CameraOptions camera) {
  camera.field_of_view = 0;
  const Camera flat = fit_camera(V, 100, 100, camera);
  Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    const Vec3 p = flat.project(V.row(v));
    low = low.min(p.head<2>().array());
    high = high.max(p.head<2>().array());
  }
  return std::clamp((high.y() - low.y()) / std::max(1e-9, high.x() - low.x()), 0.4, 2.0);
}

Grid layout(int tiles, double aspect, const RenderOptions& options,
            const ContactSheetOptions& sheet) {
  Grid grid;
  grid.columns =
      sheet.columns > 0
          ? sheet.columns
          : std::clamp(static_cast<int>(std::ceil(std::sqrt(1.4 * tiles * aspect))), 1, 12);
  grid.columns = std::min(grid.columns, std::max(tiles, 1));
  grid.rows = (tiles + grid.columns - 1) / grid.columns;
  grid.gap = std::max(2, options.width / 240);
  grid.label_height = glyph_height + grid.gap;
  grid.tile_width = (options.width - grid.gap * (grid.columns + 1)) / grid.columns;
  grid.tile_height = static_cast<int>(std::lround(aspect * grid.tile_width));
  if (grid.tile_width < 8 || grid.tile_height < 8) {
    throw InputError("the contact sheet is too small for " + std::to_string(tiles) + " tiles",
                     "render", "choose a larger width");
  }
  return grid;
}

}  // namespace

SkeletonOverlay skeleton_overlay(const Skeleton& skeleton, std::span<const Transform> columns) {
  SkeletonOverlay overlay;
  for (std::size_t i = 0; i < skeleton.handles.size(); ++i) {
    Transform T = Transform::Identity();
    if (!columns.empty()) {
      const std::size_t column =
          i < skeleton.column.size() ? static_cast<std::size_t>(skeleton.column[i]) : i;
      if (column >= columns.size()) {
        throw InputError("there are fewer transforms than weight columns", "skeleton overlay");
      }
      T = columns[column];
    }
    const Handle& handle = skeleton.handles[i];
    if (handle.kind == Handle::Kind::point) overlay.dots.push_back(transformed(T, handle.point));
    for (const auto& [a, b] : handle.segments) {
      const Vec3 head = transformed(T, a), tail = transformed(T, b);
      overlay.bones.emplace_back(head, tail);
      overlay.dots.push_back(head);
      overlay.dots.push_back(tail);
    }
  }
  // Bones that meet share their end; one dot is enough.
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(overlay.dots.begin(), overlay.dots.end(), less);
  overlay.dots.erase(std::unique(overlay.dots.begin(), overlay.dots.end()), overlay.dots.end());
  return overlay;
}

Image render_heat_map(const Points& V, const Triangles& F, const Vector& weight,
                      const RenderOptions& options) {
  require_drawable(V, F, options);
  require_rows(weight.rows(), V, "the weight column");
  const Picture picture(V, F, options, false);
  Image image = picture.draw([&](const SurfacePoint& p) { return heat_at(p, weight); }, true);
  picture.draw_extrema(image, -1);
  return image;
}

Image render_dominant(const Points& V, const Triangles& F, const SparseRows& W,
                      const RenderOptions& options) {
  require_drawable(V, F, options);
  require_rows(W.rows(), V, "the weight matrix");
  const Points colours = dominant_colours(W);
  const Picture picture(V, F, options, false);
  Image image = picture.draw([&](const SurfacePoint& p) { return blended(p, colours); }, true);
  picture.draw_extrema(image, -1);
  return image;
}

Image render_contact_sheet(const Points& V, const Triangles& F, const SparseRows& W,
                           const std::vector<std::string>& names, const RenderOptions& options,
                           const ContactSheetOptions& sheet) {
  require_drawable(V, F, options);
  require_rows(W.rows(), V, "the weight matrix");
  const int bones = static_cast<int>(W.cols());
  if (!names.empty() && names.size() != static_cast<std::size_t>(bones)) {
    throw InputError("there must be a name for every weight column", "contact sheet");
  }
  const int tiles = bones + 1;
  const double aspect =
      sheet.tile_aspect > 0 ? sheet.tile_aspect : apparent_aspect(V, options.camera);
  const Grid grid = layout(tiles, aspect, options, sheet);
  const int caption_height = options.caption.empty() ? 0 : 2 * (glyph_height + grid.gap);

  RenderOptions tile_options = options;
  tile_options.width = grid.tile_width;
  tile_options.height = grid.tile_height;
  tile_options.caption.clear();
  const Picture picture(V, F, tile_options, true);

  Image image(
      options.width,
      grid.gap + grid.rows * (grid.tile_height + grid.label_height + grid.gap) + caption_height,
      options.background);
  const Rgb8 ink =
      to_linear(options.background).sum() < 0.6 ? Rgb8{225, 228, 232} : Rgb8{60, 64, 70};
  const auto place = [&](int tile, const Image& content, const std::string& name) {
    const int x = grid.gap + tile % grid.columns * (grid.tile_width + grid.gap);
    const int y =
        grid.gap + tile / grid.columns * (grid.tile_height + grid.label_height + grid.gap);
    paste(image, content, x, y);
    const std::string label = shortened(name, grid.tile_width, 1);
    draw_text(image, x + (grid.tile_width - text_width(label, 1)) / 2, y + grid.tile_height + 1,
              label, ink, 1);
  };

  const Points colours = dominant_colours(W);
  Image all = picture.draw([&](const SurfacePoint& p) { return blended(p, colours); }, true);
  picture.draw_extrema(all, -1);
  place(0, all, "all bones");
  const Eigen::SparseMatrix<double> by_column = W;
  for (int j = 0; j < bones; ++j) {
    options.progress("contact sheet", static_cast<double>(j) / bones);
    const Vector weight = by_column.col(j);
    const std::string name = names.empty() ? std::to_string(j) : names[static_cast<std::size_t>(j)];
    Image tile = picture.draw([&](const SurfacePoint& p) { return heat_at(p, weight); }, false);
    picture.draw_extrema(tile, j);
    place(j + 1, tile, name);
  }
  if (!options.caption.empty()) {
    const std::string line = shortened(options.caption, options.width - 4 * grid.gap, 2);
    draw_text(image, 2 * grid.gap, image.height - caption_height, line, ink, 2);
  }
  return image;
}

Image render_vertex_colours(const Points& V, const Triangles& F, const Points& colours,
                            const RenderOptions& options) {
  require_drawable(V, F, options);
  require_rows(colours.rows(), V, "the colour table");
  const Picture picture(V, F, options, false);
  return picture.draw([&](const SurfacePoint& p) { return blended(p, colours); }, true);
}

Image render_posed(const Points& V, const Triangles& F, const Points& colours,
                   const RenderOptions& options) {
  require_drawable(V, F, options);
  static const Vec3 neutral(0.52, 0.54, 0.57);
  const bool per_face = F.rows() > 0 && colours.rows() == F.rows();
  if (!per_face && colours.rows() > 1) require_rows(colours.rows(), V, "the colour table");
  const Picture picture(V, F, options, false);
  return picture.draw(
      [&](const SurfacePoint& p) -> Vec3 {
        if (colours.rows() == 0) return neutral;
        if (per_face) return colours.row(p.face);
        if (colours.rows() == 1) return colours.row(0);
        return blended(p, colours);
      },
      true);
}

}  // namespace skinfield
