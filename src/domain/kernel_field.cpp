#include "skinfield/domain/kernel_field.h"

#include "base/vector_clones.h"
#include "domain/kd_tree.h"
#include "domain/point_hash.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace skinfield {
namespace {

constexpr double finest_cell = 1.0 / 1024;             // of the unit box
constexpr double compact_end = 2.1, gaussian_end = 3;  // in units of sigma
constexpr std::size_t most_measured = 8192;            // points whose neighbours decide on sigma

Points positions(const std::vector<Site>& sites) {
  Points X(static_cast<Eigen::Index>(sites.size()), 3);
  for (std::size_t i = 0; i < sites.size(); ++i)
    X.row(static_cast<Eigen::Index>(i)) = sites[i].x.transpose();
  return X;
}

SKINFIELD_VECTOR_CLONES
void squared_distances(const float* x, const float* y, const float* z, const float* from, int n,
                       float* d2) {
  for (int k = 0; k < n; ++k) {
    const float dx = x[k] - from[0], dy = y[k] - from[1], dz = z[k] - from[2];
    d2[k] = dx * dx + dy * dy + dz * dz;
  }
}

/// d2 becomes (1 - d2 / r^2)^3; the sum, in eight parts so that it fills a register.
SKINFIELD_VECTOR_CLONES
float compact_kernel(float* d2, float inverse, int n) {
  float part[8] = {};
  int k = 0;
  for (; k + 8 <= n; k += 8)
    for (int q = 0; q < 8; ++q) {
      float rest = 1 - d2[k + q] * inverse;
      rest = rest > 0 ? rest : 0;
      d2[k + q] = rest * rest * rest;
      part[q] += d2[k + q];
    }
  for (; k < n; ++k) {
    float rest = 1 - d2[k] * inverse;
    rest = rest > 0 ? rest : 0;
    d2[k] = rest * rest * rest;
    part[0] += d2[k];
  }
  return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}

}  // namespace

void LocalPoints::gather(const std::vector<Site>& points, const std::vector<std::int32_t>& index,
                         const Vec3& origin) {
  x.resize(index.size());
  y.resize(index.size());
  z.resize(index.size());
  for (std::size_t k = 0; k < index.size(); ++k) {
    const Vec3 d = points[static_cast<std::size_t>(index[k])].x - origin;
    x[k] = static_cast<float>(d[0]);
    y[k] = static_cast<float>(d[1]);
    z[k] = static_cast<float>(d[2]);
  }
}

struct KernelField::Impl {
  const Solid& solid;
  std::vector<Site> points;
  KernelFieldOptions options;
  double sigma = 1, radius = 1;
  std::optional<KdTree> tree;
  std::optional<PointHash> hash;
};

KernelField::KernelField(const Solid& solid, std::vector<Site> points,
                         const KernelFieldOptions& options)
    : impl_(new Impl{solid, std::move(points), options, 1, 1, {}, {}}) {
  Impl& f = *impl_;
  if (f.points.empty())
    throw DomainError("a kernel field needs points", {}, "use the surface as domain");
  // Points that lie together are stored together. The order depends on the points alone, so that
  // a field that is taken up again is the same.
  const std::vector<int> order = morton_order(positions(f.points), finest_cell);
  std::vector<Site> sorted;
  sorted.reserve(order.size());
  for (const int i : order) sorted.push_back(f.points[static_cast<std::size_t>(i)]);
  f.points = std::move(sorted);
  const Points X = positions(f.points);
  f.tree.emplace(X);

  const std::size_t measured = std::min(most_measured, f.points.size());
  std::vector<double> distance(measured);
  parallel_for(measured, 64, [&](std::size_t k) {
    std::vector<Neighbour> found;
    f.tree->nearest(f.points[k * f.points.size() / measured].x, options.neighbour + 1, found);
    distance[k] = found.back().distance;
  });
  std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(measured / 2),
                   distance.end());
  f.sigma = options.width * std::max(distance[measured / 2], 1e-6);
  f.radius = (options.kernel == KernelFieldOptions::Kernel::compact ? compact_end : gaussian_end) *
             f.sigma;
  f.hash.emplace(X, f.radius);
}

KernelField::~KernelField() = default;
KernelField::KernelField(KernelField&&) noexcept = default;
KernelField& KernelField::operator=(KernelField&&) noexcept = default;

const std::vector<Site>& KernelField::points() const { return impl_->points; }
double KernelField::sigma() const { return impl_->sigma; }
double KernelField::radius() const { return impl_->radius; }
const Solid& KernelField::solid() const { return impl_->solid; }

void KernelField::see(const Site& from, double reach, std::vector<std::int32_t>& seen) const {
  thread_local std::vector<float> distance2;
  impl_->hash->find(from.x, reach, seen, distance2);
  const auto empty_ball = static_cast<float>(from.clearance * from.clearance);
  const bool dirty = impl_->solid.has_dirty();
  std::size_t kept = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const bool free = !dirty && distance2[k] <= empty_ball;
    if (free || !impl_->solid.blocked(from, impl_->points[static_cast<std::size_t>(seen[k])]))
      seen[kept++] = seen[k];
  }
  seen.resize(kept);
  std::sort(seen.begin(), seen.end());
}

void KernelField::near(const Vec3& from, double reach, std::vector<std::int32_t>& found) const {
  thread_local std::vector<float> distance2;
  impl_->hash->find(from, reach, found, distance2);
  std::sort(found.begin(), found.end());
}

void KernelField::weights(const Vec3& x, const std::vector<std::int32_t>& seen, float* phi) const {
  const Impl& f = *impl_;
  thread_local LocalPoints local;
  local.gather(f.points, seen, x);
  weights(local, Vec3::Zero(), phi);
}

void KernelField::weights(const LocalPoints& local, const Vec3& x, float* phi) const {
  const Impl& f = *impl_;
  const auto n = static_cast<int>(local.x.size());
  const bool compact = f.options.kernel == KernelFieldOptions::Kernel::compact;
  const float offset[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]),
                           static_cast<float>(x[2])};
  const float end2 = static_cast<float>(f.radius * f.radius);
  squared_distances(local.x.data(), local.y.data(), local.z.data(), offset, n, phi);
  float sum = 0;
  if (compact) {
    sum = compact_kernel(phi, 1 / end2, n);
  } else {
    const auto factor = static_cast<float>(-0.5 / (f.sigma * f.sigma));
    for (int k = 0; k < n; ++k) {
      phi[k] = phi[k] < end2 ? std::exp(factor * phi[k]) : 0.0f;
      sum += phi[k];
    }
  }
  if (!(sum > 1e-20f)) {
    squared_distances(local.x.data(), local.y.data(), local.z.data(), offset, n, phi);
    const auto nearest = std::min_element(phi, phi + n) - phi;
    std::fill(phi, phi + n, 0.0f);
    phi[nearest] = 1;
    return;
  }
  const float scale = 1 / sum;
  for (int k = 0; k < n; ++k) phi[k] *= scale;
}

int KernelField::nearest(const Vec3& x) const {
  std::vector<Neighbour> found;
  impl_->tree->nearest(x, 1, found);
  return found.front().index;
}

}  // namespace skinfield
