#include "weights/neighbours.h"

#include "skinfield/base/error.h"

#include <algorithm>
#include <utility>

namespace skinfield {
namespace {

template <class Cells, class Visit>
void for_each_edge(const Cells& cells, const Visit& visit) {
  for (Eigen::Index c = 0; c < cells.rows(); ++c) {
    for (Eigen::Index a = 0; a < cells.cols(); ++a) {
      for (Eigen::Index b = 0; b < cells.cols(); ++b) {
        if (cells(c, a) != cells(c, b)) visit(cells(c, a), cells(c, b));
      }
    }
  }
}

template <class Cells>
bool in_range(const Cells& cells, Eigen::Index n) {
  return cells.size() == 0 || (cells.minCoeff() >= 0 && cells.maxCoeff() < n);
}

}  // namespace

Neighbours neighbours(const Mesh& mesh) {
  const Eigen::Index n = mesh.V.rows();
  if (!in_range(mesh.F, n) || !in_range(mesh.T, n)) {
    throw InputError("a vertex index is out of range", "mesh");
  }
  const auto count = static_cast<std::size_t>(n);
  std::vector<std::int32_t> start(count + 1, 0);
  const auto tally = [&](std::int32_t a, std::int32_t) {
    ++start[static_cast<std::size_t>(a) + 1];
  };
  for_each_edge(mesh.F, tally);
  for_each_edge(mesh.T, tally);
  for (std::size_t i = 0; i < count; ++i) start[i + 1] += start[i];
  std::vector<std::int32_t> all(static_cast<std::size_t>(start[count]));
  std::vector<std::int32_t> next(start.begin(), start.end() - 1);
  const auto store = [&](std::int32_t a, std::int32_t b) {
    all[static_cast<std::size_t>(next[static_cast<std::size_t>(a)]++)] = b;
  };
  for_each_edge(mesh.F, store);
  for_each_edge(mesh.T, store);

  Neighbours result;
  result.start.assign(1, 0);
  result.start.reserve(count + 1);
  for (std::size_t i = 0; i < count; ++i) {
    const auto begin = all.begin() + start[i];
    auto end = all.begin() + start[i + 1];
    std::sort(begin, end);
    end = std::unique(begin, end);
    result.vertex.insert(result.vertex.end(), begin, end);
    result.start.push_back(static_cast<std::int32_t>(result.vertex.size()));
  }
  return result;
}

}  // namespace skinfield
