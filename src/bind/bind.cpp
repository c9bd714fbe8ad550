#include "skinfield/bind/bind.h"

#include "bind/build_domain.h"
#include "bind/conditions.h"
#include "bind/field_stage.h"
#include "bind/solve_method.h"
#include "bind/solved_domain.h"
#include "skinfield/bind/report.h"
#include "skinfield/bind/triangulate.h"
#include "skinfield/domain/tetrahedraliser.h"
#include "skinfield/geometry/normals.h"
#include "skinfield/rig/handle_geometry.h"
#include "skinfield/weights/operations.h"
#include "skinfield/weights/statistics.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace skinfield {
namespace {

/// Wall and processor seconds of consecutive stages.
class Stopwatch {
 public:
  explicit Stopwatch(BindReport& report) : report_(report) {}
  void lap(const std::string& stage) {
    const auto wall = std::chrono::steady_clock::now();
    const double cpu = process_cpu_seconds();
    report_.seconds[stage] += std::chrono::duration<double>(wall - wall_).count();
    report_.cpu_seconds[stage] += cpu - cpu_;
    wall_ = wall;
    cpu_ = cpu;
  }

 private:
  BindReport& report_;
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  double cpu_ = process_cpu_seconds();
};

void check_input(const Character& character, const BindOptions& options) {
  const Points& V = character.mesh.V;
  if (V.rows() == 0)
    throw InputError("the mesh has no vertices", character.name,
                     "give a mesh with triangles or points");
  for (Eigen::Index i = 0; i < V.rows(); ++i)
    if (!V.row(i).allFinite())
      throw InputError("vertex " + std::to_string(i) + " has a position that is not finite",
                       character.name, "repair the file");
  if (character.skeleton.handles.empty() && !options.paint)
    throw InputError("there are no bones to bind to", character.name,
                     "give --skeleton FILE, --regions FILE or --paint FILE");
}

/// A region is on the shape or in it, unless no node stands for it.
bool holds_nodes(const SolvedDomain& solved, std::size_t handle) {
  return !solved.domain ||
         solved.domain->fixed().weights.col(static_cast<Eigen::Index>(handle)).any();
}

void describe_handles(const SolvedDomain& solved, BindReport& report) {
  const std::vector<Handle>& handles = solved.scaled.handles;
  const InsideTest inside_shape = inside_test(solved);  // empty: nothing is
  const bool volume = solved.points || solved.tets || (solved.tris && solved.tris->facts().planar);
  report.handles = static_cast<int>(handles.size());
  for (std::size_t h = 0; h < handles.size(); ++h) {
    const Handle& handle = handles[h];
    if (handle.kind == Handle::Kind::region) {
      const bool holds = holds_nodes(solved, h);
      (holds ? report.handles_inside : report.handles_outside).push_back(handle.name);
      if (!holds)
        report.warnings.push_back("no node stands for region " + handle.name +
                                  ": it has its own vertices at most");
      continue;
    }
    const Points X = probe_handles({handle}, 0.01);
    int inside = 0;
    for (Eigen::Index i = 0; i < X.rows(); ++i)
      inside += inside_shape && inside_shape(Vec3(X.row(i).transpose()));
    auto& list = inside == X.rows() && X.rows() > 0 ? report.handles_inside
                 : inside > 0                       ? report.handles_partly_inside
                                                    : report.handles_outside;
    list.push_back(handle.name);
    if (inside == 0 && volume)
      report.warnings.push_back("handle " + handle.name +
                                " lies outside the shape and gets no weight");
  }
}

void describe_weights(const SkinWeights& weights, const Character& character, BindReport& report) {
  const WeightStatistics s = weight_statistics(weights, character.skeleton.column);
  report.rows = weights.W.rows();
  report.row_sum_error = s.row_sum_error;
  report.negative = s.negative;
  report.non_finite = s.non_finite;
  report.influences.assign(s.influences.begin(), s.influences.end());
  for (int c : s.without_vertices)
    report.handles_without_vertices.push_back(static_cast<std::size_t>(c) < weights.names.size()
                                                  ? weights.names[static_cast<std::size_t>(c)]
                                                  : std::to_string(c));
}

/// @param raw weights of the vertices before rows were brought onto the simplex.
void describe_projection(const RowMatrix& raw, const Mesh& mesh, BindReport& report) {
  report.extrema_before_projection = mesh_extrema(raw, mesh);
  const Vector below = (-raw).cwiseMax(0.0).rowwise().sum();
  report.clamped_mass_mean = below.mean();
  report.clamped_mass_max = below.maxCoeff();
}

/// Are rows given on the mesh's vertices exact there without further ado?
bool own_vertices_are_nodes(const SolvedDomain& solved, const BindReport& report) {
  return solved.tris || (solved.tets && report.tet_route != name_of(TetRoute::wrap));
}

/// 1/2 tr(W' K M^-1 K W)
double biharmonic_energy(const Domain& domain, const RowMatrix& W) {
  const RowMatrix KW = domain.stiffness() * W;
  return 0.5 * (domain.mass().cwiseInverse().asDiagonal() * KW).cwiseProduct(KW).sum();
}

/// Does any vertex have more influences worth the name than it may keep?
bool cuts_influences(const RowMatrix& W, const BindOptions& options) {
  const double dust = std::max(options.prune, 1e-6);
  for (Eigen::Index i = 0; i < W.rows(); ++i)
    if ((W.row(i).array() > dust).count() > options.max_influences) return true;
  return false;
}

}  // namespace

std::string name_of(Rung rung) {
  switch (rung) {
    case Rung::volume:
      return "volume";
    case Rung::surface:
      return "surface";
    case Rung::nearest_visible_handle:
      return "nearest_visible_handle";
    case Rung::nearest_handle:
      return "nearest_handle";
  }
  return "";
}

namespace {

/// An outline that has no field gets its triangles first; what was said so far stays said.
BindResult bind_below(const Character& outline, const BindOptions& options,
                      const BindReport& so_far, const Progress& progress) {
  BindResult result = bind(outline, options, progress);
  result.report.warnings.insert(result.report.warnings.begin(), so_far.warnings.begin(),
                                so_far.warnings.end());
  return result;
}

}  // namespace

BindResult bind(const Character& given, const BindOptions& wanted, const Progress& progress) {
  BindOptions options = wanted;
  check_input(given, options);
  check_method(options, given);
  BindResult result;
  BindReport& report = result.report;
  Stopwatch watch(report);
  progress("diagnose", 0);
  report.input = diagnose(given.mesh, {}, progress);
  watch.lap("diagnose");
  std::optional<Character> triangulated;
  const bool on_field = facts_of(options.method).on_field;
  if (given.mesh.is_outline() && !on_field) {
    triangulated = given;
    triangulate_outline(*triangulated, options.nodes, progress);
    watch.lap("triangulate");
  }
  const Character& character = triangulated ? *triangulated : given;

  auto solved = std::make_shared<SolvedDomain>();
  solved->scaled = scale_to_unit_box(character);
  report.unit_scale = solved->scaled.box.scale;
  solved->column = character.skeleton.column;
  solved->columns = character.skeleton.columns;
  solved->names = character.skeleton.column_names;
  solved->max_influences = options.max_influences;
  solved->prune = options.prune;
  if (solved->scaled.handles.empty()) {
    // Paint alone: its columns are the handles.
    solved->columns = static_cast<int>(options.paint->weights.cols());
    for (int c = 0; c < solved->columns; ++c) {
      solved->column.push_back(c);
      solved->names.push_back("paint_" + std::to_string(c));
    }
  }
  for (int joint : character.skeleton.left_out)
    report.joints_left_out.push_back(
        character.skeleton.joints[static_cast<std::size_t>(joint)].name);
  Mesh& mesh = solved->scaled.mesh;
  if (mesh.is_point_cloud() && mesh.N.rows() != mesh.V.rows())
    mesh.N = estimate_point_normals(mesh.V, probe_handles(solved->scaled.handles, 0.02));
  const Conditions conditions = conditions_for(character, options, *solved);
  find_symmetry(options, *solved, report);

  progress("domain", 0);
  if (on_field) {
    if (options.keep_field) result.field.emplace();
    if (!solve_field(options, character.skeleton, conditions, *solved, report,
                     result.field ? &*result.field : nullptr, progress)) {
      options = options_below_field(options);
      if (given.mesh.is_outline()) return bind_below(given, options, report, progress);
    }
    watch.lap("solve");
  }
  if (!solved->field) {
    if (facts_of(options.method).on_domain)
      build_domain(options, character, conditions, *solved, report, progress);
    else
      use_own_vertices(conditions, *solved);
    watch.lap("domain");
    describe_domain(*solved, report);
  }
  describe_handles(*solved, report);

  const bool solid_field = solved->field && solved->field->solid().dimension() == 3;
  const Points normals = solved->points      ? solved->points->solid().normals()
                         : solid_field       ? solved->field->solid().normals()
                         : mesh.F.rows() > 0 ? vertex_normals(mesh.V, mesh.F)
                                             : mesh.N;
  Interpolation own;
  if (solved->has_nodes()) {
    progress("solve", 0);
    MethodSolution weights = solve_method(
        *solved, conditions, options, masses_on_vertices(options, character, *solved), progress);
    report.solve = weights.stats;
    solved->nodal = std::move(weights.nodal);
    // Energies are in file units.
    const int dimension = solved->rung == Rung::volume ? 3 : 2;
    const double scale = std::pow(solved->scaled.box.scale, 2 * weights.derivative - dimension);
    report.solve.energy *= scale;
    report.solve.lower_bound *= scale;
    report.history = std::move(weights.history);
    result.tensors = std::move(weights.tensors);
    for (BindReport::Step& step : report.history) {
      step.energy *= scale;
      step.lower_bound *= scale;
    }
    for (const auto& [stage, seconds] : weights.seconds) report.seconds["solve_" + stage] = seconds;
    watch.lap("solve");
    own = solved->at_mesh(normals);
    if (weights.raw.rows() > 0) describe_projection(own.P * weights.raw, mesh, report);
    watch.lap("evaluate");
    if (options.max_influences > 0 && options.resolve &&
        cuts_influences(own.P * solved->nodal, options)) {
      RowMatrix again = resolve_method(*solved, own.P, conditions, options, progress);
      if (again.rows() > 0) solved->nodal = std::move(again);
      watch.lap("resolve");
    }
  }

  if (solved->domain)
    report.biharmonic_energy =
        biharmonic_energy(*solved->domain, solved->nodal) *
        std::pow(solved->scaled.box.scale, solved->rung == Rung::volume ? 1 : 2);

  progress("evaluate", 0);
  std::vector<Fill> fill;
  RowMatrix rows =
      solved->at(mesh.V, normals, solved->has_nodes() || solved->field ? &own : nullptr, fill);
  if (!own_vertices_are_nodes(*solved, report)) apply_regions(solved->scaled.handles, rows);
  apply_exact_conditions(conditions, rows);
  count_fills(fill, report.vertices_filled);
  SkinWeights weights = solved->to_columns(rows, character.vertex_of_input);
  watch.lap("evaluate");

  Pruned pruned =
      prune(weights, {.max_influences = options.max_influences, .epsilon = options.prune});
  report.pruned_mass_mean = pruned.mean_mass;
  report.pruned_mass_max = pruned.max_mass;
  result.weights = std::move(pruned.weights);
  describe_weights(result.weights, character, report);
  report.extrema = mesh_extrema(rows, mesh);
  watch.lap("finish");
  result.solved = std::move(solved);
  return result;
}

SkinWeights transfer(const SolvedDomain& solved, const Character& target,
                     std::map<std::string, std::int64_t>* vertices_filled,
                     std::map<std::string, std::int64_t>* field_vertices) {
  const Points X = solved.scaled.box.to(target.mesh.V);
  const Points N = target.mesh.F.rows() > 0 ? vertex_normals(X, target.mesh.F) : target.mesh.N;
  std::vector<Fill> fill;
  const RowMatrix rows = solved.at_surface(X, target.mesh.F, N, fill, field_vertices);
  if (vertices_filled) count_fills(fill, *vertices_filled);
  return prune(solved.to_columns(rows, target.vertex_of_input),
               {.max_influences = solved.max_influences, .epsilon = solved.prune})
      .weights;
}

}  // namespace skinfield
