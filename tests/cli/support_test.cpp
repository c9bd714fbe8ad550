// The harness that every other test of the program stands on.
#include "cli/support.h"

#include <gtest/gtest.h>

namespace skinfield_test {
namespace {

RunResult shell(const std::string& script, RunOptions options = {}) {
  options.program = "/bin/sh";
  return run({"-c", script}, options);
}

TEST(Support, KeepsTheStreamsApartAndTheExitCode) {
  const RunResult result = shell("echo data; echo message >&2; exit 5");
  EXPECT_EQ(result.code, 5);
  EXPECT_EQ(result.out, "data\n");
  EXPECT_EQ(result.err, "message\n");
}

TEST(Support, RunsInTheFolderItIsGivenWithEmptyInput) {
  const TemporaryFolder folder;
  RunOptions options;
  options.folder = folder.path().string();
  EXPECT_EQ(shell("cat; pwd -P > here", options).out, "");
  EXPECT_EQ(read_file(folder / "here"), std::filesystem::canonical(folder.path()).string() + "\n");
}

TEST(Support, InterruptsAsAUserWould) {
  RunOptions options;
  options.interrupt_after_ms = 50;
  const RunResult result = shell("trap 'exit 130' INT; while :; do sleep 0.02; done", options);
  EXPECT_EQ(result.code, 130);
}

TEST(Support, RemovesItsFolder) {
  std::filesystem::path path;
  {
    const TemporaryFolder folder;
    path = folder.path();
    write_file(folder / "file", "text");
    EXPECT_EQ(read_file(folder / "file"), "text");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Support, SplitsLines) {
  EXPECT_EQ(lines("a\n\nb"), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_TRUE(lines("").empty());
}

}  // namespace
}  // namespace skinfield_test
