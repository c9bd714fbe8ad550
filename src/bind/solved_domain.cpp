#include "bind/solved_domain.h"

#include "skinfield/base/parallel.h"

#include <cmath>

namespace skinfield {
namespace {

/// Rows on the simplex exactly: dust below 1e-12 goes, the rest sums to one.
void tidy(RowMatrix& W) {
  parallel_for(static_cast<std::size_t>(W.rows()), 256, [&](std::size_t i) {
    auto row = W.row(static_cast<Eigen::Index>(i));
    double sum = 0;
    for (Eigen::Index j = 0; j < row.size(); ++j) {
      if (!(row[j] > 1e-12)) row[j] = 0;
      sum += row[j];
    }
    if (sum > 0) row /= sum;
  });
}

}  // namespace

Interpolation SolvedDomain::interpolation(const Points& X, const Points& normals) const {
  if (domain) return domain->at(X, normals);
  // Barycentric on the closest triangle.
  const auto n = static_cast<std::size_t>(X.rows());
  std::vector<ClosestPoint> closest(n);
  parallel_for(n, 64, [&](std::size_t i) {
    closest[i] = own_triangles->at(X.row(static_cast<Eigen::Index>(i)));
  });
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (std::size_t i = 0; i < n; ++i) {
    if (closest[i].face < 0) continue;  // no triangle at all: a zero row
    const Vec3 b = closest[i].barycentric.cwiseMax(0.0);
    for (int c = 0; c < 3; ++c)
      entries.emplace_back(static_cast<std::int32_t>(i), scaled.mesh.F(closest[i].face, c),
                           b[c] / b.sum());
  }
  Interpolation result;
  result.P.resize(X.rows(), scaled.mesh.V.rows());
  result.P.setFromTriplets(entries.begin(), entries.end());
  result.fill.assign(n, Fill::none);
  return result;
}

Interpolation SolvedDomain::at_mesh(const Points& normals) const {
  if (points) return points->at_mesh();
  if (domain) return domain->at(scaled.mesh.V, normals);
  // A vertex is its own node; one that no triangle has (inside a tetrahedral mesh) takes the
  // surface's nearest point.
  const Mesh& mesh = scaled.mesh;
  std::vector<char> has_triangle(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Eigen::Index k = 0; k < mesh.F.size(); ++k)
    has_triangle[static_cast<std::size_t>(mesh.F.data()[k])] = 1;
  Interpolation result = interpolation(mesh.V, normals);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (Eigen::Index i = 0; i < mesh.V.rows(); ++i) {
    const auto row = static_cast<std::int32_t>(i);
    if (has_triangle[static_cast<std::size_t>(i)]) {
      entries.emplace_back(row, row, 1.0);
      continue;
    }
    for (SparseRows::InnerIterator it(result.P, i); it; ++it)
      entries.emplace_back(row, it.col(), it.value());
  }
  result.P.setZero();
  result.P.setFromTriplets(entries.begin(), entries.end());
  return result;
}

RowMatrix SolvedDomain::at_once(const Points& X, const Points& normals, const Interpolation* known,
                                std::vector<Fill>& fill) const {
  RowMatrix W = RowMatrix::Zero(X.rows(), static_cast<Eigen::Index>(scaled.handles.size()));
  if (field) {
    if (known) {
      W = field_rows;
      fill = field_fill;
    } else {
      W = field->at(X, normals, fill);
    }
  } else if (has_nodes()) {
    const Interpolation asked = known ? Interpolation{} : interpolation(X, normals);
    const Interpolation& interpolation = known ? *known : asked;
    W = interpolation.P * nodal;
    fill = interpolation.fill;
  } else {
    fill.assign(static_cast<std::size_t>(X.rows()), Fill::nearest);
  }
  complete(X, normals, W, fill);
  return W;
}

void SolvedDomain::complete(const Points& X, const Points& normals, RowMatrix& W,
                            std::vector<Fill>& fill) const {
  tidy(W);
  // Rows that no node reaches take the nearest handle that they see, else the nearest.
  std::vector<int> empty;
  for (Eigen::Index i = 0; i < W.rows(); ++i)
    if (!(W.row(i).sum() > 0.5)) empty.push_back(static_cast<int>(i));
  if (!empty.empty() && !scaled.handles.empty()) {
    Points E(static_cast<Eigen::Index>(empty.size()), 3);
    Points EN(normals.rows() > 0 ? E.rows() : 0, 3);
    for (std::size_t k = 0; k < empty.size(); ++k) {
      E.row(static_cast<Eigen::Index>(k)) = X.row(empty[k]);
      if (EN.rows() > 0) EN.row(static_cast<Eigen::Index>(k)) = normals.row(empty[k]);
    }
    std::vector<Fill> how;
    const RowMatrix nearest = nearest_handle_weights(scaled.mesh, scaled.handles, E, EN, true, how);
    for (std::size_t k = 0; k < empty.size(); ++k) {
      W.row(empty[k]) = nearest.row(static_cast<Eigen::Index>(k));
      fill[static_cast<std::size_t>(empty[k])] = how[k];
    }
  }
}

void SolvedDomain::mirror(Points& X, Points& normals) const {
  X.col(0) = (2 * mirror_plane - X.col(0).array()).matrix();
  if (normals.rows() > 0) normals.col(0) *= -1;
}

RowMatrix SolvedDomain::mirrored_mean(const RowMatrix& W, const RowMatrix& mirrored) const {
  RowMatrix mean = W;
  for (Eigen::Index h = 0; h < W.cols(); ++h)
    mean.col(h) = 0.5 * (W.col(h) + mirrored.col(partner[static_cast<std::size_t>(h)]));
  return mean;
}

RowMatrix SolvedDomain::at(const Points& X, const Points& normals, const Interpolation* known,
                           std::vector<Fill>& fill) const {
  RowMatrix W = at_once(X, normals, known, fill);
  if (!symmetric) return W;
  // The mean of the field and its mirror image: exactly symmetric, and a domain can be asked
  // anywhere.
  Points R = X, RN = normals;
  mirror(R, RN);
  std::vector<Fill> ignored;
  return mirrored_mean(W, at_once(R, RN, nullptr, ignored));
}

RowMatrix SolvedDomain::at_surface(const Points& V, const Triangles& F, const Points& normals,
                                   std::vector<Fill>& fill,
                                   std::map<std::string, std::int64_t>* evaluated) const {
  if (!field) return at(V, normals, nullptr, fill);
  FieldEvaluationCounts counts;
  RowMatrix W = field->at_surface(V, F, normals, fill, counts);
  complete(V, normals, W, fill);
  if (evaluated) *evaluated = counts_by_name(counts);
  if (!symmetric) return W;
  Points R = V, RN = normals;
  mirror(R, RN);
  std::vector<Fill> ignored;
  FieldEvaluationCounts of_mirrored;
  RowMatrix mirrored = field->at_surface(R, F, RN, ignored, of_mirrored);
  complete(R, RN, mirrored, ignored);
  return mirrored_mean(W, mirrored);
}

SkinWeights SolvedDomain::to_columns(const RowMatrix& handle_rows,
                                     const std::vector<int>& vertex_of_input) const {
  SkinWeights weights;
  weights.names = names;
  weights.W.resize(static_cast<Eigen::Index>(vertex_of_input.size()), columns);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  for (std::size_t i = 0; i < vertex_of_input.size(); ++i) {
    const auto row = handle_rows.row(vertex_of_input[i]);
    for (Eigen::Index h = 0; h < row.size(); ++h)
      if (row[h] > 0)
        entries.emplace_back(static_cast<std::int32_t>(i), column[static_cast<std::size_t>(h)],
                             row[h]);
  }
  weights.W.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

std::map<std::string, std::int64_t> counts_by_name(const FieldEvaluationCounts& counts) {
  return {{"seen", counts.seen},
          {"flood_filled", counts.flood_filled},
          {"without_rays", counts.without_rays},
          {"passengers", counts.passengers}};
}

void count_fills(const std::vector<Fill>& fill, std::map<std::string, std::int64_t>& counts) {
  for (Fill f : fill) switch (f) {
      case Fill::none:
        break;
      case Fill::hidden:
        ++counts["hidden"];
        break;
      case Fill::passenger:
        ++counts["passenger"];
        break;
      case Fill::handle:
        ++counts["nearest_visible_handle"];
        break;
      case Fill::nearest:
        ++counts["nearest_handle"];
        break;
    }
}

}  // namespace skinfield
