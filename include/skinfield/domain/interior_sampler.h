// Random points inside a solid: uniform, near handles, and evenly spread ones in nested sets
// (geometric fields, section 5.1 and appendix A).
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/domain/grading.h"
#include "skinfield/domain/solid.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace skinfield {

/// Positions in the unit box. Thread-safe for queries. Refers to the solid, which must outlive it.
class InteriorSampler {
 public:
  /// @throws DomainError if the solid has no volume.
  InteriorSampler(const Solid& solid, std::uint64_t seed, const Progress& progress = {});
  ~InteriorSampler();
  InteriorSampler(InteriorSampler&&) noexcept;
  InteriorSampler& operator=(InteriorSampler&&) noexcept;

  /// From now on points have the grading's density.
  void grade(const Grading& grading, std::uint64_t seed);
  const Grading& grading() const;
  double volume() const;  ///< of a planar solid its area
  /// Probability density of draw at x in the interior.
  double density(const Vec3& x) const;
  /// Uniform in the interior or graded; depends on (seed, stream) alone. The clearance is a lower
  /// bound.
  Site draw(std::uint64_t seed, std::uint64_t stream) const;
  /// The site of a point drawn elsewhere.
  Site site(const Vec3& x) const;
  /// Points that keep their distance from each other: of the result, the first counts[l] do so at
  /// the density of counts[l] points. counts ascending, the last is the size of the result (fewer
  /// where the solid has no room for more).
  std::vector<Site> spread(const std::vector<int>& counts, std::uint64_t seed,
                           const Progress& progress) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A sample of an integral over the interior.
struct WeightedSite {
  Site site;
  double weight = 0;  ///< volume that it stands for
};

/// Samples of the interior, a share of them within `radius` of the segments (points: both ends
/// equal; graded where the sampler is), the rest as the sampler draws; weighted by the balance
/// heuristic of multiple importance sampling, so that the sum of weight * g estimates the integral
/// of g without bias. Refers to its arguments.
class InteriorSamples {
 public:
  using Segments = std::vector<std::pair<Vec3, Vec3>>;
  InteriorSamples(const InteriorSampler& sampler, const Solid& solid, const Segments& segments,
                  double radius, double share_near);
  /// `count` draws, those outside dropped, with exact clearances. Depends on (seed, stream) and
  /// the arguments alone.
  std::vector<WeightedSite> draw(int count, std::uint64_t seed, std::uint64_t stream,
                                 const Progress& progress = {}) const;

 private:
  /// Probability density near handles at x.
  double density(const Vec3& x) const;

  const InteriorSampler& sampler_;
  const Solid& solid_;
  const Segments& segments_;
  double share_near_, total_ = 0;
  std::vector<double> radius_;             ///< of each segment
  std::vector<double> until_;              ///< lengths up to and with each segment
  std::vector<std::vector<Site>> pieces_;  ///< known places on each segment
};

}  // namespace skinfield
