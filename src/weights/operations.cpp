#include "skinfield/weights/operations.h"

#include "skinfield/base/error.h"
#include "weights/rows.h"

#include <cmath>
#include <string>

namespace skinfield {

SkinWeights sparse_weights(const RowMatrix& W, std::vector<std::string> names, double drop) {
  if (!names.empty() && static_cast<Eigen::Index>(names.size()) != W.cols()) {
    throw InputError(
        std::to_string(names.size()) + " column names for " + std::to_string(W.cols()) + " columns",
        "weights");
  }
  SkinWeights result;
  result.names = std::move(names);
  result.W = rows::build(W.rows(), W.cols(), [&] {
    return [&](Eigen::Index i, rows::Row& row) {
      for (Eigen::Index j = 0; j < W.cols(); ++j) {
        const double w = W(i, j);
        if (!(std::abs(w) <= drop)) row.emplace_back(static_cast<std::int32_t>(j), w);
      }
    };
  });
  return result;
}

RowMatrix dense_weights(const SkinWeights& weights) {
  RowMatrix W = RowMatrix::Zero(weights.vertices(), weights.columns());
  parallel_for(static_cast<std::size_t>(W.rows()), rows::block, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (SparseRows::InnerIterator it(weights.W, row); it; ++it) W(row, it.col()) += it.value();
  });
  return W;
}

Normalised normalise(const SkinWeights& weights) {
  Normalised result;
  result.weights.names = weights.names;
  result.weights.W = rows::build(weights.vertices(), weights.columns(), [&] {
    return [&](Eigen::Index i, rows::Row& row) {
      double largest = 0;
      for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
        if (!std::isfinite(it.value()) || it.value() <= 0) continue;
        row.emplace_back(static_cast<std::int32_t>(it.col()), it.value());
        largest = std::max(largest, it.value());
      }
      // Dividing by the largest first keeps sums of huge entries finite.
      double sum = 0;
      for (const auto& entry : row) sum += entry.second / largest;
      for (auto& entry : row) entry.second = entry.second / largest / sum;
    };
  });
  for (Eigen::Index i = 0; i < weights.vertices(); ++i) {
    for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
      if (!std::isfinite(it.value()) || it.value() < 0) ++result.removed;
    }
    const auto* start = result.weights.W.outerIndexPtr();
    if (start[i] == start[i + 1]) result.empty_rows.push_back(static_cast<int>(i));
  }
  return result;
}

RowMatrix interpolate(const SkinWeights& weights, const RowMatrix& data) {
  if (data.rows() != weights.W.cols()) {
    throw InputError("the data have " + std::to_string(data.rows()) + " rows for " +
                         std::to_string(weights.W.cols()) + " columns of weights",
                     "interpolate");
  }
  const Normalised normalised = normalise(weights);
  if (!normalised.empty_rows.empty()) {
    throw InputError("vertex " + std::to_string(normalised.empty_rows.front()) + " has no weights",
                     "interpolate", "bind the mesh first");
  }
  return normalised.weights.W * data;
}

Pruned prune(const SkinWeights& weights, const PruneOptions& options) {
  if (options.max_influences < 0) throw InputError("negative number of influences", "prune");
  if (!(options.epsilon >= 0 && options.epsilon <= 1)) {
    throw InputError("epsilon must lie in [0,1]", "prune");
  }
  Pruned result;
  result.weights.names = weights.names;
  Vector cut = Vector::Zero(weights.vertices());
  result.weights.W = rows::build(weights.vertices(), weights.columns(), [&] {
    return [&](Eigen::Index i, rows::Row& row) {
      rows::read(weights.W, i, row);
      double sum = 0;
      for (const auto& entry : row) sum += entry.second;
      if (!(sum > 0)) {
        row.clear();
        return;
      }
      std::sort(row.begin(), row.end(), [](const rows::Entry& a, const rows::Entry& b) {
        return a.second > b.second || (a.second == b.second && a.first < b.first);
      });
      std::size_t keep = row.size();
      if (options.max_influences > 0) {
        keep = std::min(keep, static_cast<std::size_t>(options.max_influences));
      }
      while (keep > 1 &&
             (row[keep - 1].second < options.epsilon * sum || row[keep - 1].second == 0)) {
        --keep;
      }
      for (std::size_t k = keep; k < row.size(); ++k) cut[i] += row[k].second / sum;
      row.resize(keep);
      std::sort(row.begin(), row.end());
      double kept = 0;
      for (const auto& entry : row) kept += entry.second;
      for (auto& entry : row) entry.second /= kept;
    };
  });
  if (cut.size() > 0) {
    result.mean_mass = cut.mean();
    result.max_mass = cut.maxCoeff();
    result.rows_cut = (cut.array() > 0).count();
  }
  return result;
}

}  // namespace skinfield
