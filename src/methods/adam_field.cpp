#include "methods/adam_field.h"

#include "base/vector_clones.h"
#include "skinfield/base/parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace skinfield {
namespace {

using Eight = float __attribute__((vector_size(32)));
constexpr int kLanes = 8;
constexpr std::size_t node_blocks = 16;  // of gradients: depends on nothing, so neither do results
constexpr float beta1 = 0.9f, beta2 = 0.8f, tiny = 1e-8f;  // appendix A: beta2 0.8
constexpr int most_places = 6;

/// f (places, padded) = phi F over the listed rows.
SKINFIELD_VECTOR_CLONES
void gather_values(const float* F, std::ptrdiff_t padded, const std::int32_t* node, int n,
                   const float* phi, int places, float* f) {
  for (std::ptrdiff_t j = 0; j < padded; j += kLanes) {
    Eight sum[most_places] = {};
    for (int k = 0; k < n; ++k) {
      Eight row;
      std::memcpy(&row, F + node[k] * padded + j, sizeof row);
      for (int q = 0; q < places; ++q) sum[q] += phi[static_cast<std::ptrdiff_t>(q) * n + k] * row;
    }
    for (int q = 0; q < places; ++q) std::memcpy(f + q * padded + j, &sum[q], sizeof sum[q]);
  }
}

/// Rows [begin, end) of the list: G += phi' g.
SKINFIELD_VECTOR_CLONES
void scatter_gradient(float* G, std::ptrdiff_t padded, const std::int32_t* node, int begin, int end,
                      int n, const float* phi, int places, const float* g) {
  for (std::ptrdiff_t j = 0; j < padded; j += kLanes) {
    Eight at[most_places];
    for (int q = 0; q < places; ++q) std::memcpy(&at[q], g + q * padded + j, sizeof at[q]);
    for (int k = begin; k < end; ++k) {
      Eight row;
      float* to = G + node[k] * padded + j;
      std::memcpy(&row, to, sizeof row);
      for (int q = 0; q < places; ++q) row += phi[static_cast<std::ptrdiff_t>(q) * n + k] * at[q];
      std::memcpy(to, &row, sizeof row);
    }
  }
}

SKINFIELD_VECTOR_CLONES
void adam_update(float* x, float* m, float* v, const float* g, std::ptrdiff_t n, float rate,
                 float unbias1, float unbias2) {
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    m[i] = beta1 * m[i] + (1 - beta1) * g[i];
    v[i] = beta2 * v[i] + (1 - beta2) * g[i] * g[i];
    x[i] -= rate * (m[i] * unbias1) / (std::sqrt(v[i] * unbias2) + tiny);
  }
}

}  // namespace

SKINFIELD_VECTOR_CLONES
void softplus_and_slope(const float* f, int n, float* value, float* slope) {
  for (int i = 0; i < n; ++i) {
    // e = exp(-|f|) = 2^p: the whole part goes to the exponent, the rest to a polynomial.
    const float size = f[i] < 0 ? -f[i] : f[i];
    const float p = (size > 80 ? -80 : -size) * 1.44269504f;
    const auto whole = static_cast<std::int32_t>(p - 0.5f);  // p <= 0: rounds to nearest
    const float r = (p - static_cast<float>(whole)) * 0.693147181f;
    const float series =
        1 + r * (1 + r * (0.5f + r * (1.0f / 6 + r * (1.0f / 24 + r * (1.0f / 120)))));
    const float e = series * std::bit_cast<float>((whole + 127) << 23);
    // log(1 + e) = 2 artanh(e / (2 + e)), the argument at most 1/3.
    const float s = e / (2 + e), s2 = s * s;
    const float log1p =
        2 * s * (1 + s2 * (1.0f / 3 + s2 * (0.2f + s2 * (1.0f / 7 + s2 * (1.0f / 9)))));
    value[i] = (f[i] > 0 ? f[i] : 0) + log1p;
    slope[i] = (f[i] > 0 ? 1 : e) / (1 + e);
  }
}

AdamField::AdamField(const FloatRows& F, const FloatRows& first, const FloatRows& second,
                     const std::vector<char>& bound)
    : columns_(F.cols()), padded_((F.cols() + kLanes - 1) / kLanes * kLanes) {
  mask_.assign(static_cast<std::size_t>(padded_), 0.0f);
  for (std::size_t j = 0; j < bound.size(); ++j) mask_[j] = bound[j] ? 1.0f : 0.0f;
  F_ = pad(F);
  first_ = first.size() > 0 ? pad(first) : FloatRows::Zero(F.rows(), padded_);
  second_ = second.size() > 0 ? pad(second) : FloatRows::Zero(F.rows(), padded_);
}

FloatRows AdamField::pad(const FloatRows& rows) const {
  FloatRows padded = FloatRows::Zero(rows.rows(), padded_);
  padded.leftCols(columns_) = rows;
  return padded;
}

double AdamField::forward(const FieldSample& sample, std::vector<float>* g) const {
  const FieldStencil& st = sample.stencil;
  const auto m = static_cast<int>(padded_);
  const auto places = static_cast<int>(st.place.size());
  const auto size = static_cast<std::size_t>(places * m);
  thread_local std::vector<float> f, slope, share, residual;
  f.resize(size);
  slope.resize(size);
  share.resize(size);
  residual.assign(static_cast<std::size_t>(m), 0.0f);
  gather_values(F_.data(), padded_, st.node.data(), static_cast<int>(st.node.size()), st.phi.data(),
                places, f.data());
  softplus_and_slope(f.data(), places * m, share.data(), slope.data());
  // Equation 13 over h^2, each wanted place a blend with the wall's (equation 9).
  float coefficient[most_places] = {}, total[most_places];
  for (std::size_t q = 0; q < st.twin.size(); ++q) {
    const double c = (q == 0 ? -2 : 1) / (sample.h * sample.h);
    const double blend = st.twin[q] >= 0 ? st.blend[q] : 0;
    coefficient[q] += static_cast<float>(c * (1 - blend));
    if (blend > 0) coefficient[st.twin[q]] += static_cast<float>(c * blend);
  }
  for (int q = 0; q < places; ++q) {
    const Prescribed& p = st.place[static_cast<std::size_t>(q)];
    float* n = share.data() + q * m;
    total[q] = 0;
    for (int j = 0; j < m; ++j) total[q] += n[j] *= mask_[static_cast<std::size_t>(j)];
    const float scale = 1 / total[q];
    const float c = coefficient[q] * static_cast<float>(p.free);
    for (int j = 0; j < m; ++j) {
      n[j] *= scale;
      residual[static_cast<std::size_t>(j)] += c * n[j];
    }
    for (const auto& [column, value] : p.value)
      residual[static_cast<std::size_t>(column)] += coefficient[q] * static_cast<float>(value);
  }
  double energy = 0;
  for (const float r : residual) energy += static_cast<double>(r) * static_cast<double>(r);
  if (g) {
    g->resize(size);
    for (int q = 0; q < places; ++q) {
      const float c =
          coefficient[q] *
          static_cast<float>(sample.weight * st.place[static_cast<std::size_t>(q)].free) / total[q];
      const float* n = share.data() + q * m;
      float mean = 0;
      for (int j = 0; j < m; ++j) mean += residual[static_cast<std::size_t>(j)] * n[j];
      for (int j = 0; j < m; ++j)
        (*g)[static_cast<std::size_t>(q * m + j)] =
            c * (residual[static_cast<std::size_t>(j)] - mean) *
            slope[static_cast<std::size_t>(q * m + j)] * mask_[static_cast<std::size_t>(j)];
    }
  }
  return 0.5 * sample.weight * energy;
}

double AdamField::energy(std::span<const FieldSample* const> samples) {
  return parallel_reduce(
      samples.size(), 32, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i)
          if (samples[i]->weight > 0) sum += forward(*samples[i], nullptr);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

double AdamField::step(std::span<const FieldSample* const> samples, double rate, std::int64_t t) {
  g_.resize(std::max(g_.size(), samples.size()));
  struct Range {
    std::int32_t low = 0, high = -1;
  };
  std::vector<Range> range(samples.size());  // of nodes: looked at once for every block
  const double energy = parallel_reduce(
      samples.size(), 32, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          if (!(samples[i]->weight > 0)) continue;
          sum += forward(*samples[i], &g_[i]);
          range[i] = {samples[i]->stencil.node.front(), samples[i]->stencil.node.back()};
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
  const auto points = static_cast<std::size_t>(F_.rows());
  const std::size_t block = (points + node_blocks - 1) / node_blocks;
  const auto unbias = [t](float beta) {
    return static_cast<float>(1 / (1 - std::pow(static_cast<double>(beta), t)));
  };
  parallel_blocks(points, block, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<float> gradient;
    gradient.assign((end - begin) * static_cast<std::size_t>(padded_), 0.0f);
    const auto low = static_cast<std::int32_t>(begin), high = static_cast<std::int32_t>(end);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (range[i].high < low || range[i].low >= high) continue;
      const FieldStencil& st = samples[i]->stencil;
      const auto first = std::lower_bound(st.node.begin(), st.node.end(), low);
      const auto last = std::lower_bound(first, st.node.end(), high);
      if (first == last) continue;
      scatter_gradient(gradient.data() - low * padded_, padded_, st.node.data(),
                       static_cast<int>(first - st.node.begin()),
                       static_cast<int>(last - st.node.begin()), static_cast<int>(st.node.size()),
                       st.phi.data(), static_cast<int>(st.place.size()), g_[i].data());
    }
    const std::ptrdiff_t offset = low * padded_;
    adam_update(F_.data() + offset, first_.data() + offset, second_.data() + offset,
                gradient.data(), static_cast<std::ptrdiff_t>(gradient.size()),
                static_cast<float>(rate), unbias(beta1), unbias(beta2));
  });
  return energy;
}

}  // namespace skinfield
