#include "skinfield/io/tgf.h"

#include "io/text.h"

#include <cmath>
#include <unordered_map>

namespace skinfield {
namespace {

void set_frames(Joint& joint) {
  joint.inverse_bind.topRightCorner<3, 1>() = -joint.position;
  joint.world_rest.topRightCorner<3, 1>() = joint.position;
  joint.local_rest = joint.world_rest;
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : lines_(bytes, name) {}

  Skeleton read() {
    skeleton_.source = Skeleton::Source::tgf;
    std::string_view line;
    int marks = 0;
    while (lines_.next(line) && marks < 2) {
      line = text::trimmed(line);
      if (line.empty()) continue;
      if (line.front() == '#') {
        ++marks;
        continue;
      }
      text::split(line, fields_);
      if (marks == 0) {
        read_vertex();
      } else {
        read_edge();
      }
    }
    if (skeleton_.joints.empty()) lines_.fail("the skeleton has no vertices", "name another file");
    return std::move(skeleton_);
  }

 private:
  void read_vertex() {
    const auto id = text::to_integer(fields_[0]);
    if (!id) lines_.fail("a vertex line does not begin with a number", "it is no TGF skeleton");
    if (fields_.size() < 3) lines_.fail("a vertex line needs an id and two or three coordinates");
    Joint joint;
    joint.name = std::to_string(*id);
    for (std::size_t c = 0; c < 3 && c + 1 < fields_.size(); ++c) {
      const auto value = text::to_number(fields_[c + 1]);
      if (!value) {
        lines_.fail(text::quoted(fields_[c + 1]) + " is no coordinate");
      }
      // The bound of mesh positions: squares of coordinates must fit a double.
      if (!(std::abs(*value) <= 1e100)) {
        lines_.fail("a position is not finite", "repair the vertex line");
      }
      joint.position[static_cast<Eigen::Index>(c)] = *value;
    }
    set_frames(joint);
    if (!index_.emplace(*id, static_cast<int>(skeleton_.joints.size())).second) {
      lines_.fail("vertex " + joint.name + " occurs twice", "give each vertex its own id");
    }
    skeleton_.joints.push_back(std::move(joint));
  }

  void read_edge() {
    if (fields_.size() < 2) lines_.fail("a bone line needs two vertices");
    int ends[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const auto id = text::to_integer(fields_[k]);
      const auto found = id ? index_.find(*id) : index_.end();
      if (found == index_.end()) {
        lines_.fail("a bone names vertex " + text::quoted(fields_[k]) + ", which is not there",
                    "correct the bone or add the vertex");
      }
      ends[k] = found->second;
    }
    if (fields_.size() >= 5 && fields_[2] == "0") return;
    skeleton_.bones.emplace_back(ends[0], ends[1]);
  }

  text::Lines lines_;
  std::vector<std::string_view> fields_;
  std::unordered_map<std::int64_t, int> index_;
  Skeleton skeleton_;
};

}  // namespace

Skeleton parse_tgf(std::string_view bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

void transform_skeleton(Skeleton& skeleton, const ReadOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw InputError("the scale is no positive number", {}, "give a positive number");
  }
  for (Joint& joint : skeleton.joints) {
    Vec3 x = joint.position;
    if (options.up == Up::z) x = Vec3(x[0], x[2], -x[1]);
    joint.position = x * options.scale;
    set_frames(joint);
  }
}

}  // namespace skinfield
