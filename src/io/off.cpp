#include "skinfield/io/off.h"

#include "io/faces.h"
#include "io/text.h"

namespace skinfield {
namespace {

struct Header {
  bool texture = false, normals = false;
};

/// Understands the keyword that begins an OFF file; false if it is none.
bool parse_keyword(std::string_view word, const text::Lines& lines, Header& header) {
  if (word.size() < 3 || word.substr(word.size() - 3) != "OFF") return false;
  word.remove_suffix(3);
  if (word.substr(0, 2) == "ST") {
    header.texture = true;
    word.remove_prefix(2);
  }
  if (!word.empty() && word.front() == 'C') word.remove_prefix(1);
  if (!word.empty() && word.front() == 'N') {
    header.normals = true;
    word.remove_prefix(1);
  }
  if (!word.empty()) {
    lines.fail("OFF in other than three dimensions", "convert it to plain OFF or OBJ");
  }
  return true;
}

}  // namespace

MeshFile parse_off(std::string_view bytes, const std::string& name) {
  text::Lines lines(bytes, name);
  std::string_view line;
  std::vector<std::string_view> fields;
  Header header;
  const auto next_fields = [&](const char* thing) {
    if (!lines.next_content(line, '#')) {
      lines.fail(std::string("the file ends before ") + thing, "it is truncated");
    }
    text::split(line, fields);
  };
  next_fields("its counts");
  if (parse_keyword(fields[0], lines, header)) {
    fields.erase(fields.begin());
    if (!fields.empty() && fields[0] == "BINARY") {
      lines.fail("binary OFF is not read", "convert it to ASCII OFF or PLY");
    }
    if (fields.empty()) next_fields("its counts");
  }
  const auto integer = [&](std::size_t i, const char* thing) {
    const auto value = i < fields.size() ? text::to_integer(fields[i]) : std::nullopt;
    if (!value) lines.fail(std::string(thing) + " is missing or not an integer");
    return *value;
  };
  const std::int64_t vertices = integer(0, "the number of vertices");
  const std::int64_t faces = integer(1, "the number of faces");
  // The shortest vertex line is "0 0 0\n", the shortest face line "0\n".
  const auto left = static_cast<std::int64_t>(lines.remaining()) + 1;
  if (vertices < 0 || faces < 0 || vertices > left / 6 || faces > left / 2 ||
      vertices > INT32_MAX) {
    lines.fail("claims more vertices or faces than the file can hold",
               "it is truncated or damaged");
  }

  MeshFile mesh;
  mesh.V.resize(vertices, 3);
  if (header.normals) mesh.N.resize(vertices, 3);
  const std::size_t needed = header.normals ? 6 : 3;
  for (std::int64_t i = 0; i < vertices; ++i) {
    next_fields("its last vertex");
    if (fields.size() < needed) lines.fail("a vertex line is too short");
    for (std::size_t c = 0; c < needed; ++c) {
      const auto value = text::to_number(fields[c]);
      if (!value) lines.fail("a vertex line holds something that is not a number");
      const auto column = static_cast<Eigen::Index>(c);
      (c < 3 ? mesh.V(i, column) : mesh.N(i, column - 3)) = *value;
    }
  }
  FaceList list;
  std::vector<std::int32_t> polygon;
  for (std::int64_t f = 0; f < faces; ++f) {
    next_fields("its last face");
    const std::int64_t corners = integer(0, "the number of corners of a face");
    if (corners < 0 || corners >= static_cast<std::int64_t>(fields.size())) {
      lines.fail("a face line has fewer corners than it claims", "it is truncated or damaged");
    }
    polygon.clear();
    for (std::int64_t c = 0; c < corners; ++c) {
      const std::int64_t v = integer(static_cast<std::size_t>(c) + 1, "a corner of a face");
      if (v < 0 || v >= vertices) {
        lines.fail("a face names vertex " + std::to_string(v) + " of " + std::to_string(vertices),
                   "the file is damaged; export it again");
      }
      polygon.push_back(static_cast<std::int32_t>(v));
    }
    list.add(polygon);
  }
  mesh.F = list.matrix();
  if (list.skipped() > 0) {
    mesh.warnings.push_back(std::to_string(list.skipped()) +
                            " faces with fewer than three corners");
  }
  return mesh;
}

}  // namespace skinfield
