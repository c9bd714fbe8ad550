// What `bind` is asked for on the command line, and what that means to the library.
#pragma once

#include "cli.h"

#include "skinfield/bind/bind.h"

#include <map>
#include <set>

namespace skinfield::cli {

struct BindArguments {
  std::string input, output, method = "auto", solver = "auto", domain = "auto";
  std::string mass = "barycentric";
  std::string quality = "normal", symmetry = "off";
  std::string regions, paint, weights_in, lock, report, weights_out, boundary, save_field, resume,
      tensors, visibility;
  SkeletonOptions skeleton;
  int nodes = 0, iterations = 0, max_influences = -1, levels = 0, samples_per_step = 0;
  double tolerance = 0, time_limit = 0, prune = -1;
  double kernel_width = 0, difference_step = 0, rows_per_point = 0, judge_step = 0;
  std::uint64_t seed = 0;
  std::set<std::string> given;  ///< names of the options on the command line
};

bool is_gltf(const std::string& path);
/// Throws UsageError unless bind writes such files.
void check_output(const std::string& path);

const MethodFacts& chosen_method(const BindArguments& o);
std::vector<std::string> method_names();
std::set<std::string> solver_names();
std::string method_help();
std::string solver_help();
std::string tolerance_help();

/// Throws UsageError for options that the method has no use for: they are not ignored.
void check_method_options(const BindArguments& o);
BindOptions bind_options(const BindArguments& o);
/// For the report: as given or defaulted.
std::map<std::string, std::string> described(const BindArguments& o, const BindOptions& b);

}  // namespace skinfield::cli
