#include "skinfield/io/gltf_animation.h"

#include "io/gltf_document.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace skinfield {
namespace {

using namespace gltf;

const GltfDocument* document_of(const Asset& asset) {
  return dynamic_cast<const GltfDocument*>(asset.document.get());
}

GltfChannel::Interpolation interpolation_of(const std::string& name) {
  if (name == "STEP") return GltfChannel::Interpolation::step;
  if (name == "CUBICSPLINE") return GltfChannel::Interpolation::cubic_spline;
  return GltfChannel::Interpolation::linear;
}

/// False for channels that move no node.
bool read_channel(const GltfDocument& document, const Json& animation, const Json& json,
                  GltfChannel& channel, const std::string& who) {
  if (!json.is_object()) document.fail(who + " is no object", "export it again");
  const auto target = json.find("target");
  if (target == json.end() || !target->is_object()) return false;
  channel.node = document.index(*target, "node", "nodes", who);
  const std::string path = document.text(*target, "path");
  if (channel.node < 0) return false;
  int width = 3;
  if (path == "translation") {
    channel.path = GltfChannel::Path::translation;
  } else if (path == "scale") {
    channel.path = GltfChannel::Path::scale;
  } else if (path == "rotation") {
    channel.path = GltfChannel::Path::rotation;
    width = 4;
  } else {
    return false;
  }
  const std::int64_t index = document.integer(json, "sampler", -1, who);
  const auto samplers = animation.find("samplers");
  if (samplers == animation.end() || !samplers->is_array() || index < 0 ||
      static_cast<std::uint64_t>(index) >= samplers->size() ||
      !(*samplers)[static_cast<std::size_t>(index)].is_object()) {
    document.fail(who + ": its sampler is out of range", "export it again");
  }
  const Json& sampler = (*samplers)[static_cast<std::size_t>(index)];
  channel.interpolation = interpolation_of(document.text(sampler, "interpolation"));
  AccessorValues times = read_accessor(document, document.index(sampler, "input", "accessors", who),
                                       {"SCALAR"}, who + ": input");
  const AccessorValues values =
      read_accessor(document, document.index(sampler, "output", "accessors", who),
                    {width == 3 ? "VEC3" : "VEC4"}, who + ": output");
  const std::size_t each =
      channel.interpolation == GltfChannel::Interpolation::cubic_spline ? 3 : 1;
  if (times.count == 0) return false;
  if (values.count < each * times.count) {
    document.fail(who + " has fewer values than times", "export it again");
  }
  channel.values.setZero(static_cast<Eigen::Index>(each * times.count), 4);
  for (std::size_t i = 0; i < each * times.count; ++i) {
    for (int c = 0; c < width; ++c) {
      channel.values(static_cast<Eigen::Index>(i), c) = values(i, c);
    }
  }
  channel.times = std::move(times.values);
  if (!channel.values.allFinite() || !std::is_sorted(channel.times.begin(), channel.times.end()) ||
      !std::isfinite(channel.times.front()) || !std::isfinite(channel.times.back())) {
    document.fail(who + " has keys that are not finite or not in order", "export it again");
  }
  return true;
}

Eigen::Vector4d normalised(const Eigen::Vector4d& q) {
  const double length = q.norm();
  return length > 0 ? Eigen::Vector4d(q / length) : Eigen::Vector4d(0, 0, 0, 1);
}

Eigen::Vector4d sample(const GltfChannel& channel, double time) {
  const auto& t = channel.times;
  const bool cubic = channel.interpolation == GltfChannel::Interpolation::cubic_spline;
  const bool rotation = channel.path == GltfChannel::Path::rotation;
  const auto value = [&channel, cubic](std::size_t key, int which) -> Eigen::Vector4d {
    const std::size_t row = cubic ? 3 * key + static_cast<std::size_t>(which) : key;
    return channel.values.row(static_cast<Eigen::Index>(row)).transpose();
  };
  const auto after = std::upper_bound(t.begin(), t.end(), time);
  Eigen::Vector4d result;
  if (after == t.begin() || after == t.end() ||
      channel.interpolation == GltfChannel::Interpolation::step) {
    const std::size_t key =
        after == t.begin() ? 0 : static_cast<std::size_t>(after - t.begin()) - 1;
    result = value(key, 1);
  } else {
    const auto k = static_cast<std::size_t>(after - t.begin()) - 1;
    const double span = t[k + 1] - t[k], u = (time - t[k]) / span;
    if (cubic) {
      const double u2 = u * u, u3 = u2 * u;
      result = (2 * u3 - 3 * u2 + 1) * value(k, 1) + span * (u3 - 2 * u2 + u) * value(k, 2) +
               (3 * u2 - 2 * u3) * value(k + 1, 1) + span * (u3 - u2) * value(k + 1, 0);
    } else if (rotation) {
      const Eigen::Vector4d a = normalised(value(k, 1)), b = normalised(value(k + 1, 1));
      const Eigen::Quaterniond p(a[3], a[0], a[1], a[2]), q(b[3], b[0], b[1], b[2]);
      result = p.slerp(u, q).coeffs();  // the short way round
    } else {
      result = (1 - u) * value(k, 1) + u * value(k + 1, 1);
    }
  }
  return rotation ? normalised(result) : result;
}

}  // namespace

std::vector<GltfAnimation> gltf_animations(const Asset& asset) {
  std::vector<GltfAnimation> animations;
  const GltfDocument* document = document_of(asset);
  if (!document) return animations;
  const Json& list = document->list("animations");
  for (std::size_t a = 0; a < list.size(); ++a) {
    const std::string who = "animation " + std::to_string(a);
    const Json& json = document->item("animations", static_cast<std::int64_t>(a), who);
    GltfAnimation animation;
    animation.name = document->text(json, "name");
    if (animation.name.empty()) animation.name = "animation_" + std::to_string(a);
    const auto channels = json.find("channels");
    if (channels == json.end() || !channels->is_array()) {
      document->fail(who + " has no channels", "export it again");
    }
    for (std::size_t c = 0; c < channels->size(); ++c) {
      GltfChannel channel;
      if (!read_channel(*document, json, (*channels)[c], channel,
                        who + ", channel " + std::to_string(c))) {
        continue;
      }
      const bool first = animation.channels.empty();
      animation.begin =
          first ? channel.times.front() : std::min(animation.begin, channel.times.front());
      animation.end = first ? channel.times.back() : std::max(animation.end, channel.times.back());
      animation.channels.push_back(std::move(channel));
    }
    animations.push_back(std::move(animation));
  }
  return animations;
}

std::vector<Transform> joint_world_transforms(const Asset& asset, int character,
                                              const GltfAnimation* animation, double time) {
  const GltfDocument* document = document_of(asset);
  const auto c = static_cast<std::size_t>(character);
  if (!document || c >= document->characters.size()) return {};
  const std::vector<Node>& nodes = document->nodes;
  std::vector<Transform> local(nodes.size());
  if (animation) {
    std::vector<Node> posed = nodes;
    for (const GltfChannel& channel : animation->channels) {
      const auto n = static_cast<std::size_t>(channel.node);
      if (n >= posed.size()) continue;
      const Eigen::Vector4d value = sample(channel, time);
      switch (channel.path) {
        case GltfChannel::Path::translation:
          posed[n].translation = value.head<3>();
          break;
        case GltfChannel::Path::rotation:
          posed[n].rotation = value;
          break;
        case GltfChannel::Path::scale:
          posed[n].scale = value.head<3>();
          break;
      }
    }
    std::transform(posed.begin(), posed.end(), local.begin(), local_transform);
  } else {
    std::transform(nodes.begin(), nodes.end(), local.begin(), local_transform);
  }
  std::vector<Transform> world(nodes.size());
  for (const int i : document->node_order) {
    const auto n = static_cast<std::size_t>(i);
    const int parent = nodes[n].parent;
    world[n] =
        parent < 0 ? local[n] : Transform(world[static_cast<std::size_t>(parent)] * local[n]);
  }
  std::vector<Transform> joints;
  for (const int n : document->characters[c].joint_nodes) {
    joints.push_back(world[static_cast<std::size_t>(n)]);
  }
  return joints;
}

std::vector<Transform> joint_skinning_transforms(const Asset& asset, int character,
                                                 const GltfAnimation* animation, double time) {
  std::vector<Transform> transforms = joint_world_transforms(asset, character, animation, time);
  if (transforms.empty()) return transforms;
  const GltfDocument* document = document_of(asset);
  const std::vector<Joint>& joints =
      document->characters[static_cast<std::size_t>(character)].joints;
  for (std::size_t j = 0; j < transforms.size(); ++j) {
    transforms[j] = (transforms[j] * joints[j].inverse_bind).eval();
  }
  return transforms;
}

}  // namespace skinfield
