#include "skinfield/io/sfield.h"

#include "io/bytes.h"
#include "skinfield/base/error.h"
#include "skinfield/io/file.h"
#include "skinfield/io/npy.h"

#include <algorithm>

namespace skinfield {
namespace {

constexpr std::int64_t schema = 3;  // 1 had no skeleton, 2 no outline

NpyArray from_floats(const FloatRows& rows) {
  NpyArray array;
  array.type = "<f4";
  array.shape = {rows.rows(), rows.cols()};
  array.data.reserve(static_cast<std::size_t>(rows.size()) * sizeof(float));
  for (Eigen::Index i = 0; i < rows.size(); ++i) put_little(array.data, rows.data()[i]);
  return array;
}

NpyArray integers_of(const Segments& E) {
  return npy_from_integers(std::vector<std::int64_t>(E.data(), E.data() + E.size()));
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

Vec3 from_box(const UnitBox& box, const Vec3& x) { return x / box.scale + box.origin; }

/// The skeleton's handles from the file's.
void place_handles(FieldFile& file) {
  file.skeleton.handles = file.handles;
  for (Handle& handle : file.skeleton.handles) {
    if (handle.kind == Handle::Kind::region) {
      handle.kind = Handle::Kind::point;
      handle.point.setZero();
      for (const int v : handle.vertices)
        handle.point +=
            file.shape.V.row(v).transpose() / static_cast<double>(handle.vertices.size());
      handle.vertices.clear();
    }
    handle.point = from_box(file.box, handle.point);
    for (auto& [a, b] : handle.segments) {
      a = from_box(file.box, a);
      b = from_box(file.box, b);
    }
  }
}

constexpr Eigen::Index joint_numbers = 3 + 3 * 16;  // position, inverse bind, local and world rest

void add_skeleton(const Skeleton& skeleton, NpzArrays& arrays) {
  std::vector<std::string> names;
  std::vector<std::int64_t> parents, bones, handle_joints;
  RowMatrix numbers(static_cast<Eigen::Index>(skeleton.joints.size()), joint_numbers);
  for (const Joint& joint : skeleton.joints) {
    double* row = numbers.row(static_cast<Eigen::Index>(names.size())).data();
    names.push_back(joint.name);
    parents.push_back(joint.parent);
    row = std::copy_n(joint.position.data(), 3, row);
    for (const Transform* T : {&joint.inverse_bind, &joint.local_rest, &joint.world_rest})
      row = std::copy_n(T->data(), 16, row);
  }
  for (const auto& [head, tail] : skeleton.bones) bones.insert(bones.end(), {head, tail});
  for (const Handle& handle : skeleton.handles) handle_joints.push_back(handle.joint);
  arrays.insert(
      arrays.end(),
      {{"skeleton_source", npy_from_integers({static_cast<std::int64_t>(skeleton.source)})},
       {"joint_names", npy_from_strings(names)},
       {"joint_parents", npy_from_integers(parents)},
       {"joint_numbers", npy_from_matrix(numbers)},
       {"bones", npy_from_integers(bones)},
       {"handle_joints", npy_from_integers(handle_joints)},
       {"handle_columns", npy_from_integers(std::vector<std::int64_t>(skeleton.column.begin(),
                                                                      skeleton.column.end()))},
       {"column_names", npy_from_strings(skeleton.column_names)}});
}

/// Do all parents lead to a root?
bool is_forest(const std::vector<Joint>& joints) {
  std::vector<char> rooted(joints.size(), 0);
  std::vector<std::size_t> chain;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    chain.clear();
    for (int at = static_cast<int>(j); at >= 0 && !rooted[static_cast<std::size_t>(at)];
         at = joints[static_cast<std::size_t>(at)].parent) {
      chain.push_back(static_cast<std::size_t>(at));
      if (chain.size() > joints.size()) return false;
    }
    for (const std::size_t at : chain) rooted[at] = 1;
  }
  return true;
}

/// Needs the file's handles. @param handles columns of the parameters.
void read_skeleton_arrays(const Arrays& arrays, Eigen::Index handles, FieldFile& file) {
  Skeleton& skeleton = file.skeleton;
  const auto index = [&](std::int64_t i, std::int64_t least, std::size_t end, const char* key) {
    if (i < least || i >= static_cast<std::int64_t>(end))
      arrays.fail(std::string("\"") + key + "\" names what does not exist");
    return static_cast<int>(i);
  };
  const std::vector<std::int64_t> source = arrays.integers("skeleton_source");
  if (source.size() != 1 || source[0] < 0 || source[0] > 2)
    arrays.fail("\"skeleton_source\" is out of range");
  skeleton.source = static_cast<Skeleton::Source>(source[0]);
  const std::vector<std::string> names = arrays.strings("joint_names");
  const std::vector<std::int64_t> parents = arrays.integers("joint_parents");
  const RowMatrix numbers =
      arrays.matrix("joint_numbers", static_cast<Eigen::Index>(names.size()), joint_numbers);
  if (parents.size() != names.size()) arrays.fail("\"joint_parents\" has the wrong size");
  for (std::size_t j = 0; j < names.size(); ++j) {
    Joint& joint = skeleton.joints.emplace_back();
    joint.name = names[j];
    joint.parent = index(parents[j], -1, names.size(), "joint_parents");
    const double* row = numbers.row(static_cast<Eigen::Index>(j)).data();
    joint.position = Eigen::Map<const Vec3>(row);
    row += 3;
    for (Transform* T : {&joint.inverse_bind, &joint.local_rest, &joint.world_rest}) {
      *T = Eigen::Map<const Transform>(row);
      row += 16;
    }
  }
  if (!is_forest(skeleton.joints)) arrays.fail("\"joint_parents\" goes in circles");
  const std::vector<std::int64_t> bones = arrays.integers("bones");
  if (bones.size() % 2 != 0) arrays.fail("\"bones\" has the wrong size");
  for (std::size_t b = 0; b < bones.size(); b += 2)
    skeleton.bones.emplace_back(index(bones[b], 0, names.size(), "bones"),
                                index(bones[b + 1], 0, names.size(), "bones"));
  const std::vector<std::int64_t> joints = arrays.integers("handle_joints");
  if (joints.size() != file.handles.size()) arrays.fail("\"handle_joints\" has the wrong size");
  for (std::size_t h = 0; h < joints.size(); ++h)
    file.handles[h].joint = index(joints[h], -1, names.size(), "handle_joints");
  skeleton.column_names = arrays.strings("column_names");
  skeleton.columns = static_cast<int>(skeleton.column_names.size());
  for (const std::int64_t c : arrays.integers("handle_columns"))
    skeleton.column.push_back(index(c, 0, skeleton.column_names.size(), "handle_columns"));
  if (static_cast<Eigen::Index>(skeleton.column.size()) != handles)
    arrays.fail("\"handle_columns\" has the wrong size");
  place_handles(file);
}

void read_mirror(const Arrays& arrays, Eigen::Index handles, FieldFile& file) {
  for (const std::int64_t h : arrays.integers("mirror_partner")) {
    if (h < 0 || h >= handles) arrays.fail("\"mirror_partner\" names what does not exist");
    file.mirror_partner.push_back(static_cast<int>(h));
  }
  if (!file.mirror_partner.empty() &&
      static_cast<Eigen::Index>(file.mirror_partner.size()) != handles)
    arrays.fail("\"mirror_partner\" has the wrong size");
  file.mirror_plane = arrays.matrix("mirror_plane", 1, 1)(0, 0);
}

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
  NpzArrays arrays{
      {"schema", npy_from_integers({schema})},
      {"solver", npy_from_strings({s.solver})},
      {"progress", npy_from_integers({static_cast<std::int64_t>(s.seed >> 32),
                                      static_cast<std::int64_t>(s.seed & 0xffffffff), s.level,
                                      s.step, s.steps})},
      {"counts", npy_from_integers(counts)},
      {"neumann_radius", npy_from_vector({s.neumann_radius})},
      {"points", from_points(s.X)},
      {"parameters", from_floats(s.F)},
      {"first_moments", from_floats(s.first)},
      {"second_moments", from_floats(s.second)},
      {"vertices", from_points(file.shape.V)},
      {"normals", from_points(file.shape.N)},
      {"faces", npy_from_integers(faces)},
      {"outline", integers_of(file.shape.outline.E)},
      {"outline_shapes", npy_from_integers(std::vector<std::int64_t>(
                             file.shape.outline.shape.begin(), file.shape.outline.shape.end()))},
      {"loose_segments", integers_of(file.shape.outline.loose)},
      {"box", npy_from_vector(
                  {file.box.origin[0], file.box.origin[1], file.box.origin[2], file.box.scale})},
      {"handle_names", npy_from_strings(names)},
      {"segment_handles", npy_from_integers(segments)},
      {"segment_ends", npy_from_vector(ends)},
      {"region_vertices", npy_from_integers(vertices)},
      {"paint_index", npy_from_integers(index)},
      {"paint_weights", npy_from_matrix(file.paint.weights)},
      {"setting_names", npy_from_strings(setting_names)},
      {"settings", npy_from_vector(settings)},
      {"mirror_partner", npy_from_integers(std::vector<std::int64_t>(file.mirror_partner.begin(),
                                                                     file.mirror_partner.end()))},
      {"mirror_plane", npy_from_vector({file.mirror_plane})}};
  add_skeleton(file.skeleton, arrays);
  return format_npz(arrays);
}

FieldFile parse_sfield(std::string_view bytes, const std::string& name) {
  const Arrays arrays(bytes, name);
  const std::vector<std::int64_t> version = arrays.integers("schema");
  if (version.size() != 1 || version[0] != schema)
    throw InputError("is a saved field of version " +
                         (version.size() == 1 ? std::to_string(version[0]) : "?") +
                         ", this program reads version " + std::to_string(schema),
                     name, "save it with this program, or read it with the one that saved it");
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
  const auto pairs = [&](const char* key) {
    const std::vector<std::int64_t> list = arrays.integers(key);
    if (list.size() % 2 != 0) arrays.fail(std::string("\"") + key + "\" has the wrong size");
    Segments E(static_cast<Eigen::Index>(list.size() / 2), 2);
    for (std::size_t k = 0; k < list.size(); ++k) E.data()[k] = vertex(list[k], key);
    return E;
  };
  Outline& outline = file.shape.outline;
  outline.E = pairs("outline");
  outline.loose = pairs("loose_segments");
  for (const std::int64_t shape : arrays.integers("outline_shapes")) {
    if (shape < 0 || shape > outline.E.rows()) arrays.fail("\"outline_shapes\" is out of range");
    outline.shape.push_back(static_cast<int>(shape));
  }
  if (static_cast<Eigen::Index>(outline.shape.size()) != outline.E.rows())
    arrays.fail("\"outline_shapes\" has the wrong size");
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
  read_mirror(arrays, F.cols(), file);
  read_skeleton_arrays(arrays, F.cols(), file);
  return file;
}

FieldFile read_sfield(const std::filesystem::path& path) {
  return parse_sfield(read_file(path), path.string());
}

void write_sfield(const std::filesystem::path& path, const FieldFile& file) {
  write_file_atomically(path, format_sfield(file));
}

}  // namespace skinfield
