#include "cli.h"

#include "skinfield/base/parallel.h"

#include <fmt/core.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

namespace {

using namespace skinfield;
using namespace skinfield::cli;

std::string version_text() {
  return "skinfield " SKINFIELD_VERSION "\nprofile: " + link_profile() +
         "\nlicence: MIT; linked: Eigen (MPL-2.0), Embree and oneTBB (Apache-2.0), nlohmann/json "
         "and fmt "
         "(MIT),\nCLI11 (BSD-3-Clause), nanoflann (BSD-2-Clause), libpng, zlib; see LICENSES.md";
}

int run(int argc, char** argv) {
  CLI::App app{"Skinning weights for 3D characters: any mesh in, valid weights out.", "skinfield"};
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(
      "Example: skinfield bind hero.glb -o hero-bound.glb\n"
      "Exit codes: 0 done, 1 internal error, 2 usage, 3 bad input, 4 cannot be solved,\n"
      "5 cannot write, 130 interrupted");
  Common common;
  std::vector<std::pair<CLI::App*, Verb>> verbs;
  add_bind(app, common, verbs);
  add_inspect(app, common, verbs);
  add_pose(app, common, verbs);
  add_render(app, common, verbs);
  add_compare(app, common, verbs);
  add_transfer(app, common, verbs);
  add_interpolate(app, common, verbs);
  add_tetrahedralise(app, common, verbs);
  add_sample(app, common, verbs);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::string line = error.what();
    for (char& c : line)
      if (c == '\n') c = ' ';
    fmt::print(stderr, "skinfield: {} (see skinfield --help)\n", line);
    return exit_usage;
  }
  const ThreadLimit limit(common.threads);
  for (const auto& [verb, action] : verbs)
    if (verb->parsed()) action();
  return exit_done;
}

}  // namespace

int main(int argc, char** argv) {
  const auto failed = [](const char* message, int code) {
    fmt::print(stderr, "skinfield: {}\n", message);
    return code;
  };
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    return failed(error.what(), exit_usage);
  } catch (const InputError& error) {
    return failed(error.what(), exit_input);
  } catch (const DomainError& error) {
    return failed(error.what(), exit_unsolvable);
  } catch (const SolveError& error) {
    return failed(error.what(), exit_unsolvable);
  } catch (const IoError& error) {
    return failed(error.what(), exit_output);
  } catch (const Cancelled& error) {
    return failed(error.what(), exit_interrupted);
  } catch (const std::bad_alloc&) {
    return failed("out of memory (use fewer nodes or a smaller mesh)", exit_unsolvable);
  } catch (const std::exception& error) {
    return failed(error.what(), exit_internal);
  }
}
