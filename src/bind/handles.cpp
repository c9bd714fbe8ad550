#include "skinfield/bind/handles.h"

#include "skinfield/base/error.h"
#include "skinfield/geometry/winding_number.h"
#include "skinfield/io/obj.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace skinfield {
namespace {

/// Joints that any existing weight uses.
std::vector<bool> used_joints(const Character& character) {
  std::vector<bool> used;
  if (!character.weights) return used;
  used.assign(character.skeleton.joints.size(), false);
  const SparseRows& W = character.weights->W;
  for (Eigen::Index i = 0; i < W.rows(); ++i)
    for (SparseRows::InnerIterator it(W, i); it; ++it)
      if (it.value() > 0 && static_cast<std::size_t>(it.col()) < used.size())
        used[static_cast<std::size_t>(it.col())] = true;
  return used;
}

using Triplets = std::vector<Eigen::Triplet<double, std::int32_t>>;

/// Appends row `from` of W to `entries` as row `to`.
void append_row(const SparseRows& W, Eigen::Index from, Eigen::Index to, Triplets& entries) {
  for (SparseRows::InnerIterator it(W, from); it; ++it)
    entries.emplace_back(static_cast<std::int32_t>(to), it.col(), it.value());
}

/// What an OBJ says about the faces and parts that are kept.
std::shared_ptr<const Document> kept_document(const ObjDocument& document, Eigen::Index faces,
                                              const std::vector<int>& face_rows,
                                              const std::vector<std::size_t>& part_rows) {
  auto kept = std::make_shared<ObjDocument>(document);
  for (Triangles* table : {&kept->texcoord_of_corner, &kept->normal_of_corner})
    if (table->rows() == faces) *table = Triangles((*table)(face_rows, Eigen::all));
  kept->material_of_part.clear();
  for (std::size_t p : part_rows)
    if (p < document.material_of_part.size())
      kept->material_of_part.push_back(document.material_of_part[p]);
  return kept;
}

/// The segments of the parts that are kept.
Outline kept_outline(const Outline& outline, const std::vector<std::size_t>& part_rows,
                     const std::vector<int>& renumbered) {
  Outline kept;
  std::vector<Eigen::Index> rows;
  for (std::size_t e = 0; e < outline.shape.size(); ++e) {
    const auto part =
        std::find(part_rows.begin(), part_rows.end(), static_cast<std::size_t>(outline.shape[e]));
    if (part == part_rows.end()) continue;
    rows.push_back(static_cast<Eigen::Index>(e));
    kept.shape.push_back(static_cast<int>(part - part_rows.begin()));
  }
  kept.E = Segments(outline.E(rows, Eigen::all)).unaryExpr([&renumbered](std::int32_t v) {
    return renumbered[static_cast<std::size_t>(v)];
  });
  std::vector<std::int32_t> loose;
  for (Eigen::Index e = 0; e < outline.loose.rows(); ++e) {
    const int a = renumbered[static_cast<std::size_t>(outline.loose(e, 0))];
    const int b = renumbered[static_cast<std::size_t>(outline.loose(e, 1))];
    if (a >= 0 && b >= 0) loose.insert(loose.end(), {a, b});
  }
  kept.loose =
      Eigen::Map<const Segments>(loose.data(), static_cast<Eigen::Index>(loose.size() / 2), 2);
  return kept;
}

/// The merged vertices of a region, ascending.
std::vector<int> region_vertices(const Character& character, const SparseRows& regions,
                                 Eigen::Index column) {
  std::set<int> vertices;
  for (Eigen::Index i = 0; i < regions.rows(); ++i) {
    const double entry = regions.coeff(i, column);
    if (entry == 0) continue;
    if (entry != 1)
      throw InputError("vertex " + std::to_string(i) + " has an entry that is neither 0 nor 1",
                       character.name, "a vertex belongs to a region or not (shares: --paint)");
    vertices.insert(character.vertex_of_input[static_cast<std::size_t>(i)]);
  }
  if (vertices.empty())
    throw InputError("region " + std::to_string(column) + " has no vertex", character.name,
                     "give each column at least one 1");
  return {vertices.begin(), vertices.end()};
}

/// A root joint that stands for a region among a glTF's.
Joint region_joint(const Handle& region) {
  Joint joint;
  joint.name = region.name;
  joint.position = region.point;
  joint.local_rest.topRightCorner<3, 1>() = region.point;
  joint.world_rest = joint.local_rest;
  joint.inverse_bind.topRightCorner<3, 1>() = -region.point;
  return joint;
}

}  // namespace

void keep_only(Asset& asset, const std::string& name) {
  std::set<std::string> names;
  std::vector<Character> kept;
  for (Character& c : asset.characters) {
    for (const Part& part : c.parts) names.insert(part.name);
    std::vector<Part> parts;
    std::vector<std::size_t> part_rows;
    for (std::size_t p = 0; p < c.parts.size(); ++p) {
      if (c.parts[p].name != name) continue;
      parts.push_back(c.parts[p]);
      part_rows.push_back(p);
    }
    if (parts.empty()) continue;
    std::vector<int> input_rows, face_rows;
    for (Part& part : parts) {
      const int begin = static_cast<int>(input_rows.size());
      const int face_begin = static_cast<int>(face_rows.size());
      for (int i = part.begin; i < part.end; ++i) input_rows.push_back(i);
      for (int f = part.face_begin; f < part.face_end; ++f) face_rows.push_back(f);
      part.begin = begin, part.end = static_cast<int>(input_rows.size());
      part.face_begin = face_begin, part.face_end = static_cast<int>(face_rows.size());
    }
    std::vector<int> renumbered(static_cast<std::size_t>(c.mesh.V.rows()), -1);
    std::vector<int> vertices;
    std::vector<int> vertex_of_input;
    for (int i : input_rows) {
      int& r = renumbered[static_cast<std::size_t>(c.vertex_of_input[static_cast<std::size_t>(i)])];
      if (r < 0) {
        r = static_cast<int>(vertices.size());
        vertices.push_back(c.vertex_of_input[static_cast<std::size_t>(i)]);
      }
      vertex_of_input.push_back(r);
    }
    Mesh mesh;
    mesh.V = c.mesh.V(vertices, Eigen::all);
    if (c.mesh.N.rows() > 0) mesh.N = c.mesh.N(vertices, Eigen::all);
    mesh.F.resize(static_cast<Eigen::Index>(face_rows.size()), 3);
    for (std::size_t f = 0; f < face_rows.size(); ++f)
      for (int k = 0; k < 3; ++k)
        mesh.F(static_cast<Eigen::Index>(f), k) =
            renumbered[static_cast<std::size_t>(c.mesh.F(face_rows[f], k))];
    mesh.outline = kept_outline(c.mesh.outline, part_rows, renumbered);
    if (c.input_faces.rows() > 0) {
      std::vector<int> row_of_input(c.vertex_of_input.size(), -1);
      for (std::size_t r = 0; r < input_rows.size(); ++r)
        row_of_input[static_cast<std::size_t>(input_rows[r])] = static_cast<int>(r);
      Triangles faces = c.input_faces(face_rows, Eigen::all);
      for (Eigen::Index k = 0; k < faces.size(); ++k)
        faces.data()[k] = row_of_input[static_cast<std::size_t>(faces.data()[k])];
      c.input_faces = std::move(faces);
    }
    if (c.input_normals.rows() > 0)
      c.input_normals = Points(c.input_normals(input_rows, Eigen::all));
    if (const auto* obj = dynamic_cast<const ObjDocument*>(asset.document.get()))
      asset.document = kept_document(*obj, c.mesh.F.rows(), face_rows, part_rows);
    if (c.weights) {
      SparseRows W(static_cast<Eigen::Index>(input_rows.size()), c.weights->W.cols());
      Triplets entries;
      for (std::size_t r = 0; r < input_rows.size(); ++r)
        append_row(c.weights->W, input_rows[r], static_cast<Eigen::Index>(r), entries);
      W.setFromTriplets(entries.begin(), entries.end());
      c.weights->W = W;
    }
    c.mesh = std::move(mesh);
    c.parts = std::move(parts);
    c.vertex_of_input = std::move(vertex_of_input);
    kept.push_back(std::move(c));
  }
  if (kept.empty()) {
    std::string list;
    for (const std::string& n : names)
      if (!n.empty()) list += (list.empty() ? "" : ", ") + n;
    throw InputError("no mesh or object is called " + name, asset.path,
                     list.empty() ? "none in it has a name" : "there are: " + list);
  }
  asset.characters = std::move(kept);
}

std::vector<SkinWeights> weights_among_others(const Asset& whole, const std::string& name,
                                              const std::vector<SkinWeights>& kept) {
  std::vector<SkinWeights> all;
  std::size_t next = 0;
  for (const Character& c : whole.characters) {
    const auto is_kept = [&name](const Part& part) { return part.name == name; };
    all.emplace_back();
    if (std::none_of(c.parts.begin(), c.parts.end(), is_kept)) continue;
    const SkinWeights& given = kept.at(next++);
    const bool others = !std::all_of(c.parts.begin(), c.parts.end(), is_kept);
    if (others && (!c.weights || c.weights->W.cols() != given.W.cols()))
      throw InputError("its other meshes have no weights for this skeleton", whole.path,
                       "bind all of them, or write a weight matrix");
    Triplets entries;
    Eigen::Index row = 0;
    for (const Part& part : c.parts)
      for (int i = part.begin; i < part.end; ++i)
        if (is_kept(part))
          append_row(given.W, row++, i, entries);
        else
          append_row(c.weights->W, i, i, entries);
    all.back().names = given.names;
    all.back().W.resize(static_cast<Eigen::Index>(c.vertex_of_input.size()), given.W.cols());
    all.back().W.setFromTriplets(entries.begin(), entries.end());
  }
  return all;
}

void give_skeleton(Character& character, const Skeleton& skeleton) {
  character.skeleton = skeleton;
  character.weights.reset();
}

void make_handles(Character& character, const JointOptions& options) {
  Skeleton& skeleton = character.skeleton;
  if (skeleton.source == Skeleton::Source::tgf) return make_tgf_handles(skeleton);
  InsideTest inside;
  std::optional<WindingNumber> winding;
  if (character.mesh.F.rows() > 0) {
    winding.emplace(character.mesh.V, character.mesh.F);
    // Broken shapes read low inside; half of what the joints see is the boundary there.
    std::vector<double> at_joints;
    for (const Joint& joint : skeleton.joints) at_joints.push_back(winding->at(joint.position));
    std::nth_element(at_joints.begin(),
                     at_joints.begin() + static_cast<std::ptrdiff_t>(at_joints.size() / 2),
                     at_joints.end());
    const double level = 0.5 * std::clamp(at_joints[at_joints.size() / 2], 0.0, 1.0);
    if (level > 0.1) inside = inside_test(*winding, level);
  }
  make_joint_handles(skeleton, options, used_joints(character), inside);
}

void add_regions(Character& character, const SkinWeights& regions) {
  const auto inputs = static_cast<Eigen::Index>(character.vertex_of_input.size());
  if (regions.W.rows() != inputs)
    throw InputError("holds " + std::to_string(regions.W.rows()) + " rows for " +
                         std::to_string(inputs) + " vertices",
                     character.name, "give one a vertex, in the file's order");
  Skeleton& skeleton = character.skeleton;
  for (Eigen::Index c = 0; c < regions.W.cols(); ++c) {
    const auto k = static_cast<std::size_t>(c);
    Handle handle;
    handle.kind = Handle::Kind::region;
    handle.name = k < regions.names.size() ? regions.names[k] : "region_" + std::to_string(c);
    handle.vertices = region_vertices(character, regions.W, c);
    handle.point = character.mesh.V(handle.vertices, Eigen::all).colwise().mean().transpose();
    if (skeleton.source == Skeleton::Source::gltf) {
      handle.joint = static_cast<int>(skeleton.joints.size());
      skeleton.joints.push_back(region_joint(handle));
    }
    skeleton.column.push_back(skeleton.columns++);
    skeleton.column_names.push_back(handle.name);
    skeleton.handles.push_back(std::move(handle));
  }
}

}  // namespace skinfield
