#include "skinfield/render/image_warp.h"

#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/render/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace skinfield {
namespace {

constexpr int kSubsamples = 4;        // a side of a pixel: how finely coverage is told
constexpr int kBandRows = 16;         // rows that one task draws
constexpr int kMaxSamples = 16;       // a side, of a shrunken triangle's pixel
constexpr double kOnEdge = 1e-9;      // of barycentric coordinates: both neighbours have an edge
constexpr double kPastBorder = 1e-6;  // pixels
constexpr const char* kWhere = "image warp";

using Vec2 = Eigen::Vector2d;

/// A picture's linear light.
class Light {
 public:
  explicit Light(const Image& image) : image_(image) {
    for (int value = 0; value < 256; ++value) {
      const auto byte = static_cast<std::uint8_t>(value);
      linear_[static_cast<std::size_t>(value)] = to_linear({byte, byte, byte}).x();
    }
  }

  /// Bilinear between pixel centres, which are at half numbers; beyond the border as at it.
  Vec3 at(const Vec2& place) const {
    const double x = std::clamp(place.x() - 0.5, 0.0, image_.width - 1.0),
                 y = std::clamp(place.y() - 0.5, 0.0, image_.height - 1.0);
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, image_.width - 1), y1 = std::min(y0 + 1, image_.height - 1);
    const double u = x - x0, v = y - y0;
    return (1 - v) * ((1 - u) * pixel(x0, y0) + u * pixel(x1, y0)) +
           v * ((1 - u) * pixel(x0, y1) + u * pixel(x1, y1));
  }

 private:
  Vec3 pixel(int x, int y) const {
    const std::uint8_t* rgb = image_.rgb.data() + 3 * (static_cast<std::size_t>(y) *
                                                           static_cast<std::size_t>(image_.width) +
                                                       static_cast<std::size_t>(x));
    return {linear_[rgb[0]], linear_[rgb[1]], linear_[rgb[2]]};
  }

  const Image& image_;
  std::array<double, 256> linear_{};
};

/// One triangle in the result's pixels, and the way from there to the picture's.
struct Piece {
  std::array<Vec2, 3> corner;
  Eigen::Matrix2d to_barycentric;  ///< of corners 1 and 2, from place - corner[0]
  Eigen::Matrix2d turn;
  Vec2 shift;
  int samples;  ///< a side, so that a pixel skips none of the picture's

  Vec2 source(const Vec2& place) const { return turn * place + shift; }
  bool covers(const Vec2& place) const {
    const Vec2 b = to_barycentric * (place - corner[0]);
    return b.x() >= -kOnEdge && b.y() >= -kOnEdge && b.x() + b.y() <= 1 + kOnEdge;
  }
  Vec3 colour(const Light& light, int x, int y) const {
    Vec3 sum = Vec3::Zero();
    for (int j = 0; j < samples; ++j) {
      for (int i = 0; i < samples; ++i) {
        sum += light.at(source({x + (i + 0.5) / samples, y + (j + 0.5) / samples}));
      }
    }
    return sum / (samples * samples);
  }
};

Piece piece(const std::array<Vec2, 3>& from, const std::array<Vec2, 3>& to) {
  Piece result;
  result.corner = to;
  Eigen::Matrix2d rest, posed;
  rest << from[1] - from[0], from[2] - from[0];
  posed << to[1] - to[0], to[2] - to[0];
  result.to_barycentric = posed.inverse();
  result.turn = rest * result.to_barycentric;
  result.shift = from[0] - result.turn * to[0];
  // The picture's pixels that a step of one pixel passes, at most.
  const double squares = result.turn.squaredNorm(), area = result.turn.determinant();
  const double stretch =
      std::sqrt(0.5 * (squares + std::sqrt(std::max(0.0, squares * squares - 4 * area * area))));
  result.samples = static_cast<int>(std::clamp(std::ceil(stretch - 1e-6), 1.0, 1.0 * kMaxSamples));
  return result;
}

void check(const ImageFrame& frame, const PlanarPoints& rest, const PlanarPoints& posed,
           const Triangles& F) {
  const auto refuse = [](const std::string& what) { throw InputError(what, kWhere); };
  if (rest.rows() != posed.rows()) refuse("rest and pose differ in their number of vertices");
  if (F.size() > 0 && (F.minCoeff() < 0 || F.maxCoeff() >= rest.rows())) {
    refuse("a triangle names a vertex that does not exist");
  }
  if (!rest.allFinite() || !posed.allFinite()) refuse("a position is not finite");
  const Vec2 size = frame.high - frame.low;
  if (!(size.minCoeff() > 0) || !size.allFinite()) refuse("the picture's frame has no area");
}

/// Triangles by the bands of rows that they reach.
std::vector<std::vector<int>> by_band(const std::vector<Piece>& pieces, int height) {
  std::vector<std::vector<int>> bands(
      static_cast<std::size_t>((height + kBandRows - 1) / kBandRows));
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const auto& c = pieces[k].corner;
    const double low = std::min({c[0].y(), c[1].y(), c[2].y()}),
                 high = std::max({c[0].y(), c[1].y(), c[2].y()});
    const int first = std::max(0, static_cast<int>(low) / kBandRows),
              last =
                  std::min(static_cast<int>(bands.size()) - 1, static_cast<int>(high) / kBandRows);
    for (int band = first; band <= last; ++band) {
      bands[static_cast<std::size_t>(band)].push_back(static_cast<int>(k));
    }
  }
  return bands;
}

/// Which piece each subsample of a band shows, -1 for none.
class Band {
 public:
  Band(int width, int first_row, int rows)
      : columns_(width * kSubsamples),
        first_(first_row * kSubsamples),
        rows_(rows * kSubsamples),
        shown_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1) {}

  void draw(const Piece& piece, int number, const Vec2& source_size) {
    const auto& c = piece.corner;
    const auto range = [&](int axis, int first, int count) {
      const auto [low, high] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
      return std::pair(
          static_cast<int>(std::clamp(std::floor(low * kSubsamples) - first, 0.0, 1.0 * count)),
          static_cast<int>(
              std::clamp(std::ceil(high * kSubsamples) + 1 - first, 0.0, 1.0 * count)));
    };
    const auto [left, right] = range(0, 0, columns_);
    const auto [top, bottom] = range(1, first_, rows_);
    for (int j = top; j < bottom; ++j) {
      for (int i = left; i < right; ++i) {
        const Vec2 place{(i + 0.5) / kSubsamples, (first_ + j + 0.5) / kSubsamples};
        if (!piece.covers(place)) continue;
        const Vec2 source = piece.source(place);
        if (source.minCoeff() < -kPastBorder || (source - source_size).maxCoeff() > kPastBorder) {
          continue;
        }
        shown_[index(i, j)] = number;
      }
    }
  }

  /// The light of a pixel, `row` counted from the band's first.
  Vec3 pixel(const std::vector<Piece>& pieces, const Light& light, const Vec3& background, int x,
             int row) const {
    Vec3 sum = Vec3::Zero(), colour = Vec3::Zero();
    int last = -2;
    for (int j = 0; j < kSubsamples; ++j) {
      for (int i = 0; i < kSubsamples; ++i) {
        const int number = shown_[index(x * kSubsamples + i, row * kSubsamples + j)];
        if (number != last) {
          colour = number < 0 ? background
                              : pieces[static_cast<std::size_t>(number)].colour(
                                    light, x, first_ / kSubsamples + row);
          last = number;
        }
        sum += colour;
      }
    }
    return sum / (kSubsamples * kSubsamples);
  }

 private:
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(i);
  }

  int columns_, first_, rows_;
  std::vector<int> shown_;
};

}  // namespace

ImageFrame frame_around(const PlanarPoints& points) {
  ImageFrame frame;
  if (points.rows() == 0) return frame;
  frame.low = points.colwise().minCoeff().transpose();
  frame.high = points.colwise().maxCoeff().transpose();
  return frame;
}

Image warp_image(const Image& image, const ImageFrame& frame, const PlanarPoints& rest,
                 const PlanarPoints& posed, const Triangles& F, Rgb8 background) {
  check(frame, rest, posed, F);
  const Vec2 size(image.width, image.height);
  const Vec2 unit = size.cwiseQuotient(frame.high - frame.low);
  const auto in_pixels = [&](const PlanarPoints& points, Eigen::Index v) {
    return Vec2((points(v, 0) - frame.low.x()) * unit.x(),
                (frame.high.y() - points(v, 1)) * unit.y());
  };
  // Whole pixels to the left and above, and to the right and below.
  Vec2 before = Vec2::Zero(), after = Vec2::Zero();
  for (const std::int32_t v : F.reshaped()) {
    const Vec2 place = in_pixels(posed, v);
    before = before.cwiseMax((-place.array() - kPastBorder).ceil().matrix());
    after = after.cwiseMax(((place - size).array() - kPastBorder).ceil().matrix());
  }
  const Vec2 whole = size + before + after;
  constexpr double too_much = 1e6;  // Image refuses what is less, in its own words
  Image result(static_cast<int>(std::min(whole.x(), too_much)),
               static_cast<int>(std::min(whole.y(), too_much)), background);

  std::vector<Piece> pieces;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    std::array<Vec2, 3> from, to;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = F(f, static_cast<Eigen::Index>(k));
      from[k] = in_pixels(rest, v);
      to[k] = in_pixels(posed, v) + before;
    }
    const Vec2 a = to[1] - to[0], b = to[2] - to[0];
    // A triangle that has become a line shows nothing.
    if (std::abs(a.x() * b.y() - a.y() * b.x()) <= 1e-12 * a.norm() * b.norm()) continue;
    pieces.push_back(piece(from, to));
  }
  const std::vector<std::vector<int>> bands = by_band(pieces, result.height);
  const Light light(image);
  const Vec3 behind = to_linear(background);
  parallel_for(bands.size(), 1, [&](std::size_t b) {
    if (bands[b].empty()) return;
    const int first = static_cast<int>(b) * kBandRows,
              rows = std::min(kBandRows, result.height - first);
    Band band(result.width, first, rows);
    for (const int k : bands[b]) band.draw(pieces[static_cast<std::size_t>(k)], k, size);
    for (int row = 0; row < rows; ++row) {
      for (int x = 0; x < result.width; ++x) {
        result.set(x, first + row, to_srgb(band.pixel(pieces, light, behind, x, row)));
      }
    }
  });
  return result;
}

}  // namespace skinfield
