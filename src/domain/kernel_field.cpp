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

/// d2 becomes (1 - d2 * inverse)^3; the sum, in eight parts so that it fills a register.
SKINFIELD_VECTOR_CLONES
float compact_kernel(float* d2, const float* inverse, int n) {
  float part[8] = {};
  int k = 0;
  for (; k + 8 <= n; k += 8)
    for (int q = 0; q < 8; ++q) {
      float rest = 1 - d2[k + q] * inverse[k + q];
      rest = rest > 0 ? rest : 0;
      d2[k + q] = rest * rest * rest;
      part[q] += d2[k + q];
    }
  for (; k < n; ++k) {
    float rest = 1 - d2[k] * inverse[k];
    rest = rest > 0 ? rest : 0;
    d2[k] = rest * rest * rest;
    part[0] += d2[k];
  }
  return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}

/// Drops what lies further than the narrower kernels' reach.
void keep_near(const std::vector<float>& scale, double reach, double radius,
               std::vector<std::int32_t>& found, std::vector<float>& distance2) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double s = static_cast<double>(scale[static_cast<std::size_t>(found[k])]);
    const double end = reach - (1 - s) * radius;
    if (!(end > 0 && static_cast<double>(distance2[k]) < end * end)) continue;
    found[kept] = found[k];
    distance2[kept++] = distance2[k];
  }
  found.resize(kept);
  distance2.resize(kept);
}

}  // namespace

struct KernelField::Impl {
  const Solid& solid;
  std::vector<Site> points;
  KernelFieldOptions options;
  Grading grading;
  double sigma = 1, radius = 1;
  std::vector<float> scale, inverse;  // of each point
  std::optional<KdTree> tree;
  std::optional<PointHash> hash;
};

KernelField::KernelField(const Solid& solid, std::vector<Site> points,
                         const KernelFieldOptions& options, const Grading& grading)
    : impl_(new Impl{solid, std::move(points), options, grading, 1, 1, {}, {}, {}, {}}) {
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

  f.scale.resize(f.points.size());
  for (std::size_t i = 0; i < f.points.size(); ++i)
    f.scale[i] = static_cast<float>(grading.at(f.points[i].x));
  const std::size_t measured = std::min(most_measured, f.points.size());
  std::vector<double> distance(measured);
  parallel_for(measured, 64, [&](std::size_t k) {
    std::vector<Neighbour> found;
    const std::size_t i = k * f.points.size() / measured;
    f.tree->nearest(f.points[i].x, options.neighbour + 1, found);
    distance[k] = found.back().distance / static_cast<double>(f.scale[i]);
  });
  std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(measured / 2),
                   distance.end());
  f.sigma = options.width * std::max(distance[measured / 2], 1e-6);
  f.radius = (options.kernel == KernelFieldOptions::Kernel::compact ? compact_end : gaussian_end) *
             f.sigma;
  for (const float s : f.scale)
    f.inverse.push_back(1 / static_cast<float>(f.radius * f.radius) / (s * s));
  f.hash.emplace(X, f.radius);
}

KernelField::~KernelField() = default;
KernelField::KernelField(KernelField&&) noexcept = default;
KernelField& KernelField::operator=(KernelField&&) noexcept = default;

const std::vector<Site>& KernelField::points() const { return impl_->points; }
double KernelField::sigma() const { return impl_->sigma; }
double KernelField::radius() const { return impl_->radius; }
const Grading& KernelField::grading() const { return impl_->grading; }
const Solid& KernelField::solid() const { return impl_->solid; }

void KernelField::see(const Site& from, double reach, std::vector<std::int32_t>& seen) const {
  thread_local std::vector<float> distance2;
  const Impl& f = *impl_;
  f.hash->find(from.x, reach, seen, distance2);
  if (!f.grading.uniform()) keep_near(f.scale, reach, f.radius, seen, distance2);
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
  if (!impl_->grading.uniform()) keep_near(impl_->scale, reach, impl_->radius, found, distance2);
  std::sort(found.begin(), found.end());
}

void KernelField::gather(const std::vector<std::int32_t>& index, const Vec3& origin,
                         LocalPoints& local) const {
  for (auto* values : {&local.x, &local.y, &local.z, &local.inverse}) values->resize(index.size());
  for (std::size_t k = 0; k < index.size(); ++k) {
    const auto i = static_cast<std::size_t>(index[k]);
    const Vec3 d = impl_->points[i].x - origin;
    local.x[k] = static_cast<float>(d[0]);
    local.y[k] = static_cast<float>(d[1]);
    local.z[k] = static_cast<float>(d[2]);
    local.inverse[k] = impl_->inverse[i];
  }
}

void KernelField::weights(const Vec3& x, const std::vector<std::int32_t>& seen, float* phi) const {
  thread_local LocalPoints local;
  gather(seen, x, local);
  weights(local, Vec3::Zero(), phi);
}

void KernelField::weights(const LocalPoints& local, const Vec3& x, float* phi) const {
  const Impl& f = *impl_;
  const auto n = static_cast<int>(local.x.size());
  const bool compact = f.options.kernel == KernelFieldOptions::Kernel::compact;
  const float offset[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]),
                           static_cast<float>(x[2])};
  squared_distances(local.x.data(), local.y.data(), local.z.data(), offset, n, phi);
  float sum = 0;
  if (compact) {
    sum = compact_kernel(phi, local.inverse.data(), n);
  } else {
    constexpr auto factor = static_cast<float>(-0.5 * gaussian_end * gaussian_end);
    for (int k = 0; k < n; ++k) {
      const float t = phi[k] * local.inverse[static_cast<std::size_t>(k)];
      phi[k] = t < 1 ? std::exp(factor * t) : 0.0f;
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
