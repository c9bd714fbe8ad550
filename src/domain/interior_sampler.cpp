#include "skinfield/domain/interior_sampler.h"

#include "domain/disk_grid.h"
#include "domain/interior_cells.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinfield {
namespace {

constexpr int cell_depth = 6, cell_depth_in_plane = 9;
constexpr int cell_tests = 8;
constexpr double density_tests = 1 << 19;                             // in the whole box
constexpr int least_density_tests = 8, most_density_tests = 1 << 14;  // of a cell
constexpr int most_pieces = 200;                                      // of a segment
constexpr int most_tries = 4000;
constexpr double disk = 0.78;           // smallest distance in units of (V / N)^(1/3)
constexpr double disk_in_plane = 0.72;  // of (A / N)^(1/2): as full as balls then are
constexpr double pool_per_point = 8;    // candidates
constexpr double fallback = 0.9;        // of the distance, where the pool has no room left

double power(double x, int dimension) { return dimension == 2 ? x * x : x * x * x; }

double root(double x, int dimension) { return dimension == 2 ? std::sqrt(x) : std::cbrt(x); }

/// Of a ball, or of a disc.
double ball_volume(double radius, int dimension) {
  return (dimension == 2 ? 1.0 : 4.0 / 3) * std::numbers::pi * power(radius, dimension);
}

/// Uniform in [-1,1]^d.
Vec3 in_cube(Random& random, int dimension) {
  const Vec3 u(random.uniform(), random.uniform(), random.uniform());
  Vec3 x = 2 * u - Vec3::Ones();
  if (dimension == 2) x.z() = 0;
  return x;
}

}  // namespace

struct InteriorSampler::Impl {
  const Solid& solid;
  int dimension;
  std::vector<InteriorCell> cells;
  std::vector<double> until;  // volume of the boxes up to and with each
  double volume = 0;
  bool closed;  // cells wholly inside need no test
  Grading grading;
  std::vector<double> densest;  // of each cell; empty: 1
  double mass = 0;              // integral of the density
};

InteriorSampler::InteriorSampler(const Solid& solid, std::uint64_t seed, const Progress& progress)
    : impl_(
          new Impl{solid,
                   solid.dimension(),
                   interior_cells(solid, solid.dimension() == 2 ? cell_depth_in_plane : cell_depth,
                                  cell_tests, seed, progress),
                   {},
                   0,
                   !solid.has_dirty(),
                   {},
                   {},
                   0}) {
  double boxes = 0;
  for (const InteriorCell& c : impl_->cells) {
    const double box = power(2 * c.half, impl_->dimension);
    boxes += box;
    impl_->until.push_back(boxes);
    impl_->volume += box * c.share;
  }
  if (!(impl_->volume > 0))
    throw DomainError("the shape encloses no volume", {}, "use the surface as domain");
  impl_->mass = impl_->volume;
  parallel_for(impl_->cells.size(), 32, [&](std::size_t i) {
    if (impl_->cells[i].whole) impl_->cells[i].site = solid.site(impl_->cells[i].centre);
  });
}

InteriorSampler::~InteriorSampler() = default;
InteriorSampler::InteriorSampler(InteriorSampler&&) noexcept = default;
InteriorSampler& InteriorSampler::operator=(InteriorSampler&&) noexcept = default;

void InteriorSampler::grade(const Grading& grading, std::uint64_t seed) {
  if (grading.uniform()) return;
  Impl& d = *impl_;
  d.grading = grading;
  d.densest.resize(d.cells.size());
  std::vector<double> mean(d.cells.size());
  parallel_for(d.cells.size(), 32, [&](std::size_t c) {
    const InteriorCell& cell = d.cells[c];
    const double s = grading.at(cell.centre) - grading.slope() * std::sqrt(d.dimension) * cell.half;
    d.densest[c] = 1 / power(std::max(s, grading.least()), d.dimension);
    Random random(seed, 0x60000000ull + c);
    const int tests =
        std::clamp(static_cast<int>(density_tests * power(2 * cell.half, d.dimension)),
                   least_density_tests, most_density_tests);
    for (int k = 0; k < tests; ++k) {
      const Vec3 x = cell.centre + cell.half * in_cube(random, d.dimension);
      mean[c] += grading.density(x) / tests;
    }
  });
  double sum = 0;
  d.mass = 0;
  for (std::size_t c = 0; c < d.cells.size(); ++c) {
    const double box = power(2 * d.cells[c].half, d.dimension);
    sum += box * d.densest[c];
    d.until[c] = sum;
    d.mass += box * d.cells[c].share * mean[c];
  }
}

double InteriorSampler::volume() const { return impl_->volume; }

double InteriorSampler::density(const Vec3& x) const {
  return impl_->grading.density(x) / impl_->mass;
}

Site InteriorSampler::draw(std::uint64_t seed, std::uint64_t stream) const {
  Random random(seed, stream);
  Site site;
  for (int attempt = 0; attempt < most_tries; ++attempt) {
    const double target = random.uniform() * impl_->until.back();
    const auto at = std::upper_bound(impl_->until.begin(), impl_->until.end(), target);
    const auto c =
        std::min(static_cast<std::size_t>(at - impl_->until.begin()), impl_->cells.size() - 1);
    const InteriorCell& cell = impl_->cells[c];
    const Vec3 x = cell.centre + cell.half * in_cube(random, impl_->dimension);
    if (!impl_->densest.empty() && random.uniform() * impl_->densest[c] > impl_->grading.density(x))
      continue;
    site = impl_->solid.site_near(cell.site, x);
    if ((cell.whole && impl_->closed) || impl_->solid.inside(site)) return site;
  }
  return site;
}

const Grading& InteriorSampler::grading() const { return impl_->grading; }

Site InteriorSampler::site(const Vec3& x) const { return impl_->solid.site(x); }

std::vector<Site> InteriorSampler::spread(const std::vector<int>& counts, std::uint64_t seed,
                                          const Progress& progress) const {
  std::vector<Site> pool(static_cast<std::size_t>(pool_per_point * counts.back()));
  parallel_for(pool.size(), 256, [&](std::size_t i) {
    if ((i & 255) == 0) progress.check();
    pool[i] = draw(seed, 0x50000000ull + i);
  });
  std::vector<Site> chosen;
  std::vector<char> used(pool.size(), 0);
  for (const int count : counts) {
    const auto wanted = static_cast<std::size_t>(count);
    double radius = (impl_->dimension == 2 ? disk_in_plane : disk) *
                    root(impl_->mass / count, impl_->dimension);
    for (int round = 0; chosen.size() < wanted && round < 40; ++round, radius *= fallback) {
      progress.check();
      DiskGrid grid(radius * impl_->grading.least(), wanted);
      for (const Site& s : chosen) grid.add(s.x, radius * impl_->grading.at(s.x), false);
      for (std::size_t i = 0; i < pool.size() && chosen.size() < wanted; ++i) {
        if (used[i]) continue;
        const double own = radius * impl_->grading.at(pool[i].x);
        if (grid.conflicts(pool[i].x, own, 1)) continue;
        grid.add(pool[i].x, own, false);
        chosen.push_back(pool[i]);
        used[i] = 1;
      }
    }
  }
  parallel_for(chosen.size(), 64,
               [&](std::size_t i) { impl_->solid.measure_clearance(chosen[i]); });
  return chosen;
}

InteriorSamples::InteriorSamples(const InteriorSampler& sampler, const Solid& solid,
                                 const Segments& segments, double widest, double share_near)
    : sampler_(sampler),
      solid_(solid),
      segments_(segments),
      share_near_(segments.empty() ? 0 : share_near) {
  for (const auto& [a, b] : segments) {
    const double radius = widest * sampler.grading().at(0.5 * (a + b));
    radius_.push_back(radius);
    // A point counts like a bone as long as the ball is wide.
    total_ += std::max((b - a).norm(), 2 * radius);
    until_.push_back(total_);
    const int count = std::clamp(static_cast<int>((b - a).norm() / radius), 1, most_pieces);
    std::vector<Site>& pieces = pieces_.emplace_back();
    for (int p = 0; p < count; ++p) pieces.push_back(solid.site(a + (p + 0.5) / count * (b - a)));
  }
}

double InteriorSamples::density(const Vec3& x) const {
  double sum = 0;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const auto& [a, b] = segments_[s];
    const double radius = radius_[s], ball = ball_volume(radius, solid_.dimension());
    const double length = (b - a).norm();
    const double share = std::max(length, 2 * radius) / total_;
    if (length == 0) {
      sum += (x - a).norm() < radius ? share / ball : 0;
      continue;
    }
    const Vec3 along = (b - a) / length;
    const double t = (x - a).dot(along);
    const double off2 = (x - a - t * along).squaredNorm();
    if (off2 >= radius * radius) continue;
    const double half = std::sqrt(radius * radius - off2);
    const double chord = std::min(length, t + half) - std::max(0.0, t - half);
    sum += share * std::max(0.0, chord) / (length * ball);
  }
  return sum;
}

std::vector<WeightedSite> InteriorSamples::draw(int count, std::uint64_t seed, std::uint64_t stream,
                                                const Progress& progress) const {
  const int near = static_cast<int>(std::lround(share_near_ * count));
  std::vector<WeightedSite> drawn(static_cast<std::size_t>(count));
  parallel_for(drawn.size(), 64, [&](std::size_t i) {
    if ((i & 63) == 0) progress.check();
    WeightedSite& sample = drawn[i];
    if (static_cast<int>(i) < near) {
      // A uniform point of a segment, a uniform offset in a ball.
      Random random(seed, stream + i);
      const double target = random.uniform() * total_;
      const auto at = std::upper_bound(until_.begin(), until_.end(), target);
      const auto s = std::min(static_cast<std::size_t>(at - until_.begin()), until_.size() - 1);
      const auto& [a, b] = segments_[s];
      const double t = random.uniform();
      const int dimension = solid_.dimension();
      const Vec3 direction = random.direction(dimension);
      const Vec3 x = a + t * (b - a) + radius_[s] * root(random.uniform(), dimension) * direction;
      const auto& pieces = pieces_[s];
      sample.site = solid_.site_near(
          pieces[static_cast<std::size_t>(t * static_cast<double>(pieces.size()))], x);
      if (!solid_.inside(sample.site)) return;
    } else {
      sample.site = sampler_.draw(seed, stream + i);
    }
    solid_.measure_clearance(sample.site);
    const double spread = (count - near) * sampler_.density(sample.site.x);
    sample.weight = 1 / (spread + (near > 0 ? near * density(sample.site.x) : 0));
  });
  std::erase_if(drawn, [](const WeightedSite& s) { return s.weight == 0; });
  return drawn;
}

}  // namespace skinfield
