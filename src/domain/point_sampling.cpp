#include "domain/point_sampling.h"

#include "domain/disk_grid.h"
#include "domain/fixed_node_list.h"
#include "domain/interior_cells.h"
#include "domain/kd_tree.h"
#include "domain/region_samples.h"
#include "domain/stage_clock.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace skinfield {
namespace {

constexpr double disk = 0.84;           // Poisson-disk radius in units of h
constexpr double disk_at_handle = 0.6;  // of that, between a handle sample and an inner point
constexpr double pool_per_node = 10;    // candidates a node
constexpr double clash = 0.3;           // of h: samples of different handles are farther apart
constexpr int cell_depth = 6;
constexpr int cell_tests = 8;

/// Candidates inside the shape with density ~ h^-3, and the order in which darts try them.
struct Pool {
  Points X;                ///< cell after cell: neighbours lie close in memory
  std::vector<double> h;   ///< the size field's shape at each
  std::vector<int> order;  ///< random
};

Pool draw_pool(const Solid& solid, const std::vector<InteriorCell>& cells, const SizeField& size,
               std::uint64_t seed, const Progress& progress) {
  struct Candidate {
    Vec3 x;
    double h;
  };
  std::vector<std::vector<Candidate>> drawn(cells.size());
  parallel_for(cells.size(), 8, [&](std::size_t c) {
    progress.check();
    const InteriorCell& cell = cells[c];
    Random random(seed, 0x20000000ull + c);
    const SizeField local = size.near(cell.centre, std::numbers::sqrt3 * cell.half);
    const auto density = [](double h) { return 1 / (h * h * h); };
    // A whole cell can be many h wide: draw at its finest density, thin to the local one.
    const double corner = std::max(size.low(), local.at(cell.centre) - 0.6 * cell.half);
    const double densest = density(corner);
    const double expected = pool_per_node * std::pow(2 * cell.half, 3) * densest;
    const int count = static_cast<int>(std::floor(expected + random.uniform()));
    for (int k = 0; k < count; ++k) {
      const Vec3 u(random.uniform(), random.uniform(), random.uniform());
      const Vec3 x = cell.centre + cell.half * (2 * u - Vec3::Ones());
      const double h = local.shape(x);
      if (random.uniform() * densest > density(local.of_shape(h))) continue;
      if (cell.whole || solid.inside(solid.site_near(cell.site, x))) drawn[c].push_back({x, h});
    }
  });
  std::vector<std::size_t> start(cells.size() + 1, 0);
  for (std::size_t c = 0; c < cells.size(); ++c) start[c + 1] = start[c] + drawn[c].size();
  Pool pool;
  pool.X.resize(static_cast<Eigen::Index>(start.back()), 3);
  pool.h.resize(start.back());
  std::vector<std::pair<std::uint64_t, int>> order(start.back());
  parallel_for(cells.size(), 64, [&](std::size_t c) {
    for (std::size_t k = 0; k < drawn[c].size(); ++k) {
      const std::size_t i = start[c] + k;
      pool.X.row(static_cast<Eigen::Index>(i)) = drawn[c][k].x.transpose();
      pool.h[i] = drawn[c][k].h;
      Random random(seed, 0x40000000ull + i);
      const std::uint64_t high = random.bits();
      order[i] = {(high << 32) | random.bits(), static_cast<int>(i)};
    }
  });
  std::sort(order.begin(), order.end());
  pool.order.reserve(order.size());
  for (const auto& [key, i] : order) pool.order.push_back(i);
  return pool;
}

/// Scales the size field so that the integral of h^-3 over the shape, the number of nodes that it
/// asks for, is `nodes`.
void scale_to(int nodes, const std::vector<InteriorCell>& cells, double low, double high,
              SizeField& size) {
  std::vector<double> shape(8 * cells.size());  // at midpoints of the cells' octants
  size.scale(1, 0, 1e300);
  parallel_for(shape.size(), 256, [&](std::size_t i) {
    const InteriorCell& cell = cells[i / 8];
    const auto sign = [&](std::size_t bit) { return (i & bit) != 0 ? 0.5 : -0.5; };
    shape[i] = size.at(cell.centre + cell.half * Vec3(sign(1), sign(2), sign(4)));
  });
  double small = 1e-3, large = 1e3;
  for (int step = 0; step < 40; ++step) {
    const double c = std::sqrt(small * large);
    double wanted = 0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const double side = cells[i / 8].half;
      const double h = std::clamp(c * shape[i], low, high);
      wanted += side * side * side * cells[i / 8].share / (h * h * h);
    }
    (wanted > nodes ? small : large) = c;
  }
  size.scale(std::sqrt(small * large), low, high);
}

/// Every point of a handle along which samples run, with the length of its bone.
template <class Visit>
void walk_handles(const std::vector<Handle>& handles, const Visit& visit) {
  for (std::size_t h = 0; h < handles.size(); ++h) {
    if (handles[h].kind == Handle::Kind::bone)
      for (const auto& [a, b] : handles[h].segments) visit(static_cast<int>(h), a, b);
    else if (handles[h].kind == Handle::Kind::point)
      visit(static_cast<int>(h), handles[h].point, handles[h].point);
  }
}

/// How far one sees around a point where triangles tell no distance: in a quarter of all
/// directions no farther than this.
double room_around(const Solid& solid, const Site& site, double far) {
  constexpr int count = 48;
  std::vector<Vec3> direction(count);
  std::vector<double> t(count, far);
  std::vector<unsigned char> hit(count);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, angle = 2.399963229728653 * i;  // Fibonacci lattice
    const double r = std::sqrt(1 - z * z);
    direction[static_cast<std::size_t>(i)] = {r * std::cos(angle), r * std::sin(angle), z};
  }
  solid.reach(site, direction, t, hit);
  std::nth_element(t.begin(), t.begin() + count / 4, t.end());
  return t[count / 4];
}

SizeField size_field(const Solid& solid, const std::vector<Handle>& handles, double h,
                     bool adaptive) {
  if (!adaptive) return SizeField(h);
  std::vector<Vec3> centres;
  std::vector<double> base;
  walk_handles(handles, [&](int, const Vec3& a, const Vec3& b) {
    const double length = (b - a).norm();
    constexpr int samples = 9;
    for (int k = 0; k < samples; ++k) {
      const Vec3 x = a + (b - a) * (static_cast<double>(k) / (samples - 1));
      const Site site = solid.site(x);
      if (!solid.inside(site)) continue;
      double local = length > 0 ? 0.3 * length : h;
      // Four nodes across a limb, and more where a bone runs close under the surface.
      const double room = solid.has_dirty() ? room_around(solid, site, 4 * local) : site.clearance;
      if (room > 0) local = std::min(local, std::max(0.5 * room, 0.05 * length));
      centres.push_back(x);
      base.push_back(local);
      if (length == 0) break;
    }
  });
  if (centres.empty()) return SizeField(h);
  Points Y(static_cast<Eigen::Index>(centres.size()), 3);
  for (std::size_t i = 0; i < centres.size(); ++i)
    Y.row(static_cast<Eigen::Index>(i)) = centres[i].transpose();
  return {std::move(Y), Eigen::Map<Vector>(base.data(), static_cast<Eigen::Index>(base.size())),
          0.3};
}

struct HandleSample {
  Vec3 x;
  int handle;
  bool shared;  ///< an end, which other handles may share
};

/// Bones that leave a joint at a small angle ask for different weights at points nearer to each
/// other than the nodes can tell apart. Such samples go, so that the solution near joints does not
/// depend on how densely bones are sampled. A handle that would lose all keeps them.
void drop_clashes(const SizeField& size, std::vector<HandleSample>& samples) {
  Points X(static_cast<Eigen::Index>(samples.size()), 3);
  for (std::size_t i = 0; i < samples.size(); ++i)
    X.row(static_cast<Eigen::Index>(i)) = samples[i].x.transpose();
  const KdTree tree(X);
  std::vector<char> clashes(samples.size(), 0);
  parallel_for(samples.size(), 64, [&](std::size_t i) {
    if (samples[i].shared) return;
    std::vector<Neighbour> found;
    tree.nearest(samples[i].x, 24, found);
    for (const Neighbour& n : found) {
      const HandleSample& other = samples[static_cast<std::size_t>(n.index)];
      if (n.distance > clash * size.at(samples[i].x)) break;
      if (!other.shared && other.handle != samples[i].handle && n.distance > 0) clashes[i] = 1;
    }
  });
  std::map<int, int> left;
  for (std::size_t i = 0; i < samples.size(); ++i) left[samples[i].handle] += clashes[i] ? 0 : 1;
  std::erase_if(samples, [&, i = std::size_t{0}](const HandleSample& s) mutable {
    return clashes[i++] != 0 && left[s.handle] > 0;
  });
}

FixedNodes fixed_nodes(const Solid& solid, const std::vector<Handle>& handles,
                       const PaintedPoints& paint, const SizeField& size, double spacing) {
  FixedNodeList list;
  std::vector<HandleSample> samples;
  walk_handles(handles, [&](int handle, const Vec3& a, const Vec3& b) {
    const auto add = [&](const Vec3& x, bool end) {
      if (solid.inside(x)) samples.push_back({x, handle, end});
    };
    add(a, true);
    const double length = (b - a).norm();
    if (length == 0) return;
    // Steps follow the local size: equal parts of the integral of 1 / h along the bone.
    constexpr int fine = 64;
    double sum[fine + 1] = {0};
    for (int k = 0; k < fine; ++k)
      sum[k + 1] = sum[k] + length / fine / size.at(a + (b - a) * ((k + 0.5) / fine));
    const int steps = std::clamp(static_cast<int>(std::ceil(sum[fine] / spacing)), 2, 400);
    int k = 0;
    for (int s = 1; s < steps; ++s) {
      const double target = sum[fine] * s / steps;
      while (k < fine - 1 && sum[k + 1] < target) ++k;
      add(a + (b - a) * ((k + (target - sum[k]) / (sum[k + 1] - sum[k])) / fine), false);
    }
    add(b, true);
  });
  for (std::size_t h = 0; h < handles.size(); ++h) {
    if (handles[h].kind != Handle::Kind::region) continue;
    for (const Vec3& x : region_samples(solid, handles[h], size))
      samples.push_back({x, static_cast<int>(h), false});
  }
  drop_clashes(size, samples);
  for (const HandleSample& s : samples) list.add(s.x, s.handle);
  for (Eigen::Index i = 0; i < paint.X.rows(); ++i) {
    list.paint(moved_inside(solid, paint.X.row(i), normal_or_zero(paint.N, i)),
               paint.weights.row(i).transpose());
  }
  const Eigen::Index columns =
      handles.empty() ? paint.weights.cols() : static_cast<Eigen::Index>(handles.size());
  return list.nodes(columns);
}

/// The rows of the pool that keep their distance from each other and from the fixed nodes.
std::vector<int> throw_darts(const Pool& pool, const Points& fixed, const SizeField& size,
                             const Progress& progress) {
  DiskGrid grid(disk * size.low(), pool.order.size() / 8);
  for (Eigen::Index i = 0; i < fixed.rows(); ++i) {
    const Vec3 x = fixed.row(i).transpose();
    grid.add(x, disk * size.at(x), true);
  }
  const auto position = [&](int i) { return Vec3(pool.X.row(i).transpose()); };
  const auto radius = [&](int i) {
    return disk * size.of_shape(pool.h[static_cast<std::size_t>(i)]);
  };
  std::vector<int> kept;
  std::vector<char> conflict;
  // Most candidates conflict with darts long thrown: these are found in parallel, the rest is
  // tried one after the other, as all would be.
  for (std::size_t begin = 0, count = 0; begin < pool.order.size(); begin += count) {
    progress.check();
    count = std::min(std::max<std::size_t>(256, begin / 4), pool.order.size() - begin);
    conflict.assign(count, 0);
    parallel_for(count, 128, [&](std::size_t k) {
      const int i = pool.order[begin + k];
      conflict[k] = grid.conflicts(position(i), radius(i), disk_at_handle);
    });
    for (std::size_t k = 0; k < count; ++k) {
      const int i = pool.order[begin + k];
      if (conflict[k] || grid.conflicts(position(i), radius(i), disk_at_handle)) continue;
      grid.add(position(i), radius(i), false);
      kept.push_back(i);
    }
  }
  return kept;
}

/// Moves inner nodes to the centroids of their shares of the pool (Lloyd), where they stay inside
/// and in view of where they were.
void lloyd(const Solid& solid, const Points& pool, Points& X, std::vector<Site>& sites,
           Eigen::Index first, const Progress& progress) {
  const KdTree tree(X);
  std::vector<int> owner(static_cast<std::size_t>(pool.rows()));
  parallel_for(owner.size(), 256, [&](std::size_t i) {
    std::vector<Neighbour> found;
    tree.nearest(pool.row(static_cast<Eigen::Index>(i)).transpose(), 1, found);
    owner[i] = found.front().index;
  });
  Points sum = Points::Zero(X.rows(), 3);
  Vector count = Vector::Zero(X.rows());
  for (std::size_t i = 0; i < owner.size(); ++i) {
    sum.row(owner[i]) += pool.row(static_cast<Eigen::Index>(i));
    count[owner[i]] += 1;
  }
  parallel_for(static_cast<std::size_t>(X.rows() - first), 32, [&](std::size_t k) {
    progress.check();
    const Eigen::Index i = first + static_cast<Eigen::Index>(k);
    if (count[i] < 2) return;
    const Vec3 to = (sum.row(i) / count[i]).transpose();
    const Site old = sites[static_cast<std::size_t>(i)];
    Site moved;
    if (!solid.has_dirty() && (to - old.x).norm() < old.clearance) {
      // Nothing blocks within the clearance: the winding number stays, the new clearance is at
      // least the rest, which is what it is used for.
      moved = old;
      moved.x = to;
      moved.clearance = old.clearance - (to - old.x).norm();
    } else {
      moved = solid.site(to);
      if (!solid.inside(moved) || solid.blocked(old, moved)) return;
    }
    sites[static_cast<std::size_t>(i)] = moved;
    X.row(i) = to.transpose();
  });
}

}  // namespace

double SizeField::shape(const Vec3& x) const {
  double least = 1e300;
  for (Eigen::Index i = 0; i < centres_.rows(); ++i) {
    const double dx = x[0] - centres_(i, 0), dy = x[1] - centres_(i, 1), dz = x[2] - centres_(i, 2);
    const double far = slope_ * slope_ * (dx * dx + dy * dy + dz * dz);
    least = std::min(least, std::max(base_[i] * base_[i], far));
  }
  return std::sqrt(least);
}

SizeField SizeField::near(const Vec3& x, double radius) const {
  // A centre's value changes by at most slope * radius on the way, and the least value as well.
  const double bound = shape(x) + 2 * slope_ * radius * (1 + 1e-9);
  SizeField part = *this;
  Eigen::Index kept = 0;
  for (Eigen::Index i = 0; i < centres_.rows(); ++i) {
    const double far = slope_ * (x.transpose() - centres_.row(i)).norm();
    if (std::max(base_[i], far) > bound) continue;
    part.centres_.row(kept) = centres_.row(i);
    part.base_[kept++] = base_[i];
  }
  part.centres_.conservativeResize(kept, 3);
  part.base_.conservativeResize(kept);
  return part;
}

Points probe_handles(const std::vector<Handle>& handles, double spacing) {
  std::vector<Vec3> all;
  walk_handles(handles, [&](int, const Vec3& a, const Vec3& b) {
    const double length = (b - a).norm();
    if (length == 0) return all.push_back(a);
    const int steps = std::clamp(static_cast<int>(std::ceil(length / spacing)), 4, 200);
    for (int s = 0; s <= steps; ++s) all.push_back(a + (b - a) * (static_cast<double>(s) / steps));
  });
  Points X(static_cast<Eigen::Index>(all.size()), 3);
  for (std::size_t i = 0; i < all.size(); ++i)
    X.row(static_cast<Eigen::Index>(i)) = all[i].transpose();
  return X;
}

SampledNodes sample_nodes(const Solid& solid, const std::vector<Handle>& handles,
                          const PaintedPoints& paint, const PointDomainOptions& options,
                          PointDomainFacts& facts, const Progress& progress) {
  StageClock clock(facts.seconds);
  const auto cells = interior_cells(solid, cell_depth, cell_tests, options.seed, progress);
  SampledNodes result;
  for (const InteriorCell& c : cells) result.volume += std::pow(2 * c.half, 3) * c.share;
  if (!(result.volume > 0))
    throw DomainError("the shape encloses no volume", {}, "use the surface as domain");
  clock.lap("cells_inside");

  const double mean = std::cbrt(result.volume / options.nodes);
  SizeField size = size_field(solid, handles, mean, options.adaptive);
  if (options.adaptive) scale_to(options.nodes, cells, 0.3 * mean, 2 * mean, size);
  clock.lap("size_field");
  result.fixed = fixed_nodes(solid, handles, paint, size, options.handle_spacing);
  if (result.fixed.X.rows() == 0)
    throw DomainError("no handle has a part inside the shape", {}, "use the surface as domain");
  const Pool pool = draw_pool(solid, cells, size, options.seed, progress);
  clock.lap("candidates");

  std::vector<int> kept = throw_darts(pool, result.fixed.X, size, progress);
  // Darts pack a little more or less densely than the integral foresees: once more, to measure.
  const double ratio =
      static_cast<double>(kept.size()) /
      std::max<double>(1, options.nodes - static_cast<double>(result.fixed.X.rows()));
  if (std::abs(ratio - 1) > 0.02 && ratio > 0.2 && ratio < 5) {
    size.stretch(std::cbrt(ratio));
    kept = throw_darts(pool, result.fixed.X, size, progress);
  }
  const Eigen::Index first = result.fixed.X.rows();
  result.X.resize(first + static_cast<Eigen::Index>(kept.size()), 3);
  result.X.topRows(first) = result.fixed.X;
  for (std::size_t k = 0; k < kept.size(); ++k)
    result.X.row(first + static_cast<Eigen::Index>(k)) = pool.X.row(kept[k]);
  clock.lap("darts");

  result.sites = solid.sites(result.X);
  for (int step = 0; step < options.lloyd_steps; ++step)
    lloyd(solid, pool.X, result.X, result.sites, first, progress);
  clock.lap("lloyd");
  result.spacing.resize(result.X.rows());
  parallel_for(static_cast<std::size_t>(result.X.rows()), 64, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    result.spacing[row] = size.at(result.X.row(row).transpose());
  });
  facts.volume = result.volume;
  facts.handle_nodes = static_cast<int>(first);
  return result;
}

}  // namespace skinfield
