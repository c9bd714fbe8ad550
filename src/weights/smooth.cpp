#include "skinfield/weights/smooth.h"

#include "skinfield/base/error.h"
#include "weights/neighbours.h"
#include "weights/rows.h"

namespace skinfield {
namespace {

SparseRows step(const SparseRows& W, const Neighbours& graph, const SmoothOptions& options,
                const std::vector<bool>& locked) {
  return rows::build(W.rows(), W.cols(), [&] {
    return [&, sum = rows::Accumulator(W.cols())](Eigen::Index i, rows::Row& row) mutable {
      const auto around = graph.of(i);
      const bool kept = !options.keep.empty() && options.keep[static_cast<std::size_t>(i)];
      if (around.empty() || kept) return rows::read(W, i, row);
      sum.add(W, i, 1 - options.strength);
      const double share = options.strength / static_cast<double>(around.size());
      for (const std::int32_t k : around) sum.add(W, k, share);
      sum.take(row);
      if (options.locked.empty()) return;

      // Locked columns keep their values; the others share what those leave of the row.
      double total = 0, held = 0, free = 0;
      for (SparseRows::InnerIterator it(W, i); it; ++it) {
        total += it.value();
        if (locked[static_cast<std::size_t>(it.col())]) held += it.value();
      }
      for (const auto& [column, value] : row) {
        if (!locked[static_cast<std::size_t>(column)]) free += value;
      }
      if (!(free > 0)) return rows::read(W, i, row);
      const double scale = std::max(total - held, 0.0) / free;
      for (const auto& [column, value] : row) {
        if (!locked[static_cast<std::size_t>(column)]) sum.add(column, value * scale);
      }
      for (SparseRows::InnerIterator it(W, i); it; ++it) {
        if (locked[static_cast<std::size_t>(it.col())]) {
          sum.add(static_cast<std::int32_t>(it.col()), it.value());
        }
      }
      sum.take(row);
    };
  });
}

}  // namespace

SkinWeights smooth(const SkinWeights& weights, const Mesh& mesh, const SmoothOptions& options,
                   const Progress& progress) {
  if (weights.vertices() != mesh.V.rows()) {
    throw InputError("weights have " + std::to_string(weights.vertices()) + " rows, the mesh has " +
                         std::to_string(mesh.V.rows()) + " vertices",
                     "smooth");
  }
  if (options.steps < 0 || !(options.strength >= 0 && options.strength <= 1)) {
    throw InputError("steps must be >= 0 and strength in [0,1]", "smooth");
  }
  if (!options.keep.empty() &&
      static_cast<Eigen::Index>(options.keep.size()) != weights.vertices()) {
    throw InputError("one keep flag a vertex is needed", "smooth");
  }
  std::vector<bool> locked(static_cast<std::size_t>(weights.columns()), false);
  for (const int column : options.locked) {
    if (column < 0 || column >= weights.columns()) {
      throw InputError("locked column " + std::to_string(column) + " does not exist", "smooth");
    }
    locked[static_cast<std::size_t>(column)] = true;
  }
  const Neighbours graph = neighbours(mesh);
  SkinWeights result = weights;
  for (int k = 0; k < options.steps; ++k) {
    progress.check();
    result.W = step(result.W, graph, options, locked);
    progress("smoothing", static_cast<double>(k + 1) / options.steps);
  }
  return result;
}

}  // namespace skinfield
