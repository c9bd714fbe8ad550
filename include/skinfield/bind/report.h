// The report of a bind, schema 1 (design.md 6): everything an artist or a script wants to know.
#pragma once

#include "skinfield/bind/bind.h"

#include <string>

namespace skinfield {

/// What the report says about the run besides the result.
struct ReportContext {
  std::string input_path, output_path, profile;
  Method method = Method::bounded_biharmonic;
  int threads = 0;
  std::int64_t peak_memory_bytes = 0;
  double total_s = 0, total_cpu_s = 0;
  std::map<std::string, std::string> options;  ///< as given or defaulted
  std::uint64_t seed = 0;
};

/// Indented JSON.
std::string report_json(const std::vector<BindReport>& characters, const ReportContext& context);

/// Largest resident set so far, and processor seconds so far, of this process.
std::int64_t peak_memory_bytes();
double process_cpu_seconds();

}  // namespace skinfield
