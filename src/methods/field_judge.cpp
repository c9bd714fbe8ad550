#include "methods/field_judge.h"

#include "methods/field_rows.h"
#include "skinfield/base/parallel.h"

#include <array>
#include <cmath>

namespace skinfield {
namespace {

constexpr int judged_samples = 1 << 12;
constexpr double near_handles = 0.5;   // of the samples: the energy is largest there
constexpr double near_radius = 3;      // in steps
constexpr std::uint64_t seed = 20251;  // the same samples whatever the solve's seed

}  // namespace

FieldJudge::FieldJudge(const GeometricField::Impl& field, const GeometricFieldsOptions& options,
                       const Progress& progress)
    : field_(field), step_(options.judged_step) {
  const InteriorSamples source(*field.sampler, field.solid, field.conditions->segments(),
                               near_radius * step_, near_handles);
  samples_ = source.draw(judged_samples, seed, 0, progress);
  for (WeightedSite& s : samples_)
    s.weight *=
        winding_weight(field.solid.winding(s.site), options.winding_low, options.winding_high);
}

void FieldJudge::look(const Progress& progress) {
  const int dimension = field_.solid.dimension();
  stencils_.resize(samples_.size());
  parallel_for(samples_.size(), 32, [&](std::size_t i) {
    if ((i & 31) == 0) progress.check();
    const Site& site = samples_[i].site;
    std::array<Vec3, 7> place;
    place[0] = site.x;
    for (int axis = 0; axis < dimension; ++axis) {
      place[static_cast<std::size_t>(1 + 2 * axis)] = site.x + step_ * Vec3::Unit(axis);
      place[static_cast<std::size_t>(2 + 2 * axis)] = site.x - step_ * Vec3::Unit(axis);
    }
    const std::span wanted = std::span(place).first(static_cast<std::size_t>(1 + 2 * dimension));
    if (!make_stencil(*field_.kernel, *field_.conditions, site, wanted, stencils_[i]))
      stencils_[i].place.clear();
  });
}

double FieldJudge::energy(const FloatRows& F, const Progress& progress) const {
  progress.check();
  const int dimension = field_.solid.dimension();
  const FieldReader reader(F, field_.conditions->bound(), field_.softplus);
  return parallel_reduce(
             samples_.size(), 32, 0.0,
             [&](std::size_t begin, std::size_t end) {
               double sum = 0;
               Vector alpha(F.cols()), laplacian(F.cols());
               for (std::size_t i = begin; i < end; ++i) {
                 if (stencils_[i].place.empty()) continue;
                 laplacian.setZero();
                 for (std::size_t q = 0; q <= 2 * static_cast<std::size_t>(dimension); ++q) {
                   reader.at(stencils_[i], q, alpha.data());
                   laplacian += (q == 0 ? -2.0 * dimension : 1.0) * alpha;
                 }
                 sum += samples_[i].weight * laplacian.squaredNorm();
               }
               return sum;
             },
             [](double a, double b) { return a + b; }) /
         std::pow(step_, 4);
}

}  // namespace skinfield
