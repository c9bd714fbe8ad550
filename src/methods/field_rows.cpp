#include "methods/field_rows.h"

#include "domain/point_hash.h"
#include "methods/tile_kernel.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

namespace skinfield {
namespace {

constexpr int most_directions = 3;
constexpr int most_samples = kTileRows / 2;  // of a tile, in the plane
constexpr std::size_t chunks = 16;  // partial gradients; depends on nothing, so neither do results

/// One bit a column: is the row nonzero there?
class ColumnMasks {
 public:
  ColumnMasks(const FloatRows& F) : words_(static_cast<std::size_t>((F.cols() + 63) / 64)) {
    bits_.assign(static_cast<std::size_t>(F.rows()) * words_, 0);
    parallel_for(static_cast<std::size_t>(F.rows()), 1024, [&](std::size_t i) {
      const float* row = F.data() + static_cast<Eigen::Index>(i) * F.cols();
      for (Eigen::Index j = 0; j < F.cols(); ++j)
        if (row[j] != 0)
          bits_[i * words_ + static_cast<std::size_t>(j / 64)] |= std::uint64_t{1} << (j % 64);
    });
  }
  std::size_t words() const { return words_; }
  const std::uint64_t* of(std::int32_t i) const {
    return bits_.data() + static_cast<std::size_t>(i) * words_;
  }

 private:
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace

std::array<Vec3, 3> random_frame(Random& random, int dimension) {
  if (dimension == 2) {
    const Vec3 a = random.direction(2);
    return {a, Vec3(-a.y(), a.x(), 0), Vec3::UnitZ()};
  }
  const Vec3 a = random.direction();
  const Vec3 u = a.unitOrthogonal(), v = a.cross(u);
  const double angle = 2 * std::numbers::pi * random.uniform();
  const Vec3 b = std::cos(angle) * u + std::sin(angle) * v;
  return {a, b, a.cross(b)};
}

double winding_weight(double winding, double low, double high) {
  return std::clamp((winding - low) / (high - low), 0.0, 1.0);
}

FieldRows::FieldRows(const KernelField& field, const FieldConditions& conditions,
                     std::span<const WeightedSite> samples, double h, int columns,
                     std::uint64_t seed, std::uint64_t stream, const Progress& progress)
    : points_(static_cast<Eigen::Index>(field.points().size())),
      columns_(columns),
      directions_(field.solid().dimension()) {
  const auto tile_samples = static_cast<std::size_t>(kTileRows / directions_);
  Points Y(static_cast<Eigen::Index>(samples.size()), 3);
  for (std::size_t i = 0; i < samples.size(); ++i)
    Y.row(static_cast<Eigen::Index>(i)) = samples[i].site.x.transpose();
  const std::vector<int> order = morton_order(Y, 0.5 * field.sigma());
  const std::size_t count = (samples.size() + tile_samples - 1) / tile_samples;
  tiles_.resize(count);
  std::vector<std::int64_t> blind(count, 0);
  parallel_for(count, 8, [&](std::size_t t) {
    if ((t & 7) == 0) progress.check();
    const std::size_t begin = t * tile_samples;
    const std::size_t n = std::min(tile_samples, samples.size() - begin);
    fill(field, conditions, samples, std::span(order).subspan(begin, n), h, seed, stream, tiles_[t],
         blind[t]);
  });
  blind_ = std::accumulate(blind.begin(), blind.end(), std::int64_t{0});
  rows_ = directions_ * (static_cast<std::int64_t>(samples.size()) - blind_);
}

void FieldRows::fill(const KernelField& field, const FieldConditions& conditions,
                     std::span<const WeightedSite> samples, std::span<const int> order, double h,
                     std::uint64_t seed, std::uint64_t stream, Tile& tile,
                     std::int64_t& blind) const {
  thread_local std::vector<FieldStencil> stencils;
  thread_local std::vector<std::int32_t> local;
  stencils.resize(most_samples);
  local.resize(std::max(local.size(), static_cast<std::size_t>(points_)));
  std::array<char, most_samples> sees{};
  std::array<double, most_samples> step{};
  const auto directions = static_cast<std::size_t>(directions_);
  for (std::size_t s = 0; s < order.size(); ++s) {
    const WeightedSite& sample = samples[static_cast<std::size_t>(order[s])];
    Random random(seed, stream + static_cast<std::uint64_t>(order[s]));
    const std::array<Vec3, 3> frame = random_frame(random, directions_);
    std::array<Vec3, 1 + 2 * most_directions> place;
    place[0] = sample.site.x;
    step[s] = h * field.grading().at(sample.site.x);
    for (std::size_t d = 0; d < directions; ++d) {
      place[1 + 2 * d] = sample.site.x + step[s] * frame[d];
      place[2 + 2 * d] = sample.site.x - step[s] * frame[d];
    }
    sees[s] = make_stencil(field, conditions, sample.site,
                           std::span(place).first(1 + 2 * directions), stencils[s]);
    if (!sees[s]) {
      ++blind;
      continue;
    }
    tile.node.insert(tile.node.end(), stencils[s].node.begin(), stencils[s].node.end());
  }
  std::sort(tile.node.begin(), tile.node.end());
  tile.node.erase(std::unique(tile.node.begin(), tile.node.end()), tile.node.end());
  tile.node.shrink_to_fit();
  for (std::size_t k = 0; k < tile.node.size(); ++k)
    local[static_cast<std::size_t>(tile.node[k])] = static_cast<std::int32_t>(k);
  tile.R.assign(tile.node.size() * kTileRows, 0.0f);

  std::vector<double> of_column(static_cast<std::size_t>(columns_), 0);
  std::vector<float> mixed;
  for (std::size_t s = 0; s < order.size(); ++s) {
    if (!sees[s]) continue;
    const FieldStencil& st = stencils[s];
    const double weight = samples[static_cast<std::size_t>(order[s])].weight;
    const double scale = std::sqrt(weight / directions_) / (step[s] * step[s]);
    for (int d = 0; d < directions_; ++d) {
      // Equation 13; with equation 9 every place is a blend of two.
      const int row = static_cast<int>(s) * directions_ + d;
      mixed.assign(st.node.size(), 0.0f);
      const auto add = [&](int q, double c) {
        const Prescribed& p = st.place[static_cast<std::size_t>(q)];
        for (const auto& [column, value] : p.value)
          of_column[static_cast<std::size_t>(column)] += c * value;
        if (p.free > 0)
          add_scaled(mixed.data(), st.row(static_cast<std::size_t>(q)),
                     static_cast<float>(c * p.free), static_cast<int>(mixed.size()));
      };
      for (const auto& [q, c] : {std::pair{0, -2.0}, {1 + 2 * d, 1.0}, {2 + 2 * d, 1.0}}) {
        const auto at = static_cast<std::size_t>(q);
        const double blend = st.twin[at] >= 0 ? st.blend[at] : 0;
        add(q, scale * c * (1 - blend));
        if (blend > 0) add(st.twin[at], scale * c * blend);
      }
      for (std::size_t k = 0; k < mixed.size(); ++k)
        tile.R[static_cast<std::size_t>(local[static_cast<std::size_t>(st.node[k])]) * kTileRows +
               static_cast<std::size_t>(row)] = mixed[k];
      for (int j = 0; j < columns_; ++j) {
        double& value = of_column[static_cast<std::size_t>(j)];
        if (value != 0) tile.constants.push_back({row, j, static_cast<float>(value)});
        value = 0;
      }
    }
  }
}

double FieldRows::energy(const FloatRows& F, FloatRows* G, const Progress& progress) const {
  const ColumnMasks masks(F);
  const auto m = static_cast<std::size_t>(F.cols());
  const std::size_t block = (tiles_.size() + chunks - 1) / chunks;
  struct Part {
    double energy = 0;
    std::int32_t low = 0, high = 0;
    std::vector<float> G;
  };
  std::vector<Part> parts(chunks);
  parallel_blocks(tiles_.size(), block, [&](std::size_t begin, std::size_t end) {
    progress.check();
    Part& part = parts[begin / block];
    if (G) {
      part.low = std::numeric_limits<std::int32_t>::max();
      for (std::size_t t = begin; t < end; ++t) {
        if (tiles_[t].node.empty()) continue;
        part.low = std::min(part.low, tiles_[t].node.front());
        part.high = std::max(part.high, tiles_[t].node.back() + 1);
      }
      if (part.high == 0) part.low = 0;
      part.G.assign(static_cast<std::size_t>(part.high - part.low) * m, 0.0f);
    }
    std::vector<std::uint64_t> mask(masks.words());
    std::vector<int> active;
    std::vector<float> local;
    alignas(64) std::array<float, kTileRows * kLanes> residual;
    for (std::size_t t = begin; t < end; ++t) {
      const Tile& tile = tiles_[t];
      const auto n = static_cast<int>(tile.node.size());
      std::fill(mask.begin(), mask.end(), 0);
      for (const std::int32_t i : tile.node)
        for (std::size_t w = 0; w < mask.size(); ++w) mask[w] |= masks.of(i)[w];
      for (const Constant& c : tile.constants)
        mask[static_cast<std::size_t>(c.column / 64)] |= std::uint64_t{1} << (c.column % 64);
      active.clear();
      for (std::size_t w = 0; w < mask.size(); ++w)
        for (std::uint64_t bits = mask[w]; bits != 0; bits &= bits - 1)
          active.push_back(static_cast<int>(64 * w) + std::countr_zero(bits));
      local.resize(static_cast<std::size_t>(n) * kLanes);
      for (std::size_t first = 0; first < active.size(); first += kLanes) {
        const std::size_t lanes = std::min<std::size_t>(kLanes, active.size() - first);
        std::array<int, kLanes> column{};
        for (std::size_t l = 0; l < lanes; ++l) column[l] = active[first + l];
        std::fill(local.begin(), local.end(), 0.0f);
        for (int k = 0; k < n; ++k) {
          const float* row = F.data() + static_cast<std::size_t>(tile.node[k]) * m;
          for (std::size_t l = 0; l < lanes; ++l)
            local[static_cast<std::size_t>(k) * kLanes + l] = row[column[l]];
        }
        residual.fill(0);
        for (const Constant& c : tile.constants)
          for (std::size_t l = 0; l < lanes; ++l)
            if (column[l] == c.column)
              residual[static_cast<std::size_t>(c.row) * kLanes + l] += c.value;
        tile_forward(tile.R.data(), n, local.data(), residual.data());
        double sum = 0;
        for (const float r : residual) sum += static_cast<double>(r) * static_cast<double>(r);
        part.energy += 0.5 * sum;
        if (!G) continue;
        tile_backward(tile.R.data(), n, residual.data(), local.data());
        for (int k = 0; k < n; ++k) {
          float* row = part.G.data() + static_cast<std::size_t>(tile.node[k] - part.low) * m;
          for (std::size_t l = 0; l < lanes; ++l)
            row[column[l]] += local[static_cast<std::size_t>(k) * kLanes + l];
        }
      }
    }
  });
  double energy = 0;
  for (const Part& part : parts) energy += part.energy;
  if (G) {
    G->setZero(points_, F.cols());
    parallel_blocks(static_cast<std::size_t>(points_), 1024, [&](std::size_t b, std::size_t e) {
      for (const Part& part : parts) {
        const std::size_t from = std::max(b, static_cast<std::size_t>(part.low));
        const std::size_t to = std::min(e, static_cast<std::size_t>(part.high));
        if (from < to)
          add_scaled(G->data() + from * m,
                     part.G.data() + (from - static_cast<std::size_t>(part.low)) * m, 1,
                     static_cast<int>((to - from) * m));
      }
    });
  }
  return energy;
}

Vector FieldRows::majorant() const {
  Vector D = Vector::Zero(points_);
  for (const Tile& tile : tiles_) {
    std::array<double, kTileRows> norm{};
    for (std::size_t at = 0; at < tile.R.size(); ++at)
      norm[at % kTileRows] += static_cast<double>(std::abs(tile.R[at]));
    for (std::size_t at = 0; at < tile.R.size(); ++at)
      D[tile.node[at / kTileRows]] +=
          static_cast<double>(std::abs(tile.R[at])) * norm[at % kTileRows];
  }
  return D;
}

double FieldRows::largest_eigenvalue(const Vector& D, int iterations, Vector& v,
                                     const Progress& progress) const {
  // The energy of v with no constants: an energy difference would cancel, so blocks are asked
  // directly, all in one lane.
  const Vector root = D.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  double value = 0;
  for (int k = 0; k < iterations; ++k) {
    progress.check();
    v /= std::max(v.norm(), 1e-300);
    const Vector u = root.cwiseProduct(v);
    const Vector z = parallel_reduce(
        tiles_.size(), (tiles_.size() + chunks - 1) / chunks, Vector(Vector::Zero(points_)),
        [&](std::size_t begin, std::size_t end) {
          Vector sum = Vector::Zero(points_);
          for (std::size_t t = begin; t < end; ++t) {
            const Tile& tile = tiles_[t];
            std::array<float, kTileRows> residual{};
            for (std::size_t i = 0; i < tile.node.size(); ++i)
              add_scaled(residual.data(), tile.R.data() + i * kTileRows,
                         static_cast<float>(u[tile.node[i]]), kTileRows);
            for (std::size_t i = 0; i < tile.node.size(); ++i) {
              float dot = 0;
              for (int r = 0; r < kTileRows; ++r)
                dot += tile.R[i * kTileRows + static_cast<std::size_t>(r)] *
                       residual[static_cast<std::size_t>(r)];
              sum[tile.node[i]] += static_cast<double>(dot);
            }
          }
          return sum;
        },
        [](const Vector& a, const Vector& b) { return Vector(a + b); });
    v = root.cwiseProduct(z);
    value = v.norm();
  }
  return std::clamp(value, 1e-6, 1.0);
}

std::size_t FieldRows::bytes() const {
  std::size_t sum = 0;
  for (const Tile& tile : tiles_)
    sum += tile.R.size() * sizeof(float) + tile.node.size() * sizeof(std::int32_t) +
           tile.constants.size() * sizeof(Constant);
  return sum;
}

}  // namespace skinfield
