#include "skinfield/methods/geometric_fields.h"

#include "domain/inside_check.h"
#include "domain/stage_clock.h"
#include "methods/field_impl.h"
#include "methods/field_judge.h"
#include "methods/field_levels.h"
#include "methods/field_shape.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace skinfield {
namespace {

constexpr int fewest_points = 16;
// Far from handles what is coarse settles; in the plane, which is wider, from fewer points on.
constexpr int coarsest_convex = 1 << 10, coarsest_convex_in_plane = 1 << 7;
constexpr int convex_growth = 4;
constexpr int paper_first = 1 << 13, paper_first_in_plane = 1 << 11;  // points of its first level
constexpr int paper_doublings = 3;
constexpr int pool_doublings = 5;     // what is far from handles settles while points are few
constexpr double radius_share = 0.5;  // condition radii in units of sigma (appendix A)
constexpr double graded_narrowest = 0.25, least_narrowest = 0.05;
constexpr int grading_places = 1000;  // in the shape, for the typical length of bones there

double narrowest_kernel(const GeometricFieldsOptions& options) {
  if (options.narrowest > 0) return std::clamp(options.narrowest, least_narrowest, 1.0);
  return options.solver == GeometricFieldsOptions::Solver::convex ? graded_narrowest : 1;
}

/// Coarse to fine, up to the wanted number.
std::vector<int> level_counts(const GeometricFieldsOptions& options, int dimension) {
  const int finest = wanted_points(options, dimension);
  std::vector<int> counts{finest};
  if (options.solver == GeometricFieldsOptions::Solver::convex) {
    const auto more = [&] {
      return options.levels > 0 ? static_cast<int>(counts.size()) < options.levels
                                : counts.back() / convex_growth >=
                                      (dimension == 2 ? coarsest_convex_in_plane : coarsest_convex);
    };
    while (more()) counts.push_back(std::max(counts.back() / convex_growth, fewest_points));
  } else {
    const bool pooled = options.solver == GeometricFieldsOptions::Solver::adam_pool;
    const int doublings = options.levels > 0 ? options.levels - 1
                          : pooled           ? pool_doublings
                                             : paper_doublings;
    for (int k = 0; k < doublings; ++k)
      counts.push_back(std::max(counts.back() / 2, fewest_points));
  }
  std::reverse(counts.begin(), counts.end());
  return counts;
}

const char* name_of(GeometricFieldsOptions::Solver solver) {
  switch (solver) {
    case GeometricFieldsOptions::Solver::adam:
      return "adam";
    case GeometricFieldsOptions::Solver::adam_pool:
      return "adam-pool";
    default:
      return "convex";
  }
}

void check_resumable(const FieldState& state, const char* solver, Eigen::Index columns,
                     std::size_t levels) {
  const auto fail = [](const std::string& what) {
    throw InputError("the saved field does not fit: " + what, {}, "solve without --resume");
  };
  if (state.solver != solver) fail("it was solved by " + state.solver + ", not by " + solver);
  if (state.F.cols() != columns)
    fail("it has " + std::to_string(state.F.cols()) + " handles for " + std::to_string(columns));
  if (state.F.rows() != state.X.rows() || state.X.rows() == 0 || !state.X.allFinite() ||
      !state.F.allFinite())
    fail("its points and parameters are damaged");
  if (state.level < 0 || static_cast<std::size_t>(state.level) >= levels)
    fail("it is at a level that these options do not have");
}

/// The paper's radii: half of sigma.
ConditionRadii radii_of(const KernelField& kernel, const GeometricFieldsOptions& options,
                        const FieldState& state) {
  const bool neumann = options.boundary == GeometricFieldsOptions::Boundary::neumann;
  const double radius = radius_share * kernel.sigma();
  return {radius, radius, neumann ? state.neumann_radius : 0};
}

}  // namespace

std::vector<std::pair<std::string, double>> settings_of(const GeometricFieldsOptions& o) {
  return {{"solver", static_cast<double>(o.solver)},
          {"boundary", static_cast<double>(o.boundary)},
          {"visibility", static_cast<double>(o.visibility)},
          {"kernel", static_cast<double>(o.kernel.kernel)},
          {"kernel_neighbour", o.kernel.neighbour},
          {"kernel_width", o.kernel.width},
          {"points", o.points},
          {"step", o.step},
          {"rows_per_point", o.rows_per_point},
          {"near_handles", o.near_handles},
          {"winding_low", o.winding_low},
          {"winding_high", o.winding_high},
          {"samples_per_step", o.samples_per_step},
          {"narrowest", o.narrowest}};
}

void apply_settings(const std::vector<std::pair<std::string, double>>& settings,
                    GeometricFieldsOptions& o) {
  using Options = GeometricFieldsOptions;
  for (const auto& [name, value] : settings) {
    const int whole = static_cast<int>(std::clamp(value, -1e9, 1e9));
    if (name == "solver" && whole >= 0 && whole <= 2)
      o.solver = static_cast<Options::Solver>(whole);
    if (name == "boundary") o.boundary = static_cast<Options::Boundary>(whole == 1);
    if (name == "visibility" && whole >= 0 && whole <= 2)
      o.visibility = static_cast<SolidOptions::Visibility>(whole);
    if (name == "kernel") o.kernel.kernel = static_cast<KernelFieldOptions::Kernel>(whole == 1);
    if (name == "kernel_neighbour") o.kernel.neighbour = std::clamp(whole, 1, 64);
    if (name == "kernel_width" && value > 0) o.kernel.width = value;
    if (name == "points" && whole >= 0) o.points = whole;
    if (name == "step" && value > 0) o.step = value;
    if (name == "rows_per_point" && value > 0) o.rows_per_point = value;
    if (name == "near_handles") o.near_handles = std::clamp(value, 0.0, 0.95);
    if (name == "winding_low") o.winding_low = value;
    if (name == "winding_high") o.winding_high = value;
    if (name == "narrowest" && value >= 0) o.narrowest = value;
    if (name == "samples_per_step" && whole >= 0) o.samples_per_step = whole;
  }
}

GeometricField::GeometricField(const Mesh& mesh, const std::vector<Handle>& handles,
                               const PaintedVertices& paint, const GeometricFieldsOptions& options,
                               const Progress& progress)
    : GeometricField(LaidShape(mesh, handles), paint, options, progress) {}

GeometricField::GeometricField(const LaidShape& shape, const PaintedVertices& paint,
                               const GeometricFieldsOptions& options, const Progress& progress)
    : impl_(new Impl{shape.mesh,
                     shape.handles,
                     paint,
                     shape.plane,
                     make_field_solid(shape, paint, options, progress),
                     {},
                     {},
                     {},
                     {},
                     false}) {
  check_has_inside(impl_->solid, impl_->mesh);
  impl_->softplus = options.solver != GeometricFieldsOptions::Solver::convex;
  impl_->conditions.emplace(impl_->solid, impl_->mesh, impl_->handles, paint,
                            options.boundary == GeometricFieldsOptions::Boundary::neumann);
  const std::vector<char>& bound = impl_->conditions->bound();
  if (std::find(bound.begin(), bound.end(), 1) == bound.end())
    throw DomainError("no handle has a part inside the shape", {}, "use the surface as domain");
  impl_->sampler.emplace(impl_->solid, options.seed, progress);
  if (const double narrowest = narrowest_kernel(options); narrowest < 1) {
    Points places(grading_places, 3);
    for (Eigen::Index i = 0; i < places.rows(); ++i)
      places.row(i) =
          impl_->sampler->draw(options.seed, 0x70000000ull + static_cast<std::uint64_t>(i)).x;
    impl_->sampler->grade(
        {impl_->conditions->segments(), places, narrowest, impl_->solid.dimension()}, options.seed);
  }
}

GeometricField::~GeometricField() = default;
GeometricField::GeometricField(GeometricField&&) noexcept = default;

std::shared_ptr<GeometricField> restore_field(const Mesh& mesh, const std::vector<Handle>& handles,
                                              const PaintedVertices& paint,
                                              const GeometricFieldsOptions& options,
                                              const FieldState& state, const Progress& progress) {
  auto restored = std::make_shared<GeometricField>(mesh, handles, paint, options, progress);
  GeometricField::Impl& field = restored->impl();
  check_resumable(state, name_of(options.solver),
                  static_cast<Eigen::Index>(field.conditions->bound().size()), state.counts.size());
  field.kernel.emplace(field.solid, field.solid.sites(state.X), options.kernel,
                       field.sampler->grading());
  field.F = state.F;
  field.conditions->set_radii(radii_of(*field.kernel, options, state), field.sampler->grading());
  return restored;
}

GeometricFieldsResult geometric_fields(const Mesh& mesh, const std::vector<Handle>& handles,
                                       const PaintedVertices& paint,
                                       const GeometricFieldsOptions& options,
                                       const FieldState* resume, const Progress& progress) {
  GeometricFieldsResult result;
  StageClock clock(result.facts.seconds);
  progress("solid", 0);
  result.field = std::make_shared<GeometricField>(mesh, handles, paint, options, progress);
  GeometricField::Impl& field = result.field->impl();
  clock.lap("solid");

  FieldState& state = result.state;
  state.solver = name_of(options.solver);
  state.seed = options.seed;
  state.counts = level_counts(options, field.solid.dimension());
  if (resume) {
    if (!resume->counts.empty()) state.counts = resume->counts;
    check_resumable(*resume, state.solver.c_str(),
                    static_cast<Eigen::Index>(field.conditions->bound().size()),
                    state.counts.size());
    state = *resume;
    result.stats.iterations = static_cast<int>(state.steps);
  }
  progress("points", 0);
  const std::vector<Site> points = field.sampler->spread(state.counts, state.seed, progress);
  clock.lap("points");

  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  LevelSolver solver(field, options, state, result.facts, result.stats);
  solver.stop = [&] {
    if (options.max_iterations > 0 && result.stats.iterations >= options.max_iterations)
      return true;
    return options.time_limit_s > 0 &&
           std::chrono::duration<double>(Clock::now() - start).count() > options.time_limit_s;
  };
  std::optional<FieldJudge> judge;
  if (options.judged_step > 0) {
    judge.emplace(field, options, progress);
    solver.watch = [&](const FloatRows& F) {
      std::vector<JudgedEnergy>& judged = result.facts.judged;
      if (judged.empty() || judged.back().iteration != state.steps) judged.emplace_back();
      judged.back() = {state.steps, static_cast<std::int64_t>(field.kernel->points().size()),
                       judge->energy(F, progress)};
    };
    clock.lap("judge");
  }
  const int first_level = state.level;
  for (int level = first_level; level < static_cast<int>(state.counts.size()); ++level) {
    progress("level", static_cast<double>(level) / static_cast<double>(state.counts.size()));
    const auto wanted = static_cast<std::size_t>(state.counts[static_cast<std::size_t>(level)]);
    std::vector<Site> here(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(
                                                                std::min(wanted, points.size())));
    if (resume && level == first_level)
      solver.take_up(*resume, std::move(here), progress);
    else
      solver.enter(level, std::move(here), progress);
    clock.lap("prolong");
    // Neumann's radius stays what it is on the paper's first level.
    const KernelField& kernel = *field.kernel;
    if (!(state.neumann_radius > 0)) {
      const auto count = static_cast<double>(kernel.points().size());
      const double ratio = field.solid.dimension() == 2 ? std::sqrt(count / paper_first_in_plane)
                                                        : std::cbrt(count / paper_first);
      state.neumann_radius = radius_share * kernel.sigma() * std::min(1.0, ratio);
    }
    result.facts.radii = radii_of(kernel, options, state);
    field.conditions->set_radii(result.facts.radii, field.sampler->grading());
    if (judge) judge->look(progress);
    const bool finest = level + 1 == static_cast<int>(state.counts.size());
    if (!solver.solve(level, finest, clock, progress)) break;
  }
  result.facts.sigma = field.kernel->sigma();
  result.facts.volume = field.sampler->volume();
  solver.settle_unreached(progress);
  if (judge) solver.watch(field.F);
  state.F = field.F;
  state.X.resize(static_cast<Eigen::Index>(field.kernel->points().size()), 3);
  for (Eigen::Index i = 0; i < state.X.rows(); ++i)
    state.X.row(i) = field.kernel->points()[static_cast<std::size_t>(i)].x.transpose();
  clock.lap("components");
  progress("evaluation", 0);
  result.W = result.field->at_mesh(result.fill, result.facts.vertices);
  clock.lap("evaluation");
  return result;
}

}  // namespace skinfield
