#include "skinfield/domain/point_domain.h"

#include "domain/inside_check.h"
#include "domain/kd_tree.h"
#include "domain/point_evaluation.h"
#include "domain/point_sampling.h"
#include "domain/stage_clock.h"
#include "domain/voronoi_cells.h"
#include "skinfield/base/parallel.h"

#include <cmath>
#include <optional>

namespace skinfield {
namespace {

constexpr double surface_step = 1e-4;  // how far inside a surface point looks from, unit box

/// Nodes whose component of K's graph holds a fixed row.
std::vector<char> reached_by_handles(const SparseRows& K, const std::vector<int>& fixed,
                                     PointDomainFacts& facts) {
  const auto n = static_cast<std::size_t>(K.rows());
  std::vector<char> is_fixed(n, 0), reached(n, 0), seen(n, 0);
  for (int i : fixed) is_fixed[static_cast<std::size_t>(i)] = 1;
  for (std::size_t s = 0; s < n; ++s) {
    if (seen[s]) continue;
    std::vector<int> component{static_cast<int>(s)};
    seen[s] = 1;
    bool handle = false;
    for (std::size_t k = 0; k < component.size(); ++k) {
      const auto i = static_cast<std::size_t>(component[k]);
      handle |= is_fixed[i] != 0;
      for (SparseRows::InnerIterator it(K, component[k]); it; ++it) {
        if (it.value() == 0 || seen[static_cast<std::size_t>(it.col())]) continue;
        seen[static_cast<std::size_t>(it.col())] = 1;
        component.push_back(static_cast<int>(it.col()));
      }
    }
    ++facts.components;
    if (handle) {
      for (int i : component) reached[static_cast<std::size_t>(i)] = 1;
    } else {
      ++facts.components_without_handle;
      facts.nodes_without_handle += static_cast<int>(component.size());
    }
  }
  return reached;
}

}  // namespace

struct PointDomain::Impl {
  Impl(const Mesh& mesh, const std::vector<Handle>& handles, const PointDomainOptions& options,
       const PaintedPoints& paint, const Progress& progress);

  std::optional<Solid> solid;
  SampledNodes nodes;
  std::optional<KdTree> tree;
  VoronoiCells cells;
  FixedRows fixed;
  std::vector<char> connected;
  std::optional<PointEvaluation> evaluation;
  PointDomainFacts facts;

  /// Rows of the vertices that bound the solid: what passengers hold on to.
  InterpolationRows solid_rows(const Points& X, const Points& N,
                               std::vector<int>& passengers) const;
};

PointDomain::Impl::Impl(const Mesh& mesh, const std::vector<Handle>& handles,
                        const PointDomainOptions& options, const PaintedPoints& paint,
                        const Progress& progress) {
  StageClock clock(facts.seconds);
  progress("solid", 0);
  // A first guess of the node distance: shapes fill about a tenth of their box.
  const Box3 box = bounding_box(mesh.V);
  const Eigen::RowVector3d side = box.row(1) - box.row(0);
  const double guess = std::cbrt(0.1 * std::max(side.prod(), 1e-6) / options.nodes);
  const Points along = probe_handles(handles, 0.005), regions = probe_regions(mesh, handles);
  Points probes(along.rows() + regions.rows(), 3);
  probes << along, regions;
  if (probes.rows() == 0) probes = paint.X;
  solid.emplace(mesh, probes, SolidOptions{.spacing = guess}, progress);
  if (!handles.empty()) check_has_inside(*solid, mesh);
  clock.lap("solid");
  progress("nodes", 0);
  nodes = sample_nodes(*solid, handles, paint, options, facts, progress);
  tree.emplace(nodes.X);
  clock.restart();
  progress("neighbours", 0);
  const auto neighbours =
      visible_neighbours(*solid, nodes, *tree, options.candidates, options.neighbours, progress);
  clock.lap("neighbours");
  progress("cells", 0);
  cells = voronoi_cells(*solid, nodes, neighbours, options.directions, options.seed, progress);
  facts.rays = cells.rays;
  clock.lap("cells");

  fixed.weights = nodes.fixed.weights;
  for (int i = 0; i < fixed.weights.rows(); ++i) fixed.node.push_back(i);
  connected = reached_by_handles(cells.K, fixed.node, facts);
  evaluation.emplace(*solid, nodes.sites, *tree, cells.K, connected, surface_step);
}

InterpolationRows PointDomain::Impl::solid_rows(const Points& X, const Points& N,
                                                std::vector<int>& passengers) const {
  InterpolationRows rows;
  rows.row.resize(static_cast<std::size_t>(X.rows()));
  rows.fill.assign(rows.row.size(), Fill::none);
  const bool clean = !solid->has_dirty();
  std::vector<char> outside(rows.row.size(), 0);
  parallel_for(rows.row.size(), 32, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 x = X.row(row).transpose();
    const Vec3 n = normal_or_zero(N, row);
    Site site;
    if (clean && !evaluation->look_from(x, n, site)) {
      outside[i] = 1;
      return;
    }
    rows.fill[i] = evaluation->evaluate(x, n, clean, rows.row[i]);
  });
  for (std::size_t i = 0; i < outside.size(); ++i)
    if (outside[i]) passengers.push_back(static_cast<int>(i));
  return rows;
}

PointDomain::PointDomain(const Mesh& mesh, const std::vector<Handle>& handles,
                         const PointDomainOptions& options, const PaintedPoints& paint,
                         const Progress& progress)
    : impl_(std::make_unique<Impl>(mesh, handles, options, paint, progress)) {}

PointDomain::~PointDomain() = default;

const Points& PointDomain::nodes() const { return impl_->nodes.X; }
const SparseRows& PointDomain::stiffness() const { return impl_->cells.K; }
const Vector& PointDomain::mass() const { return impl_->cells.M; }
const FixedRows& PointDomain::fixed() const { return impl_->fixed; }
const Solid& PointDomain::solid() const { return *impl_->solid; }
const PointDomainFacts& PointDomain::facts() const { return impl_->facts; }

Interpolation PointDomain::at_mesh() const {
  const Impl& d = *impl_;
  const Points& V = d.solid->vertices();
  const Points& N = d.solid->normals();
  InterpolationRows rows;
  rows.row.resize(static_cast<std::size_t>(V.rows()));
  rows.fill.assign(rows.row.size(), Fill::none);
  // Vertices of the solid first; passengers outside of it hold on to them.
  std::vector<char> carried(rows.row.size(), 0);
  parallel_for(rows.row.size(), 32, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 x = V.row(row).transpose();
    const Vec3 n = N.row(row).transpose();
    const auto kind = d.solid->kind_of_vertex(static_cast<int>(i));
    if (kind == Solid::PartKind::passenger) {
      if (!d.solid->inside(x)) {
        carried[i] = 1;
        return;
      }
      rows.fill[i] = d.evaluation->evaluate(x, Vec3::Zero(), !d.solid->has_dirty(), rows.row[i]);
      return;
    }
    // A torn part's own normals are noise: tangent planes from them cost more than they correct.
    const bool clean = kind == Solid::PartKind::clean;
    rows.fill[i] =
        d.evaluation->evaluate(x, clean ? n : d.evaluation->away_from_nodes(x), clean, rows.row[i]);
  });
  std::vector<int> wanted, holding;
  for (std::size_t i = 0; i < carried.size(); ++i)
    (carried[i] ? wanted : holding).push_back(static_cast<int>(i));
  if (!wanted.empty() && !holding.empty()) {
    Points X(static_cast<Eigen::Index>(holding.size()), 3), XN(X.rows(), 3);
    InterpolationRows held;
    for (std::size_t k = 0; k < holding.size(); ++k) {
      X.row(static_cast<Eigen::Index>(k)) = V.row(holding[k]);
      XN.row(static_cast<Eigen::Index>(k)) = N.row(holding[k]);
      held.row.push_back(rows.row[static_cast<std::size_t>(holding[k])]);
    }
    carry_passengers(V, N, X, XN, held, wanted, rows);
    std::vector<int> component(rows.row.size());
    for (std::size_t i = 0; i < component.size(); ++i)
      component[i] = d.solid->component_of_vertex(static_cast<int>(i));
    stiffen_floating(V, component, X, wanted, rows);
  }
  return {to_matrix(rows, d.nodes.X.rows()), std::move(rows.fill)};
}

SparseRows PointDomain::from_mesh() const {
  constexpr int tried = 24, used = 8;
  const Impl& d = *impl_;
  const Points& V = d.solid->vertices();
  const Points& N = d.solid->normals();
  const KdTree vertices(V);
  InterpolationRows rows;
  rows.row.resize(d.nodes.sites.size());
  parallel_for(rows.row.size(), 32, [&](std::size_t i) {
    const Site& node = d.nodes.sites[i];
    std::vector<Neighbour> found;
    vertices.nearest(node.x, tried, found);
    auto& row = rows.row[i];
    for (const Neighbour& n : found) {
      const Vec3 look = V.row(n.index).transpose() - surface_step * N.row(n.index).transpose();
      if (d.solid->blocked(node, d.solid->site(look))) continue;
      row.emplace_back(n.index, 1 / (n.distance * n.distance + 1e-12));
      if (static_cast<int>(row.size()) == used) break;
    }
    if (row.empty() && !found.empty()) row.emplace_back(found.front().index, 1.0);
  });
  return to_matrix(rows, V.rows());
}

Interpolation PointDomain::at(const Points& X, const Points& normals) const {
  const Impl& d = *impl_;
  std::vector<int> outside;
  InterpolationRows rows = d.solid_rows(X, normals, outside);
  if (!outside.empty()) {
    // Points outside hold on to the solid's own vertices.
    const Points& V = d.solid->vertices();
    const Points& N = d.solid->normals();
    std::vector<char> used(static_cast<std::size_t>(V.rows()), 0);
    for (Eigen::Index f = 0; f < d.solid->faces().rows(); ++f)
      for (int c = 0; c < 3; ++c) used[static_cast<std::size_t>(d.solid->faces()(f, c))] = 1;
    std::vector<int> holding;
    for (std::size_t i = 0; i < used.size(); ++i)
      if (used[i]) holding.push_back(static_cast<int>(i));
    Points H(static_cast<Eigen::Index>(holding.size()), 3), HN(H.rows(), 3);
    for (std::size_t k = 0; k < holding.size(); ++k) {
      H.row(static_cast<Eigen::Index>(k)) = V.row(holding[k]);
      HN.row(static_cast<Eigen::Index>(k)) = N.row(holding[k]);
    }
    std::vector<int> blind;
    const InterpolationRows held = d.solid_rows(H, HN, blind);
    InterpolationRows complete = held;
    for (int i : blind) {
      const auto k = static_cast<Eigen::Index>(i);
      complete.fill[static_cast<std::size_t>(i)] =
          d.evaluation->evaluate(H.row(k).transpose(), HN.row(k).transpose(), true,
                                 complete.row[static_cast<std::size_t>(i)]);
    }
    carry_passengers(X, normals, H, HN, complete, outside, rows);
  }
  return {to_matrix(rows, d.nodes.X.rows()), std::move(rows.fill)};
}

}  // namespace skinfield
