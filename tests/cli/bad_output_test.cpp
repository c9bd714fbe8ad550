// Wrong options are exit code 2, outputs that cannot be written 5, an interrupt 130; always one
// line, and never half a file.
#include "cli/characters.h"

#include <unistd.h>

namespace skinfield_test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double prompt_s = 20;  // sanitizers slow every step down
#else
constexpr double prompt_s = 2;
#endif

std::vector<std::string> bind_box(const std::vector<std::string>& more) {
  std::vector<std::string> all{"bind", "box.obj", "--skeleton", "box.tgf", "--nodes", "100"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(BadUsage, OptionsAndValues) {
  const BoxFolder folder;
  expect_refused(folder, {}, 2, {"--help"});
  expect_refused(folder, {"fly"}, 2, {"--help"});
  expect_refused(folder, {"bind"}, 2, {"required"});
  expect_refused(folder, {"bind", "box.obj"}, 2, {"--output"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--nope"}), 2, {"--nope"});
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"--quality", "best"},   {"--method", "magic"},      {"--domain", "cubes"},
      {"--leaf", "long"},      {"--symmetry", "y"},        {"--up", "x"},
      {"--nodes", "ten"},      {"--nodes", "-5"},          {"--tolerance", "nan"},
      {"--tolerance", "0"},    {"--scale", "0"},           {"--scale", "inf"},
      {"--time-limit", "inf"}, {"--seed", "-1"},           {"--prune", "2"},
      {"--iterations", "0"},   {"--max-influences", "-1"}, {"--threads", "many"}};
  for (const auto& [option, value] : wrong)
    expect_refused(folder, {"bind", "box.obj", "-o", "out.glb", option, value}, 2, {option, value});
  expect_refused(folder, {"sample", "unicorn", "-o", "out.glb"}, 2, {"unicorn", "gecko"});
  expect_refused(folder, {"sample", "gecko", "--triangles", "-5", "-o", "out.glb"}, 2, {"-5"});
  expect_refused(folder, {"render", "box.obj", "--yaw", "nan", "-o", "out.png"}, 2,
                 {"--yaw", "nan"});
}

TEST(BadUsage, OutputNames) {
  const BoxFolder folder;
  expect_refused(folder, bind_box({"-o", "out.xyz"}), 2, {"out.xyz", ".glb"});
  expect_refused(folder, bind_box({"-o", "out"}), 2, {"out: unknown output format"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--weights", "w.txt"}), 2, {"w.txt", ".npz"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--weights", "w.glb"}), 2, {"w.glb", ".npz"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--report", "./out.glb"}), 2, {"two outputs"});
  expect_refused(folder, {"render", "box.obj", "-o", "out.jpg"}, 2, {"out.jpg", ".png"});
  expect_refused(folder, {"pose", "box.obj", "-o", "out.fbx"}, 2, {"out.fbx", ".obj"});
  expect_refused(folder, {"sample", "gecko", "-o", "out.obj"}, 2, {"out.obj", ".glb"});
  expect_refused(folder, {"transfer", "box.obj", "box.obj", "-o", "out.txt"}, 2,
                 {"out.txt", ".npz"});
}

TEST(BadUsage, Locks) {
  const BoxFolder folder;
  expect_refused(folder, bind_box({"-o", "out.glb", "--lock", "*"}), 2, {"--lock", "--weights-in"});
  expect_runs(folder, bind_box({"-o", "w.npz", "--quiet"}));
  expect_refused(folder, bind_box({"-o", "out.glb", "--weights-in", "w.npz", "--lock", "hat*"}), 2,
                 {"--lock hat*", "no handle"});
}

TEST(BadOutput, FolderMissing) {
  const BoxFolder folder;
  expect_refused(folder, bind_box({"-o", "none/out.glb"}), 5, {"none/out.glb", "does not exist"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--report", "none/r.json"}), 5,
                 {"none/r.json"});
  expect_refused(folder, bind_box({"-o", "out.glb", "--weights", "none/w.npz"}), 5, {"none/w.npz"});
  expect_refused(folder, {"sample", "gecko", "-o", "none/out.glb"}, 5, {"none/out.glb"});
  expect_refused(folder, {"render", "box.obj", "-o", "none/out.png"}, 5, {"none/out.png"});
  expect_refused(folder, {"pose", "box.obj", "-o", "none/out.obj"}, 5, {"none/out.obj"});
  std::filesystem::create_directory(folder / "folder.glb");
  expect_refused(folder, bind_box({"-o", "folder.glb"}), 5, {"folder.glb: is a folder"});
}

TEST(BadOutput, DeviceFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const BoxFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.glb");
  expect_refused(folder, bind_box({"-o", "full.glb"}), 5,
                 {"full.glb", "No space left", "free some"});
  // The report fails, so the weights do not appear either.
  expect_refused(folder, bind_box({"-o", "out.glb", "--report", "full.glb"}), 5, {"No space left"});
}

/// Runs the program where `disk` in the folder is a file system of 64 kB with out.glb in it, which
/// only this run sees; stdout lists what lies there in the end. Code 125: not allowed here.
RunResult run_on_small_disk(const BoxFolder& folder, const std::string& options,
                            const std::vector<std::string>& arguments) {
  std::filesystem::create_directory(folder / "disk");
  RunOptions run_options;
  run_options.folder = folder.path().string();
  run_options.program = "/usr/bin/env";
  std::vector<std::string> all{
      "unshare",
      "-rm",
      "sh",
      "-c",
      "mount -t tmpfs -o size=64k none disk 2>/dev/null && cp out.glb disk || exit 125\n"
      "[ -z \"$0\" ] || mount -o \"remount,$0\" disk 2>/dev/null || exit 125\n"
      "\"$@\"; code=$?; ls -A disk; cat disk/out.glb; exit $code",
      options,
      SKINFIELD_PROGRAM};
  all.insert(all.end(), arguments.begin(), arguments.end());
  RunResult result = run(all, run_options);
  if (result.code == 1 && result.err.find("unshare") != std::string::npos) result.code = 125;
  if (result.code == 127) result.code = 125;
  return result;
}

TEST(BadOutput, DiskFull) {
  const BoxFolder folder;
  const RunResult result =
      run_on_small_disk(folder, "", {"sample", "gecko", "--quiet", "-o", "disk/out.glb"});
  if (result.code == 125) GTEST_SKIP() << "may not mount a small disk here";
  EXPECT_EQ(result.code, 5);
  EXPECT_EQ(result.out, "out.glb\nprecious");
  ASSERT_EQ(lines(result.err).size(), 1U) << result.err;
  EXPECT_NE(result.err.find("disk/out.glb: cannot write the file: No space left"),
            std::string::npos)
      << result.err;
}

TEST(BadOutput, ReadOnlyDisk) {
  const BoxFolder folder;
  const RunResult result = run_on_small_disk(folder, "ro", bind_box({"-o", "disk/out.glb"}));
  if (result.code == 125) GTEST_SKIP() << "may not mount a small disk here";
  EXPECT_EQ(result.code, 5);
  EXPECT_EQ(result.out, "out.glb\nprecious");
  ASSERT_EQ(lines(result.err).size(), 1U) << result.err;
  EXPECT_NE(result.err.find("disk/out.glb"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("may write to"), std::string::npos) << result.err;
}

TEST(BadOutput, FolderWithoutPermission) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const BoxFolder folder;
  std::filesystem::create_directory(folder / "locked");
  std::filesystem::permissions(folder / "locked", std::filesystem::perms(0555));
  expect_refused(folder, bind_box({"-o", "locked/out.glb"}), 5, {"locked/out.glb", "may write to"});
}

TEST(Interrupt, EndsAtEveryStageWithoutAFile) {
  const TemporaryFolder folder;
  expect_runs(folder, {"sample", "gecko", "--triangles", "60000", "-o", "gecko.glb"});
  write_file(folder / "out.glb", "precious");
  const auto before = contents(folder);
  for (const int after_ms : {20, 150, 600, 1500, 3000}) {
    RunOptions options;
    options.folder = folder.path().string();
    options.interrupt_after_ms = after_ms;
    const auto begin = std::chrono::steady_clock::now();
    const RunResult result = run(
        {"bind", "gecko.glb", "--quality", "high", "-o", "out.glb", "--report", "r.json"}, options);
    const double late =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() -
        1e-3 * after_ms;
    EXPECT_EQ(result.code, 130) << after_ms << ": " << result.err;
    EXPECT_LT(late, prompt_s) << after_ms;
    EXPECT_LE(lines(result.err).size(), 1U) << result.err;
    EXPECT_EQ(contents(folder), before);
  }
}

}  // namespace
}  // namespace skinfield_test
