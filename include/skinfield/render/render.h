// Pictures of characters by ray casting: no GPU, no window, the same bytes at any thread count.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/geometry/mesh.h"
#include "skinfield/render/camera.h"
#include "skinfield/render/image.h"
#include "skinfield/rig/skeleton.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skinfield {

/// Bones as octahedra and joints as dots, drawn in front of a translucent body.
struct SkeletonOverlay {
  std::vector<std::pair<Vec3, Vec3>> bones;  ///< head, tail
  std::vector<Vec3> dots;                    ///< point handles and bone ends
  int highlighted = -1;                      ///< bone drawn in the accent colour, or -1

  bool empty() const { return bones.empty() && dots.empty(); }
};

/// The handles' segments and points. `columns` (one a column, or empty for the rest pose) are the
/// transforms from the bind pose to the pose: world * inverse bind.
SkeletonOverlay skeleton_overlay(const Skeleton& skeleton, std::span<const Transform> columns = {});

/// A local extremum of a weight column.
struct ExtremumMark {
  Vec3 position = Vec3::Zero();
  int column = 0;
  bool maximum = true;
};

struct RenderOptions {
  int width = 960, height = 720;
  int samples_per_side = 3;  ///< 1..4, squared: the samples a pixel
  CameraOptions camera;
  Rgb8 background = {238, 240, 243};
  double crease = 55;        ///< degrees between faces from which an edge looks sharp
  Points normals;            ///< (n,3) of a point cloud, or empty: discs face the viewer
  SkeletonOverlay skeleton;  ///< empty: none
  /// In pictures of weights: maxima as light discs, minima as dark ones, rings where the body
  /// hides them. A contact sheet has each in its column's tile, and all in the first.
  std::vector<ExtremumMark> extrema;
  std::string caption;  ///< a line at the lower border, or empty
  Progress progress;
};

// In all of these V is (n,3), finite, n >= 1, and F (f,3); with f = 0 the vertices are drawn as
// small discs. They throw InputError where sizes disagree, indices are out of range, positions
// are not finite or there is nothing to draw, and Cancelled.

/// One weight (n) per vertex in a sequential colour map, isolines at 0.1, 0.2 ... 0.9 (0.5 twice
/// as wide). Weights that are not finite are grey.
Image render_heat_map(const Points& V, const Triangles& F, const Vector& weight,
                      const RenderOptions& options = {});

/// A colour per column of W (n,m), blended by weight; vertices without weights are grey.
Image render_dominant(const Points& V, const Triangles& F, const SparseRows& W,
                      const RenderOptions& options = {});

/// Heat maps of all columns in a grid with the names below. options.width is the sheet's width
/// and options.height is not used; options.skeleton appears in a first, additional tile of
/// dominant colours. names: (m) or empty (column numbers).
struct ContactSheetOptions {
  int columns = 0;         ///< tiles a row; 0: by the number of bones
  double tile_aspect = 0;  ///< height over width; 0: by the shape
};
Image render_contact_sheet(const Points& V, const Triangles& F, const SparseRows& W,
                           const std::vector<std::string>& names, const RenderOptions& options = {},
                           const ContactSheetOptions& sheet = {});

/// Linear RGB per vertex (n,3), between them interpolated.
Image render_vertex_colours(const Points& V, const Triangles& F, const Points& colours,
                            const RenderOptions& options = {});

/// A shaded (posed) mesh. colours: linear RGB per face (f,3), per vertex (n,3), one row for all,
/// or empty for a neutral grey; where f = n they are taken per face.
Image render_posed(const Points& V, const Triangles& F, const Points& colours = {},
                   const RenderOptions& options = {});

}  // namespace skinfield
