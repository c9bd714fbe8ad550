#include "skinfield/io/stl.h"

#include "io/bytes.h"
#include "io/faces.h"
#include "io/text.h"

namespace skinfield {
namespace {

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

std::uint64_t claimed_facets(std::string_view bytes) {
  ByteReader reader(bytes.substr(80), {});
  return reader.get<std::uint32_t>("the facet count");
}

/// Every three rows a triangle.
Triangles consecutive_triangles(Eigen::Index count) {
  Triangles F(count, 3);
  for (Eigen::Index i = 0; i < F.size(); ++i) F.data()[i] = static_cast<std::int32_t>(i);
  return F;
}

MeshFile parse_binary(std::string_view bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  reader.take(80, "the STL header");
  const std::uint32_t facets = reader.get<std::uint32_t>("the facet count");
  reader.expect(std::uint64_t{facets} * 3, 0, "vertices");
  reader.expect(facets, kFacetBytes, "facets");
  MeshFile mesh;
  mesh.V.resize(Eigen::Index{facets} * 3, 3);
  for (Eigen::Index f = 0; f < Eigen::Index{facets}; ++f) {
    reader.take(12, "a facet's normal");
    for (Eigen::Index i = 0; i < 9; ++i) {
      mesh.V(3 * f + i / 3, i % 3) = static_cast<double>(reader.get<float>("a facet"));
    }
    reader.take(2, "a facet's attribute");
  }
  mesh.F = consecutive_triangles(facets);
  return mesh;
}

void close_part(MeshFile& mesh, int vertices) {
  if (mesh.parts.empty()) return;
  mesh.parts.back().end = vertices;
  mesh.parts.back().face_end = vertices / 3;
}

MeshFile parse_ascii(std::string_view bytes, const std::string& name) {
  MeshFile mesh;
  std::vector<double> xyz;
  text::Lines lines(bytes, name);
  std::string_view line;
  std::vector<std::string_view> fields;
  int corners = 0;
  bool closed = true;
  const auto vertices = [&] { return static_cast<int>(xyz.size() / 3); };
  while (lines.next(line)) {
    text::split(line, fields);
    if (fields.empty()) continue;
    const std::string word = text::lower(fields[0]);
    if (word == "vertex") {
      if (fields.size() < 4) lines.fail("a vertex needs three coordinates");
      for (std::size_t c = 1; c < 4; ++c) {
        const auto value = text::to_number(fields[c]);
        if (!value) lines.fail("a coordinate is not a number");
        xyz.push_back(*value);
      }
      ++corners;
    } else if (word == "facet") {
      if (!closed) lines.fail("a facet begins inside another", "the file is damaged");
      corners = 0;
      closed = false;
    } else if (word == "endfacet") {
      if (corners != 3) lines.fail("a facet has " + std::to_string(corners) + " vertices, not 3");
      closed = true;
    } else if (word == "solid") {
      close_part(mesh, vertices());
      Part part;
      part.name = std::string(text::trimmed(line.substr(line.find(fields[0]) + 5)));
      part.begin = vertices();
      part.face_begin = part.begin / 3;
      mesh.parts.push_back(std::move(part));
    } else if (word != "outer" && word != "endloop" && word != "endsolid") {
      lines.fail(text::quoted(word) + " is no STL keyword", "the file is damaged");
    }
  }
  if (!closed) lines.fail("the file ends inside a facet", "it is truncated");
  if (xyz.size() % 9 != 0) lines.fail("vertices outside facets", "the file is damaged");
  close_part(mesh, vertices());
  if (mesh.parts.size() == 1) mesh.parts.clear();
  mesh.V = points_from(xyz);
  mesh.F = consecutive_triangles(mesh.V.rows() / 3);
  return mesh;
}

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + kFacetBytes * claimed_facets(bytes);
}

MeshFile parse_stl(std::string_view bytes, const std::string& name) {
  if (is_binary_stl(bytes)) return parse_binary(bytes, name);
  const std::string_view start = text::trimmed(bytes.substr(0, 256));
  if (text::lower(start.substr(0, 5)) == "solid") return parse_ascii(bytes, name);
  return parse_binary(bytes, name);
}

}  // namespace skinfield
