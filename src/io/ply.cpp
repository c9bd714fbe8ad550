#include "skinfield/io/ply.h"

#include "io/bytes.h"
#include "io/faces.h"
#include "io/text.h"

#include <array>
#include <cmath>
#include <limits>

namespace skinfield {
namespace {

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
  std::string name;
  Type type = Type::f32;
  bool list = false;
  Type count_type = Type::u8;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool ascii = true, big_endian = false;
  std::vector<Element> elements;
  std::size_t size = 0;  ///< bytes up to the data
};

std::size_t size_of(Type type) {
  switch (type) {
    case Type::i8:
    case Type::u8:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::f32:
      return 4;
    case Type::f64:
      return 8;
  }
  return 8;
}

Type type_named(std::string_view word, const text::Lines& lines) {
  if (word == "char" || word == "int8") return Type::i8;
  if (word == "uchar" || word == "uint8") return Type::u8;
  if (word == "short" || word == "int16") return Type::i16;
  if (word == "ushort" || word == "uint16") return Type::u16;
  if (word == "int" || word == "int32") return Type::i32;
  if (word == "uint" || word == "uint32") return Type::u32;
  if (word == "float" || word == "float32") return Type::f32;
  if (word == "double" || word == "float64") return Type::f64;
  lines.fail(text::quoted(word) + " is no PLY type");
}

Header parse_header(std::string_view bytes, text::Lines& lines) {
  Header header;
  std::string_view line;
  std::vector<std::string_view> fields;
  if (!lines.next(line) || text::trimmed(line) != "ply") {
    lines.fail("does not begin with \"ply\"", "it is no PLY file");
  }
  bool format = false;
  for (;;) {
    if (!lines.next(line)) lines.fail("the file ends inside its header", "it is truncated");
    text::split(line, fields);
    if (fields.empty() || fields[0] == "comment" || fields[0] == "obj_info") continue;
    if (fields[0] == "end_header") break;
    if (fields[0] == "format" && fields.size() >= 2) {
      format = true;
      header.ascii = fields[1] == "ascii";
      header.big_endian = fields[1] == "binary_big_endian";
      if (!header.ascii && !header.big_endian && fields[1] != "binary_little_endian") {
        lines.fail("unknown PLY format", "convert it to binary_little_endian");
      }
    } else if (fields[0] == "element" && fields.size() == 3) {
      Element element;
      element.name = std::string(fields[1]);
      const auto count = text::to_integer(fields[2]);
      if (!count || *count < 0 || *count > std::numeric_limits<std::int32_t>::max()) {
        lines.fail("an impossible number of elements", "the file is damaged");
      }
      element.count = *count;
      header.elements.push_back(std::move(element));
    } else if (fields[0] == "property" && fields.size() >= 3 && !header.elements.empty()) {
      Property property;
      property.list = fields[1] == "list";
      if (property.list && fields.size() < 5) lines.fail("an incomplete list property");
      if (property.list) property.count_type = type_named(fields[2], lines);
      property.type = type_named(fields[property.list ? 3 : 1], lines);
      property.name = std::string(fields[property.list ? 4 : 2]);
      header.elements.back().properties.push_back(std::move(property));
    } else {
      lines.fail("a header line that PLY does not know", "the file is damaged");
    }
  }
  if (!format) lines.fail("the header names no format", "the file is damaged");
  header.size = bytes.size() - lines.remaining();
  return header;
}

/// The values one after the other, whatever the encoding.
class Values {
 public:
  Values(std::string_view bytes, const Header& header, const std::string& name)
      : ascii_(header.ascii),
        tokens_(bytes.substr(header.ascii ? 0 : bytes.size()), name),
        binary_(bytes, name, header.big_endian) {
    if (ascii_) {
      // Line numbers in messages count from the top of the file: step over the header.
      while (bytes.size() - tokens_.remaining() < header.size) tokens_.rest_of_line();
    } else {
      binary_.take(header.size, "the header");
    }
  }

  double next(Type type, const char* thing) {
    if (ascii_) return tokens_.number(thing);
    switch (type) {
      case Type::i8:
        return binary_.get<std::int8_t>(thing);
      case Type::u8:
        return binary_.get<std::uint8_t>(thing);
      case Type::i16:
        return binary_.get<std::int16_t>(thing);
      case Type::u16:
        return binary_.get<std::uint16_t>(thing);
      case Type::i32:
        return binary_.get<std::int32_t>(thing);
      case Type::u32:
        return binary_.get<std::uint32_t>(thing);
      case Type::f32:
        return static_cast<double>(binary_.get<float>(thing));
      case Type::f64:
        return binary_.get<double>(thing);
    }
    return 0;
  }

  /// The length of a list, which cannot be more than what is left of the file.
  std::int64_t list_length(const Property& property) {
    const double length = next(property.count_type, "a list's length");
    const double left = ascii_ ? static_cast<double>(tokens_.remaining()) / 2 + 1
                               : static_cast<double>(binary_.remaining() / size_of(property.type));
    if (!(length >= 0 && length <= left) || length != std::floor(length)) {
      fail("a list claims more entries than the file holds", "it is truncated or damaged");
    }
    return static_cast<std::int64_t>(length);
  }

  void expect(const Element& element) {
    std::size_t each = 0;
    for (const Property& property : element.properties) {
      each += ascii_ ? 2 : size_of(property.list ? property.count_type : property.type);
    }
    const std::size_t left = ascii_ ? tokens_.remaining() + 1 : binary_.remaining();
    if (element.count > 0 && each > 0 && static_cast<std::uint64_t>(element.count) > left / each) {
      fail("claims " + std::to_string(element.count) + " elements " + text::quoted(element.name) +
               ", more than the file holds",
           "it is truncated or damaged");
    }
  }

  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    if (ascii_) tokens_.fail(what, remedy);
    binary_.fail(what, remedy);
  }

 private:
  bool ascii_;
  text::Tokens tokens_;
  ByteReader binary_;
};

void read_vertices(const Element& element, Values& values, MeshFile& mesh) {
  constexpr std::array<const char*, 6> names = {"x", "y", "z", "nx", "ny", "nz"};
  std::vector<int> slot(element.properties.size(), -1);
  std::array<bool, 6> found{};
  for (std::size_t p = 0; p < slot.size(); ++p) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (!element.properties[p].list && element.properties[p].name == names[k]) {
        slot[p] = static_cast<int>(k);
        found[k] = true;
      }
    }
  }
  if (!found[0] || !found[1]) values.fail("its vertices have no x and y", "export it again");
  const bool normals = found[3] && found[4] && found[5];
  mesh.V.setZero(element.count, 3);
  if (normals) mesh.N.setZero(element.count, 3);
  for (Eigen::Index i = 0; i < element.count; ++i) {
    for (std::size_t p = 0; p < slot.size(); ++p) {
      const Property& property = element.properties[p];
      const std::int64_t n = property.list ? values.list_length(property) : 1;
      for (std::int64_t k = 0; k < n; ++k) {
        const double value = values.next(property.type, "a vertex");
        if (slot[p] >= 0 && slot[p] < 3) mesh.V(i, slot[p]) = value;
        if (slot[p] >= 3 && normals) mesh.N(i, slot[p] - 3) = value;
      }
    }
  }
}

void read_faces(const Element& element, Values& values, std::int64_t vertices, FaceList& list) {
  std::vector<std::int32_t> polygon;
  for (std::int64_t f = 0; f < element.count; ++f) {
    for (const Property& property : element.properties) {
      const bool corners =
          property.list && (property.name == "vertex_indices" || property.name == "vertex_index");
      const std::int64_t n = property.list ? values.list_length(property) : 1;
      polygon.clear();
      for (std::int64_t k = 0; k < n; ++k) {
        const double v = values.next(property.type, "a face");
        if (!corners) continue;
        if (!(v >= 0 && v < static_cast<double>(vertices))) {
          values.fail("face " + std::to_string(f + 1) + " names a vertex that is not one of the " +
                          std::to_string(vertices),
                      "the file is damaged; export it again");
        }
        polygon.push_back(static_cast<std::int32_t>(v));
      }
      if (corners) list.add(polygon);
    }
  }
}

void skip(const Element& element, Values& values) {
  if (element.properties.empty()) return;
  for (std::int64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      const std::int64_t n = property.list ? values.list_length(property) : 1;
      for (std::int64_t k = 0; k < n; ++k) values.next(property.type, "an element");
    }
  }
}

}  // namespace

MeshFile parse_ply(std::string_view bytes, const std::string& name) {
  text::Lines lines(bytes, name);
  const Header header = parse_header(bytes, lines);
  std::int64_t vertices = -1;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") vertices = element.count;
    if (element.name == "tristrips" && element.count > 0) {
      throw InputError("triangle strips are not read", name, "export it with plain faces");
    }
  }
  if (vertices < 0) throw InputError("has no vertex element", name, "export it again");
  Values values(bytes, header, name);
  MeshFile mesh;
  FaceList list;
  for (const Element& element : header.elements) {
    values.expect(element);
    if (element.name == "vertex") {
      read_vertices(element, values, mesh);
    } else if (element.name == "face" && !element.properties.empty()) {
      read_faces(element, values, vertices, list);
    } else {
      skip(element, values);
    }
  }
  mesh.F = list.matrix();
  if (list.skipped() > 0) {
    mesh.warnings.push_back(std::to_string(list.skipped()) +
                            " faces with fewer than three corners");
  }
  return mesh;
}

std::string format_ply(const Points& V, const Triangles& F, const Points& N,
                       const Points& colours) {
  const bool normals = N.rows() == V.rows() && N.rows() > 0;
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                    std::to_string(V.rows()) +
                    "\nproperty double x\nproperty double y\nproperty double z\n";
  if (normals) out += "property double nx\nproperty double ny\nproperty double nz\n";
  const bool coloured = colours.rows() > 0;
  if (coloured) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  out += "element face " + std::to_string(F.rows()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    for (int c = 0; c < 3; ++c) put_little(out, V(i, c));
    for (int c = 0; normals && c < 3; ++c) put_little(out, N(i, c));
    for (int c = 0; coloured && c < 3; ++c) {
      put_little(out, static_cast<std::uint8_t>(std::lround(255 * colours(i, c))));
    }
  }
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    out.push_back('\3');
    for (int c = 0; c < 3; ++c) put_little(out, F(f, c));
  }
  return out;
}

}  // namespace skinfield
