#include "tensor_output.h"

#include "cli.h"

#include "skinfield/io/file.h"
#include "skinfield/io/npy.h"
#include "skinfield/render/colour.h"
#include "skinfield/render/render.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace skinfield::cli {
namespace {

/// Triangles, each a piece of an element.
struct Slice {
  Points V;
  Triangles F;
  std::vector<Eigen::Index> element;
};

/// Where the plane x[axis] = height cuts the tetrahedra: a triangle or two each.
Slice cut(const TensorField& field, int axis, double height) {
  std::vector<Vec3> corners;
  Slice slice;
  for (Eigen::Index e = 0; e < field.elements.rows(); ++e) {
    std::vector<Vec3> below, above, ring;
    for (int i = 0; i < 4; ++i) {
      const Vec3 x = field.nodes.row(field.elements(e, i)).transpose();
      (x[axis] < height ? below : above).push_back(x);
    }
    // Around the cut: from one lower corner to all upper ones, and back from the other.
    for (std::size_t b = 0; b < below.size(); ++b)
      for (std::size_t a = 0; a < above.size(); ++a) {
        const Vec3 &low = below[b], &high = above[b % 2 == 0 ? a : above.size() - 1 - a];
        ring.emplace_back(low + (height - low[axis]) / (high[axis] - low[axis]) * (high - low));
      }
    for (std::size_t k = 2; k < ring.size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, k - 1, k}) corners.push_back(ring[corner]);
      slice.element.push_back(e);
    }
  }
  slice.V.resize(static_cast<Eigen::Index>(corners.size()), 3);
  slice.F.resize(static_cast<Eigen::Index>(slice.element.size()), 3);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    slice.V.row(static_cast<Eigen::Index>(k)) = corners[k].transpose();
    slice.F.data()[k] = static_cast<std::int32_t>(k);
  }
  return slice;
}

/// Of the elements' centres: the plane there cuts at least one.
double median_height(const TensorField& field, int axis) {
  std::vector<double> heights;
  for (Eigen::Index e = 0; e < field.elements.rows(); ++e)
    heights.push_back(field.nodes(field.elements.row(e), axis).mean());
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

std::string picture(const TensorField& field) {
  const Box3 box = bounding_box(field.nodes);
  int axis = 0;
  (box.row(1) - box.row(0)).minCoeff(&axis);
  Slice slice;
  if (field.elements.cols() == 4) {
    slice = cut(field, axis, median_height(field, axis));
  } else {
    slice.V = field.nodes;
    slice.F = field.elements;
    for (Eigen::Index e = 0; e < field.elements.rows(); ++e) slice.element.push_back(e);
  }
  const Vector condition = field.condition(slice.element);
  const double largest = condition.size() > 0 ? condition.maxCoeff() : 1;
  Points colours(slice.F.rows(), 3);
  for (Eigen::Index f = 0; f < colours.rows(); ++f)
    colours.row(f) = heat_colour((condition[f] - 1) / std::max(largest - 1, 1e-12)).transpose();
  RenderOptions options;
  options.crease = 0;
  options.camera.field_of_view = 0;
  options.camera.yaw = axis == 0 ? 90 : 0;
  options.camera.pitch = axis == 1 ? 90 : 0;
  options.caption = fmt::format("condition 1 to {:.3g}", largest);
  const std::vector<std::uint8_t> png =
      encode_png(render_posed(slice.V, slice.F, colours, options));
  return {png.begin(), png.end()};
}

}  // namespace

void check_tensor_output(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension != ".npz" && extension != ".png")
    throw UsageError(path + ": --tensors writes .npz or .png");
}

std::string format_tensors(const TensorField& field, const std::string& path) {
  if (lower_extension(path) == ".png") return picture(field);
  NpyArray elements =
      npy_from_integers({field.elements.data(), field.elements.data() + field.elements.size()});
  elements.shape = {field.elements.rows(), field.elements.cols()};
  return format_npz(
      {{"nodes", npy_from_matrix(field.nodes)},
       {"elements", std::move(elements)},
       {"direction", npy_from_matrix(field.direction)},
       {"condition", npy_from_vector({field.condition.begin(), field.condition.end()})}});
}

}  // namespace skinfield::cli
