// A tet mesh of the shared data with its bones' rows, set up from nothing but the files.
#pragma once

#include "skinfield/methods/bounded_biharmonic.h"
#include "skinfield/operators/mass.h"
#include "skinfield/operators/stiffness.h"
#include "support/medit.h"

#include <algorithm>
#include <filesystem>
#include <vector>

namespace skinfield_test {

struct FemCase {
  skinfield::Mesh mesh;
  skinfield::SparseRows K;
  skinfield::Vector M;
  skinfield::FixedRows fixed;
  skinfield::BoundedBiharmonicProblem problem() const { return {K, M, fixed}; }
};

/// Vertices on a bone are fixed to it; on k bones, to 1/k each.
inline skinfield::FixedRows rows_on_bones(
    const skinfield::Mesh& mesh,
    const std::vector<std::pair<skinfield::Vec3, skinfield::Vec3>>& bones) {
  using skinfield::Vec3;
  const double tolerance = 1e-6 * skinfield::diagonal(skinfield::bounding_box(mesh.V));
  skinfield::FixedRows fixed;
  std::vector<Eigen::RowVectorXd> rows;
  for (int i = 0; i < mesh.V.rows(); ++i) {
    Eigen::RowVectorXd w = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(bones.size()));
    for (std::size_t b = 0; b < bones.size(); ++b) {
      const Vec3 x = mesh.V.row(i), a = bones[b].first, d = bones[b].second - a;
      const double t = std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
      if ((a + t * d - x).norm() <= tolerance) w[static_cast<Eigen::Index>(b)] = 1;
    }
    if (w.sum() == 0) continue;
    fixed.node.push_back(i);
    rows.push_back(w / w.sum());
  }
  fixed.weights.resize(static_cast<Eigen::Index>(rows.size()),
                       static_cast<Eigen::Index>(bones.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    fixed.weights.row(static_cast<Eigen::Index>(k)) = rows[k];
  }
  return fixed;
}

inline FemCase read_fem_case(const std::filesystem::path& mesh,
                             const std::filesystem::path& bones) {
  FemCase result;
  if (!read_medit(mesh, result.mesh)) return result;
  result.fixed = rows_on_bones(result.mesh, read_bones(bones));
  result.K = skinfield::stiffness(result.mesh.V, result.mesh.T);
  result.M = skinfield::barycentric_mass(result.mesh.V, result.mesh.T);
  return result;
}

}  // namespace skinfield_test
