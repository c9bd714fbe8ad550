// Runs the built program as a user would: arguments in, exit code and both streams out, in a
// folder of its own that goes when the test ends.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace skinfield_test {

/// A fresh empty folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "skinfield-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a folder: " + name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, ignored);
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// A file or folder inside, as an argument.
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

struct RunResult {
  int code = -1;    ///< exit code; 128 + signal if a signal ended it
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

struct RunOptions {
  std::string folder;          ///< working directory, empty: the test's
  int interrupt_after_ms = 0;  ///< send SIGINT after so long, 0: never
  int time_limit_s = 300;      ///< kill it after so long
  std::string program = SKINFIELD_PROGRAM;
};

/// Runs the program with `arguments` (no shell: no quoting, no globbing), standard input empty.
inline RunResult run(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  const TemporaryFolder streams;
  const std::string out = streams / "out", err = streams / "err";
  std::vector<std::string> words{options.program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) {
    const int in_fd = open("/dev/null", O_RDONLY);
    const int out_fd = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err_fd = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(in_fd, 0);
    dup2(out_fd, 1);
    dup2(err_fd, 2);
    if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }

  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  bool interrupted = false;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    const auto elapsed = Clock::now() - begin;
    if (options.interrupt_after_ms > 0 && !interrupted &&
        elapsed >= std::chrono::milliseconds(options.interrupt_after_ms)) {
      kill(child, SIGINT);
      interrupted = true;
    }
    if (elapsed >= std::chrono::seconds(options.time_limit_s)) kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

  RunResult result;
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = read_file(out);
  result.err = read_file(err);
  return result;
}

/// Lines of a stream, without the last empty one.
inline std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    all.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return all;
}

/// What the Khronos validator finds in `file` that `source` (may be empty) does not have: nothing
/// is code 0, issues are code 1 and listed on `out`, code 3: the validator is not installed.
inline RunResult validate_gltf(const std::string& file, const std::string& source = {}) {
  RunOptions options;
  options.program = "/usr/bin/env";
  std::vector<std::string> arguments{
      "node", std::string(SKINFIELD_SOURCE_DIR) + "/tools/gltf_validate.js", file};
  if (!source.empty()) arguments.push_back(source);
  RunResult result = run(arguments, options);
  if (result.code == 127) result.code = 3;  // no node
  return result;
}

}  // namespace skinfield_test

/// Skips a test where the validator is not installed (npm could not be reached at set-up).
#define SKINFIELD_NEEDS_VALIDATOR(result) \
  if ((result).code == 3) GTEST_SKIP() << "gltf-validator is not installed (make setup)"
