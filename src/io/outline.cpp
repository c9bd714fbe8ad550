#include "io/outline.h"

#include "skinfield/geometry/plane.h"

#include <algorithm>
#include <array>
#include <map>

namespace skinfield {
namespace {

constexpr double kFlat = 1e-6;  // of the diagonal, as Diagnosis has it

using Segment = std::array<int, 3>;  ///< shape, lower end, upper end

/// Takes away and gives back, one by one, segments with an end that no other of their shape meets.
std::vector<Segment> trim_open_ends(std::vector<Segment>& segments) {
  std::map<std::array<int, 2>, std::vector<std::size_t>> at;  // (shape, vertex)
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (const std::size_t end : {1, 2}) at[{segments[i][0], segments[i][end]}].push_back(i);
  }
  std::vector<char> gone(segments.size(), 0);
  std::vector<std::array<int, 2>> ends;
  for (const auto& [end, list] : at) {
    if (list.size() == 1) ends.push_back(end);
  }
  std::vector<Segment> trimmed;
  while (!ends.empty()) {
    const auto end = ends.back();
    ends.pop_back();
    auto& list = at[end];
    if (list.size() != 1) continue;
    const std::size_t i = list.front();
    gone[i] = 1;
    trimmed.push_back(segments[i]);
    for (const std::size_t side : {1, 2}) {
      const std::array<int, 2> other{segments[i][0], segments[i][side]};
      auto& rest = at[other];
      rest.erase(std::find(rest.begin(), rest.end(), i));
      if (rest.size() == 1) ends.push_back(other);
    }
  }
  std::vector<Segment> kept;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!gone[i]) kept.push_back(segments[i]);
  }
  segments = std::move(kept);
  return trimmed;
}

/// Does every vertex end an even number of the segments of each shape?
bool is_even(const std::vector<Segment>& segments) {
  std::map<std::array<int, 2>, int> count;
  for (const Segment& s : segments) {
    for (const std::size_t end : {1, 2}) ++count[{s[0], s[end]}];
  }
  return std::all_of(count.begin(), count.end(),
                     [](const auto& entry) { return entry.second % 2 == 0; });
}

}  // namespace

Outline sound_outline(const Outline& outline, const std::vector<int>& merged, const Points& V,
                      std::vector<std::string>& warnings) {
  if (outline.empty()) return {};
  std::map<Segment, std::size_t> first;         // where it stands, odd times
  std::map<Segment, std::array<int, 2>> drawn;  // which way round, at first
  std::vector<Segment> segments;
  for (Eigen::Index e = 0; e < outline.E.rows(); ++e) {
    const int a = merged[static_cast<std::size_t>(outline.E(e, 0))];
    const int b = merged[static_cast<std::size_t>(outline.E(e, 1))];
    if (a == b) continue;
    const Segment s{outline.shape[static_cast<std::size_t>(e)], std::min(a, b), std::max(a, b)};
    drawn.try_emplace(s, std::array<int, 2>{a, b});
    const auto [found, fresh] = first.emplace(s, segments.size());
    if (fresh) {
      segments.push_back(s);
    } else {
      segments[found->second] = {-1, 0, 0};
      first.erase(found);
    }
  }
  std::erase_if(segments, [](const Segment& s) { return s[0] < 0; });
  if (!segments.empty() && !plane_of(V, kFlat * diagonal(bounding_box(V)))) {
    warnings.push_back("the polylines do not lie in one plane and are ignored");
    return {};
  }
  std::vector<Segment> loose = trim_open_ends(segments);
  if (!is_even(segments)) {
    warnings.push_back(
        "the polylines branch, and an outline is made of closed ones: geometric fields alone take "
        "them");
    loose.insert(loose.end(), segments.begin(), segments.end());
    segments.clear();
  } else if (!loose.empty()) {
    warnings.push_back(std::to_string(loose.size()) +
                       " segments of polylines do not close: geometric fields alone take them");
  }
  std::sort(loose.begin(), loose.end());
  Outline sound;
  sound.E.resize(static_cast<Eigen::Index>(segments.size()), 2);
  for (std::size_t e = 0; e < segments.size(); ++e) {
    sound.E.row(static_cast<Eigen::Index>(e)) << segments[e][1], segments[e][2];
    sound.shape.push_back(segments[e][0]);
  }
  sound.loose.resize(static_cast<Eigen::Index>(loose.size()), 2);
  for (std::size_t e = 0; e < loose.size(); ++e) {
    const std::array<int, 2>& way = drawn.at(loose[e]);
    sound.loose.row(static_cast<Eigen::Index>(e)) << way[0], way[1];
  }
  return sound;
}

}  // namespace skinfield
