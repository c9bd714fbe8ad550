#include "bind/conditions.h"

#include "bind/tet_stage.h"
#include "skinfield/base/parallel.h"
#include "skinfield/geometry/closest_point.h"
#include "skinfield/methods/support.h"
#include "skinfield/weights/mirror.h"
#include "skinfield/weights/operations.h"
#include "skinfield/weights/statistics.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace skinfield {
namespace {

/// First input vertex of each merged vertex.
std::vector<int> first_input(const Character& character) {
  std::vector<int> first(static_cast<std::size_t>(character.mesh.V.rows()), -1);
  for (std::size_t i = 0; i < character.vertex_of_input.size(); ++i) {
    int& f = first[static_cast<std::size_t>(character.vertex_of_input[i])];
    if (f < 0) f = static_cast<int>(i);
  }
  return first;
}

PaintedPoints painted_points(const Character& character, const Paint& paint,
                             const SolvedDomain& solved, std::vector<int>& painted) {
  if (paint.weights.cols() != solved.columns)
    throw InputError("the paint has " + std::to_string(paint.weights.cols()) +
                         " columns, the skeleton " + std::to_string(solved.columns) + " handles",
                     character.name, "one column a handle, in the skeleton's order");
  const Eigen::Index inputs = static_cast<Eigen::Index>(character.vertex_of_input.size());
  std::vector<int> row_of(static_cast<std::size_t>(character.mesh.V.rows()), -1);
  for (std::size_t k = 0; k < paint.vertex.size(); ++k) {
    if (paint.vertex[k] < 0 || paint.vertex[k] >= inputs)
      throw InputError("painted vertex " + std::to_string(paint.vertex[k]) + " does not exist",
                       character.name);
    const int v = character.vertex_of_input[static_cast<std::size_t>(paint.vertex[k])];
    if (row_of[static_cast<std::size_t>(v)] < 0) painted.push_back(v);
    row_of[static_cast<std::size_t>(v)] = static_cast<int>(k);
  }
  const Mesh& mesh = solved.scaled.mesh;
  const Points normals = mesh.F.rows() > 0 ? vertex_normals(mesh.V, mesh.F) : mesh.N;
  const auto n = static_cast<Eigen::Index>(painted.size());
  const auto handles = static_cast<Eigen::Index>(solved.column.size());
  PaintedPoints points;
  points.X.resize(n, 3);
  points.N.resize(normals.rows() > 0 ? n : 0, 3);
  points.weights = RowMatrix::Zero(n, handles);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int v = painted[static_cast<std::size_t>(i)];
    points.X.row(i) = mesh.V.row(v);
    if (points.N.rows() > 0) points.N.row(i) = normals.row(v);
    const int k = row_of[static_cast<std::size_t>(v)];
    for (Eigen::Index h = 0; h < handles; ++h)
      points.weights(i, h) = paint.weights(k, solved.column[static_cast<std::size_t>(h)]);
    const double sum = points.weights.row(i).sum();
    if (!(sum > 0))
      throw InputError("painted vertex " +
                           std::to_string(paint.vertex[static_cast<std::size_t>(k)]) +
                           " has weight only on joints that do not deform",
                       character.name, "let them deform: --joints all");
    points.weights.row(i) /= sum;
  }
  return points;
}

}  // namespace

Conditions conditions_for(const Character& character, const BindOptions& options,
                          const SolvedDomain& solved) {
  Conditions conditions;
  if (options.paint)
    conditions.paint = painted_points(character, *options.paint, solved, conditions.painted_vertex);
  if (!options.start) {
    if (!options.locked_columns.empty())
      throw InputError("locked columns need weights to keep", character.name, "give --weights-in");
    return conditions;
  }
  const SparseRows& W = options.start->W;
  const auto inputs = static_cast<Eigen::Index>(character.vertex_of_input.size());
  if (W.rows() != inputs || W.cols() != solved.columns)
    throw InputError("the given weights are " + std::to_string(W.rows()) + " x " +
                         std::to_string(W.cols()) + ", the character needs " +
                         std::to_string(inputs) + " x " + std::to_string(solved.columns),
                     character.name);
  const std::vector<int> first = first_input(character);
  const RowMatrix dense = dense_weights(normalise(*options.start).weights);
  const auto handles = static_cast<Eigen::Index>(solved.column.size());
  conditions.start = RowMatrix::Zero(character.mesh.V.rows(), handles);
  for (Eigen::Index v = 0; v < conditions.start.rows(); ++v) {
    if (first[static_cast<std::size_t>(v)] < 0) continue;
    for (Eigen::Index h = 0; h < handles; ++h)
      conditions.start(v, h) =
          dense(first[static_cast<std::size_t>(v)], solved.column[static_cast<std::size_t>(h)]);
  }
  for (std::size_t h = 0; h < solved.column.size(); ++h)
    if (std::find(options.locked_columns.begin(), options.locked_columns.end(), solved.column[h]) !=
        options.locked_columns.end())
      conditions.locked.push_back(static_cast<int>(h));
  // The inner vertices of a triangulated outline are not the input's: nothing is kept there.
  const bool has_inner = std::find(first.begin(), first.end(), -1) != first.end();
  if (has_inner && !conditions.locked.empty())
    throw InputError("columns are locked, but an outline's weights say nothing of its inside",
                     character.name, "bind to .glb first, and lock columns of that");
  return conditions;
}

SparseRows closest_on_mesh(const Points& X, const Mesh& mesh) {
  const ClosestPointQuery query(mesh.V, mesh.F);
  const auto n = static_cast<std::size_t>(X.rows());
  std::vector<ClosestPoint> closest(n);
  parallel_for(n, 64,
               [&](std::size_t i) { closest[i] = query.at(X.row(static_cast<Eigen::Index>(i))); });
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (std::size_t i = 0; i < n; ++i) {
    if (closest[i].face < 0) continue;
    for (int c = 0; c < 3; ++c) {
      entries.emplace_back(static_cast<std::int32_t>(i), mesh.F(closest[i].face, c),
                           closest[i].barycentric[c]);
    }
  }
  SparseRows P(X.rows(), mesh.V.rows());
  P.setFromTriplets(entries.begin(), entries.end());
  return P;
}

RowMatrix start_on_nodes(const Conditions& conditions, const SolvedDomain& solved) {
  if (conditions.start.rows() == 0) return {};
  // Points take from the vertices that they see, tets and surfaces, which may have been refined,
  // from the point of the mesh at or next to them.
  const auto from_mesh = [&]() -> SparseRows {
    if (solved.points) return solved.points->from_mesh();
    if (solved.tris) return solved.tris->from_mesh();
    if (solved.tets) return nodes_from_mesh(*solved.tets, solved.scaled.mesh);
    return closest_on_mesh(solved.domain->nodes(), solved.scaled.mesh);
  };
  RowMatrix start = from_mesh() * conditions.start;
  for (Eigen::Index i = 0; i < start.rows(); ++i) {
    const double sum = start.row(i).sum();
    if (sum > 0)
      start.row(i) /= sum;
    else
      start.row(i).setConstant(1.0 / static_cast<double>(start.cols()));
  }
  return start;
}

std::vector<Handle> handles_of_paint(const Conditions& conditions, const SolvedDomain& solved) {
  std::vector<Handle> handles(static_cast<std::size_t>(solved.columns));
  for (std::size_t h = 0; h < handles.size(); ++h) {
    handles[h].kind = Handle::Kind::region;
    handles[h].name = solved.names[h];
  }
  for (std::size_t k = 0; k < conditions.painted_vertex.size(); ++k) {
    Eigen::Index largest = 0;
    conditions.paint.weights.row(static_cast<Eigen::Index>(k)).maxCoeff(&largest);
    handles[static_cast<std::size_t>(largest)].vertices.push_back(conditions.painted_vertex[k]);
  }
  return handles;
}

FixedRows paint_on_nodes(const Conditions& conditions, const Domain& domain) {
  FixedRows fixed;
  if (conditions.paint.X.rows() == 0) return fixed;
  // A surface's nodes include the mesh's vertices: there the interpolation is a single 1.
  const SparseRows P = domain.at(conditions.paint.X, conditions.paint.N).P;
  std::map<int, Eigen::Index> row_of_node;
  for (Eigen::Index i = 0; i < P.rows(); ++i)
    for (SparseRows::InnerIterator it(P, i); it; ++it)
      if (it.value() > 0.999) row_of_node.emplace(static_cast<int>(it.col()), i);
  fixed.weights.resize(static_cast<Eigen::Index>(row_of_node.size()),
                       conditions.paint.weights.cols());
  for (const auto& [node, row] : row_of_node) {
    fixed.weights.row(static_cast<Eigen::Index>(fixed.node.size())) =
        conditions.paint.weights.row(row);
    fixed.node.push_back(node);
  }
  return fixed;
}

void apply_regions(const std::vector<Handle>& handles, RowMatrix& rows) {
  std::map<int, std::vector<Eigen::Index>> regions_of;
  for (std::size_t h = 0; h < handles.size(); ++h)
    if (handles[h].kind == Handle::Kind::region)
      for (const int v : handles[h].vertices) regions_of[v].push_back(static_cast<Eigen::Index>(h));
  for (const auto& [v, regions] : regions_of) {
    rows.row(v).setZero();
    for (const Eigen::Index h : regions) rows(v, h) = 1.0 / static_cast<double>(regions.size());
  }
}

void apply_exact_conditions(const Conditions& conditions, RowMatrix& rows) {
  if (!conditions.locked.empty()) {
    std::vector<char> locked(static_cast<std::size_t>(rows.cols()), 0);
    for (int h : conditions.locked) locked[static_cast<std::size_t>(h)] = 1;
    for (Eigen::Index v = 0; v < rows.rows(); ++v) {
      double kept = 0, free = 0;
      for (Eigen::Index h = 0; h < rows.cols(); ++h)
        (locked[static_cast<std::size_t>(h)] ? kept : free) +=
            locked[static_cast<std::size_t>(h)] ? conditions.start(v, h) : rows(v, h);
      const double scale = free > 0 ? std::max(0.0, 1 - kept) / free : 0;
      for (Eigen::Index h = 0; h < rows.cols(); ++h)
        rows(v, h) =
            locked[static_cast<std::size_t>(h)] ? conditions.start(v, h) : rows(v, h) * scale;
      const double sum = rows.row(v).sum();
      if (sum > 0) rows.row(v) /= sum;
    }
  }
  for (std::size_t k = 0; k < conditions.painted_vertex.size(); ++k)
    rows.row(conditions.painted_vertex[k]) =
        conditions.paint.weights.row(static_cast<Eigen::Index>(k));
}

void find_symmetry(const BindOptions& options, SolvedDomain& solved, BindReport& report) {
  if (options.symmetry == BindOptions::Symmetry::off) return;
  const Points& V = solved.scaled.mesh.V;
  const Box3 box = bounding_box(V);
  solved.mirror_plane = 0.5 * (box(0, 0) + box(1, 0));
  const MirrorPlane plane{Vec3::UnitX(), solved.mirror_plane};
  const double tolerance = 0.02;  // unit box: hand-modelled symmetry
  const std::vector<Handle>& handles = solved.scaled.handles;
  Points middle(static_cast<Eigen::Index>(handles.size()), 3);
  std::vector<std::string> names;
  for (std::size_t h = 0; h < handles.size(); ++h) {
    const Points X = probe_handles({handles[h]}, 0.05);
    middle.row(static_cast<Eigen::Index>(h)) =
        X.rows() > 0 ? Eigen::RowVector3d(X.colwise().mean()) : handles[h].point.transpose();
    names.push_back(handles[h].name);
  }
  if (handles.empty()) return;
  solved.partner = pair_columns(names, middle, plane, tolerance);
  // Symmetric in earnest: handles lie where their partners' reflections do, and so do vertices.
  double off_handles = 0;
  for (std::size_t h = 0; h < handles.size(); ++h)
    off_handles =
        std::max(off_handles, (plane.reflect(middle.row(static_cast<Eigen::Index>(h)).transpose()) -
                               middle.row(solved.partner[h]).transpose())
                                  .norm());
  double off_vertices = 0;
  if (solved.scaled.mesh.F.rows() > 0) {
    const ClosestPointQuery query(V, solved.scaled.mesh.F);
    const Eigen::Index step = std::max<Eigen::Index>(1, V.rows() / 2000);
    for (Eigen::Index v = 0; v < V.rows(); v += step)
      off_vertices = std::max(off_vertices, query.at(plane.reflect(V.row(v).transpose())).distance);
  }
  const bool symmetric = off_handles < tolerance && off_vertices < tolerance;
  if (!symmetric && options.symmetry == BindOptions::Symmetry::x)
    report.warnings.push_back(
        "--symmetry x: " + std::string(off_handles < tolerance ? "the mesh" : "the skeleton") +
        " is not symmetric in x; its weights are made so all the same");
  solved.symmetric = symmetric || options.symmetry == BindOptions::Symmetry::x;
}

RowMatrix resolve_on_kept_support(const SolvedDomain& solved, const SparseRows& P, int influences,
                                  const BoundedBiharmonicOptions& method,
                                  const Progress& progress) {
  SupportOptions support;
  support.influences = influences;
  // It starts next to its solution: at this tolerance no weight was off by more than 1e-4.
  BoundedBiharmonicOptions again = method;
  again.tolerance = std::max(method.tolerance, 1e-2);
  return resolve_on_support(
             {solved.domain->stiffness(), solved.domain->mass(), solved.domain->fixed()},
             solved.nodal, P, support, again, progress)
      .W;
}

std::int64_t mesh_extrema(const RowMatrix& rows, const Mesh& mesh) {
  const Extrema extrema = local_extrema(sparse_weights(rows), mesh, extremum_tolerance);
  return extrema.maxima + extrema.minima;
}

}  // namespace skinfield
