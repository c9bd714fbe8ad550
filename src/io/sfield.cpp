#include "skinfield/io/sfield.h"

#include "io/bytes.h"
#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/npy.h"

#include <algorithm>

namespace skinfield {
namespace {

constexpr std::int64_t schema = 1;

NpyArray from_floats(const FloatRows& rows) {
  NpyArray array;
  array.type = "<f4";
  array.shape = {rows.rows(), rows.cols()};
  array.data.reserve(static_cast<std::size_t>(rows.size()) * sizeof(float));
  for (Eigen::Index i = 0; i < rows.size(); ++i) put_little(array.data, rows.data()[i]);
  return array;
}

NpyArray from_points(const Points& X) { return npy_from_matrix(RowMatrix(X)); }

class Arrays {
 public:
  Arrays(std::string_view bytes, const std::string& name)
      : name_(name), arrays_(parse_npz(bytes, name)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(what, name_, "save the field again");
  }
  const NpyArray& get(const std::string& key) const {
    const NpyArray* found = find_array(arrays_, key);
    if (!found) fail("lacks \"" + key + "\"");
    return *found;
  }
  RowMatrix matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const {
    RowMatrix m = npy_matrix(get(key), name_);
    if (m.size() == 0) m.resize(std::max<Eigen::Index>(rows, 0), std::max<Eigen::Index>(cols, 0));
    if ((rows >= 0 && m.rows() != rows) || (cols >= 0 && m.cols() != cols))
      fail("\"" + key + "\" has the wrong size");
    if (!m.allFinite()) fail("\"" + key + "\" is not finite");
    return m;
  }
  std::vector<std::int64_t> integers(const std::string& key) const {
    return npy_integers(get(key), name_);
  }
  std::vector<std::string> strings(const std::string& key) const {
    return npy_strings(get(key), name_);
  }

 private:
  std::string name_;
  NpzArrays arrays_;
};

}  // namespace

std::string format_sfield(const FieldFile& file) {
  const FieldState& s = file.state;
  std::vector<std::int64_t> counts(s.counts.begin(), s.counts.end()), faces, segments, vertices,
      index(file.paint.index.begin(), file.paint.index.end());
  faces.assign(file.shape.F.data(), file.shape.F.data() + file.shape.F.size());
  std::vector<std::string> names, setting_names;
  std::vector<double> ends, settings;
  for (std::size_t h = 0; h < file.handles.size(); ++h) {
    const Handle& handle = file.handles[h];
    names.push_back(handle.name);
    const auto add = [&](const Vec3& a, const Vec3& b) {
      segments.push_back(static_cast<std::int64_t>(h));
      for (const Vec3& x : {a, b}) ends.insert(ends.end(), x.data(), x.data() + 3);
    };
    if (handle.kind == Handle::Kind::point) add(handle.point, handle.point);
    for (const auto& [a, b] : handle.segments) add(a, b);
    for (const int v : handle.vertices) {
      vertices.push_back(static_cast<std::int64_t>(h));
      vertices.push_back(v);
    }
  }
  for (const auto& [key, value] : file.settings) {
    setting_names.push_back(key);
    settings.push_back(value);
  }
  return format_npz({{"schema", npy_from_integers({schema})},
                     {"solver", npy_from_strings({s.solver})},
                     {"progress", npy_from_integers({static_cast<std::int64_t>(s.seed >> 32),
                                                     static_cast<std::int64_t>(s.seed & 0xffffffff),
                                                     s.level, s.step, s.steps})},
                     {"counts", npy_from_integers(counts)},
                     {"neumann_radius", npy_from_vector({s.neumann_radius})},
                     {"points", from_points(s.X)},
                     {"parameters", from_floats(s.F)},
                     {"first_moments", from_floats(s.first)},
                     {"second_moments", from_floats(s.second)},
                     {"vertices", from_points(file.shape.V)},
                     {"normals", from_points(file.shape.N)},
                     {"faces", npy_from_integers(faces)},
                     {"box", npy_from_vector({file.box.origin[0], file.box.origin[1],
                                              file.box.origin[2], file.box.scale})},
                     {"handle_names", npy_from_strings(names)},
                     {"segment_handles", npy_from_integers(segments)},
                     {"segment_ends", npy_from_vector(ends)},
                     {"region_vertices", npy_from_integers(vertices)},
                     {"paint_index", npy_from_integers(index)},
                     {"paint_weights", npy_from_matrix(file.paint.weights)},
                     {"setting_names", npy_from_strings(setting_names)},
                     {"settings", npy_from_vector(settings)}});
}

FieldFile parse_sfield(std::string_view bytes, const std::string& name) {
  const Arrays arrays(bytes, name);
  const std::vector<std::int64_t> version = arrays.integers("schema");
  if (version.size() != 1 || version[0] != schema)
    throw InputError("is a saved field of another version", name, "save it with this version");
  FieldFile file;
  FieldState& s = file.state;
  const std::vector<std::string> solver = arrays.strings("solver");
  const std::vector<std::int64_t> progress = arrays.integers("progress");
  if (solver.size() != 1 || progress.size() != 5) arrays.fail("\"progress\" has the wrong size");
  s.solver = solver[0];
  // Two halves: arrays of integers are exact to 53 bits.
  s.seed = static_cast<std::uint64_t>(progress[0]) << 32 | static_cast<std::uint64_t>(progress[1]);
  s.step = progress[3];
  s.steps = progress[4];
  for (const std::int64_t count : arrays.integers("counts")) {
    if (count < 1 || count > INT32_MAX / 16) arrays.fail("\"counts\" is out of range");
    if (!s.counts.empty() && count < s.counts.back()) arrays.fail("\"counts\" is not ascending");
    s.counts.push_back(static_cast<int>(count));
  }
  if (progress[2] < 0 || progress[2] >= static_cast<std::int64_t>(s.counts.size()) || s.step < 0 ||
      s.steps < 0)
    arrays.fail("\"progress\" is out of range");
  s.level = static_cast<int>(progress[2]);
  s.neumann_radius = arrays.matrix("neumann_radius", 1, 1)(0, 0);
  s.X = arrays.matrix("points", -1, 3);
  const RowMatrix F = arrays.matrix("parameters", s.X.rows(), -1);
  s.F = F.cast<float>();
  if (arrays.get("first_moments").size() > 0) {
    s.first = arrays.matrix("first_moments", F.rows(), F.cols()).cast<float>();
    s.second = arrays.matrix("second_moments", F.rows(), F.cols()).cast<float>();
  }
  file.shape.V = arrays.matrix("vertices", -1, 3);
  if (arrays.get("normals").size() > 0)
    file.shape.N = arrays.matrix("normals", file.shape.V.rows(), 3);
  const auto vertex = [&](std::int64_t v, const char* key) {
    if (v < 0 || v >= file.shape.V.rows())
      arrays.fail(std::string("\"") + key + "\" names a vertex that does not exist");
    return static_cast<int>(v);
  };
  const std::vector<std::int64_t> faces = arrays.integers("faces");
  if (faces.size() % 3 != 0) arrays.fail("\"faces\" has the wrong size");
  file.shape.F.resize(static_cast<Eigen::Index>(faces.size() / 3), 3);
  for (std::size_t k = 0; k < faces.size(); ++k) file.shape.F.data()[k] = vertex(faces[k], "faces");
  const RowMatrix box = arrays.matrix("box", 4, 1);
  file.box.origin = box.topRows(3);
  file.box.scale = box(3, 0);
  if (!(file.box.scale > 0)) arrays.fail("\"box\" has no size");

  for (const std::string& handle : arrays.strings("handle_names")) {
    file.handles.emplace_back();
    file.handles.back().name = handle;
  }
  if (static_cast<Eigen::Index>(file.handles.size()) != F.cols() && !file.handles.empty())
    arrays.fail("\"handle_names\" has the wrong size");
  const auto handle = [&](std::int64_t h) -> Handle& {
    if (h < 0 || h >= static_cast<std::int64_t>(file.handles.size()))
      arrays.fail("a segment names a handle that does not exist");
    return file.handles[static_cast<std::size_t>(h)];
  };
  const std::vector<std::int64_t> segments = arrays.integers("segment_handles");
  const RowMatrix ends =
      arrays.matrix("segment_ends", static_cast<Eigen::Index>(6 * segments.size()), -1);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const double* at = ends.data() + 6 * k;
    const Vec3 a(at[0], at[1], at[2]), b(at[3], at[4], at[5]);
    Handle& to = handle(segments[k]);
    if (a == b) {
      to.kind = Handle::Kind::point;
      to.point = a;
    } else {
      to.segments.emplace_back(a, b);
    }
  }
  const std::vector<std::int64_t> regions = arrays.integers("region_vertices");
  if (regions.size() % 2 != 0) arrays.fail("\"region_vertices\" has the wrong size");
  for (std::size_t k = 0; k < regions.size(); k += 2) {
    Handle& to = handle(regions[k]);
    to.kind = Handle::Kind::region;
    to.vertices.push_back(vertex(regions[k + 1], "region_vertices"));
  }
  for (const std::int64_t v : arrays.integers("paint_index"))
    file.paint.index.push_back(vertex(v, "paint_index"));
  const auto painted = static_cast<Eigen::Index>(file.paint.index.size());
  if (painted > 0) file.paint.weights = arrays.matrix("paint_weights", painted, F.cols());
  const std::vector<std::string> keys = arrays.strings("setting_names");
  const RowMatrix values = arrays.matrix("settings", static_cast<Eigen::Index>(keys.size()), -1);
  for (std::size_t k = 0; k < keys.size(); ++k)
    file.settings.emplace_back(keys[k], values.data()[k]);
  return file;
}

FieldFile read_sfield(const std::filesystem::path& path) {
  return parse_sfield(read_file(path), path.string());
}

void write_sfield(const std::filesystem::path& path, const FieldFile& file) {
  write_file_atomically(path, format_sfield(file));
}

}  // namespace skinfield
