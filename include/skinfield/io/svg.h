// SVG: filled shapes as flat outlines.
#pragma once

#include "skinfield/io/mesh_file.h"

namespace skinfield {

/// Outlines of path (M L H V C S Q T A Z, absolute and relative), polygon, polyline, rect, circle
/// and ellipse. Transforms of groups and elements apply (matrix, translate, scale, rotate, skewX,
/// skewY); viewBox and width do not: coordinates are user units of the outermost svg element. The y
/// axis is turned upward, (x, y) becomes (x, -y, 0), so that pictures stand as they do on a screen.
///
/// Each element is one shape and one part, even-odd inside it (loops within loops are holes);
/// shapes unite. Open subpaths are closed as filling does, or skipped where fill is none. Curves
/// become chords within 5e-4 of the drawing's diagonal. Definitions (defs, clipPath, mask, pattern,
/// marker, symbol) and what is not displayed are passed over; text, images and use are named in a
/// warning. Throws InputError for XML that cannot be read and for no closed outline.
MeshFile parse_svg(std::string_view bytes, const std::string& name);

}  // namespace skinfield
