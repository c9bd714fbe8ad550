#include "bind/ladder.h"

#include "skinfield/base/parallel.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>

namespace skinfield {

ScaledCharacter scale_to_unit_box(const Character& character) {
  ScaledCharacter scaled;
  scaled.box = unit_box(character.mesh.V);
  scaled.mesh = character.mesh;
  scaled.mesh.V = scaled.box.to(character.mesh.V);
  scaled.handles = character.skeleton.handles;
  for (Handle& handle : scaled.handles) {
    handle.point = scaled.box.to(handle.point);
    for (auto& [a, b] : handle.segments) {
      a = scaled.box.to(a);
      b = scaled.box.to(b);
    }
  }
  return scaled;
}

RowMatrix nearest_handle_weights(const Mesh& mesh, const std::vector<Handle>& handles,
                                 const Points& X, const Points& normals, bool visible,
                                 std::vector<Fill>& fill) {
  constexpr double step = 1e-4;
  RowMatrix W = RowMatrix::Zero(X.rows(), static_cast<Eigen::Index>(handles.size()));
  fill.assign(static_cast<std::size_t>(X.rows()), Fill::nearest);
  const RayScene scene(mesh.V, mesh.F);
  parallel_for(static_cast<std::size_t>(X.rows()), 64, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 x = X.row(row).transpose();
    std::vector<std::pair<double, int>> order;
    std::vector<Vec3> closest(handles.size(), x);
    for (std::size_t h = 0; h < handles.size(); ++h)
      order.emplace_back(handle_distance(handles[h], x, mesh.V, &closest[h]), static_cast<int>(h));
    std::sort(order.begin(), order.end());
    int chosen = order.front().second;
    if (visible && !scene.empty()) {
      const Vec3 n = normal_or_zero(normals, row);
      for (const auto& [distance, h] : order) {
        const Vec3& y = closest[static_cast<std::size_t>(h)];
        // A sheet has two sides: look from the one that faces the handle.
        const Vec3 from = x + (n.dot(y - x) >= 0 ? step : -step) * n;
        if (!scene.occluded(from, y, step, step)) {
          chosen = h;
          fill[i] = Fill::handle;
          break;
        }
      }
    }
    W(row, chosen) = 1;
  });
  return W;
}

}  // namespace skinfield
