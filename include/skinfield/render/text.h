// A small bitmap font for captions and labels: printable ASCII, 5 x 9 pixels a glyph.
#pragma once

#include "skinfield/render/image.h"

#include <string>
#include <string_view>

namespace skinfield {

constexpr int glyph_width = 5;   ///< pixels of ink; a sixth column separates glyphs
constexpr int glyph_height = 9;  ///< seven rows above the base line, two below

/// Nine rows from the top, bit 4 = leftmost column. Anything outside 32..126 gives '?'.
const std::array<std::uint8_t, glyph_height>& glyph(char character);

/// Width in pixels of a line of text at an integer scale >= 1.
int text_width(std::string_view text, int scale);

/// Draws one line with its upper left corner at (x,y). A UTF-8 sequence beyond ASCII is one '?'.
void draw_text(Image& image, int x, int y, std::string_view text, Rgb8 colour, int scale);

/// The text, or as much of it as fits in `width` pixels with ".." in the middle: names of bones
/// differ at both ends.
std::string shortened(std::string_view text, int width, int scale);

}  // namespace skinfield
