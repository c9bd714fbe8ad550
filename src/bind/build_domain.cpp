#include "bind/build_domain.h"

#include "bind/solve_method.h"
#include "bind/tet_stage.h"
#include "skinfield/domain/surface_domain.h"
#include "skinfield/geometry/winding_number.h"

#include <algorithm>

namespace skinfield {
namespace {

using DomainKind = BindOptions::DomainKind;

/// More of the area than this without a handle, and the parts had better be joined.
constexpr double kMostWithoutHandle = 0.01;

bool build_tets(const BindOptions& options, const Character& character, SolvedDomain& solved,
                BindReport& report, const Progress& progress) {
  try {
    auto domain = make_tet_domain(options, character, solved, report, progress);
    solved.tets = domain.get();
    solved.domain = std::move(domain);
    solved.rung = Rung::volume;
    return true;
  } catch (const DomainError& error) {
    if (options.domain == DomainKind::tets || facts_of(options.method).needs_elements) throw;
    report.warnings.push_back(error.message() + ": the weights live on points");
    return false;
  }
}

bool build_points(const BindOptions& options, const Conditions& conditions, SolvedDomain& solved,
                  BindReport& report, const Progress& progress) {
  if (options.mass != MassKind::barycentric || options.masses)
    throw OptionError("the nodes of a point domain have masses of their own", {},
                      "use --domain tets or tris or --method bone-heat, or leave --mass out");
  try {
    PointDomainOptions point_options;
    point_options.nodes = options.nodes;
    point_options.seed = options.seed;
    auto domain = std::make_unique<PointDomain>(solved.scaled.mesh, solved.scaled.handles,
                                                point_options, conditions.paint, progress);
    solved.points = domain.get();
    solved.domain = std::move(domain);
    solved.rung = Rung::volume;
    return true;
  } catch (const DomainError& error) {
    report.warnings.push_back(error.message() + ": the weights live on the surface");
    return false;
  }
}

/// Exact finite elements on the mesh's triangles; false, with a warning, where they would leave
/// much of the area without a handle, or no handle in the shape.
bool build_tris(const BindOptions& options, const Character& character, SolvedDomain& solved,
                BindReport& report, const Progress& progress) {
  try {
    TriDomainOptions tri_options;
    tri_options.nodes = std::min(tri_options.nodes, options.nodes);
    tri_options.mass_kind = options.mass;
    tri_options.mass = masses_on_vertices(options, character, solved);
    auto domain = std::make_unique<TriDomain>(solved.scaled.mesh, solved.scaled.handles,
                                              tri_options, progress);
    const TriDomainFacts& facts = domain->facts();
    if (facts.area_without_handle > kMostWithoutHandle * facts.area) {
      report.warnings.push_back(std::to_string(facts.components_without_handle) + " of " +
                                std::to_string(facts.components) +
                                " parts hold no handle: parts are joined where they touch");
      return false;
    }
    solved.tris = domain.get();
    solved.domain = std::move(domain);
    return true;
  } catch (const DomainError& error) {
    report.warnings.push_back(error.message() + ": the nearest part of the surface serves");
    return false;
  }
}

bool build_surface(const BindOptions& options, SolvedDomain& solved, BindReport& report,
                   const Progress& progress) {
  if (options.masses)
    throw OptionError("the surface's nodes are more than the vertices that masses were given for",
                      {}, "use --mass voronoi or barycentric");
  try {
    SurfaceDomainOptions surface_options;
    surface_options.mass = options.mass;
    solved.domain = std::make_unique<SurfaceDomain>(solved.scaled.mesh, solved.scaled.handles,
                                                    surface_options, progress);
    return true;
  } catch (const DomainError& error) {
    report.warnings.push_back(error.message() + ": each vertex takes its nearest handle");
    return false;
  }
}

}  // namespace

void build_domain(const BindOptions& options, const Character& character,
                  const Conditions& conditions, SolvedDomain& solved, BindReport& report,
                  const Progress& progress) {
  const DomainKind kind = options.domain;
  const Mesh& mesh = solved.scaled.mesh;
  const bool flat = report.input.planar && mesh.F.rows() > 0;
  const bool surface_wanted = kind == DomainKind::surface;
  const bool elements = mesh.T.rows() > 0 || (facts_of(options.method).needs_elements && !flat);
  if (kind == DomainKind::tets || (elements && kind == DomainKind::automatic)) {
    if (build_tets(options, character, solved, report, progress)) return;
  }
  if (flat && kind == DomainKind::points)
    report.warnings.emplace_back("a flat shape has no inside for points: its triangles serve");
  if (!surface_wanted && !flat && build_points(options, conditions, solved, report, progress))
    return;
  if (solved.scaled.handles.empty()) solved.scaled.handles = handles_of_paint(conditions, solved);
  solved.rung = Rung::surface;
  if (mesh.F.rows() > 0) {
    if ((flat || surface_wanted) && build_tris(options, character, solved, report, progress))
      return;
    if (build_surface(options, solved, report, progress)) return;
  }
  solved.rung = mesh.F.rows() > 0 ? Rung::nearest_visible_handle : Rung::nearest_handle;
}

void use_own_vertices(const Conditions& conditions, SolvedDomain& solved) {
  if (solved.scaled.handles.empty()) solved.scaled.handles = handles_of_paint(conditions, solved);
  solved.rung = Rung::surface;
  solved.own_triangles =
      std::make_unique<ClosestPointQuery>(solved.scaled.mesh.V, solved.scaled.mesh.F);
}

void describe_domain(const SolvedDomain& solved, BindReport& report) {
  report.rung = solved.rung;
  report.domain_kind = solved.points        ? "points"
                       : solved.tets        ? "tets"
                       : solved.tris        ? "tris"
                       : solved.has_nodes() ? "surface"
                                            : "handles";
  if (solved.own_triangles) report.nodes = static_cast<int>(solved.scaled.mesh.V.rows());
  if (solved.domain) {
    report.nodes = static_cast<int>(solved.domain->nodes().rows());
    report.neighbours = (solved.domain->stiffness().nonZeros() - report.nodes) / 2;
  }
  const auto components = [&report](const auto& facts) {
    report.handle_nodes = facts.handle_nodes;
    report.node_components = facts.components;
    report.node_components_without_handle = facts.components_without_handle;
  };
  if (solved.tets) {
    components(solved.tets->facts());
    report.elements = solved.tets->elements().rows();
    report.split_nodes = solved.tets->facts().new_nodes;
  }
  if (solved.tris) components(solved.tris->facts());
  if (!solved.points) return;
  const PointDomainFacts& facts = solved.points->facts();
  components(facts);
  report.rays = facts.rays;
  for (const auto& [stage, seconds] : facts.seconds) report.seconds["domain_" + stage] = seconds;
  const Solid::Facts& solid = solved.points->solid().facts();
  report.clean_parts = solid.clean;
  report.dirty_parts = solid.dirty;
  report.passenger_parts = solid.passengers;
  report.flipped_faces = solid.flipped_faces;
}

InsideTest inside_test(const SolvedDomain& solved) {
  if (solved.points)
    return [&solid = solved.points->solid()](const Vec3& x) { return solid.inside(x); };
  if (solved.tets) return [&tets = *solved.tets](const Vec3& x) { return tets.contains(x); };
  if (solved.tris) return [&tris = *solved.tris](const Vec3& x) { return tris.covers(x); };
  if (solved.field) return [&field = *solved.field](const Vec3& x) { return field.inside(x); };
  if (!solved.own_triangles) return {};
  const Mesh& mesh = solved.scaled.mesh;
  return [winding = std::make_shared<WindingNumber>(mesh.V, mesh.F)](const Vec3& x) {
    return winding->at(x) > 0.5;
  };
}

}  // namespace skinfield
