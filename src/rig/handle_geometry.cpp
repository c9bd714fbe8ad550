#include "skinfield/rig/handle_geometry.h"

#include "skinfield/base/error.h"
#include "skinfield/geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skinfield {

InsideTest inside_test(const WindingNumber& winding, double level) {
  return [&winding, level](const Vec3& x) { return winding.at(x) > level; };
}

Points sample_handle(const Handle& handle, double spacing, const Points& V) {
  if (!(spacing > 0)) throw InputError("the spacing of samples must be positive", handle.name);
  std::vector<Vec3> samples;
  if (handle.kind == Handle::Kind::point) samples.push_back(handle.point);
  for (const int i : handle.vertices) {
    if (handle.kind != Handle::Kind::region) break;
    if (i < 0 || i >= V.rows()) {
      throw InputError("the region names vertex " + std::to_string(i) + ", which does not exist",
                       handle.name);
    }
    samples.emplace_back(V.row(i).transpose());
  }
  if (handle.kind == Handle::Kind::bone) {
    std::vector<Vec3> ends;
    const auto add_end = [&](const Vec3& x) {
      if (std::find(ends.begin(), ends.end(), x) != ends.end()) return;
      ends.push_back(x);
      samples.push_back(x);
    };
    for (const auto& [a, b] : handle.segments) {
      const double steps = std::max(1.0, std::ceil((b - a).norm() / spacing));
      if (!(steps < 1e7)) throw InputError("the spacing of samples is too small", handle.name);
      add_end(a);
      for (int k = 1; k < static_cast<int>(steps); ++k) samples.push_back(a + k / steps * (b - a));
      add_end(b);
    }
  }
  Points result(static_cast<Eigen::Index>(samples.size()), 3);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    result.row(static_cast<Eigen::Index>(k)) = samples[k].transpose();
  }
  return result;
}

double handle_distance(const Handle& handle, const Vec3& x, const Points& V, Vec3* closest) {
  double best = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vec3& y) {
    const double d = (y - x).norm();
    if (d >= best) return;
    best = d;
    if (closest) *closest = y;
  };
  switch (handle.kind) {
    case Handle::Kind::point:
      consider(handle.point);
      break;
    case Handle::Kind::region:
      for (const int i : handle.vertices) {
        if (i >= 0 && i < V.rows()) consider(V.row(i).transpose());
      }
      break;
    case Handle::Kind::bone:
      for (const auto& [a, b] : handle.segments) {
        consider(a + closest_on_segment(a, b, x) * (b - a));
      }
      break;
  }
  return best;
}

const char* to_string(HandlePlace place) {
  switch (place) {
    case HandlePlace::inside:
      return "inside";
    case HandlePlace::partly:
      return "partly";
    default:
      return "outside";
  }
}

HandleInside inside_part(const Handle& handle, const InsideTest& inside, int samples) {
  HandleInside result;
  if (handle.kind != Handle::Kind::bone) {
    const bool in = handle.kind == Handle::Kind::region || inside(handle.point);
    result.place = in ? HandlePlace::inside : HandlePlace::outside;
    result.fraction = in ? 1 : 0;
    return result;
  }
  double length = 0, kept = 0;
  for (const auto& segment : handle.segments) {
    const Vec3 from = segment.first, to = segment.second, along = to - from;
    // An end on the surface is neither in nor out: it is asked a little further in.
    constexpr double inset = 1e-4;
    const auto place = [&](int k) {
      return std::clamp(static_cast<double>(k) / samples, inset, 1 - inset);
    };
    const auto in = [&](double t) { return inside(from + t * along); };
    bool was = in(place(0));
    double begin = 0;
    const auto close = [&](double end) {
      if (end <= begin) return;
      result.segments.emplace_back(from + begin * along, end >= 1 ? to : Vec3(from + end * along));
      kept += (end - begin) * along.norm();
    };
    for (int k = 1; k <= samples; ++k) {
      const bool now = in(place(k));
      if (now == was) continue;
      double low = place(k - 1), high = place(k);
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        (in(middle) == was ? low : high) = middle;
      }
      if (was) {
        close(low);
      } else {
        begin = high;
      }
      was = now;
    }
    if (was) close(1);
    length += along.norm();
  }
  result.fraction = length > 0 ? std::min(kept / length, 1.0) : 0;
  if (result.fraction > 0) {
    result.place = result.fraction > 1 - 1e-9 ? HandlePlace::inside : HandlePlace::partly;
  }
  return result;
}

HandlePlace classify_handle(const Handle& handle, const WindingNumber& winding, double level) {
  return inside_part(handle, inside_test(winding, level)).place;
}

}  // namespace skinfield
