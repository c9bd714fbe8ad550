// What the verbs of the command line share. Thin: parse, call, print.
#pragma once

#include "skinfield/base/progress.h"
#include "skinfield/io/asset.h"
#include "skinfield/rig/handles.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skinfield::cli {

enum ExitCode {
  exit_done = 0,
  exit_internal = 1,
  exit_usage = 2,
  exit_input = 3,
  exit_unsolvable = 4,
  exit_output = 5,
  exit_interrupted = 130,
};

/// A wrong combination of options (exit code 2).
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Options that every verb takes.
struct Common {
  bool quiet = false, verbose = false, json = false;
  int threads = 0;
};

/// Adds a verb's options to `app` and returns what runs it.
using Verb = std::function<void()>;
void add_bind(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_inspect(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_pose(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_render(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_compare(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_transfer(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_interpolate(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_sample(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs);
void add_tetrahedralise(CLI::App& app, Common& common,
                        std::vector<std::pair<CLI::App*, Verb>>& verbs);

/// The options of a verb with the common ones added.
CLI::App* new_verb(CLI::App& app, Common& common, const std::string& name,
                   const std::string& description, const std::string& example);

/// Progress on a terminal's stderr, and Ctrl-C.
Progress make_progress(const Common& common);
void note(const Common& common, const std::string& line);
void warn(const std::string& line);

/// Accepts finite numbers from `least` to `most`; their names in the message, such as "a number
/// from 0 to 1".
CLI::Validator number(double least, double most);
/// Refuses outputs that cannot be written (exit code 5), before anything is computed. Empty paths
/// are passed over; the same path twice is a usage error.
void check_outputs(const std::vector<std::string>& paths);
std::string link_profile();

/// How a character's skeleton is found and which joints deform.
struct SkeletonOptions {
  std::string skeleton, joints = "auto", exclude, leaf = "extend", up = "y", only;
  double scale = 1;
  void add_to(CLI::App& verb);
  JointOptions joint_options() const;
};

/// --regions.
void add_regions_option(CLI::App& verb, std::string& path);
/// Sets of vertices as handles behind those that the character has; messages name the file.
void read_regions(const std::string& path, Character& character);

/// Reads a character file with its skeleton from the file itself or from --skeleton, and makes
/// the handles.
Asset read_characters(const std::string& path, const SkeletonOptions& options,
                      bool skeleton_needed = true);

}  // namespace skinfield::cli
