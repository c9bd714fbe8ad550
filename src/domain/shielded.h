// Work that may crash, abort, exit or never end, done in a child process.
#pragma once

#include "skinfield/base/progress.h"

#include <functional>
#include <string>

namespace skinfield {

struct Shielded {
  bool good = false;
  std::string bytes;  ///< what the work returned
  std::string why;    ///< if not good: one line
};

/// Forks, runs `work` in the child with its output silenced, and brings its bytes back. The child
/// has one thread: the work must not use parallel loops. What it throws, a crash, an exit and the
/// end of `time_limit_s` all come back as not good.
/// @throws Cancelled (the child is ended)
Shielded run_shielded(const std::function<std::string()>& work, double time_limit_s,
                      const Progress& progress);

}  // namespace skinfield
