#include "domain/shielded.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace skinfield {
namespace {

TEST(Shielded, BringsBytesBack) {
  std::string long_one(3 << 20, 'x');
  long_one[5] = '\0';
  const Shielded result = run_shielded([&] { return long_one; }, 60, {});
  EXPECT_TRUE(result.good) << result.why;
  EXPECT_EQ(result.bytes, long_one);
  EXPECT_TRUE(run_shielded([] { return std::string(); }, 60, {}).good);
}

TEST(Shielded, SurvivesWhateverTheWorkDoes) {
  const auto why = [](const std::function<std::string()>& work) {
    const Shielded result = run_shielded(work, 60, {});
    EXPECT_FALSE(result.good);
    EXPECT_TRUE(result.bytes.empty());
    return result.why;
  };
  EXPECT_EQ(why([]() -> std::string { throw std::runtime_error("first\nsecond"); }), "first");
  EXPECT_EQ(why([]() -> std::string { throw 3; }), "an unknown exception");
  EXPECT_NE(why([]() -> std::string { std::abort(); }).find("crashed"), std::string::npos);
  EXPECT_NE(why([]() -> std::string {
              raise(SIGKILL);
              return {};
            }).find("crashed"),
            std::string::npos);
  EXPECT_EQ(why([]() -> std::string { _exit(3); }), "gave up without a result");
  EXPECT_EQ(why([]() -> std::string { _exit(0); }), "gave up without a result");
}

TEST(Shielded, EndsWorkThatTakesTooLong) {
  const auto start = std::chrono::steady_clock::now();
  const Shielded result = run_shielded(
      []() -> std::string {
        while (true) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      },
      0.3, {});
  EXPECT_FALSE(result.good);
  EXPECT_NE(result.why.find("took longer"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Shielded, StopsWhenItIsAskedTo) {
  std::atomic<int> asked{0};
  Progress progress;
  progress.cancelled = [&] { return ++asked > 2; };
  EXPECT_THROW(run_shielded(
                   []() -> std::string {
                     while (true) std::this_thread::sleep_for(std::chrono::milliseconds(5));
                   },
                   60, progress),
               Cancelled);
}

TEST(Shielded, TheWorkIsSilent) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const Shielded result = run_shielded(
      [] {
        std::puts("noise");
        std::fputs("noise", stderr);
        std::fflush(nullptr);
        return std::string("done");
      },
      60, {});
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(result.bytes, "done");
}

}  // namespace
}  // namespace skinfield
