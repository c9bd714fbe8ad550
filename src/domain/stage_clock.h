// Seconds of consecutive stages, for the report.
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace skinfield {

class StageClock {
 public:
  explicit StageClock(std::map<std::string, double>& seconds) : seconds_(seconds) {}
  /// Adds the time since the last lap to `stage`.
  void lap(const std::string& stage) {
    const auto now = Clock::now();
    seconds_[stage] += std::chrono::duration<double>(now - start_).count();
    start_ = now;
  }
  /// Leaves out the time since the last lap: another clock counts it.
  void restart() { start_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  std::map<std::string, double>& seconds_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace skinfield
