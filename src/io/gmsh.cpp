#include "skinfield/io/gmsh.h"

#include "io/bytes.h"
#include "io/faces.h"
#include "io/text.h"

#include <fmt/format.h>

#include <unordered_map>

namespace skinfield {
namespace {

/// Nodes of an element type, 0 for types that are not known.
int nodes_of(std::int64_t type) {
  static constexpr int kNodes[] = {0, 2,  3,  4,  4, 8,  6,  5,  3,  6,  9, 10, 27, 18, 14, 1,
                                   8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5,  6,  20, 35, 56};
  return type > 0 && type < 32 ? kNodes[type] : 0;
}

enum class Shape { skipped, triangle, quad, tetrahedron, refused };

/// The first nodes of an element of higher order are its corners.
Shape shape_of(std::int64_t type) {
  switch (type) {
    case 1:
    case 8:
    case 15:
    case 26:
    case 27:
    case 28:
      return Shape::skipped;
    case 2:
    case 9:
    case 20:
    case 21:
    case 22:
    case 23:
    case 24:
    case 25:
      return Shape::triangle;
    case 3:
    case 10:
    case 16:
      return Shape::quad;
    case 4:
    case 11:
    case 29:
    case 30:
    case 31:
      return Shape::tetrahedron;
    default:
      return Shape::refused;
  }
}

/// Text between the sections, binary numbers inside them.
class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  MeshFile read() {
    std::string_view line;
    while (next_line(line)) {
      line = text::trimmed(line);
      if (line.empty()) continue;
      if (line == "$MeshFormat") {
        read_format();
      } else if (!formatted_) {
        fail("does not begin with $MeshFormat", "it is no Gmsh mesh");
      } else if (line == "$Nodes") {
        read_nodes();
      } else if (line == "$Elements") {
        read_elements();
      } else if (line.substr(0, 4) == "$End") {
        continue;
      } else if (line.front() == '$') {
        skip_to("$End" + std::string(line.substr(1)));
      } else {
        fail("text between the sections", "the file is damaged");
      }
    }
    if (xyz_.empty()) fail("there is no $Nodes section with nodes", "it is truncated or empty");
    MeshFile mesh;
    mesh.V = points_from(xyz_);
    mesh.F = faces_.matrix();
    mesh.T = Eigen::Map<const Tetrahedra>(tetrahedra_.data(),
                                          static_cast<Eigen::Index>(tetrahedra_.size() / 4), 4);
    return mesh;
  }

 private:
  std::string_view rest() const { return bytes_.substr(position_); }
  bool next_line(std::string_view& line) {
    if (position_ >= bytes_.size()) return false;
    const std::size_t end = rest().find('\n');
    line = rest().substr(0, end);
    position_ = end == std::string_view::npos ? bytes_.size() : position_ + end + 1;
    return true;
  }
  void skip_to(const std::string& end) {
    const std::size_t found = rest().find(end);
    if (found == std::string_view::npos) fail("there is no " + end, "it is truncated");
    position_ += found + end.size();
  }
  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    throw InputError(what, name_ + ": byte " + std::to_string(position_), remedy);
  }

  void read_format() {
    std::string_view line;
    std::vector<std::string_view> fields;
    if (!next_line(line)) fail("the file ends inside $MeshFormat", "it is truncated");
    text::split(line, fields);
    if (fields.size() < 3) fail("$MeshFormat is incomplete", "the file is damaged");
    if (fields[0].substr(0, 2) != "2.") {
      fail("Gmsh format " + std::string(fields[0].substr(0, 10)) + " is not read",
           "save it as version 2.2 (gmsh -format msh22)");
    }
    binary_ = fields[1] == "1";
    if (binary_) {
      if (fields[2] != "8") fail("reals are not 8 bytes", "save it with double precision");
      ByteReader reader = begin_binary();
      const auto one = reader.get<std::int32_t>("the byte order mark");
      if (one != 1 && one != 1 << 24) fail("the byte order mark is wrong", "the file is damaged");
      big_endian_ = one != 1;
      end_binary(reader);
    }
    formatted_ = true;
  }

  ByteReader begin_binary() const { return ByteReader(rest(), name_, big_endian_); }
  void end_binary(const ByteReader& reader) { position_ += reader.offset(); }
  text::Tokens begin_text() const { return text::Tokens(rest(), name_); }
  void end_text(const text::Tokens& tokens) { position_ = bytes_.size() - tokens.remaining(); }

  std::int64_t read_count(const char* thing, std::size_t least_bytes) {
    std::string_view line;
    if (!next_line(line)) fail("the file ends before " + std::string(thing), "it is truncated");
    const auto n = text::to_integer(text::trimmed(line));
    if (!n || *n < 0 || *n > INT32_MAX ||
        static_cast<std::uint64_t>(*n) > (rest().size() + 1) / least_bytes) {
      fail(std::string(thing) + " is impossible for a file of this size",
           "it is truncated or damaged");
    }
    return *n;
  }

  void read_nodes() {
    const std::int64_t n = read_count("the number of nodes", binary_ ? 28 : 8);
    xyz_.reserve(3 * static_cast<std::size_t>(n));
    const auto add = [this](std::int64_t id, double x, double y, double z) {
      if (!index_.emplace(id, static_cast<std::int32_t>(xyz_.size() / 3)).second) {
        fail("node " + std::to_string(id) + " occurs twice", "the file is damaged");
      }
      xyz_.insert(xyz_.end(), {x, y, z});
    };
    if (binary_) {
      ByteReader reader = begin_binary();
      for (std::int64_t i = 0; i < n; ++i) {
        const auto id = reader.get<std::int32_t>("a node");
        const double x = reader.get<double>("a node"), y = reader.get<double>("a node"),
                     z = reader.get<double>("a node");
        add(id, x, y, z);
      }
      end_binary(reader);
    } else {
      text::Tokens tokens = begin_text();
      for (std::int64_t i = 0; i < n; ++i) {
        const std::int64_t id = tokens.integer("a node's number");
        const double x = tokens.number("a coordinate"), y = tokens.number("a coordinate"),
                     z = tokens.number("a coordinate");
        add(id, x, y, z);
      }
      end_text(tokens);
    }
  }

  void read_elements() {
    const std::int64_t n = read_count("the number of elements", 6);
    std::int32_t corners[4] = {};
    if (!binary_) {
      text::Tokens tokens = begin_text();
      for (std::int64_t i = 0; i < n; ++i) {
        tokens.integer("an element's number");
        const std::int64_t type = tokens.integer("an element's type");
        const int nodes = check_type(type);
        const std::int64_t tags = tokens.count("the number of tags", 2);
        for (std::int64_t t = 0; t < tags; ++t) tokens.integer("a tag");
        for (int c = 0; c < nodes; ++c) {
          const std::int64_t id = tokens.integer("a node of an element");
          if (c < 4) corners[c] = index_of(id);
        }
        add_element(type, corners);
      }
      end_text(tokens);
      return;
    }
    ByteReader reader = begin_binary();
    for (std::int64_t i = 0; i < n;) {
      const auto type = reader.get<std::int32_t>("an element's type");
      const auto count = reader.get<std::int32_t>("the number of elements");
      const auto tags = reader.get<std::int32_t>("the number of tags");
      const int nodes = check_type(type);
      if (count < 1 || tags < 0 || count > n - i)
        fail("a damaged element block", "export it again");
      for (std::int32_t k = 0; k < count; ++k) {
        reader.get<std::int32_t>("an element's number");
        reader.take(std::uint64_t{4} * static_cast<std::uint32_t>(tags), "tags");
        for (int c = 0; c < nodes; ++c) {
          const auto id = reader.get<std::int32_t>("a node of an element");
          if (c < 4) corners[c] = index_of(id);
        }
        add_element(type, corners);
      }
      i += count;
    }
    end_binary(reader);
  }

  int check_type(std::int64_t type) const {
    const int nodes = nodes_of(type);
    if (nodes == 0 || shape_of(type) == Shape::refused) {
      fail("elements of Gmsh type " + std::to_string(type) + " are not read",
           "split the solids into tetrahedra");
    }
    return nodes;
  }

  std::int32_t index_of(std::int64_t id) const {
    const auto found = index_.find(id);
    if (found == index_.end()) {
      fail("an element names node " + std::to_string(id) + ", which is not there",
           "the file is damaged; export it again");
    }
    return found->second;
  }

  void add_element(std::int64_t type, const std::int32_t (&v)[4]) {
    switch (shape_of(type)) {
      case Shape::triangle:
        faces_.add(v[0], v[1], v[2]);
        break;
      case Shape::quad:
        faces_.add(v[0], v[1], v[2]);
        faces_.add(v[0], v[2], v[3]);
        break;
      case Shape::tetrahedron:
        tetrahedra_.insert(tetrahedra_.end(), v, v + 4);
        break;
      case Shape::skipped:
      case Shape::refused:
        break;
    }
  }

  std::string_view bytes_;
  std::string name_;
  std::size_t position_ = 0;
  bool formatted_ = false, binary_ = false, big_endian_ = false;
  std::unordered_map<std::int64_t, std::int32_t> index_;
  std::vector<double> xyz_;
  FaceList faces_;
  std::vector<std::int32_t> tetrahedra_;
};

}  // namespace

MeshFile parse_gmsh(std::string_view bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

std::string format_gmsh(const Points& V, const Triangles& F, const Tetrahedra& T) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", V.rows());
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    fmt::format_to(to, "{} {} {} {}\n", i + 1, V(i, 0), V(i, 1), V(i, 2));
  }
  fmt::format_to(to, "$EndNodes\n$Elements\n{}\n", F.rows() + T.rows());
  // Number, type (2: triangle, 4: tetrahedron), two tags: physical and geometrical entity.
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    fmt::format_to(to, "{} 2 2 1 1 {} {} {}\n", f + 1, F(f, 0) + 1, F(f, 1) + 1, F(f, 2) + 1);
  }
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    fmt::format_to(to, "{} 4 2 1 1 {} {} {} {}\n", F.rows() + t + 1, T(t, 0) + 1, T(t, 1) + 1,
                   T(t, 2) + 1, T(t, 3) + 1);
  }
  fmt::format_to(to, "$EndElements\n");
  return fmt::to_string(out);
}

}  // namespace skinfield
