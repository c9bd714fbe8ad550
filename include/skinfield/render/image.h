// Pictures in memory and as PNG files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

using Rgb8 = std::array<std::uint8_t, 3>;  ///< red, green, blue; sRGB

/// Rows from the top, three bytes a pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< (3 * width * height)

  Image() = default;
  /// Throws InputError unless both sizes are in 1..32768.
  Image(int columns, int rows, Rgb8 colour);

  Rgb8 at(int x, int y) const;
  /// Pixels outside the picture are ignored.
  void set(int x, int y, Rgb8 colour);
};

/// Copies `source` into `target` with its upper left corner at (x,y); what lies outside is cut.
void paste(Image& target, const Image& source, int x, int y);

/// The bytes of an 8-bit RGB PNG file. Equal pictures give equal bytes.
std::vector<std::uint8_t> encode_png(const Image& image);

/// Any PNG as 8-bit RGB; what is transparent shows `behind`. `name` goes into messages.
/// @throws InputError where the bytes are no PNG, damaged, or a picture of more than 2^27 pixels.
Image decode_png(std::string_view bytes, const std::string& name, Rgb8 behind = {255, 255, 255});

/// Writes beside the target and renames. Throws IoError where that fails.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace skinfield
