#include "bind/field_stage.h"

#include "skinfield/base/error.h"
#include "skinfield/methods/geometric_fields.h"

#include <cmath>
#include <map>

namespace skinfield {
namespace {

constexpr double kSamePlace = 1e-9;  // unit box

bool same_handle(const Handle& a, const Handle& b) {
  if (a.kind != b.kind || a.segments.size() != b.segments.size() || a.vertices != b.vertices)
    return false;
  for (std::size_t s = 0; s < a.segments.size(); ++s)
    if ((a.segments[s].first - b.segments[s].first).norm() > kSamePlace ||
        (a.segments[s].second - b.segments[s].second).norm() > kSamePlace)
      return false;
  return a.kind != Handle::Kind::point || (a.point - b.point).norm() <= kSamePlace;
}

void check_resumed(const FieldFile& file, const SolvedDomain& solved) {
  const Points& V = solved.scaled.mesh.V;
  if (file.shape.V.rows() != V.rows() || !((file.shape.V - V).cwiseAbs().maxCoeff() <= kSamePlace))
    throw InputError("the saved field belongs to another shape", "--resume",
                     "give the mesh that it was saved from, or start afresh");
  bool same = file.handles.size() == solved.scaled.handles.size();
  for (std::size_t h = 0; same && h < file.handles.size(); ++h)
    same = same_handle(file.handles[h], solved.scaled.handles[h]);
  if (!same)
    throw InputError("the saved field has other handles", "--resume",
                     "give the skeleton and the joint options that it was saved with");
}

/// Merged vertices once each, the first row given for them.
PaintedVertices painted_vertices(const Conditions& conditions) {
  std::map<int, Eigen::Index> row_of_vertex;
  for (std::size_t k = 0; k < conditions.painted_vertex.size(); ++k)
    row_of_vertex.emplace(conditions.painted_vertex[k], static_cast<Eigen::Index>(k));
  PaintedVertices paint;
  paint.weights.resize(static_cast<Eigen::Index>(row_of_vertex.size()),
                       conditions.paint.weights.cols());
  for (const auto& [vertex, row] : row_of_vertex) {
    paint.weights.row(static_cast<Eigen::Index>(paint.vertex.size())) =
        conditions.paint.weights.row(row);
    paint.vertex.push_back(vertex);
  }
  return paint;
}

GeometricFieldsOptions field_options(const BindOptions& options) {
  GeometricFieldsOptions method;
  // What was saved holds, until the caller says otherwise.
  if (options.resume) apply_settings(options.resume->settings, method);
  using Solver = GeometricFieldsOptions::Solver;
  if (options.solver == skinfield::Solver::convex) method.solver = Solver::convex;
  if (options.solver == skinfield::Solver::adam) method.solver = Solver::adam;
  if (options.solver == skinfield::Solver::adam_pool) method.solver = Solver::adam_pool;
  if (options.boundary)
    method.boundary = *options.boundary == Boundary::neumann
                          ? GeometricFieldsOptions::Boundary::neumann
                          : GeometricFieldsOptions::Boundary::natural;
  const FieldTuning& tuning = options.field;
  if (tuning.visibility)
    method.visibility =
        *tuning.visibility == FieldVisibility::any_hit ? SolidOptions::Visibility::any_hit
        : *tuning.visibility == FieldVisibility::none  ? SolidOptions::Visibility::none
                                                       : SolidOptions::Visibility::counted;
  if (tuning.kernel_width > 0) method.kernel.width = tuning.kernel_width;
  if (tuning.difference_step > 0) method.step = tuning.difference_step;
  if (tuning.rows_per_point > 0) method.rows_per_point = tuning.rows_per_point;
  if (tuning.samples_per_step > 0) method.samples_per_step = tuning.samples_per_step;
  method.levels = tuning.levels;
  method.judged_step = tuning.judged_step;
  if (!options.resume) {
    method.points = options.field_points;
    method.seed = options.seed;
  }
  if (options.tolerance > 0) method.tolerance = options.tolerance;
  method.max_iterations = options.iterations;
  method.time_limit_s = options.time_limit_s;
  return method;
}

void describe(const GeometricFieldsResult& result, BindReport& report) {
  const GeometricFieldsFacts& facts = result.facts;
  report.rung = result.field->solid().dimension() == 2 ? Rung::surface : Rung::volume;
  report.domain_kind = "field";
  report.nodes = static_cast<int>(result.state.X.rows());
  for (const auto& [stage, seconds] : facts.seconds) report.seconds["field_" + stage] = seconds;
  const Solid::Facts& solid = result.field->solid().facts();
  report.clean_parts = solid.clean;
  report.dirty_parts = solid.dirty;
  report.passenger_parts = solid.passengers;
  report.flipped_faces = solid.flipped_faces;
  report.field_vertices = counts_by_name(facts.vertices);
}

void solve_inside(const BindOptions& options, const Skeleton& skeleton,
                  const Conditions& conditions, SolvedDomain& solved, BindReport& report,
                  FieldFile* saved, const Progress& progress) {
  const GeometricFieldsOptions method = field_options(options);
  PaintedVertices paint = painted_vertices(conditions);
  if (options.resume) {
    check_resumed(*options.resume, solved);
    if (paint.vertex.empty()) paint = {options.resume->paint.index, options.resume->paint.weights};
  }
  GeometricFieldsResult result =
      geometric_fields(solved.scaled.mesh, solved.scaled.handles, paint, method,
                       options.resume ? &options.resume->state : nullptr, progress);
  describe(result, report);
  report.solve = result.stats;
  // Integrals of squared second derivatives: length^(d - 4).
  const double scale = std::pow(solved.scaled.box.scale, 4 - result.field->solid().dimension());
  report.solve.energy *= scale;
  report.solve.lower_bound *= scale;
  for (const JudgedEnergy& j : result.facts.judged)
    report.judged.push_back({j.iteration, j.points, scale * j.energy});
  solved.rung = report.rung;
  solved.field_rows = std::move(result.W);
  solved.field_fill = std::move(result.fill);
  if (saved) {
    saved->mirror_partner = solved.symmetric ? solved.partner : std::vector<int>{};
    saved->mirror_plane = solved.mirror_plane;
    saved->skeleton = skeleton;
    // Paint alone has columns that no skeleton names.
    saved->skeleton.column = solved.column;
    saved->skeleton.columns = solved.columns;
    saved->skeleton.column_names = solved.names;
    saved->state = std::move(result.state);
    saved->shape = solved.scaled.mesh;
    saved->box = solved.scaled.box;
    saved->handles = solved.scaled.handles;
    saved->paint.index = paint.vertex;
    saved->paint.weights = paint.weights;
    saved->settings = settings_of(method);
  }
  solved.field = std::move(result.field);
}

}  // namespace

bool solve_field(const BindOptions& options, const Skeleton& skeleton, const Conditions& conditions,
                 SolvedDomain& solved, BindReport& report, FieldFile* saved,
                 const Progress& progress) {
  try {
    solve_inside(options, skeleton, conditions, solved, report, saved, progress);
    return true;
  } catch (const DomainError& error) {
    if (saved || options.resume)
      throw DomainError(error.message() + ": there is no field", error.where(),
                        "leave --save-field and --resume out");
    report.warnings.push_back(error.message() +
                              ": the weights are bounded biharmonic ones on the surface");
    return false;
  }
}

std::shared_ptr<const SolvedDomain> solved_field(const FieldFile& file, const BindOptions& options,
                                                 const Progress& progress) {
  auto solved = std::make_shared<SolvedDomain>();
  solved->max_influences = options.max_influences;
  solved->prune = options.prune;
  solved->scaled = {file.shape, file.handles, file.box};
  solved->column = file.skeleton.column;
  solved->columns = file.skeleton.columns;
  solved->names = file.skeleton.column_names;
  solved->symmetric = !file.mirror_partner.empty();
  solved->partner = file.mirror_partner;
  solved->mirror_plane = file.mirror_plane;
  GeometricFieldsOptions method;
  apply_settings(file.settings, method);
  solved->field = restore_field(file.shape, file.handles, {file.paint.index, file.paint.weights},
                                method, file.state, progress);
  return solved;
}

BindOptions options_below_field(const BindOptions& options) {
  BindOptions below = options;
  below.method = Method::bounded_biharmonic;
  below.solver = skinfield::Solver::automatic;
  below.domain = BindOptions::DomainKind::surface;
  below.tolerance = 0;  // the field's means something else
  return below;
}

}  // namespace skinfield
