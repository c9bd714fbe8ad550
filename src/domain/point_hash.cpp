#include "domain/point_hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace skinfield {
namespace {

std::uint64_t hash(std::uint64_t key) {
  key *= 0x9E3779B97F4A7C15ull;
  return key ^ (key >> 32);
}

std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

int cell(double x, double side) { return static_cast<int>(std::floor(x / side)); }

}  // namespace

std::vector<int> morton_order(const Points& X, double side) {
  std::vector<std::uint64_t> code(static_cast<std::size_t>(X.rows()));
  for (std::size_t i = 0; i < code.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (int axis = 0; axis < 3; ++axis)
      code[i] |= spread(static_cast<std::uint64_t>(cell(X(row, axis), side) + (1 << 20))) << axis;
  }
  std::vector<int> order(code.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const std::uint64_t p = code[static_cast<std::size_t>(a)];
    const std::uint64_t q = code[static_cast<std::size_t>(b)];
    return p != q ? p < q : a < b;
  });
  return order;
}

std::uint64_t PointHash::key(int i, int j, int k) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffff; };
  return part(i) << 42 | part(j) << 21 | part(k);
}

PointHash::PointHash(const Points& X, double side) : side_(side) {
  const auto n = static_cast<std::size_t>(X.rows());
  std::vector<std::uint64_t> keys(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    keys[i] = key(cell(X(row, 0), side), cell(X(row, 1), side), cell(X(row, 2), side));
  }
  order_.resize(n);
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(), [&](std::int32_t a, std::int32_t b) {
    const std::uint64_t p = keys[static_cast<std::size_t>(a)];
    const std::uint64_t q = keys[static_cast<std::size_t>(b)];
    return p != q ? p < q : a < b;
  });
  std::size_t cells = 0;
  for (std::size_t k = 0; k < n; ++k)
    cells += k == 0 || keys[static_cast<std::size_t>(order_[k])] !=
                           keys[static_cast<std::size_t>(order_[k - 1])];
  table_.resize(std::bit_ceil(2 * cells + 2));
  const std::size_t mask = table_.size() - 1;
  for (std::size_t k = 0; k < n;) {
    const std::uint64_t key_of_cell = keys[static_cast<std::size_t>(order_[k])];
    std::size_t end = k;
    while (end < n && keys[static_cast<std::size_t>(order_[end])] == key_of_cell) ++end;
    std::size_t s = hash(key_of_cell) & mask;
    while (table_[s].begin >= 0) s = (s + 1) & mask;
    table_[s] = {key_of_cell, static_cast<std::int32_t>(k), static_cast<std::int32_t>(end)};
    k = end;
  }
  for (const std::int32_t i : order_) {
    x_.push_back(X(i, 0));
    y_.push_back(X(i, 1));
    z_.push_back(X(i, 2));
  }
}

const PointHash::Slot* PointHash::slot(std::uint64_t key) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t s = hash(key) & mask;
  while (table_[s].begin >= 0) {
    if (table_[s].key == key) return &table_[s];
    s = (s + 1) & mask;
  }
  return nullptr;
}

void PointHash::find(const Vec3& x, double radius, std::vector<std::int32_t>& index,
                     std::vector<float>& distance2) const {
  index.clear();
  distance2.clear();
  const double reach2 = radius * radius;
  int low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = cell(x[axis] - radius, side_);
    high[axis] = cell(x[axis] + radius, side_);
  }
  for (int i = low[0]; i <= high[0]; ++i)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int k = low[2]; k <= high[2]; ++k) {
        const Slot* found = slot(key(i, j, k));
        if (!found) continue;
        for (auto at = static_cast<std::size_t>(found->begin);
             at < static_cast<std::size_t>(found->end); ++at) {
          const double dx = x_[at] - x[0], dy = y_[at] - x[1], dz = z_[at] - x[2];
          const double d2 = dx * dx + dy * dy + dz * dz;
          if (d2 >= reach2) continue;
          index.push_back(order_[at]);
          distance2.push_back(static_cast<float>(d2));
        }
      }
}

}  // namespace skinfield
