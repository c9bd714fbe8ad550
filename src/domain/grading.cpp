#include "skinfield/domain/grading.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

double distance(const Vec3& a, const Vec3& b, const Vec3& x) {
  const Vec3 d = b - a;
  const double t = std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (a + t * d - x).norm();
}

}  // namespace

Grading::Grading(const Segments& segments, const Points& places, double least, int dimension)
    : least_(least), dimension_(dimension) {
  if (!(least < 1) || places.rows() == 0) return;
  for (const auto& [a, b] : segments)
    if ((b - a).squaredNorm() > 0) segments_.emplace_back(a, b);
  if (segments_.empty()) return;
  std::vector<double> lengths(static_cast<std::size_t>(places.rows()));
  for (std::size_t i = 0; i < lengths.size(); ++i)
    lengths[i] = length_at(places.row(static_cast<Eigen::Index>(i)).transpose());
  const auto half = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), half, lengths.end());
  reference_ = std::max(*half, 1e-6);
}

double Grading::length_at(const Vec3& x) const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : segments_)
    least = std::min(least, std::max((b - a).norm(), distance(a, b, x)));
  return least;
}

double Grading::at(const Vec3& x) const {
  return uniform() ? 1 : std::clamp(length_at(x) / reference_, least_, 1.0);
}

double Grading::density(const Vec3& x) const {
  const double s = at(x);
  return 1 / (dimension_ == 2 ? s * s : s * s * s);
}

}  // namespace skinfield
