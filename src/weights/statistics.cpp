#include "skinfield/weights/statistics.h"

#include "skinfield/base/error.h"
#include "weights/neighbours.h"
#include "weights/rows.h"

#include <cmath>
#include <map>

namespace skinfield {
namespace {

/// Linear interpolation between the order statistics of `sorted`.
double quantile(const std::vector<double>& sorted, double q) {
  const double x = q * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(x);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  const double t = x - static_cast<double>(low);
  return (1 - t) * sorted[low] + t * sorted[high];
}

}  // namespace

Comparison compare(const SkinWeights& a, const SkinWeights& b) {
  if (a.vertices() != b.vertices() || a.columns() != b.columns()) {
    throw InputError(std::to_string(a.vertices()) + "x" + std::to_string(a.columns()) +
                         " weights against " + std::to_string(b.vertices()) + "x" +
                         std::to_string(b.columns()),
                     "compare", "both must belong to one mesh and one skeleton");
  }
  const Eigen::Index n = a.vertices(), m = a.columns();
  Comparison result;
  result.vertex = Vector::Zero(n);
  result.column = Vector::Zero(m);
  if (n == 0) return result;
  const auto part = [&](std::size_t begin, std::size_t end) {
    Vector column = Vector::Zero(m);
    rows::Accumulator difference(m);
    rows::Row row;
    for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
      difference.add(a.W, i, 1);
      difference.add(b.W, i, -1);
      difference.take(row);
      for (const auto& [j, d] : row) {
        column[j] += std::abs(d);
        result.vertex[i] += 0.5 * std::abs(d);
      }
    }
    return column;
  };
  const auto join = [](const Vector& x, const Vector& y) -> Vector { return x + y; };
  result.column =
      parallel_reduce(static_cast<std::size_t>(n), rows::block, result.column, part, join) /
      static_cast<double>(n);
  std::vector<double> sorted(result.vertex.data(), result.vertex.data() + n);
  std::sort(sorted.begin(), sorted.end());
  Eigen::Index worst = 0;
  result.max = result.vertex.maxCoeff(&worst);
  result.worst_vertex = static_cast<int>(worst);
  result.mean = result.vertex.mean();
  result.p95 = quantile(sorted, 0.95);
  result.p99 = quantile(sorted, 0.99);
  return result;
}

SkinWeights reorder_columns(const SkinWeights& weights, const std::vector<std::string>& names) {
  if (static_cast<Eigen::Index>(weights.names.size()) != weights.columns()) {
    throw InputError("the columns have no names", "weights");
  }
  std::map<std::string, std::int32_t> place;
  for (std::size_t j = 0; j < names.size(); ++j) {
    place.emplace(names[j], static_cast<std::int32_t>(j));
  }
  std::vector<std::int32_t> target;
  for (const auto& name : weights.names) {
    const auto found = place.find(name);
    target.push_back(found == place.end() ? -1 : found->second);
  }
  SkinWeights result;
  result.names = names;
  result.W = rows::build(weights.vertices(), static_cast<Eigen::Index>(names.size()), [&] {
    return [&](Eigen::Index i, rows::Row& row) {
      for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
        const std::int32_t column = target[static_cast<std::size_t>(it.col())];
        if (column >= 0) {
          row.emplace_back(column, it.value());
        } else if (it.value() != 0) {
          throw InputError("column '" + weights.names[static_cast<std::size_t>(it.col())] +
                               "' has weight and no counterpart",
                           "weights");
        }
      }
      std::sort(row.begin(), row.end());
    };
  });
  return result;
}

WeightStatistics weight_statistics(const SkinWeights& weights, std::span<const int> columns) {
  WeightStatistics result;
  std::vector<bool> binds(static_cast<std::size_t>(weights.columns()), false);
  for (Eigen::Index i = 0; i < weights.vertices(); ++i) {
    double sum = 0;
    std::size_t count = 0;
    for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
      const double w = it.value();
      if (!std::isfinite(w)) {
        ++result.non_finite;
        continue;
      }
      if (w < 0) ++result.negative;
      if (w != 0) ++count;
      if (w > 0.5) binds[static_cast<std::size_t>(it.col())] = true;
      sum += w;
    }
    if (count == 0) {
      ++result.empty_rows;
    } else {
      result.row_sum_error = std::max(result.row_sum_error, std::abs(sum - 1));
    }
    if (result.influences.size() <= count) result.influences.resize(count + 1, 0);
    ++result.influences[count];
  }
  const auto test = [&](int j) {
    if (!binds[static_cast<std::size_t>(j)]) result.without_vertices.push_back(j);
  };
  for (const int j : columns) test(j);
  if (columns.empty()) {
    for (int j = 0; j < weights.columns(); ++j) test(j);
  }
  return result;
}

Extrema local_extrema(const SkinWeights& weights, const Mesh& mesh, double tolerance,
                      std::span<const int> exempt) {
  if (weights.vertices() != mesh.V.rows()) {
    throw InputError("weights have " + std::to_string(weights.vertices()) + " rows, the mesh has " +
                         std::to_string(mesh.V.rows()) + " vertices",
                     "extrema");
  }
  std::vector<char> judged(static_cast<std::size_t>(mesh.V.rows()), 1);
  for (const int v : exempt) {
    if (v < 0 || v >= mesh.V.rows())
      throw InputError("an exempt vertex is out of range", "extrema");
    judged[static_cast<std::size_t>(v)] = 0;
  }
  const Neighbours graph = neighbours(mesh);
  const auto m = static_cast<std::size_t>(weights.columns());
  const auto fresh = [&] {
    Extrema none;
    none.column.assign(m, 0);
    return none;
  };
  const auto part = [&](std::size_t begin, std::size_t end) {
    Extrema found = fresh();
    // Per column: the neighbours' largest and smallest weight and how many have an entry.
    std::vector<double> high(m, 0), low(m, 0), own(m, 0);
    std::vector<std::size_t> seen(m, 0);
    std::vector<std::size_t> touched;
    for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
      const auto around = graph.of(i);
      if (around.empty() || !judged[static_cast<std::size_t>(i)]) continue;
      touched.clear();
      for (SparseRows::InnerIterator it(weights.W, i); it; ++it) {
        const auto j = static_cast<std::size_t>(it.col());
        own[j] = it.value();
        touched.push_back(j);
      }
      const std::size_t held = touched.size();
      for (const std::int32_t k : around) {
        for (SparseRows::InnerIterator it(weights.W, k); it; ++it) {
          const auto j = static_cast<std::size_t>(it.col());
          high[j] = seen[j] ? std::max(high[j], it.value()) : it.value();
          low[j] = seen[j] ? std::min(low[j], it.value()) : it.value();
          if (seen[j]++ == 0) touched.push_back(j);
        }
      }
      for (std::size_t t = 0; t < touched.size(); ++t) {
        const std::size_t j = touched[t];
        // A column that is in the own row and at a neighbour stands in the list twice.
        if (t >= held && own[j] != 0) continue;
        const bool all = seen[j] == around.size();
        const double top = all ? high[j] : std::max(high[j], 0.0);
        const double bottom = all ? low[j] : std::min(low[j], 0.0);
        const bool maximum = own[j] > top + tolerance && own[j] < 1 - tolerance;
        const bool minimum = own[j] < bottom - tolerance && own[j] > tolerance;
        if (!maximum && !minimum) continue;
        ++(maximum ? found.maxima : found.minima);
        ++found.column[j];
        found.places.push_back({static_cast<int>(i), static_cast<int>(j), maximum, own[j],
                                maximum ? own[j] - top : bottom - own[j]});
      }
      for (const std::size_t j : touched) {
        own[j] = high[j] = low[j] = 0;
        seen[j] = 0;
      }
    }
    return found;
  };
  const auto join = [](Extrema a, const Extrema& b) {
    a.maxima += b.maxima;
    a.minima += b.minima;
    for (std::size_t j = 0; j < a.column.size(); ++j) a.column[j] += b.column[j];
    a.places.insert(a.places.end(), b.places.begin(), b.places.end());
    return a;
  };
  return parallel_reduce(static_cast<std::size_t>(weights.vertices()), rows::block, fresh(), part,
                         join);
}

}  // namespace skinfield
