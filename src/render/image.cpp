#include "skinfield/render/image.h"

#include "skinfield/base/error.h"

#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

namespace skinfield {
namespace {

constexpr int largest_side = 32768;
constexpr std::uint64_t largest_area = std::uint64_t{1} << 27;  // of pictures that are read

std::size_t offset(const Image& image, int x, int y) {
  return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
              static_cast<std::size_t>(x));
}

}  // namespace

Image::Image(int columns, int rows, Rgb8 colour) : width(columns), height(rows) {
  if (columns < 1 || rows < 1 || columns > largest_side || rows > largest_side) {
    throw InputError(
        "a picture cannot be " + std::to_string(columns) + " x " + std::to_string(rows) + " pixels",
        "render", "choose sides from 1 to " + std::to_string(largest_side));
  }
  rgb.resize(3 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < rgb.size(); i += 3) std::copy_n(colour.data(), 3, rgb.data() + i);
}

Rgb8 Image::at(int x, int y) const {
  const std::size_t i = offset(*this, x, y);
  return {rgb.at(i), rgb.at(i + 1), rgb.at(i + 2)};
}

void Image::set(int x, int y, Rgb8 colour) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::copy_n(colour.data(), 3, rgb.data() + offset(*this, x, y));
}

void paste(Image& target, const Image& source, int x, int y) {
  const int first = std::max(0, -x), last = std::min(source.width, target.width - x);
  if (first >= last) return;
  for (int row = std::max(0, -y); row < std::min(source.height, target.height - y); ++row) {
    std::copy_n(source.rgb.data() + offset(source, first, row),
                3 * static_cast<std::size_t>(last - first),
                target.rgb.data() + offset(target, x + first, y + row));
  }
}

std::vector<std::uint8_t> encode_png(const Image& image) {
  png_image description;
  std::memset(&description, 0, sizeof description);
  description.version = PNG_IMAGE_VERSION;
  description.width = static_cast<png_uint_32>(image.width);
  description.height = static_cast<png_uint_32>(image.height);
  description.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(description);
  std::vector<std::uint8_t> bytes(size);
  if (!png_image_write_to_memory(&description, bytes.data(), &size, 0, image.rgb.data(), 0,
                                 nullptr)) {
    throw IoError(std::string("the picture cannot be encoded: ") + description.message, "png");
  }
  bytes.resize(size);
  return bytes;
}

Image decode_png(std::string_view bytes, const std::string& name, Rgb8 behind) {
  png_image description;
  std::memset(&description, 0, sizeof description);
  description.version = PNG_IMAGE_VERSION;
  const auto refuse = [&](const std::string& what) {
    png_image_free(&description);
    throw InputError(what, name, "give a PNG file");
  };
  // To the library that is a wrong call, not a damaged file.
  if (bytes.empty()) refuse("the file is empty");
  if (!png_image_begin_read_from_memory(&description, bytes.data(), bytes.size())) {
    refuse(std::string("cannot be read as a PNG: ") + description.message);
  }
  const std::uint64_t pixels = std::uint64_t{description.width} * description.height;
  if (description.width > largest_side || description.height > largest_side ||
      pixels > largest_area) {
    refuse("the picture is too large: " + std::to_string(description.width) + " x " +
           std::to_string(description.height) + " pixels");
  }
  description.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(description.width), static_cast<int>(description.height), behind);
  const png_color background{behind[0], behind[1], behind[2]};
  if (!png_image_finish_read(&description, &background, image.rgb.data(), 0, nullptr)) {
    refuse(std::string("the PNG is damaged: ") + description.message);
  }
  return image;
}

void write_png(const std::filesystem::path& path, const Image& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image);
  std::filesystem::path beside = path;
  beside += ".part";
  {
    std::ofstream file(beside, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      const std::string why = errno ? std::strerror(errno) : "unknown reason";
      std::error_code ignored;
      std::filesystem::remove(beside, ignored);
      throw IoError("cannot be written: " + why, path.string(),
                    "check that the folder exists, is writable and has room");
    }
  }
  std::error_code failed;
  std::filesystem::rename(beside, path, failed);
  if (failed) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw IoError("cannot be written: " + failed.message(), path.string(),
                  "check that the target is not a folder");
  }
}

}  // namespace skinfield
