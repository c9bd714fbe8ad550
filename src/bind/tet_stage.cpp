#include "bind/tet_stage.h"

#include "bind/solve_method.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace skinfield {
namespace {

/// The node that a row of P leans on most.
int main_node(const SparseRows& P, Eigen::Index row) {
  int node = -1;
  double share = 0;
  for (SparseRows::InnerIterator it(P, row); it; ++it) {
    if (it.value() <= share) continue;
    share = it.value();
    node = static_cast<int>(it.col());
  }
  return node;
}

/// On a wrap's tets the surface's vertices are no nodes: regions take the nodes next to theirs.
void carry_regions(const Mesh& mesh, const Tetrahedralisation& tets, std::vector<Handle>& handles) {
  const bool any = std::any_of(handles.begin(), handles.end(), [](const Handle& handle) {
    return handle.kind == Handle::Kind::region;
  });
  if (!any) return;
  const TetDomain bare(tets.V, tets.T, {});
  for (Handle& handle : handles) {
    if (handle.kind != Handle::Kind::region) continue;
    Points X(static_cast<Eigen::Index>(handle.vertices.size()), 3);
    for (std::size_t i = 0; i < handle.vertices.size(); ++i) {
      X.row(static_cast<Eigen::Index>(i)) = mesh.V.row(handle.vertices[i]);
    }
    const SparseRows P = bare.at(X, {}).P;
    std::set<int> nodes;
    for (Eigen::Index i = 0; i < P.rows(); ++i) nodes.insert(main_node(P, i));
    nodes.erase(-1);
    handle.vertices.assign(nodes.begin(), nodes.end());
  }
}

}  // namespace

std::unique_ptr<TetDomain> make_tet_domain(const BindOptions& options, const Character& character,
                                           const SolvedDomain& solved, BindReport& report,
                                           const Progress& progress) {
  const Mesh& mesh = solved.scaled.mesh;
  std::vector<Handle> handles = solved.scaled.handles;
  std::unique_ptr<TetDomain> domain;
  if (mesh.T.rows() > 0) {
    domain = std::make_unique<TetDomain>(
        mesh.V, mesh.T, handles,
        TetDomainOptions{options.mass, masses_on_vertices(options, character, solved)});
    report.tet_route = name_of(domain->facts().new_nodes > 0 ? TetRoute::split : TetRoute::given);
  } else {
    if (options.masses)
      throw OptionError(
          "tetrahedra made here have more nodes than the vertices that masses were "
          "given for",
          {}, "use --mass voronoi or barycentric");
    TetrahedraliserOptions meshing;
    meshing.nodes = options.nodes;
    const Tetrahedralisation tets = tetrahedralise(mesh, handles, meshing, progress);
    if (tets.route == TetRoute::wrap) {
      carry_regions(mesh, tets, handles);
      report.warnings.push_back(
          fmt::format("the surface could not be filled with tetrahedra as it is ({}): they fill a "
                      "wrap around it, which closes gaps under {:.3g}",
                      tets.why_not_direct, tets.alpha / solved.scaled.box.scale));
    }
    domain =
        std::make_unique<TetDomain>(tets.V, tets.T, handles, TetDomainOptions{options.mass, {}});
    report.tet_route = name_of(tets.route);
  }
  const TetDomainFacts& facts = domain->facts();
  if (facts.inverted_tets + facts.degenerate_tets > 0) {
    report.warnings.push_back(
        fmt::format("{} tetrahedra are inverted and count like their mirror images, {} have no "
                    "volume and are left out",
                    facts.inverted_tets, facts.degenerate_tets));
  }
  return domain;
}

SparseRows nodes_from_mesh(const TetDomain& domain, const Mesh& mesh) {
  const Points& X = domain.nodes();
  if (mesh.T.rows() > 0) {
    // Nodes that splits made lie in the mesh's own tets.
    return TetDomain(mesh.V, mesh.T, {}).at(X, {}).P;
  }
  return closest_on_mesh(X, mesh);
}

FixedRows paint_on_tets(const Conditions& conditions, const TetDomain& domain) {
  FixedRows fixed;
  if (conditions.paint.X.rows() == 0) return fixed;
  const SparseRows P = domain.at(conditions.paint.X, conditions.paint.N).P;
  std::map<int, std::pair<Eigen::RowVectorXd, int>> rows;
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    const int node = main_node(P, i);
    if (node < 0) continue;
    auto [at, fresh] =
        rows.try_emplace(node, Eigen::RowVectorXd(conditions.paint.weights.row(i)), 1);
    if (fresh) continue;
    at->second.first += conditions.paint.weights.row(i);
    ++at->second.second;
  }
  fixed.weights.resize(static_cast<Eigen::Index>(rows.size()), conditions.paint.weights.cols());
  for (const auto& [node, sum] : rows) {
    fixed.weights.row(static_cast<Eigen::Index>(fixed.node.size())) =
        sum.first / static_cast<double>(sum.second);
    fixed.node.push_back(node);
  }
  return fixed;
}

}  // namespace skinfield
