#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "skinfield/base/progress.h"
#include "skinfield/base/random.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>
#include <string>
#include <vector>

using namespace skinfield;

namespace {

using Block = std::array<std::uint32_t, 4>;

TEST(Random, PhiloxGivesTheKnownAnswers) {  // Random123's kat_vectors, philox4x32 10
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, SeedsAndStreamsDiffer) {
  std::set<std::uint32_t> seen;
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    for (std::uint64_t stream = 0; stream < 10; ++stream) seen.insert(Random(seed, stream).bits());
  seen.insert(Random(0, std::uint64_t{1} << 40).bits());
  seen.insert(Random(std::uint64_t{1} << 40, 0).bits());
  EXPECT_EQ(seen.size(), 102u);
  EXPECT_EQ(Random(3, 4).bits(), Random(3, 4).bits());
}

TEST(Random, DrawsHaveTheirRangesAndMoments) {
  Random random(1, 2);
  constexpr int n = 20000;
  double sum = 0, square = 0, normal = 0, normal2 = 0;
  Vec3 mean = Vec3::Zero();
  std::array<int, 7> count{};
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    square += u * u;
    const double g = random.normal();
    normal += g;
    normal2 += g * g;
    const Vec3 d = random.direction();
    ASSERT_NEAR(d.norm(), 1, 1e-12);
    mean += d;
    const std::uint32_t k = random.below(7);
    ASSERT_LT(k, 7u);
    ++count[k];
  }
  EXPECT_NEAR(sum / n, 0.5, 0.01);
  EXPECT_NEAR(square / n, 1.0 / 3, 0.01);
  EXPECT_NEAR(normal / n, 0, 0.03);
  EXPECT_NEAR(normal2 / n, 1, 0.05);
  EXPECT_LT((mean / n).norm(), 0.03);
  for (const int c : count) EXPECT_NEAR(c, n / 7.0, 250);
}

TEST(Parallel, EveryItemOnce) {
  std::vector<std::atomic<int>> visits(1003);
  parallel_for(visits.size(), 17, [&](std::size_t i) { ++visits[i]; });
  for (const auto& v : visits) EXPECT_EQ(v, 1);
  parallel_for(0, 17, [&](std::size_t) { FAIL(); });
}

TEST(Parallel, ReductionIsTheSameBytesAtAnyThreadCount) {
  const auto sum = [] {
    return parallel_reduce(
        std::size_t{100000}, 100, 0.0,
        [](std::size_t begin, std::size_t end) {
          double s = 0;
          for (std::size_t i = begin; i < end; ++i) s += std::sin(static_cast<double>(i)) / 3;
          return s;
        },
        [](double a, double b) { return a + b; });
  };
  double one, two;
  {
    const ThreadLimit limit(1);
    EXPECT_EQ(thread_count(), 1);
    one = sum();
  }
  {
    const ThreadLimit limit(2);
    two = sum();
  }
  EXPECT_EQ(one, two);
  EXPECT_EQ(one, sum());
}

TEST(Parallel, ReductionFoldsInBlockOrder) {
  const std::string text = parallel_reduce(
      std::size_t{10}, 3, std::string(),
      [](std::size_t begin, std::size_t end) {
        return "[" + std::to_string(begin) + "," + std::to_string(end) + ")";
      },
      [](std::string a, const std::string& b) { return a + b; });
  EXPECT_EQ(text, "[0,3)[3,6)[6,9)[9,10)");
}

TEST(Parallel, ExceptionsComeOut) {
  EXPECT_THROW(parallel_for(1000, 10,
                            [](std::size_t i) {
                              if (i == 777) throw SolveError("seven");
                            }),
               SolveError);
}

TEST(Error, IsOneLineWithWhereWhatRemedy) {
  const InputError error("bad\nline", "a.obj:3", "fix\r\nit");
  EXPECT_STREQ(error.what(), "a.obj:3: bad line (fix  it)");
  EXPECT_EQ(error.where(), "a.obj:3");
  EXPECT_EQ(error.message(), "bad\nline");
  EXPECT_STREQ(DomainError("no inside").what(), "no inside");
  EXPECT_STREQ(IoError("full", "out.npz").what(), "out.npz: full");
}

TEST(Progress, ReportsAndCancels) {
  std::vector<std::pair<std::string, double>> seen;
  Progress progress;
  progress("ignored", 0);
  EXPECT_NO_THROW(progress.check());
  progress.report = [&](std::string_view stage, double f) { seen.emplace_back(stage, f); };
  progress("solve", 0.5);
  EXPECT_EQ(seen, (std::vector<std::pair<std::string, double>>{{"solve", 0.5}}));
  progress.cancelled = [] { return true; };
  EXPECT_THROW(progress.check(), Cancelled);
}

}  // namespace
