// One level of a geometric field after the other (section 5.4): prolongation, and the optimiser's
// share at each.
#pragma once

#include "domain/stage_clock.h"
#include "methods/field_impl.h"
#include "methods/field_rows.h"

#include <functional>

namespace skinfield {

class LevelSolver {
 public:
  LevelSolver(GeometricField::Impl& field, const GeometricFieldsOptions& options, FieldState& state,
              GeometricFieldsFacts& facts, SolveStats& stats)
      : field_(field), options_(options), state_(state), facts_(facts), stats_(stats) {}

  /// Asked before every step.
  std::function<bool()> stop;
  /// Told the parameters now and then (adam, adam_pool), and at the end of each level; or empty.
  std::function<void(const FloatRows&)> watch;

  /// The field gets these points; their parameters come from the level before by its regression.
  void enter(int level, std::vector<Site> points, const Progress& progress);
  /// Goes on from a saved state. Where its points are not the ones that the level would have now
  /// (paint can make parts of the shape count that did not before), these take its values.
  void take_up(const FieldState& saved, std::vector<Site> points, const Progress& progress);
  /// False if it was stopped.
  bool solve(int level, bool finest, StageClock& clock, const Progress& progress);
  /// Points that hang together with nothing prescribed take the handle nearest to their piece.
  void settle_unreached(const Progress& progress);

 private:
  bool solve_convex(int level, bool finest, StageClock& clock, const Progress& progress);
  bool solve_adam(int level, bool finest, StageClock& clock, const Progress& progress);
  /// Weighted by equation 11; those of no weight dropped.
  std::vector<WeightedSite> draw_samples(const InteriorSamples& source, int count,
                                         std::uint64_t stream, const Progress& progress) const;
  /// Reads the weights at some of the samples, for the convex solver.
  std::function<RowMatrix(const FloatRows&)> make_probe(
      const std::vector<WeightedSite>& samples) const;
  InteriorSamples sample_source() const;
  /// Replaces each by its regression at the points.
  void prolong(const std::vector<Site>& points, std::span<FloatRows* const> all) const;

  GeometricField::Impl& field_;
  const GeometricFieldsOptions& options_;
  FieldState& state_;
  GeometricFieldsFacts& facts_;
  SolveStats& stats_;
  double eigenvalue_ = 0;
};

}  // namespace skinfield
