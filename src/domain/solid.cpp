#include "skinfield/domain/solid.h"

#include "domain/clean_boundary.h"
#include "domain/planar_boundary.h"
#include "domain/smoothed_winding.h"
#include "domain/solid_parts.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/normals.h"
#include "skinfield/geometry/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace skinfield {
namespace {

constexpr double mostly_inside = 0.2;  // winding number at the handles of a torn but oriented soup
constexpr double unlimited = std::numeric_limits<double>::infinity();

double median(Vector values) {
  if (values.size() == 0) return 0;
  auto* middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

Triangles select(const Triangles& F, const std::vector<int>& rows) {
  Triangles G(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i)
    G.row(static_cast<Eigen::Index>(i)) = F.row(rows[i]);
  return G;
}

SmoothedWinding::Direct smoothed_by(std::shared_ptr<const WindingNumber> winding) {
  return [winding = std::move(winding)](const Vec3& x, double epsilon) {
    return winding->smoothed(x, epsilon);
  };
}

}  // namespace

struct Solid::Impl {
  Points V, N;
  Triangles F;                    // clean and dirty faces, without passengers
  std::vector<PartKind> kind;     // of each vertex
  std::vector<int> component;     // of each vertex, -1 if on no face
  std::vector<int> self_winding;  // k_f of clean faces
  std::unique_ptr<CleanBoundary> clean;
  std::optional<SmoothedWinding> smoothed;
  Facts facts;
  bool any_hit = false;
  bool unmasked = false;  // nothing blocks
  bool planar = false;
  double inside_from = 0;

  struct Dirty;
  void take_points(const Mesh& mesh, const SolidOptions& options, Dirty& dirty);
  void take_triangles(const Mesh& mesh, const Points& handle_samples, const SolidOptions& options,
                      Dirty& dirty, const Progress& progress);
  void take_segments(const Mesh& mesh, const Points& handle_samples, Dirty& dirty);
  void set_level(const Points& handle_samples, const SolidOptions& options, const Dirty& dirty,
                 const Progress& progress);

  bool crossing_blocks(double running, double excess, const RayHit& hit, const Vec3& x) const {
    if (any_hit) return true;
    // o = winding number on the outer side of the face that is crossed (findings E 3).
    const double o = hit.sign < 0 ? running - 1 : running;
    const double k = self_winding[static_cast<std::size_t>(hit.face)];
    double level = facts.level, extra = 0;
    if (smoothed) {
      level = smoothed->level(x);
      extra = smoothed->at(x);
    }
    return o + excess - k + extra < 0.5 * level;
  }

  /// Smallest t in [0,1] at which the way from a to b is blocked; unlimited if it is not.
  /// `known_end`: b's winding number tells how far the crossings miscount.
  double blocked_at(const Site& a, const Vec3& b, const double* end_winding,
                    std::vector<RayHit>& hits) const {
    hits.clear();
    const double length = (b - a.x).norm();
    if (clean && length > a.clearance) clean->all_hits(a.x, b, hits);
    double excess = 0;
    if (end_winding) {
      double sum = 0;
      for (const RayHit& hit : hits) sum += hit.sign;
      excess = std::min(0.0, *end_winding - a.winding - sum);
    }
    double running = a.winding;
    std::size_t next = 0;
    const auto cross_until = [&](double t_end) {
      for (; next < hits.size() && hits[next].t <= t_end; ++next) {
        if (crossing_blocks(running, excess, hits[next], a.x + hits[next].t * (b - a.x)))
          return hits[next].t;
        running += hits[next].sign;
      }
      return unlimited;
    };
    if (smoothed) {
      const int steps = std::max(1, static_cast<int>(std::ceil(length / smoothed->epsilon())));
      for (int s = 1; s <= steps; ++s) {
        const double t = static_cast<double>(s) / steps;
        const double crossed = cross_until(t);
        if (crossed < unlimited) return crossed;
        const Vec3 x = a.x + t * (b - a.x);
        if (running + excess + smoothed->at(x) < 0.5 * smoothed->level(x)) return (s - 0.5) / steps;
      }
      return unlimited;
    }
    return cross_until(1);
  }

  bool blocked(const Site& a, const Site& b, std::vector<RayHit>& hits) const {
    if (unmasked) return false;
    if (!smoothed) {
      const double length = (b.x - a.x).norm();
      if (!clean || length <= std::max(a.clearance, b.clearance)) return false;
      if (!clean->occluded(a.x, b.x)) return false;
      if (any_hit) return true;
    }
    return blocked_at(a, b.x, &b.winding, hits) < unlimited;
  }
};

/// Of the dirty parts: where they are, and how they wind.
struct Solid::Impl::Dirty {
  SmoothedWinding::Direct winding;
  Points sources;
  double edge = 0;  // median length
};

Solid::Solid(const Mesh& mesh, const Points& handle_samples, const SolidOptions& options,
             const Progress& progress)
    : impl_(std::make_unique<Impl>()) {
  Impl& s = *impl_;
  s.planar = options.planar;
  s.unmasked = options.visibility == SolidOptions::Visibility::none;
  s.any_hit = options.visibility == SolidOptions::Visibility::any_hit;
  s.inside_from = options.inside_from;
  s.V = mesh.V;
  s.kind.assign(static_cast<std::size_t>(mesh.V.rows()), PartKind::dirty);
  s.component.assign(s.kind.size(), -1);
  Impl::Dirty dirty;
  if (options.planar)
    s.take_segments(mesh, handle_samples, dirty);
  else if (mesh.is_point_cloud())
    s.take_points(mesh, options, dirty);
  else
    s.take_triangles(mesh, handle_samples, options, dirty, progress);
  s.set_level(handle_samples, options, dirty, progress);
}

void Solid::Impl::take_points(const Mesh& mesh, const SolidOptions& options, Dirty& dirty) {
  any_hit = false;  // there are no triangles
  N = mesh.N;
  const Vector area = point_areas(mesh.V, mesh.N);
  dirty.winding = smoothed_by(std::make_shared<WindingNumber>(
      mesh.V, mesh.N, area, WindingNumberOptions{options.accuracy}));
  dirty.sources = mesh.V;
  dirty.edge = std::sqrt(median(area));
  facts.components = facts.dirty = 1;
}

void Solid::Impl::take_triangles(const Mesh& mesh, const Points& handle_samples,
                                 const SolidOptions& options, Dirty& dirty,
                                 const Progress& progress) {
  CleanedFaces cleaned = drop_degenerate_and_duplicate(mesh.V, mesh.F);
  facts.duplicate_faces = cleaned.duplicate;
  OrientationRepair repaired = repair_orientation(mesh.V, cleaned.F, handle_samples);
  // A soup whose handles read as inside is better left alone: turning single faces to please the
  // handles overdoes it.
  if (repaired.flipped > 0 && repaired.inconsistent == 0 &&
      median(WindingNumber(mesh.V, cleaned.F).at(handle_samples)) > mostly_inside) {
    repaired.F = cleaned.F;
    repaired.flipped = 0;
  }
  PartsOfSolid parts =
      classify_parts(mesh.V, repaired.F, handle_samples, options.accuracy, progress);
  facts.flipped_faces = repaired.flipped + parts.turned;
  facts.components = static_cast<int>(parts.kind.size());
  for (PartKind k : parts.kind) {
    facts.clean += k == PartKind::clean;
    facts.dirty += k == PartKind::dirty;
    facts.passengers += k == PartKind::passenger;
  }
  if (any_hit) std::fill(parts.kind.begin(), parts.kind.end(), PartKind::clean);
  std::vector<int> clean_rows, dirty_rows, solid_rows;
  for (int f = 0; f < parts.F.rows(); ++f) {
    const int own = parts.component_of_face[static_cast<std::size_t>(f)];
    const PartKind k = parts.kind[static_cast<std::size_t>(own)];
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(parts.F(f, c));
      kind[v] = k;
      component[v] = own;
    }
    if (k == PartKind::passenger) continue;
    solid_rows.push_back(f);
    if (k == PartKind::clean) {
      clean_rows.push_back(f);
      self_winding.push_back(parts.self_winding[static_cast<std::size_t>(f)]);
    } else {
      dirty_rows.push_back(f);
    }
  }
  N = vertex_normals(mesh.V, parts.F);
  F = select(parts.F, solid_rows);
  if (!clean_rows.empty())
    clean = boundary_of_triangles(mesh.V, select(parts.F, clean_rows), options.accuracy);
  if (dirty_rows.empty()) return;
  const Triangles G = select(parts.F, dirty_rows);
  dirty.winding = smoothed_by(
      std::make_shared<WindingNumber>(mesh.V, G, WindingNumberOptions{options.accuracy}));
  dirty.sources.resize(G.rows(), 3);
  Vector edges(3 * G.rows());
  for (Eigen::Index f = 0; f < G.rows(); ++f) {
    dirty.sources.row(f) = (mesh.V.row(G(f, 0)) + mesh.V.row(G(f, 1)) + mesh.V.row(G(f, 2))) / 3;
    for (int c = 0; c < 3; ++c)
      edges[3 * f + c] = (mesh.V.row(G(f, c)) - mesh.V.row(G(f, (c + 1) % 3))).norm();
  }
  dirty.edge = median(edges);
}

void Solid::Impl::take_segments(const Mesh& mesh, const Points& handle_samples, Dirty& dirty) {
  const PlanarBoundary boundary = planar_boundary(mesh, handle_samples);
  const Segments &closed = boundary.closed, &open = boundary.open;
  V = boundary.V;
  N = boundary_normals(V, closed, open).topRows(mesh.V.rows());
  F = Triangles(closed.rows() + open.rows(), 3);
  F.topRows(closed.rows()) << closed, closed.col(1);
  F.bottomRows(open.rows()) << open, open.col(1);
  const Components parts = connected_components(F, V.rows());
  facts.components = parts.count;
  std::vector<char> has_open(static_cast<std::size_t>(parts.count), 0);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const int own = parts.of_face[static_cast<std::size_t>(f)];
    if (f >= closed.rows()) has_open[static_cast<std::size_t>(own)] = 1;
    for (int c = 0; c < 2; ++c) {
      const auto v = static_cast<std::size_t>(F(f, c));
      if (v >= kind.size()) continue;
      component[v] = own;
      if (f < closed.rows() || any_hit) kind[v] = PartKind::clean;
    }
  }
  facts.dirty = static_cast<int>(std::count(has_open.begin(), has_open.end(), 1));
  facts.clean = facts.components - facts.dirty;
  self_winding.assign(static_cast<std::size_t>(F.rows()), 0);
  const Segments none(0, 2);
  if (closed.rows() > 0 || any_hit) clean = boundary_of_segments(V, closed, any_hit ? open : none);
  if (open.rows() == 0 || any_hit) return;
  const DirtySegments pieces = dirty_segments(V, open);
  dirty.sources = pieces.X;
  dirty.edge = pieces.edge;
  dirty.winding = [pieces](const Vec3& x, double epsilon) { return pieces.smoothed(x, epsilon); };
}

/// Where the dirty parts are grown together, and what winding number counts as inside.
void Solid::Impl::set_level(const Points& handle_samples, const SolidOptions& options,
                            const Dirty& dirty, const Progress& progress) {
  const Eigen::Index samples = handle_samples.rows();
  facts.handle_samples = static_cast<int>(samples);
  Vector w = Vector::Zero(samples);
  if (clean)
    parallel_for(static_cast<std::size_t>(samples), 64, [&](std::size_t i) {
      const auto k = static_cast<Eigen::Index>(i);
      w[k] = clean->winding(handle_samples.row(k).transpose());
    });
  if (dirty.winding) {
    smoothed.emplace(dirty.winding, dirty.sources, dirty.edge, handle_samples, w, options.spacing,
                     progress);
    facts.epsilon = smoothed->epsilon();
    w = smoothed->at_samples();
  }
  // The level is the median over the samples that are inside at all.
  std::vector<double> within;
  for (double threshold : {0.5, 0.15}) {
    for (Eigen::Index i = 0; i < samples; ++i)
      if (w[i] >= threshold) within.push_back(w[i]);
    if (!within.empty()) break;
  }
  if (!within.empty()) {
    std::nth_element(within.begin(),
                     within.begin() + static_cast<std::ptrdiff_t>(within.size() / 2), within.end());
    facts.level = std::min(1.0, within[within.size() / 2]);
  }
  for (Eigen::Index i = 0; i < samples; ++i)
    facts.handle_samples_inside += w[i] >= 0.5 * facts.level;
}

Solid::~Solid() = default;
Solid::Solid(Solid&&) noexcept = default;
Solid& Solid::operator=(Solid&&) noexcept = default;

Site Solid::site(const Vec3& x) const {
  Site site;
  site.x = x;
  if (impl_->clean) site.winding = impl_->clean->winding(x);
  if (impl_->clean) site.clearance = impl_->clean->distance(x);
  return site;
}

Site Solid::site_near(const Site& known, const Vec3& x) const {
  Site site;
  site.x = x;
  // Crossings say all about closed parts only.
  if (impl_->any_hit && impl_->facts.dirty > 0) return this->site(x);
  const double distance = (x - known.x).norm();
  site.clearance = std::max(0.0, known.clearance - distance);
  site.winding = known.winding;
  if (!impl_->clean || distance <= known.clearance) return site;
  std::vector<RayHit> hits;
  impl_->clean->all_hits(known.x, x, hits);
  for (const RayHit& hit : hits) site.winding += hit.sign;
  return site;
}

std::vector<Site> Solid::sites(const Points& X) const {
  std::vector<Site> all(static_cast<std::size_t>(X.rows()));
  parallel_for(all.size(), 64, [&](std::size_t i) {
    all[i] = site(X.row(static_cast<Eigen::Index>(i)).transpose());
  });
  return all;
}

void Solid::measure_clearance(Site& site) const {
  if (impl_->clean) site.clearance = impl_->clean->distance(site.x);
}

double Solid::winding(const Site& a) const {
  return impl_->smoothed ? a.winding + impl_->smoothed->at(a.x) : a.winding;
}

bool Solid::inside(const Site& a) const {
  if (impl_->any_hit) return a.winding >= impl_->inside_from;
  if (!impl_->smoothed) return a.winding >= 0.5 * impl_->facts.level;
  return a.winding + impl_->smoothed->at(a.x) >= 0.5 * impl_->smoothed->level(a.x);
}

bool Solid::blocked(const Site& a, const Site& b) const {
  std::vector<RayHit> hits;
  return impl_->blocked(a, b, hits);
}

void Solid::blocked(const Site& a, std::span<const Site> b,
                    std::span<unsigned char> blocked) const {
  std::vector<RayHit> hits;
  for (std::size_t i = 0; i < b.size(); ++i) blocked[i] = impl_->blocked(a, b[i], hits);
}

void Solid::reach(const Site& a, std::span<const Vec3> directions, std::span<double> t,
                  std::span<unsigned char> hit) const {
  const Impl& s = *impl_;
  std::vector<RayHit> hits;
  std::fill(hit.begin(), hit.end(), 0);
  if (s.unmasked) return;
  if (s.smoothed) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const double where = s.blocked_at(a, a.x + t[i] * directions[i], nullptr, hits);
      if (where < unlimited) {
        t[i] *= where;
        hit[i] = 1;
      }
    }
    return;
  }
  if (!s.clean) return;
  std::vector<Vec3> far;
  std::vector<double> limit;
  std::vector<std::size_t> ray;
  for (std::size_t i = 0; i < directions.size(); ++i)
    if (t[i] > a.clearance) {
      far.push_back(directions[i]);
      limit.push_back(t[i]);
      ray.push_back(i);
    }
  std::vector<RayHit> first(far.size());
  s.clean->first_hits(a.x, far, limit, first);
  for (std::size_t k = 0; k < far.size(); ++k) {
    if (!first[k]) continue;
    const std::size_t i = ray[k];
    if (s.crossing_blocks(a.winding, 0, first[k], a.x)) {
      t[i] = first[k].t;
      hit[i] = 1;
      continue;
    }
    const double where = s.blocked_at(a, a.x + t[i] * directions[i], nullptr, hits);
    if (where < unlimited) {
      t[i] *= where;
      hit[i] = 1;
    }
  }
}

Solid::PartKind Solid::kind_of_vertex(int vertex) const {
  return impl_->kind[static_cast<std::size_t>(vertex)];
}
int Solid::component_of_vertex(int vertex) const {
  return impl_->component[static_cast<std::size_t>(vertex)];
}
bool Solid::has_clean() const { return impl_->clean != nullptr; }
bool Solid::has_dirty() const { return impl_->facts.dirty > 0; }
int Solid::dimension() const { return impl_->planar ? 2 : 3; }
const Triangles& Solid::faces() const { return impl_->F; }
const Points& Solid::vertices() const { return impl_->V; }
const Points& Solid::normals() const { return impl_->N; }
const Solid::Facts& Solid::facts() const { return impl_->facts; }

}  // namespace skinfield
