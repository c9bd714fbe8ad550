#include "domain/shielded.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>

namespace skinfield {
namespace {

constexpr char kReturned = 'R';
constexpr char kThrew = 'T';
constexpr int kPollMilliseconds = 50;
constexpr double kMostMemory = 8e9;  // bytes that the child may take beside what it was born with

void write_all(int to, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(to, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(EXIT_FAILURE);
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
}

/// Runaway work should end by itself, without filling the machine or leaving core files.
void limit_resources(double time_limit_s) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // Should the parent die, the child still ends.
  const auto seconds = static_cast<rlim_t>(time_limit_s) + 2;
  const rlimit cpu{seconds, seconds};
  setrlimit(RLIMIT_CPU, &cpu);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // Sanitizers reserve terabytes of addresses.
  double pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  if (pages > 0) {
    const double now = pages * static_cast<double>(sysconf(_SC_PAGESIZE));
    const auto bytes = static_cast<rlim_t>(now + kMostMemory);
    const rlimit memory{bytes, bytes};
    setrlimit(RLIMIT_AS, &memory);
  }
#endif
}

[[noreturn]] void be_the_child(const std::function<std::string()>& work, double time_limit_s,
                               int to) {
  for (const int s : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGPIPE}) {
    std::signal(s, SIG_DFL);
  }
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  limit_resources(time_limit_s);
  std::string bytes;
  char mark = kThrew;
  try {
    bytes = work();
    mark = kReturned;
  } catch (const std::exception& error) {
    bytes = error.what();
  } catch (...) {
    bytes = "an unknown exception";
  }
  write_all(to, &mark, 1);
  write_all(to, bytes.data(), bytes.size());
  _exit(EXIT_SUCCESS);  // no destructor of the parent's may run here
}

/// A child and the end of the pipe it writes to; ended and reaped whatever happens.
class Child {
 public:
  Child(pid_t pid, int from) : pid_(pid), from_(from) {}
  ~Child() {
    close(from_);
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int from() const { return from_; }
  int wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_;
  int from_;
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

Shielded run_shielded(const std::function<std::string()>& work, double time_limit_s,
                      const Progress& progress) {
  Shielded result;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    result.why = std::string("no pipe: ") + std::strerror(errno);
    return result;
  }
  const pid_t pid = fork();
  if (pid < 0) {
    close(ends[0]);
    close(ends[1]);
    result.why = std::string("no child process: ") + std::strerror(errno);
    return result;
  }
  if (pid == 0) {
    close(ends[0]);
    be_the_child(work, time_limit_s, ends[1]);
  }
  close(ends[1]);
  Child child(pid, ends[0]);
  const auto start = std::chrono::steady_clock::now();
  std::string bytes;
  std::array<char, 1 << 16> buffer{};
  while (true) {
    progress.check();
    const double past =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (past > time_limit_s) {
      result.why = "took longer than " + std::to_string(static_cast<int>(time_limit_s)) + " s";
      return result;
    }
    pollfd waiting{child.from(), POLLIN, 0};
    if (poll(&waiting, 1, kPollMilliseconds) <= 0) continue;
    const ssize_t count = read(child.from(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    bytes.append(buffer.data(), static_cast<std::size_t>(count));
  }
  const int status = child.wait();
  if (WIFSIGNALED(status)) {
    result.why = std::string("crashed (") + strsignal(WTERMSIG(status)) + ")";
  } else if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_SUCCESS || bytes.empty()) {
    result.why = "gave up without a result";
  } else if (bytes[0] == kThrew) {
    result.why = first_line(bytes.substr(1));
  } else {
    result.good = true;
    result.bytes = bytes.substr(1);
  }
  return result;
}

}  // namespace skinfield
