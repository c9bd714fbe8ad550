#include "posing.h"

#include "skinfield/deform/dual_quaternion.h"
#include "skinfield/deform/linear_blend.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf_animation.h"
#include "skinfield/io/pose_file.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/rig/pose.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace skinfield::cli {
namespace {

/// A pose file's first frame as rig's pose, by names of columns or by index.
Pose pose_from_file(const Skeleton& skeleton, const std::string& path) {
  const PoseFile file = read_pose(path);
  Pose pose = rest_pose(skeleton);
  if (lower_extension(path) == ".dmat") {
    std::vector<double> xyzw;
    for (const PoseEntry& entry : file.frames.front())
      for (int k = 0; k < 4; ++k) xyzw.push_back(entry.rotation.coeffs()[k]);
    return pose_from_quaternions(skeleton, xyzw);
  }
  for (const PoseEntry& entry : file.frames.front()) {
    int column = entry.index;
    if (!entry.name.empty()) {
      const auto& names = skeleton.column_names;
      const auto found = std::find(names.begin(), names.end(), entry.name);
      column = found == names.end() ? -1 : static_cast<int>(found - names.begin());
    }
    if (column < 0 || column >= static_cast<int>(pose.joints.size()))
      throw InputError(
          "no handle " + (entry.name.empty() ? std::to_string(entry.index) : entry.name), path,
          "use the skeleton's joint names or 0-based handle indices");
    pose.joints[static_cast<std::size_t>(column)].rotation = entry.rotation;
    pose.joints[static_cast<std::size_t>(column)].translation = entry.translation;
  }
  return pose;
}

const GltfAnimation& find_animation(const std::vector<GltfAnimation>& all, const std::string& which,
                                    const std::string& path) {
  for (const GltfAnimation& a : all)
    if (a.name == which) return a;
  char* end = nullptr;
  const long index = std::strtol(which.c_str(), &end, 10);
  if (!which.empty() && *end == 0 && index >= 0 && index < static_cast<long>(all.size()))
    return all[static_cast<std::size_t>(index)];
  std::string list;
  for (const GltfAnimation& a : all) list += (list.empty() ? "" : ", ") + a.name;
  throw InputError("no animation " + which, path, "there are: " + (list.empty() ? "none" : list));
}

}  // namespace

SkinWeights merged_weights(const Character& character, const SkinWeights& input_weights) {
  if (input_weights.W.rows() != static_cast<Eigen::Index>(character.vertex_of_input.size()))
    throw InputError("the weights have " + std::to_string(input_weights.W.rows()) +
                         " rows, the mesh " + std::to_string(character.vertex_of_input.size()) +
                         " vertices",
                     character.name);
  std::vector<char> done(static_cast<std::size_t>(character.mesh.V.rows()), 0);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (std::size_t i = 0; i < character.vertex_of_input.size(); ++i) {
    const int v = character.vertex_of_input[i];
    if (done[static_cast<std::size_t>(v)]) continue;
    done[static_cast<std::size_t>(v)] = 1;
    for (SparseRows::InnerIterator it(input_weights.W, static_cast<Eigen::Index>(i)); it; ++it)
      entries.emplace_back(v, it.col(), it.value());
  }
  SkinWeights merged;
  merged.names = input_weights.names;
  merged.W.resize(character.mesh.V.rows(), input_weights.W.cols());
  merged.W.setFromTriplets(entries.begin(), entries.end());
  return merged;
}

SkinWeights weights_of(const Asset& asset, int character, const std::string& weights_path) {
  const Character& c = asset.characters[static_cast<std::size_t>(character)];
  if (weights_path.empty()) {
    if (!c.weights)
      throw InputError("the file has no weights", asset.path,
                       "bind it first, or give --weights FILE");
    return merged_weights(c, *c.weights);
  }
  SkinWeights weights = read_weights(weights_path);
  if (c.skeleton.columns > 0 && weights.W.cols() != c.skeleton.columns)
    throw InputError("the weights have " + std::to_string(weights.W.cols()) +
                         " columns, the skeleton " + std::to_string(c.skeleton.columns) +
                         " handles",
                     weights_path);
  if (weights.names.empty()) weights.names = c.skeleton.column_names;
  return merged_weights(c, weights);
}

std::vector<Transform> pose_transforms(const Asset& asset, int character, const std::string& pose) {
  const Skeleton& skeleton = asset.characters[static_cast<std::size_t>(character)].skeleton;
  if (skeleton.handles.empty())
    throw InputError("the file has no bones to pose", asset.path,
                     "give --skeleton FILE or --regions FILE");
  if (pose == "demo") return column_transforms(skeleton, demo_pose(skeleton), PoseBase::bind);
  if (pose == "bind") return column_transforms(skeleton, rest_pose(skeleton), PoseBase::bind);
  if (pose == "rest") return column_transforms(skeleton, rest_pose(skeleton), PoseBase::rest);
  const std::string extension = lower_extension(pose);
  if (extension == ".json" || extension == ".dmat")
    return column_transforms(skeleton, pose_from_file(skeleton, pose), PoseBase::rest);
  const std::size_t at = pose.rfind('@');
  if (at == std::string::npos)
    throw UsageError("--pose " + pose +
                     ": use demo, bind, rest, FILE.json, FILE.dmat or ANIMATION@SECONDS");
  char* end = nullptr;
  const std::string seconds = pose.substr(at + 1);
  const double time = std::strtod(seconds.c_str(), &end);
  if (seconds.empty() || *end != 0 || !std::isfinite(time))
    throw UsageError("--pose " + pose + ": " + seconds + " is not a number of seconds");
  const std::vector<GltfAnimation> all = gltf_animations(asset);
  const GltfAnimation& animation = find_animation(all, pose.substr(0, at), asset.path);
  return joint_skinning_transforms(asset, character, &animation, time);
}

Eigen::Matrix3d turn_to_world(const Asset& asset, int character) {
  const std::vector<Transform> rest = joint_skinning_transforms(asset, character);
  if (rest.empty()) return Eigen::Matrix3d::Identity();
  // The first joint is the root of most skins; its own rest rotation against the bind pose is the
  // file's change of axes. The nearest rotation is the orthogonal factor.
  const Eigen::Matrix3d A = rest.front().topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  return R.allFinite() && R.determinant() > 0 ? R : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

Points deformed(const Points& V, const SkinWeights& weights, std::span<const Transform> columns,
                const std::string& skinning) {
  return skinning == "dqs" ? dual_quaternion(V, weights, columns)
                           : linear_blend(V, weights, columns);
}

}  // namespace skinfield::cli
