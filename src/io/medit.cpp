#include "skinfield/io/medit.h"

#include "io/faces.h"
#include "io/text.h"

#include <fmt/format.h>

namespace skinfield {
namespace {

bool is_keyword(std::string_view token) {
  return !token.empty() &&
         ((token[0] >= 'A' && token[0] <= 'Z') || (token[0] >= 'a' && token[0] <= 'z')) &&
         !text::to_number(token);
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : tokens_(bytes, name, '#') {}

  MeshFile read() {
    const std::string_view magic = tokens_.next();
    if (magic != "MeshVersionFormatted" && magic != "MeshVersionUnformatted") {
      tokens_.fail("does not begin with MeshVersionFormatted", "it is no MEDIT mesh");
    }
    tokens_.integer("the version");
    while (!tokens_.done()) {
      const std::string section(tokens_.next());
      if (section == "End") break;
      read_section(section);
    }
    check_range(tetrahedra_, "tetrahedron");
    check_range(triangles_, "triangle");
    MeshFile mesh;
    mesh.V = points_from(xyz_);
    mesh.F = Eigen::Map<const Triangles>(triangles_.data(),
                                         static_cast<Eigen::Index>(triangles_.size() / 3), 3);
    mesh.T = Eigen::Map<const Tetrahedra>(tetrahedra_.data(),
                                          static_cast<Eigen::Index>(tetrahedra_.size() / 4), 4);
    return mesh;
  }

 private:
  void read_section(const std::string& section) {
    if (section == "Dimension") {
      dimension_ = tokens_.integer("the dimension");
      if (dimension_ != 2 && dimension_ != 3) tokens_.fail("the dimension is not 2 or 3");
    } else if (section == "Vertices") {
      read_vertices();
    } else if (section == "Triangles") {
      read_elements<3>([this](const auto& v) { add(triangles_, {v[0], v[1], v[2]}); });
    } else if (section == "Quadrilaterals") {
      read_elements<4>([this](const auto& v) {
        add(triangles_, {v[0], v[1], v[2]});
        add(triangles_, {v[0], v[2], v[3]});
      });
    } else if (section == "Tetrahedra") {
      read_elements<4>([this](const auto& v) { add(tetrahedra_, {v[0], v[1], v[2], v[3]}); });
    } else if (section == "Hexahedra" || section == "Prisms" || section == "Pyramids") {
      if (tokens_.count("the number of solids", 2) > 0) {
        tokens_.fail(section + " are not read", "split the solids into tetrahedra");
      }
    } else if (is_keyword(section)) {
      while (!tokens_.done() && !is_keyword(tokens_.peek())) tokens_.next();
    } else {
      tokens_.fail(text::quoted(section) + " where a section should begin", "the file is damaged");
    }
  }

  void read_vertices() {
    const auto width = static_cast<std::size_t>(dimension_) + 1;
    const std::int64_t n = tokens_.count("the number of vertices", 2 * width);
    xyz_.clear();
    xyz_.reserve(3 * static_cast<std::size_t>(n));
    for (std::int64_t i = 0; i < n; ++i) {
      for (std::int64_t c = 0; c < 3; ++c) {
        xyz_.push_back(c < dimension_ ? tokens_.number("a coordinate") : 0.0);
      }
      tokens_.number("a vertex's reference");
    }
  }

  template <int kCorners, class Add>
  void read_elements(const Add& add_element) {
    const std::int64_t n = tokens_.count("the number of elements", 2 * (kCorners + 1));
    std::int32_t v[kCorners];
    for (std::int64_t i = 0; i < n; ++i) {
      for (std::int32_t& corner : v) {
        const std::int64_t index = tokens_.integer("a corner of an element");
        if (index < 1 || index > INT32_MAX) {
          tokens_.fail("an element names vertex " + std::to_string(index),
                       "the file is damaged; export it again");
        }
        corner = static_cast<std::int32_t>(index - 1);
      }
      tokens_.number("an element's reference");
      add_element(v);
    }
  }

  static void add(std::vector<std::int32_t>& to, std::initializer_list<std::int32_t> corners) {
    to.insert(to.end(), corners);
  }

  /// Sections come in any order, so that the range is known only at the end.
  void check_range(const std::vector<std::int32_t>& corners, const char* what) const {
    for (const std::int32_t v : corners) {
      if (static_cast<std::size_t>(v) >= xyz_.size() / 3) {
        tokens_.fail(std::string("a ") + what + " names vertex " + std::to_string(v + 1) + " of " +
                         std::to_string(xyz_.size() / 3),
                     "the file is damaged; export it again");
      }
    }
  }

  text::Tokens tokens_;
  std::int64_t dimension_ = 3;
  std::vector<double> xyz_;
  std::vector<std::int32_t> triangles_, tetrahedra_;
};

}  // namespace

MeshFile parse_medit(std::string_view bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

std::string format_medit(const Points& V, const Triangles& F, const Tetrahedra& T) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "MeshVersionFormatted 2\nDimension 3\nVertices\n{}\n", V.rows());
  for (Eigen::Index i = 0; i < V.rows(); ++i) {
    fmt::format_to(to, "{} {} {} 0\n", V(i, 0), V(i, 1), V(i, 2));
  }
  if (F.rows() > 0) fmt::format_to(to, "Triangles\n{}\n", F.rows());
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    fmt::format_to(to, "{} {} {} 0\n", F(f, 0) + 1, F(f, 1) + 1, F(f, 2) + 1);
  }
  fmt::format_to(to, "Tetrahedra\n{}\n", T.rows());
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    fmt::format_to(to, "{} {} {} {} 0\n", T(t, 0) + 1, T(t, 1) + 1, T(t, 2) + 1, T(t, 3) + 1);
  }
  fmt::format_to(to, "End\n");
  return fmt::to_string(out);
}

}  // namespace skinfield
