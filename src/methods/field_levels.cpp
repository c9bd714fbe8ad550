#include "methods/field_levels.h"

#include "methods/convex_field.h"
#include "skinfield/base/parallel.h"
#include "skinfield/rig/handle_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace skinfield {
namespace {

constexpr int first_steps = 200, middle_steps = 30, finest_steps = 100;
constexpr int wider = 4;  // times the passes in the plane, which has more points across
constexpr double gain_in_plane = 2e-5;
constexpr float dust = 1e-3f;              // of a weight: goes at each prolongation
constexpr int held_out_one_in = 10;        // samples
constexpr std::size_t most_probes = 2048;  // held-out samples at which the weights are watched
constexpr double near_radius = 1.75;       // of sigma, for samples near handles
constexpr float certain = 12;              // softplus(12) against softplus(-12): one hot to 1e-6
constexpr std::uint64_t level_streams = std::uint64_t{1} << 40;

}  // namespace

void LevelSolver::prolong(const std::vector<Site>& points, std::span<FloatRows* const> all) const {
  const KernelField& coarse = *field_.kernel;
  std::vector<FloatRows> finer(all.size());
  for (std::size_t f = 0; f < all.size(); ++f)
    finer[f] = FloatRows::Zero(static_cast<Eigen::Index>(points.size()), all[f]->cols());
  parallel_for(points.size(), 64, [&](std::size_t i) {
    thread_local std::vector<std::int32_t> seen;
    thread_local std::vector<float> phi;
    coarse.see(points[i], coarse.radius(), seen);
    if (seen.empty()) seen.push_back(coarse.nearest(points[i].x));
    phi.resize(seen.size());
    coarse.weights(points[i].x, seen, phi.data());
    for (std::size_t f = 0; f < all.size(); ++f) {
      auto row = finer[f].row(static_cast<Eigen::Index>(i));
      for (std::size_t k = 0; k < seen.size(); ++k)
        if (phi[k] > 0) row += phi[k] * all[f]->row(seen[k]);
    }
  });
  for (std::size_t f = 0; f < all.size(); ++f) *all[f] = std::move(finer[f]);
}

void LevelSolver::take_up(const FieldState& saved, std::vector<Site> points,
                          const Progress& progress) {
  field_.kernel.emplace(field_.solid, points, options_.kernel, field_.sampler->grading());
  const auto n = static_cast<Eigen::Index>(field_.kernel->points().size());
  bool same = n == saved.X.rows();
  for (Eigen::Index i = 0; same && i < n; ++i)
    same = field_.kernel->points()[static_cast<std::size_t>(i)].x == saved.X.row(i).transpose();
  field_.F = saved.F;
  if (same) return;
  field_.kernel.emplace(field_.solid, field_.solid.sites(saved.X), options_.kernel,
                        field_.sampler->grading());
  enter(saved.level, std::move(points), progress);
}

void LevelSolver::enter(int level, std::vector<Site> points, const Progress& progress) {
  progress.check();
  const std::vector<char>& bound = field_.conditions->bound();
  if (!field_.kernel) {
    const auto n = static_cast<Eigen::Index>(points.size());
    field_.kernel.emplace(field_.solid, std::move(points), options_.kernel,
                          field_.sampler->grading());
    const auto columns = static_cast<float>(std::count(bound.begin(), bound.end(), 1));
    field_.F = FloatRows::Zero(n, static_cast<Eigen::Index>(bound.size()));
    if (!field_.softplus)
      for (std::size_t j = 0; j < bound.size(); ++j)
        if (bound[j]) field_.F.col(static_cast<Eigen::Index>(j)).setConstant(1 / columns);
  } else {
    KernelField finer(field_.solid, std::move(points), options_.kernel, field_.sampler->grading());
    std::vector<FloatRows*> all{&field_.F};
    if (state_.first.size() > 0) all.insert(all.end(), {&state_.first, &state_.second});
    prolong(finer.points(), all);
    FloatRows& F = field_.F;
    if (!field_.softplus) {
      for (Eigen::Index i = 0; i < F.rows(); ++i) {
        auto row = F.row(i);
        row = (row.array() < dust).select(0.0f, row);
        row /= row.sum();
      }
    }
    field_.kernel.emplace(std::move(finer));
  }
  state_.level = level;
  state_.step = 0;
}

InteriorSamples LevelSolver::sample_source() const {
  return {*field_.sampler, field_.solid, field_.conditions->segments(),
          near_radius * field_.kernel->sigma(), options_.near_handles};
}

std::vector<WeightedSite> LevelSolver::draw_samples(const InteriorSamples& source, int count,
                                                    std::uint64_t stream,
                                                    const Progress& progress) const {
  std::vector<WeightedSite> samples = source.draw(count, state_.seed, stream, progress);
  // Equation 11.
  for (WeightedSite& s : samples)
    s.weight *=
        winding_weight(field_.solid.winding(s.site), options_.winding_low, options_.winding_high);
  std::erase_if(samples, [](const WeightedSite& s) { return !(s.weight > 0); });
  return samples;
}

std::function<RowMatrix(const FloatRows&)> LevelSolver::make_probe(
    const std::vector<WeightedSite>& samples) const {
  auto stencils =
      std::make_shared<std::vector<FieldStencil>>(std::min(samples.size(), most_probes));
  parallel_for(stencils->size(), 32, [&](std::size_t i) {
    const Site& site = samples[i * samples.size() / stencils->size()].site;
    FieldStencil& stencil = (*stencils)[i];
    if (!make_stencil(*field_.kernel, *field_.conditions, site, std::span(&site.x, 1), stencil))
      stencil.place.clear();
  });
  return [this, stencils](const FloatRows& F) {
    RowMatrix W = RowMatrix::Zero(static_cast<Eigen::Index>(stencils->size()), F.cols());
    const FieldReader reader(F, field_.conditions->bound(), false);
    parallel_for(stencils->size(), 32, [&](std::size_t i) {
      const FieldStencil& stencil = (*stencils)[i];
      if (!stencil.place.empty()) reader.at(stencil, 0, W.row(static_cast<Eigen::Index>(i)).data());
    });
    return W;
  };
}

bool LevelSolver::solve_convex(int level, bool finest, StageClock& clock,
                               const Progress& progress) {
  const KernelField& kernel = *field_.kernel;
  const std::uint64_t stream = level_streams * static_cast<std::uint64_t>(level + 1);
  const double directions = field_.solid.dimension();
  const double wanted = options_.rows_per_point * static_cast<double>(kernel.points().size()) /
                        directions * held_out_one_in / (held_out_one_in - 1);
  const std::vector<WeightedSite> samples =
      draw_samples(sample_source(),
                   std::clamp(static_cast<int>(wanted), 64, std::numeric_limits<int>::max() / 8),
                   stream, progress);
  std::vector<WeightedSite> train, held;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool out =
        Random(state_.seed, stream + level_streams / 4 + i).below(held_out_one_in) == 0;
    (out ? held : train).push_back(samples[i]);
  }
  clock.lap("samples");
  const double h = options_.step * kernel.sigma();
  const auto columns = static_cast<int>(field_.F.cols());
  const FieldRows rows(kernel, *field_.conditions, train, h, columns, state_.seed,
                       stream + level_streams / 2, progress);
  const FieldRows held_rows(kernel, *field_.conditions, held, h, columns, state_.seed,
                            stream + 3 * (level_streams / 4), progress);
  clock.lap("rows");
  ConvexOptions convex;
  convex.max_steps = level == 0 ? first_steps : finest ? finest_steps : middle_steps;
  if (field_.solid.dimension() == 2) {
    convex.max_steps *= wider;
    convex.held_out_gain = gain_in_plane;
  }
  // The limit is on the iterations of all levels.
  if (options_.max_iterations > 0)
    convex.max_steps = static_cast<int>(
        std::clamp<std::int64_t>(options_.max_iterations - stats_.iterations, 0, convex.max_steps));
  convex.tolerance = options_.tolerance;
  convex.stop = stop;
  convex.probe = make_probe(held);
  const std::int64_t before = stats_.iterations;
  SolveStats level_stats = minimise_convex(rows, held_rows, field_.conditions->bound(), convex,
                                           eigenvalue_, field_.F, progress);
  stats_.iterations = static_cast<int>(before) + level_stats.iterations;
  stats_.status = level_stats.status;
  stats_.largest_change = level_stats.largest_change;
  state_.step += level_stats.iterations;
  state_.steps = stats_.iterations;
  clock.lap("minimise");
  const bool stopped = stop();
  if (watch && !finest && !stopped) watch(field_.F);
  if (finest || stopped) {
    certify(rows, field_.conditions->bound(), field_.F, stats_, progress);
    facts_.rows = rows.rows();
    facts_.held_out_rows = held_rows.rows();
    facts_.blind_samples = rows.blind_samples() + held_rows.blind_samples();
    facts_.row_bytes = rows.bytes() + held_rows.bytes();
    facts_.held_out_energy = held_rows.energy(field_.F, nullptr, progress);
    clock.lap("certificate");
  }
  if (stopped) stats_.status = SolveStats::Status::limit;
  return !stopped;
}

bool LevelSolver::solve(int level, bool finest, StageClock& clock, const Progress& progress) {
  if (options_.solver == GeometricFieldsOptions::Solver::convex)
    return solve_convex(level, finest, clock, progress);
  return solve_adam(level, finest, clock, progress);
}

void LevelSolver::settle_unreached(const Progress& progress) {
  const KernelField& kernel = *field_.kernel;
  const std::vector<Site>& points = kernel.points();
  const FieldConditions& conditions = *field_.conditions;
  std::vector<std::vector<std::int32_t>> seen(points.size());
  std::vector<char> prescribed(points.size(), 0);
  parallel_for(points.size(), 32, [&](std::size_t i) {
    if ((i & 31) == 0) progress.check();
    // Half the way to what a sample between two points sees.
    kernel.see(points[i], kernel.radius(), seen[i]);
    prescribed[i] = conditions.touches(
        points[i],
        kernel.radius() + std::max(conditions.radii().lagrange, conditions.radii().dirichlet));
  });
  std::vector<char> done(points.size(), 0);
  std::vector<std::int32_t> piece;
  for (std::size_t s = 0; s < points.size(); ++s) {
    if (done[s]) continue;
    piece.assign(1, static_cast<std::int32_t>(s));
    done[s] = 1;
    bool reached = false;
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const auto i = static_cast<std::size_t>(piece[k]);
      reached |= prescribed[i] != 0;
      for (const std::int32_t j : seen[i]) {
        if (done[static_cast<std::size_t>(j)]) continue;
        done[static_cast<std::size_t>(j)] = 1;
        piece.push_back(j);
      }
    }
    if (reached) continue;
    facts_.unreached_points += static_cast<std::int64_t>(piece.size());
    double best = std::numeric_limits<double>::infinity();
    std::size_t handle = 0;
    for (const std::int32_t i : piece)
      for (std::size_t h = 0; h < field_.handles.size(); ++h) {
        if (!conditions.bound()[h]) continue;
        const double d = handle_distance(field_.handles[h], points[static_cast<std::size_t>(i)].x,
                                         field_.mesh.V);
        if (d < best) best = d, handle = h;
      }
    if (!std::isfinite(best)) continue;  // painted shapes without handles: nothing is nearest
    for (const std::int32_t i : piece) {
      field_.F.row(i).setConstant(field_.softplus ? -certain : 0.0f);
      field_.F(i, static_cast<Eigen::Index>(handle)) = field_.softplus ? certain : 1.0f;
    }
  }
}

}  // namespace skinfield
