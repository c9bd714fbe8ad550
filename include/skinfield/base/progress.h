// Progress and cancellation are callbacks: the library has no globals and never prints.
#pragma once

#include "skinfield/base/error.h"

#include <functional>
#include <string_view>

namespace skinfield {

struct Progress {
  /// Called now and then from the calling thread; fraction in [0,1] within the stage.
  std::function<void(std::string_view stage, double fraction)> report;
  /// Polled often, possibly from worker threads; true asks the library to stop.
  std::function<bool()> cancelled;

  void operator()(std::string_view stage, double fraction) const {
    if (report) report(stage, fraction);
  }
  /// Throws Cancelled if the caller asked to stop.
  void check() const {
    if (cancelled && cancelled()) throw Cancelled();
  }
};

}  // namespace skinfield
