#include "cli.h"
#include "posing.h"

#include "skinfield/deform/linear_blend.h"
#include "skinfield/io/file.h"
#include "skinfield/io/gltf_animation.h"
#include "skinfield/io/weights_file.h"
#include "skinfield/rig/pose.h"
#include "skinfield/weights/statistics.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>
#include <optional>

namespace skinfield::cli {
namespace {

struct Options {
  std::string a, b;
};

constexpr int frames_per_animation = 12;
constexpr double bend = 40;  // degrees, joint by joint, where a file has no animation

/// Root mean square distance between the mesh moved by either weights, over the file's animations
/// (or over bends of single joints), as a share of the bounding box diagonal.
double motion_rms(const Asset& asset, int index, const SkinWeights& a, const SkinWeights& b) {
  const Character& c = asset.characters[static_cast<std::size_t>(index)];
  double sum = 0;
  std::int64_t count = 0;
  const auto add = [&](const std::vector<Transform>& columns) {
    const Points d = linear_blend(c.mesh.V, a, columns) - linear_blend(c.mesh.V, b, columns);
    sum += d.squaredNorm();
    count += d.rows();
  };
  // Distances in bind units: what moves the whole character or its units is divided out.
  const std::vector<GltfAnimation> animations = gltf_animations(asset);
  double scale = 1;
  const auto rest = joint_skinning_transforms(asset, index);
  if (!rest.empty()) {
    double volume = 0;
    for (const Transform& t : rest) volume += std::abs(t.topLeftCorner<3, 3>().determinant());
    scale = std::cbrt(volume / static_cast<double>(rest.size()));
  }
  if (!animations.empty()) {
    for (const GltfAnimation& animation : animations)
      for (int k = 0; k < frames_per_animation; ++k)
        add(joint_skinning_transforms(asset, index, &animation,
                                      animation.begin + (animation.end - animation.begin) *
                                                            (k + 0.5) / frames_per_animation));
  } else {
    scale = 1;
    for (std::size_t j = 0; j < c.skeleton.joints.size(); ++j) {
      Pose pose = rest_pose(c.skeleton);
      if (j >= pose.joints.size()) break;
      pose.joints[j].rotation = Eigen::AngleAxisd(bend * std::numbers::pi / 180, Vec3::UnitX());
      add(column_transforms(c.skeleton, pose, PoseBase::bind));
    }
  }
  if (count == 0) return 0;
  return std::sqrt(sum / static_cast<double>(count)) / (scale * diagonal(bounding_box(c.mesh.V)));
}

struct Difference {
  Comparison weights;
  double motion = -1;  ///< below 0: there is nothing to move
  Eigen::Index rows = 0;
};

void print(const std::vector<Difference>& all, const Common& common) {
  double mean = 0, motion = 0;
  Eigen::Index rows = 0;
  bool moves = false;
  Comparison worst;
  for (const Difference& d : all) {
    mean += d.weights.mean * static_cast<double>(d.rows);
    rows += d.rows;
    worst.p95 = std::max(worst.p95, d.weights.p95);
    worst.p99 = std::max(worst.p99, d.weights.p99);
    worst.max = std::max(worst.max, d.weights.max);
    if (d.motion >= 0) moves = true, motion = std::max(motion, d.motion);
  }
  mean /= static_cast<double>(std::max<Eigen::Index>(rows, 1));
  if (common.json) {
    nlohmann::ordered_json json{{"vertices", rows},
                                {"tv_mean", mean},
                                {"tv_p95", worst.p95},
                                {"tv_p99", worst.p99},
                                {"tv_max", worst.max}};
    json["motion_rms"] = moves ? nlohmann::ordered_json(motion) : nlohmann::ordered_json(nullptr);
    fmt::print("{}\n", json.dump(1));
    return;
  }
  fmt::print(
      "vertices    {}\nTV mean     {:.6f}\nTV p95      {:.6f}\nTV p99      {:.6f}\n"
      "TV max      {:.6f}\n",
      rows, mean, worst.p95, worst.p99, worst.max);
  if (moves) fmt::print("motion RMS  {:.4f} % of the bounding box diagonal\n", 100 * motion);
}

void run(const Options& o, const Common& common) {
  const bool matrix_a = is_weights_extension(lower_extension(o.a));
  const bool matrix_b = is_weights_extension(lower_extension(o.b));
  std::vector<Difference> all;
  if (matrix_a && matrix_b) {
    const SkinWeights a = read_weights(o.a), b = read_weights(o.b);
    all.push_back({compare(a, b), -1, a.W.rows()});
    return print(all, common);
  }
  // The second file, if it is a character, gives the animations: usually the source.
  SkeletonOptions skeleton;
  skeleton.joints = "all";
  const Asset asset_b = read_characters(matrix_b ? o.a : o.b, skeleton);
  const Asset asset_a = matrix_a || matrix_b ? asset_b : read_characters(o.a, skeleton);
  if (asset_a.characters.size() != asset_b.characters.size())
    throw InputError("the files hold different numbers of characters", o.a + ", " + o.b);
  for (int i = 0; i < static_cast<int>(asset_b.characters.size()); ++i) {
    const SkinWeights a = weights_of(asset_a, i, matrix_a ? o.a : "");
    const SkinWeights b = weights_of(asset_b, i, matrix_b ? o.b : "");
    if (a.W.rows() != b.W.rows() || a.W.cols() != b.W.cols())
      throw InputError("the characters differ in vertices or joints", o.a + ", " + o.b);
    all.push_back({compare(a, b), motion_rms(asset_b, i, a, b), a.W.rows()});
  }
  print(all, common);
}

}  // namespace

void add_compare(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "compare", "How far apart two weightings are",
                            "skinfield compare hero-bound.glb hero.glb");
  verb->add_option("a", o->a, "A rigged character, or a weight matrix")->required();
  verb->add_option("b", o->b, "Another; a character's animations measure the motion")->required();
  verb->add_flag("--json", common.json, "Print JSON");
  verbs.emplace_back(verb, [o, &common] { run(*o, common); });
}

}  // namespace skinfield::cli
