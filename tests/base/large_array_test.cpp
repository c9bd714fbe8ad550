#include "base/large_array.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace skinfield {
namespace {

TEST(LargeArray, HoldsSmallAndLargeSizes) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{1000}, std::size_t{3} << 20}) {
    LargeArray<double> array;
    double* values = array.resize(size);
    ASSERT_NE(values, nullptr);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(values) % 64, 0U);
    for (std::size_t i = 0; i < size; ++i) values[i] = static_cast<double>(i);
    EXPECT_EQ(array.data()[size - 1], static_cast<double>(size - 1));
  }
}

TEST(LargeArray, KeepsItsMemoryWhileThatIsEnough) {
  LargeArray<float> array;
  EXPECT_EQ(array.data(), nullptr);
  float* first = array.resize(100);
  first[7] = 3;
  EXPECT_EQ(array.resize(50), first);
  EXPECT_EQ(array.resize(100), first);
  EXPECT_EQ(array.data()[7], 3);
  array.release();
  EXPECT_EQ(array.data(), nullptr);
  EXPECT_NE(array.resize(1), nullptr);
}

TEST(LargeArray, Moves) {
  LargeArray<float> from;
  float* memory = from.resize(10);
  LargeArray<float> to = std::move(from);
  EXPECT_EQ(to.data(), memory);
  EXPECT_NE(from.resize(5), memory);  // NOLINT(bugprone-use-after-move): empty, and as good as new
  from = std::move(to);
  EXPECT_EQ(from.data(), memory);
}

}  // namespace
}  // namespace skinfield
