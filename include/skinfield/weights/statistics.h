// How good are weights, how far apart are two of them.
#pragma once

#include "skinfield/geometry/mesh.h"
#include "skinfield/weights/skin_weights.h"

#include <span>

namespace skinfield {

/// Total variation between two weight matrices: TV_i = 1/2 sum_j |a_ij - b_ij| at vertex i, in
/// [0,1] for rows on the simplex; a metric on matrices.
struct Comparison {
  double mean = 0, p95 = 0, p99 = 0, max = 0;  ///< of TV_i over the vertices
  int worst_vertex = -1;                       ///< where the maximum is (the first such vertex)
  Vector column;                               ///< (m) mean over vertices of |a_ij - b_ij|
  Vector vertex;                               ///< (n) TV_i
};
/// Columns are taken in order. Throws InputError if the sizes differ.
Comparison compare(const SkinWeights& a, const SkinWeights& b);

/// The same weights with the columns in the order of `names`; columns that it does not name are
/// an error unless they are empty, and names that the weights lack get an empty column.
/// Throws InputError on an unnamed matrix or where weight would be lost.
SkinWeights reorder_columns(const SkinWeights& weights, const std::vector<std::string>& names);

struct WeightStatistics {
  double row_sum_error = 0;                   ///< max over rows of |sum - 1|, empty rows left out
  Eigen::Index negative = 0, non_finite = 0;  ///< entries
  Eigen::Index empty_rows = 0;
  std::vector<Eigen::Index> influences;  ///< influences[k]: rows with k non-zero entries
  std::vector<int> without_vertices;     ///< columns whose weight is above 0.5 nowhere
};
/// `columns`: the ones that should bind something (those of the deforming joints); empty = all.
WeightStatistics weight_statistics(const SkinWeights& weights, std::span<const int> columns = {});

/// What reports and pictures call an extremum: smaller ones are of no account.
constexpr double extremum_tolerance = 1e-4;

struct Extremum {
  int vertex = -1, column = -1;
  bool maximum = false;
  double weight = 0;
  double excess = 0;  ///< by how much it lies above (below) the nearest neighbour's weight
};
struct Extrema {
  Eigen::Index maxima = 0, minima = 0;  ///< all columns together
  std::vector<Eigen::Index> column;     ///< (m) maxima + minima of a column
  std::vector<Extremum> places;         ///< ascending by vertex
};
/// Spurious local extrema: vertices whose weight lies by more than `tolerance` above (below) all
/// their neighbours along the edges of mesh.F and mesh.T, values within `tolerance` of 1 (of 0)
/// left out, and so are the vertices of `exempt`: where weights are prescribed, an extremum is no
/// fault of the method. Throws InputError if the weights' rows are not the mesh's vertices, or an
/// exempt vertex is none of them.
Extrema local_extrema(const SkinWeights& weights, const Mesh& mesh, double tolerance = 1e-6,
                      std::span<const int> exempt = {});

}  // namespace skinfield
