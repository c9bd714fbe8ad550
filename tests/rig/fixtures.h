// Small hand-made skeletons and a sphere.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/rig/skeleton.h"

#include <cmath>
#include <string>
#include <vector>

namespace skinfield_test {

struct JointRow {
  std::string name;
  int parent;
  skinfield::Vec3 position;
};

/// glTF joints whose frames are translations to their positions.
inline skinfield::Skeleton joint_skeleton(const std::vector<JointRow>& rows) {
  skinfield::Skeleton skeleton;
  skeleton.source = skinfield::Skeleton::Source::gltf;
  for (const JointRow& row : rows) {
    skinfield::Joint joint;
    joint.name = row.name;
    joint.parent = row.parent;
    joint.position = row.position;
    joint.world_rest.block<3, 1>(0, 3) = row.position;
    joint.inverse_bind.block<3, 1>(0, 3) = -row.position;
    joint.local_rest.block<3, 1>(0, 3) =
        row.parent < 0
            ? row.position
            : skinfield::Vec3(row.position - rows[static_cast<std::size_t>(row.parent)].position);
    skeleton.joints.push_back(joint);
  }
  return skeleton;
}

inline skinfield::Skeleton tgf_skeleton(const std::vector<skinfield::Vec3>& positions,
                                        const std::vector<std::pair<int, int>>& bones) {
  skinfield::Skeleton skeleton;
  skeleton.source = skinfield::Skeleton::Source::tgf;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    skinfield::Joint joint;
    joint.name = std::to_string(i + 1);
    joint.position = positions[i];
    skeleton.joints.push_back(joint);
  }
  skeleton.bones = bones;
  return skeleton;
}

/// Unit sphere of latitude-longitude triangles, oriented outward.
inline skinfield::Mesh sphere(int rings = 24, int sides = 48) {
  const double pi = std::acos(-1.0);
  skinfield::Mesh mesh;
  mesh.V.resize(2 + (rings - 1) * sides, 3);
  mesh.V.row(0) << 0, 0, 1;
  for (int r = 1; r < rings; ++r) {
    for (int s = 0; s < sides; ++s) {
      const double theta = pi * r / rings, phi = 2 * pi * s / sides;
      mesh.V.row(1 + (r - 1) * sides + s) << std::sin(theta) * std::cos(phi),
          std::sin(theta) * std::sin(phi), std::cos(theta);
    }
  }
  const int last = 1 + (rings - 1) * sides;
  mesh.V.row(last) << 0, 0, -1;
  mesh.F.resize(2 * sides * (rings - 1), 3);
  int f = 0;
  const auto at = [&](int r, int s) { return 1 + (r - 1) * sides + s % sides; };
  for (int s = 0; s < sides; ++s) {
    mesh.F.row(f++) << 0, at(1, s), at(1, s + 1);
    mesh.F.row(f++) << last, at(rings - 1, s + 1), at(rings - 1, s);
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.F.row(f++) << at(r, s), at(r + 1, s), at(r + 1, s + 1);
      mesh.F.row(f++) << at(r, s), at(r + 1, s + 1), at(r, s + 1);
    }
  }
  return mesh;
}

}  // namespace skinfield_test
