// Deforming a million vertices: packed linear blend against the memory's own speed.
#include "skinfield/base/random.h"
#include "skinfield/deform/dual_quaternion.h"
#include "skinfield/deform/linear_blend.h"
#include "skinfield/deform/packed_influences.h"

#include "skinfield/base/parallel.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace {

using namespace skinfield;

constexpr int vertices = 1'000'000;
constexpr int joints = 60;

/// Four influences on neighbouring joints, in the order in which a mesh runs along a body.
SkinWeights body_weights() {
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(std::size_t{4} * vertices);
  Random random(1);
  for (int i = 0; i < vertices; ++i) {
    const int first = static_cast<int>(static_cast<std::int64_t>(i) * (joints - 4) / vertices);
    double w[4], sum = 0;
    for (double& x : w) sum += x = random.uniform() + 0.01;
    for (int k = 0; k < 4; ++k) entries.emplace_back(i, first + k, w[k] / sum);
  }
  SkinWeights weights;
  weights.W.resize(vertices, joints);
  weights.W.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

std::vector<Transform> motions() {
  std::vector<Transform> columns(joints, Transform::Identity());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const double angle = 0.01 * static_cast<double>(j);
    columns[j].topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle),
        std::cos(angle);
    columns[j](2, 3) = angle;
  }
  return columns;
}

const SkinWeights& weights() {
  static const SkinWeights shared = body_weights();
  return shared;
}

Points positions() {
  Points V(vertices, 3);
  Random random(2);
  for (Eigen::Index i = 0; i < V.rows(); ++i) V.row(i) = random.direction().transpose();
  return V;
}

void report(benchmark::State& state, std::size_t bytes_per_vertex) {
  const double bytes = static_cast<double>(bytes_per_vertex) * vertices;
  state.counters["MB_moved"] = bytes / 1e6;
  state.counters["GB/s"] =
      benchmark::Counter(bytes / 1e9, benchmark::Counter::kIsIterationInvariantRate);
  state.SetItemsProcessed(state.iterations() * vertices);
}

template <class Scalar>
void packed_linear_blend(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const PackedInfluences<Scalar> influences = pack_influences<Scalar>(weights());
  const PackedPoints<Scalar> V = positions().cast<Scalar>();
  const std::vector<Transform> columns = motions();
  PackedPoints<Scalar> deformed(V.rows(), 3);
  for (auto _ : state) {
    linear_blend<Scalar>(V, influences, columns, deformed);
    benchmark::DoNotOptimize(deformed.data());
  }
  report(state, PackedInfluences<Scalar>::bytes_per_vertex());
}

template <Points (*Deform)(const Points&, const SkinWeights&, std::span<const Transform>)>
void sparse(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const Points V = positions();
  const std::vector<Transform> columns = motions();
  for (auto _ : state) benchmark::DoNotOptimize(Deform(V, weights(), columns));
  report(state, 48 + 4 * 12 + 4);
}

/// The yardstick: the same number of bytes copied, half read and half written, by the same loops.
void copy(benchmark::State& state) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  const std::size_t bytes = PackedInfluences<float>::bytes_per_vertex() * vertices / 2;
  const std::vector<char> from(bytes, 1);
  std::vector<char> to(bytes, 2);
  for (auto _ : state) {
    parallel_blocks(bytes, 1 << 17, [&](std::size_t begin, std::size_t end) {
      std::memcpy(to.data() + begin, from.data() + begin, end - begin);
    });
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
  report(state, PackedInfluences<float>::bytes_per_vertex());
}

BENCHMARK(copy)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(packed_linear_blend<float>)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(packed_linear_blend<double>)
    ->Arg(1)
    ->Arg(0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(sparse<linear_blend>)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(sparse<dual_quaternion>)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
