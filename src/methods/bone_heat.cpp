#include "skinfield/methods/bone_heat.h"

#include "methods/direct_solve.h"
#include "methods/locks.h"
#include "methods/reached.h"
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/ray_scene.h"
#include "skinfield/operators/stiffness.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace skinfield {
namespace {

constexpr const char* kWhere = "bone heat";
constexpr double kEqual = 1 + 1e-4;   // distances that count as the same
constexpr double kSkip = 1e-5;        // of the box diagonal: a vertex lies on the surface
constexpr double kNearest = 1e-6;     // of the box diagonal: no handle is nearer
constexpr double kLeastInside = 0.1;  // winding number below which a shape has no inside

/// What sees what, and what lies inside.
class View {
 public:
  View(const Mesh& mesh, const std::vector<Handle>& handles)
      : scene_(mesh.V, mesh.F), diagonal_(diagonal(bounding_box(mesh.V))) {
    if (!(diagonal_ > 0)) diagonal_ = 1;
    std::vector<double> at_handles;
    WindingNumber winding(mesh.V, mesh.F);
    for (const Handle& handle : handles) {
      if (handle.kind == Handle::Kind::region) continue;  // on the surface, not inside
      const Vector w = winding.at(sample_handle(handle, 0.05 * diagonal_));
      at_handles.insert(at_handles.end(), w.begin(), w.end());
    }
    if (at_handles.empty()) return;
    // Broken shapes read low inside: half of what the handles read is the boundary there.
    const auto middle = at_handles.begin() + static_cast<std::ptrdiff_t>(at_handles.size() / 2);
    std::nth_element(at_handles.begin(), middle, at_handles.end());
    level_ = 0.5 * std::clamp(*middle, 0.0, 1.0);
    if (level_ > kLeastInside) winding_.emplace(std::move(winding));
  }

  double length_unit() const { return diagonal_; }
  /// Does the segment from a vertex to a point of a handle lie in the shape?
  bool clear(const Vec3& vertex, const Vec3& y) const {
    const double skip = kSkip * diagonal_;
    if ((y - vertex).norm() <= 2 * skip) return true;
    if (!scene_.empty() && scene_.occluded(vertex, y, skip, skip)) return false;
    return !winding_ || winding_->at(Vec3(0.5 * (vertex + y))) > level_;
  }

 private:
  RayScene scene_;
  double diagonal_;
  std::optional<WindingNumber> winding_;
  double level_ = 0;
};

/// The handles that heat a vertex, and H_jj.
struct Heat {
  std::vector<int> from;
  double H = 0;
};

Heat heat_of(const Vec3& x, const Mesh& mesh, const std::vector<Handle>& handles, const View& view,
             double c) {
  std::vector<std::pair<double, int>> order;
  std::vector<Vec3> closest(handles.size(), x);
  for (std::size_t h = 0; h < handles.size(); ++h) {
    const double d = handle_distance(handles[h], x, mesh.V, &closest[h]);
    if (std::isfinite(d)) order.emplace_back(d, static_cast<int>(h));
  }
  std::sort(order.begin(), order.end());
  Heat heat;
  double d = 0;
  for (const auto& [distance, h] : order) {
    if (!heat.from.empty() && distance > d * kEqual) break;
    if (!view.clear(x, closest[static_cast<std::size_t>(h)])) continue;
    if (heat.from.empty()) d = std::max(distance, kNearest * view.length_unit());
    heat.from.push_back(h);
  }
  // Section 4: equally near bones all heat the vertex, each as if it were alone.
  if (!heat.from.empty()) heat.H = c * static_cast<double>(heat.from.size()) / (d * d);
  return heat;
}

void check(const Mesh& mesh, const std::vector<Handle>& handles, const BoneHeatOptions& options) {
  const Eigen::Index n = mesh.V.rows();
  const auto m = static_cast<Eigen::Index>(handles.size());
  const auto refuse = [](const std::string& what) { throw SolveError(what, kWhere); };
  if (n == 0 || mesh.F.rows() == 0) refuse("the mesh has no triangles");
  if (m == 0) refuse("there is no handle");
  if (!(options.heat > 0) || !std::isfinite(options.heat)) refuse("the heat is not positive");
  if (options.masses.size() && (options.masses.size() != n || !(options.masses.minCoeff() > 0))) {
    refuse("the masses are not one positive number a vertex");
  }
  if (!options.paint.node.empty() && options.paint.weights.cols() != m) {
    refuse("the paint has a wrong number of columns");
  }
  if (options.start.size() && (options.start.rows() != n || options.start.cols() != m)) {
    refuse("the start has a wrong size");
  }
  if (!options.locked.empty() && options.start.size() == 0) refuse("locked columns need a start");
  for (const int j : options.locked) {
    if (j < 0 || j >= m) refuse("locked column " + std::to_string(j) + " does not exist");
  }
}

}  // namespace

BoneHeatResult bone_heat(const Mesh& mesh, const std::vector<Handle>& handles,
                         const BoneHeatOptions& options, const Progress& progress) {
  check(mesh, handles, options);
  const auto m = static_cast<Eigen::Index>(handles.size());
  const auto n = static_cast<std::size_t>(mesh.V.rows());
  const View view(mesh, handles);
  std::vector<Heat> heat(n);
  parallel_for(n, 64, [&](std::size_t j) {
    if (j % 64 == 0) progress.check();
    heat[j] = heat_of(mesh.V.row(static_cast<Eigen::Index>(j)), mesh, handles, view, options.heat);
  });

  BoneHeatResult result;
  const SparseRows K = stiffness(mesh.V, mesh.F);
  std::vector<int> seeds = options.paint.node;
  for (std::size_t j = 0; j < n; ++j) {
    if (heat[j].from.empty()) continue;
    seeds.push_back(static_cast<int>(j));
    ++result.heated;
  }
  const NodeSubset reached = reached_nodes(K, seeds);
  result.unreached = reached.left_out;
  const Vector M =
      options.masses.size() ? options.masses : lumped_mass(mesh.V, mesh.F, options.mass);

  // -Lap w + H w = H p, times the masses: (K + M H) w = M H p.
  SparseRows A = restrict_to(K, reached);
  RowMatrix B = RowMatrix::Zero(A.rows(), m);
  double constant = 0;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const int v = reached.node[static_cast<std::size_t>(i)];
    const Heat& h = heat[static_cast<std::size_t>(v)];
    if (h.from.empty()) continue;
    const double MH = M[v] * h.H, share = 1.0 / static_cast<double>(h.from.size());
    A.coeffRef(i, i) += MH;
    for (const int j : h.from) B(i, j) = MH * share;
    constant += 0.5 * MH * share;
  }
  FixedRows fixed{{}, options.paint.weights};
  for (const int v : options.paint.node) {
    fixed.node.push_back(reached.position[static_cast<std::size_t>(v)]);
  }
  const DirectSolution solution = solve_with_fixed_rows(A, B, fixed, progress);
  result.stats = solution.stats;
  const RowMatrix& X = solution.X;
  result.stats.energy = 0.5 * X.cwiseProduct(A * X).sum() - X.cwiseProduct(B).sum() + constant;
  result.stats.lower_bound = result.stats.energy;

  const Locks locks(options.locked, m);
  result.W = RowMatrix::Zero(mesh.V.rows(), m);
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const int v = reached.node[static_cast<std::size_t>(i)];
    result.W.row(v) = X.row(i);
    if (!locks.any()) continue;
    const Eigen::RowVectorXd kept = locks.part(options.start, v);
    for (const int j : options.locked) result.W(v, j) = kept[j];
  }
  return result;
}

}  // namespace skinfield
