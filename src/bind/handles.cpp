#include "skinfield/bind/handles.h"

#include "skinfield/base/error.h"
#include "skinfield/geometry/winding_number.h"

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

}  // namespace

void keep_only(Asset& asset, const std::string& name) {
  std::set<std::string> names;
  std::vector<Character> kept;
  for (Character& c : asset.characters) {
    for (const Part& part : c.parts) names.insert(part.name);
    std::vector<Part> parts;
    for (const Part& part : c.parts)
      if (part.name == name) parts.push_back(part);
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
    if (c.weights) {
      SparseRows W(static_cast<Eigen::Index>(input_rows.size()), c.weights->W.cols());
      std::vector<Eigen::Triplet<double, std::int32_t>> entries;
      for (std::size_t r = 0; r < input_rows.size(); ++r)
        for (SparseRows::InnerIterator it(c.weights->W, input_rows[r]); it; ++it)
          entries.emplace_back(static_cast<std::int32_t>(r), it.col(), it.value());
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
    for (const std::string& n : names) list += (list.empty() ? "" : ", ") + n;
    throw InputError("no mesh or object is called " + name, asset.path, "there are: " + list);
  }
  asset.characters = std::move(kept);
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

}  // namespace skinfield
