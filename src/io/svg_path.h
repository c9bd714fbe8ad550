// Outlines of SVG elements as lines and cubic Bezier curves, before and after transforms.
#pragma once

#include "skinfield/base/types.h"

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace skinfield::svg {

using Point = Eigen::Vector2d;
using Affine = Eigen::Matrix<double, 2, 3>;  ///< p' = A.leftCols(2) p + A.col(2)

/// From the end of the segment before it (or the subpath's start) to `end`.
struct Segment {
  bool curved = false;
  Point first = Point::Zero(), second = Point::Zero();  ///< control points of a curve
  Point end = Point::Zero();
};

struct Subpath {
  Point start = Point::Zero();
  std::vector<Segment> segments;
  bool closed = false;  ///< by Z, or by ending where it began
};

using Path = std::vector<Subpath>;

/// The `d` attribute (SVG 1.1, section 8.3). An error ends the path where it occurs, as the
/// standard asks; `broken` then says so.
Path parse_path(std::string_view d, bool& broken);
/// The `points` attribute of polygon and polyline; a last odd coordinate is `broken`.
Path parse_points(std::string_view points, bool closed, bool& broken);
Path rectangle(double x, double y, double width, double height, double rx, double ry);
Path ellipse(const Point& centre, double rx, double ry);

/// The `transform` attribute; nothing where it cannot be read.
std::optional<Affine> parse_transform(std::string_view text);
/// First `inner`, then `outer`.
Affine compose(const Affine& outer, const Affine& inner);
void apply(const Affine& transform, Path& path);

/// The corners of a subpath, its start first; curves as chords that leave them by at most
/// `tolerance`. The end of a closed subpath is not repeated.
std::vector<Point> flatten(const Subpath& subpath, double tolerance);

}  // namespace skinfield::svg
