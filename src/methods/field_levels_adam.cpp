// Adam's share of a level: fresh samples each step, or a pool of them (appendix A).
#include "methods/adam_field.h"
#include "methods/field_levels.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace skinfield {
namespace {

constexpr int fresh_steps = 6000;                                       // over all levels, alike
constexpr std::array<int, 6> pool_steps{800, 500, 400, 300, 200, 200};  // over its own six
constexpr int all_pool_steps = 2400;
constexpr double first_rate = 0.2, last_rate = 0.2 / 27;  // divided by 3 at three doublings
constexpr int samples_in_space = 1 << 11, samples_in_plane = 1 << 12;  // M
constexpr int rates = 4;
constexpr int watched_every = 50;
constexpr double pool_per_point = 2;  // rows of the pool
constexpr double small_pool_per_point = 16;
constexpr int small_pool = 1 << 16;
constexpr int judged = 1 << 12;  // samples for the reported energy
constexpr std::uint64_t level_streams = std::uint64_t{1} << 40;
constexpr std::uint64_t judging = 7 * (level_streams / 8);
constexpr std::uint64_t choosing = 6 * (level_streams / 8);

/// Stencils of samples along one random direction each; nodes that carry nothing are dropped.
void make_samples(const KernelField& kernel, const FieldConditions& conditions,
                  const std::vector<WeightedSite>& drawn, double h, std::uint64_t seed,
                  std::uint64_t stream, bool keep, std::vector<FieldSample>& samples,
                  const Progress& progress) {
  samples.resize(drawn.size());
  parallel_for(drawn.size(), 32, [&](std::size_t i) {
    if ((i & 31) == 0) progress.check();
    const Site& site = drawn[i].site;
    const Vec3 v =
        Random(seed, stream + level_streams / 2 + i).direction(kernel.solid().dimension());
    FieldSample& sample = samples[i];
    sample.h = h * kernel.grading().at(site.x);
    const std::array<Vec3, 3> wanted{site.x, site.x + sample.h * v, site.x - sample.h * v};
    const bool sees = make_stencil(kernel, conditions, site, wanted, sample.stencil);
    sample.weight = sees ? drawn[i].weight : 0;
    if (!sees || !keep) return;
    FieldStencil& st = sample.stencil;
    const std::size_t n = st.node.size(), places = st.place.size();
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t q = 0; q < places; ++q)
        if (st.phi[q * n + k] > 0) {
          kept.push_back(k);
          break;
        }
    std::vector<std::int32_t> node;
    std::vector<float> phi;
    node.reserve(kept.size());
    phi.reserve(kept.size() * places);
    for (const std::size_t k : kept) node.push_back(st.node[k]);
    for (std::size_t q = 0; q < places; ++q)
      for (const std::size_t k : kept) phi.push_back(st.phi[q * n + k]);
    st.node = std::move(node);
    st.phi = std::move(phi);
  });
}

std::int64_t steps_of_level(bool pooled, std::size_t level, std::size_t levels) {
  if (pooled && levels == pool_steps.size()) return pool_steps[level];
  return (pooled ? all_pool_steps : fresh_steps) / static_cast<std::int64_t>(levels);
}

/// Falls with the levels; where there is but one, after equal shares of its steps.
double rate_at(std::size_t level, std::size_t levels, std::int64_t step, std::int64_t steps) {
  const double share =
      levels > 1 ? static_cast<double>(level) / static_cast<double>(levels - 1)
                 : static_cast<double>(step * rates / steps) / static_cast<double>(rates - 1);
  return first_rate * std::pow(last_rate / first_rate, share);
}

}  // namespace

bool LevelSolver::solve_adam(int level, bool finest, StageClock& clock, const Progress& progress) {
  const KernelField& kernel = *field_.kernel;
  const FieldConditions& conditions = *field_.conditions;
  const bool pooled = options_.solver == GeometricFieldsOptions::Solver::adam_pool;
  const double h = options_.step * kernel.sigma();
  const std::uint64_t stream = level_streams * static_cast<std::uint64_t>(level + 1);
  const InteriorSamples source = sample_source();
  AdamField adam(field_.F, state_.first, state_.second, conditions.bound());

  std::vector<FieldSample> pool;
  if (pooled) {
    const auto points = static_cast<double>(kernel.points().size());
    const auto count = static_cast<int>(std::max(
        pool_per_point * points, std::min<double>(small_pool, small_pool_per_point * points)));
    const std::vector<WeightedSite> drawn = draw_samples(source, count, stream, progress);
    clock.lap("samples");
    make_samples(kernel, conditions, drawn, h, state_.seed, stream, true, pool, progress);
    clock.lap("rows");
  }
  const int own = field_.solid.dimension() == 2 ? samples_in_plane : samples_in_space;
  const int wanted = options_.samples_per_step > 0 ? options_.samples_per_step : own;
  const int batch = std::clamp(wanted, 1, 1 << 20);
  const std::size_t levels = state_.counts.size();
  const std::int64_t steps = steps_of_level(pooled, static_cast<std::size_t>(level), levels);
  std::vector<FieldSample> fresh;
  std::vector<const FieldSample*> chosen;
  bool stopped = false;
  for (; state_.step < steps; ++state_.step) {
    stopped = stop();
    if (stopped) break;
    progress.check();
    chosen.clear();
    const std::uint64_t here = stream + static_cast<std::uint64_t>(state_.step) * (1 << 20);
    if (pooled && !pool.empty()) {
      Random random(state_.seed, choosing + here);
      for (int i = 0; i < batch; ++i)
        chosen.push_back(&pool[random.below(static_cast<std::uint32_t>(pool.size()))]);
    } else {
      const std::vector<WeightedSite> drawn = draw_samples(source, batch, here, progress);
      make_samples(kernel, conditions, drawn, h, state_.seed, here, false, fresh, progress);
      for (const FieldSample& sample : fresh) chosen.push_back(&sample);
    }
    ++state_.steps;
    const double rate = rate_at(static_cast<std::size_t>(level), levels, state_.step, steps);
    adam.step(chosen, rate, state_.steps);
    stats_.iterations = static_cast<int>(state_.steps);
    if (watch && state_.steps % watched_every == 0) watch(adam.parameters());
    progress("adam", static_cast<double>(state_.step) / static_cast<double>(steps));
  }
  field_.F = adam.parameters();
  state_.first = adam.first();
  state_.second = adam.second();
  clock.lap("minimise");
  if (finest || stopped) {
    // On samples of its own; the problem is not convex, so there is no bound.
    const std::vector<WeightedSite> drawn =
        draw_samples(source, judged, stream + judging, progress);
    make_samples(kernel, conditions, drawn, h, state_.seed, stream + judging, false, fresh,
                 progress);
    chosen.clear();
    for (const FieldSample& sample : fresh) {
      chosen.push_back(&sample);
      facts_.blind_samples += sample.weight > 0 ? 0 : 1;
    }
    stats_.energy = facts_.held_out_energy = adam.energy(chosen);
    stats_.lower_bound = 0;
    stats_.relative_gap = 1;
    facts_.rows = pooled ? static_cast<std::int64_t>(pool.size()) : batch;
    clock.lap("certificate");
  }
  stats_.status = stopped ? SolveStats::Status::limit : SolveStats::Status::converged;
  return !stopped;
}

}  // namespace skinfield
