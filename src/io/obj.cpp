#include "skinfield/io/obj.h"

#include "io/faces.h"
#include "io/text.h"

#include <limits>
#include <unordered_map>

namespace skinfield {
namespace {

/// One corner of a face; texcoord and normal are -1 where it has none.
struct Corner {
  std::int32_t vertex = 0, texcoord = -1, normal = -1;
};

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name, const MaterialLoader& load)
      : lines_(bytes, name), load_(load) {}

  MeshFile read() {
    std::string_view line;
    while (next_logical_line(line)) {
      text::split(line, fields_);
      if (!fields_.empty()) read_line(line);
    }
    close_part();
    return finish();
  }

 private:
  /// Joins lines that end in a backslash and cuts comments off.
  bool next_logical_line(std::string_view& line) {
    if (!lines_.next(line)) return false;
    const bool comment = line.find('#') != std::string_view::npos;
    if (!comment && !line.empty() && line.back() == '\\') {
      joined_.clear();
      do {
        joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
      } while (lines_.next(line) && !line.empty() && line.back() == '\\');
      if (line.empty() || line.back() != '\\') joined_.append(line);
      line = joined_;
    }
    line = line.substr(0, line.find('#'));
    return true;
  }

  void read_line(std::string_view line) {
    const std::string_view word = fields_[0];
    if (word == "v") {
      push_numbers(xyz_, 2, 3);
    } else if (word == "vt") {
      push_numbers(texcoords_, 1, 2);
    } else if (word == "vn") {
      push_numbers(normals_, 3, 3);
    } else if (word == "f") {
      read_face();
    } else if (word == "l") {
      read_line_element();
    } else if (word == "o" || word == "g") {
      (word == "o" ? object_ : group_) = rest_of(line);
      part_changed_ = true;
    } else if (word == "usemtl") {
      use_material(rest_of(line));
    } else if (word == "mtllib") {
      load_library(rest_of(line));
    } else if (word == "vp" || word == "curv" || word == "surf" || word == "cstype") {
      free_form_ = true;
    }
  }

  std::string rest_of(std::string_view line) const {
    const auto skipped = static_cast<std::size_t>(fields_[0].data() - line.data());
    return std::string(text::trimmed(line.substr(skipped + fields_[0].size())));
  }

  void push_numbers(std::vector<double>& to, std::size_t least, std::size_t width) {
    if (fields_.size() < least + 1) lines_.fail("a line has too few numbers");
    for (std::size_t c = 1; c <= width; ++c) {
      const auto value = c < fields_.size() ? text::to_number(fields_[c]) : 0.0;
      if (!value) lines_.fail(text::quoted(fields_[c]) + " is not a number");
      to.push_back(*value);
    }
  }

  /// 1-based, or negative from the end, to 0-based.
  std::int32_t resolve(std::string_view token, std::size_t count, const char* what,
                       const char* who = "a face") const {
    const auto index = text::to_integer(token);
    const auto n = static_cast<std::int64_t>(count);
    if (!index || *index == 0 || *index > n || *index < -n) {
      lines_.fail(std::string(who) + " names " + what + " " + text::quoted(token) + " of " +
                      std::to_string(n),
                  "the file is damaged; export it again");
    }
    return static_cast<std::int32_t>(*index > 0 ? *index - 1 : n + *index);
  }

  void read_face() {
    corners_.clear();
    for (std::size_t i = 1; i < fields_.size(); ++i) {
      text::split(fields_[i], '/', parts_);
      Corner corner;
      corner.vertex = resolve(parts_[0], xyz_.size() / 3, "vertex");
      if (parts_.size() > 1 && !parts_[1].empty()) {
        corner.texcoord = resolve(parts_[1], texcoords_.size() / 2, "texture coordinate");
      }
      if (parts_.size() > 2 && !parts_[2].empty()) {
        corner.normal = resolve(parts_[2], normals_.size() / 3, "normal");
      }
      corners_.push_back(corner);
    }
    if (corners_.size() < 3) {
      ++skipped_faces_;
      return;
    }
    if (part_changed_ || mesh_.parts.empty()) open_part();
    for (std::size_t i = 2; i < corners_.size(); ++i) {
      const Corner &a = corners_[0], &b = corners_[i - 1], &c = corners_[i];
      faces_.add(a.vertex, b.vertex, c.vertex);
      texcoord_corners_.add(a.texcoord, b.texcoord, c.texcoord);
      normal_corners_.add(a.normal, b.normal, c.normal);
    }
    Part& part = mesh_.parts.back();
    for (const Corner& corner : corners_) {
      part.begin = std::min(part.begin, corner.vertex);
      part.end = std::max(part.end, corner.vertex + 1);
    }
  }

  /// l v1[/vt1] v2[/vt2] ...: an outline if it closes.
  void read_line_element() {
    std::int32_t before = -1;
    for (std::size_t i = 1; i < fields_.size(); ++i) {
      text::split(fields_[i], '/', parts_);
      const std::int32_t vertex = resolve(parts_[0], xyz_.size() / 3, "vertex", "a polyline");
      if (before >= 0) segments_.insert(segments_.end(), {before, vertex});
      before = vertex;
    }
  }

  void open_part() {
    part_changed_ = false;
    const std::string& name = object_.empty() ? group_ : object_;
    if (!mesh_.parts.empty()) {
      // Files repeat their group lines: only a real change begins a part.
      if (mesh_.parts.back().name == name && material_of_part_.back() == material_) return;
      close_part();
    }
    Part part;
    part.name = name;
    part.begin = std::numeric_limits<int>::max();
    part.face_begin = faces_.size();
    mesh_.parts.push_back(std::move(part));
    material_of_part_.push_back(material_);
  }
  void close_part() {
    if (!mesh_.parts.empty()) mesh_.parts.back().face_end = faces_.size();
  }

  void use_material(const std::string& name) {
    const auto [found, added] = material_index_.emplace(name, static_cast<int>(materials_.size()));
    if (added) {
      materials_.emplace_back();
      materials_.back().name = name;
    }
    material_ = found->second;
    part_changed_ = true;
  }

  void load_library(const std::string& file) {
    const auto bytes = load_ ? load_(file) : std::nullopt;
    if (!bytes) {
      mesh_.warnings.push_back("the material library \"" + file + "\" cannot be read");
      return;
    }
    for (ObjMaterial& material : parse_mtl(*bytes)) {
      const auto [found, added] =
          material_index_.emplace(material.name, static_cast<int>(materials_.size()));
      if (added) materials_.emplace_back();
      materials_[static_cast<std::size_t>(found->second)] = std::move(material);
    }
  }

  MeshFile finish() {
    mesh_.V = points_from(xyz_);
    mesh_.F = faces_.matrix();
    auto document = std::make_shared<ObjDocument>();
    document->texcoords =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>>(
            texcoords_.data(), static_cast<Eigen::Index>(texcoords_.size() / 2), 2);
    document->normals = points_from(normals_);
    document->texcoord_of_corner = texcoord_corners_.matrix();
    document->normal_of_corner = normal_corners_.matrix();
    for (std::size_t p = 0; p < mesh_.parts.size(); ++p) {
      if (material_of_part_[p] < 0) continue;
      mesh_.parts[p].colour = materials_[static_cast<std::size_t>(material_of_part_[p])].colour;
    }
    set_vertex_normals(*document);
    document->materials = std::move(materials_);
    document->material_of_part = std::move(material_of_part_);
    mesh_.document = std::move(document);
    mesh_.outline.E = Eigen::Map<const Segments>(
        segments_.data(), static_cast<Eigen::Index>(segments_.size() / 2), 2);
    mesh_.outline.shape.assign(segments_.size() / 2, 0);
    if (skipped_faces_ > 0) {
      mesh_.warnings.push_back(std::to_string(skipped_faces_) +
                               " faces with fewer than three corners");
    }
    if (free_form_) mesh_.warnings.push_back("free-form curves and surfaces are ignored");
    return std::move(mesh_);
  }

  /// Vertex normals where the file gives each vertex exactly one (or, for a cloud, one a vertex).
  void set_vertex_normals(const ObjDocument& document) {
    const Eigen::Index n = mesh_.V.rows();
    if (document.normals.rows() == 0) return;
    if (mesh_.F.rows() == 0) {
      if (document.normals.rows() == n) mesh_.N = document.normals;
      return;
    }
    std::vector<std::int32_t> normal(static_cast<std::size_t>(n), -1);
    for (Eigen::Index i = 0; i < mesh_.F.size(); ++i) {
      std::int32_t& known = normal[static_cast<std::size_t>(mesh_.F.data()[i])];
      const std::int32_t here = document.normal_of_corner.data()[i];
      if (here < 0 || (known >= 0 && known != here)) return;
      known = here;
    }
    mesh_.N.setZero(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::int32_t k = normal[static_cast<std::size_t>(i)];
      if (k >= 0) mesh_.N.row(i) = document.normals.row(k);
    }
  }

  text::Lines lines_;
  const MaterialLoader& load_;
  std::string joined_;
  std::vector<std::string_view> fields_, parts_;
  std::vector<Corner> corners_;
  std::vector<double> xyz_, texcoords_, normals_;
  FaceList faces_, texcoord_corners_, normal_corners_;
  std::string object_, group_;
  std::vector<ObjMaterial> materials_;
  std::unordered_map<std::string, int> material_index_;
  std::vector<int> material_of_part_;
  int material_ = -1;
  bool part_changed_ = false, free_form_ = false;
  int skipped_faces_ = 0;
  std::vector<std::int32_t> segments_;
  MeshFile mesh_;
};

}  // namespace

MeshFile parse_obj(std::string_view bytes, const std::string& name,
                   const MaterialLoader& load_materials) {
  return Reader(bytes, name, load_materials).read();
}

std::vector<ObjMaterial> parse_mtl(std::string_view bytes) {
  std::vector<ObjMaterial> materials;
  text::Lines lines(bytes, {});
  std::string_view line;
  std::vector<std::string_view> fields;
  while (lines.next_content(line, '#')) {
    text::split(line, fields);
    if (fields[0] == "newmtl") {
      materials.emplace_back();
      materials.back().name = std::string(text::trimmed(line.substr(6)));
      continue;
    }
    if (materials.empty()) continue;
    ObjMaterial& material = materials.back();
    const auto number = [&fields](std::size_t i, double otherwise) {
      const auto value = i < fields.size() ? text::to_number(fields[i]) : std::nullopt;
      return value && *value >= 0 && *value <= 1 ? *value : otherwise;
    };
    if (fields[0] == "Kd") {
      const double red = number(1, 0.8);
      material.colour = {red, number(2, red), number(3, red)};
    } else if (fields[0] == "d") {
      material.alpha = number(1, 1);
    } else if (fields[0] == "Tr") {
      material.alpha = 1 - number(1, 0);
    }
  }
  return materials;
}

}  // namespace skinfield
