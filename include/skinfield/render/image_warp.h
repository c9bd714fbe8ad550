// A picture that moves with a flat mesh.
#pragma once

#include "skinfield/base/types.h"
#include "skinfield/render/image.h"

namespace skinfield {

/// (n,2) places in the plane, x to the right and y up.
using PlanarPoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Where a picture lies in the plane: its lower left and its upper right corner.
struct ImageFrame {
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Ones();
};
/// The smallest frame around all points.
ImageFrame frame_around(const PlanarPoints& points);

/// Each triangle takes its part of the picture from where it lies in `rest` to where it lies in
/// `posed`, affinely; later triangles cover earlier ones. Pixels keep their size: the result is the
/// picture's own frame, grown by whole pixels as far as `posed` reaches; places that no triangle
/// covers are `background`. Bilinear where a triangle grows, the mean of as many samples as it
/// takes where it shrinks; edges are smooth. In linear light; the identity gives the picture back
/// byte for byte. Deterministic at any thread count.
/// @throws InputError where sizes differ, an index is out of range, positions are not finite, the
/// frame has no area, or the result were larger than a picture can be.
Image warp_image(const Image& image, const ImageFrame& frame, const PlanarPoints& rest,
                 const PlanarPoints& posed, const Triangles& F, Rgb8 background = {255, 255, 255});

}  // namespace skinfield
