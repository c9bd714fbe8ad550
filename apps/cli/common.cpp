#include "cli.h"

#include "skinfield/bind/handles.h"
#include "skinfield/io/file.h"
#include "skinfield/io/io.h"
#include "skinfield/io/weights_file.h"

#include <fmt/core.h>

#include <unistd.h>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <set>

namespace skinfield::cli {
namespace {

// A signal handler can reach nothing but a global; it lives here alone.
std::atomic<bool> interrupted{false};

extern "C" void on_interrupt(int) { interrupted = true; }

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::string part;
  for (char c : list + ",")
    if (c == ',') {
      if (!part.empty()) parts.push_back(part);
      part.clear();
    } else {
      part += c;
    }
  return parts;
}

}  // namespace

CLI::App* new_verb(CLI::App& app, Common& common, const std::string& name,
                   const std::string& description, const std::string& example) {
  CLI::App* verb = app.add_subcommand(name, description);
  verb->footer("Example: " + example);
  verb->add_flag("--quiet", common.quiet, "No progress, no notes");
  verb->add_flag("--verbose", common.verbose, "Say more on stderr");
  verb->add_option("--threads", common.threads, "Threads to use (0: all)")->check(number(0, 4096));
  return verb;
}

Progress make_progress(const Common& common) {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  Progress progress;
  progress.cancelled = [] { return interrupted.load(std::memory_order_relaxed); };
  if (common.quiet || isatty(STDERR_FILENO) == 0) return progress;
  auto last = std::make_shared<std::string>();
  progress.report = [last](std::string_view stage, double fraction) {
    std::string line = fmt::format("{} {:3.0f}%", stage, 100 * fraction);
    if (line == *last) return;
    *last = line;
    fmt::print(stderr, "\r\x1b[K{}", line);
    std::fflush(stderr);
  };
  return progress;
}

void note(const Common& common, const std::string& line) {
  if (common.quiet) return;
  fmt::print(stderr, "{}{}\n", isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "", line);
}

void warn(const std::string& line) { fmt::print(stderr, "warning: {}\n", line); }

CLI::Validator number(double least, double most) {
  const std::string wanted = most < 1e300 ? fmt::format("a number from {:g} to {:g}", least, most)
                                          : fmt::format("a number from {:g} up", least);
  return {[least, most, wanted](const std::string& text) -> std::string {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            const bool good = !text.empty() && *end == 0 && std::isfinite(value) &&
                              value >= least && value <= most;
            return good ? "" : text + " is not " + wanted;
          },
          {}};
}

void check_outputs(const std::vector<std::string>& paths) {
  std::set<std::filesystem::path> seen;
  for (const std::string& path : paths) {
    if (path.empty()) continue;
    if (!seen.insert(std::filesystem::path(path).lexically_normal()).second)
      throw UsageError(path + ": is named for two outputs (give each its own name)");
    check_writable(path);
  }
}

std::string link_profile() {
#ifdef SKINFIELD_PROFILE_FULL
  return "full (links TetGen, AGPL; CGAL and CHOLMOD, GPL)";
#else
  return "permissive (no GPL parts)";
#endif
}

void SkeletonOptions::add_to(CLI::App& verb) {
  verb.add_option("--skeleton", skeleton, "Bones: a TGF file, or any glTF with joints");
  verb.add_option("--joints", joints, "Which joints deform: auto, all, used, or GLOB,GLOB,...")
      ->capture_default_str();
  verb.add_option("--exclude", exclude, "Joints that never deform: GLOB,GLOB,...");
  verb.add_option("--leaf", leaf, "What a leaf joint owns")
      ->check(CLI::IsMember({"extend", "point"}))
      ->capture_default_str();
  verb.add_option("--up", up, "Up axis of OBJ, PLY, OFF, STL and tet files")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  verb.add_option("--scale", scale, "Factor on the units of those files")
      ->check(number(1e-12, 1e12))
      ->capture_default_str();
  verb.add_option("--only", only, "Only the mesh or object of this name");
}

JointOptions SkeletonOptions::joint_options() const {
  JointOptions options;
  if (joints == "auto") {
    options.which = JointOptions::Which::automatic;
  } else if (joints == "all") {
    options.which = JointOptions::Which::all;
  } else if (joints == "used") {
    options.which = JointOptions::Which::used;
  } else {
    options.which = JointOptions::Which::match;
    options.patterns = split(joints);
  }
  options.exclude = split(exclude);
  options.leaf = leaf == "point" ? JointOptions::Leaf::point : JointOptions::Leaf::extend;
  return options;
}

void add_regions_option(CLI::App& verb, std::string& path) {
  verb.add_option("--regions", path,
                  "Sets of vertices as handles, behind the bones: a matrix (.npz .npy .dmat .csv "
                  ".mtx) with a column each, a row a vertex, 1 where it belongs, else 0");
}

void read_regions(const std::string& path, Character& character) {
  const SkinWeights regions = read_weights(path);
  try {
    add_regions(character, regions);
  } catch (const InputError& error) {
    throw InputError(error.message(), path, error.remedy());
  }
}

Asset read_characters(const std::string& path, const SkeletonOptions& options,
                      bool skeleton_needed) {
  const ReadOptions read{.up = options.up == "z" ? Up::z : Up::y, .scale = options.scale};
  Asset asset = read_asset(path, read);
  if (!options.only.empty()) keep_only(asset, options.only);
  if (!options.skeleton.empty()) {
    const Skeleton skeleton = read_skeleton(options.skeleton, read);
    for (Character& character : asset.characters) give_skeleton(character, skeleton);
  }
  for (Character& character : asset.characters) {
    if (character.skeleton.joints.empty()) {
      if (skeleton_needed)
        throw InputError("the file has no bones", path, "give --skeleton FILE (TGF or glTF)");
      continue;
    }
    try {
      make_handles(character, options.joint_options());
    } catch (const InputError& error) {
      throw InputError(error.message(), options.skeleton.empty() ? path : options.skeleton,
                       error.remedy());
    }
  }
  return asset;
}

}  // namespace skinfield::cli
