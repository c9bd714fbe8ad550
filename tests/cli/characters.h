// Small characters as files, and what every refusal of the program has to look like.
#pragma once

#include "cli/support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace skinfield_test {

/// A closed box of 4 x 1 x 1 with a vertex at every whole number along x, as an OBJ.
inline std::string box_obj() {
  std::string text;
  for (int x = 0; x <= 4; ++x)
    for (int k = 0; k < 4; ++k)
      text +=
          "v " + std::to_string(x) + (k == 1 || k == 2 ? " 1" : " 0") + (k >= 2 ? " 1\n" : " 0\n");
  const auto quad = [&text](int a, int b, int c, int d) {
    std::string line = "f";
    for (int i : {a, b, c, d}) line.append(" ").append(std::to_string(i));
    text += line + "\n";
  };
  for (int x = 0; x < 4; ++x)
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * x + k + 1, b = 4 * x + (k + 1) % 4 + 1;
      quad(a, b, b + 4, a + 4);
    }
  quad(4, 3, 2, 1);
  quad(17, 18, 19, 20);
  return text;
}

/// Two bones along the middle of that box.
inline std::string box_tgf() { return "1 0.5 0.5 0.5\n2 2 0.5 0.5\n3 3.5 0.5 0.5\n#\n1 2\n2 3\n"; }

/// Names and contents of everything in a folder.
inline std::map<std::string, std::string> contents(const TemporaryFolder& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    all[entry.path().string()] = entry.is_regular_file() ? read_file(entry.path()) : "";
  return all;
}

/// One line on stderr that begins with the program's name and has all the `words`, nothing on
/// stdout, that exit code, and no file made, changed or removed.
inline void expect_refused(const TemporaryFolder& folder, const std::vector<std::string>& arguments,
                           int code, const std::vector<std::string>& words) {
  const auto before = contents(folder);
  RunOptions options;
  options.folder = folder.path().string();
  const RunResult result = run(arguments, options);
  std::string command;
  for (const std::string& argument : arguments) command += argument + " ";
  SCOPED_TRACE(command + "\n" + result.err);
  EXPECT_EQ(result.code, code);
  EXPECT_EQ(result.out, "");
  ASSERT_EQ(lines(result.err).size(), 1U);
  EXPECT_TRUE(result.err.starts_with("skinfield: "));
  for (const std::string& word : words) EXPECT_NE(result.err.find(word), std::string::npos) << word;
  EXPECT_EQ(contents(folder), before);
}

/// Runs the program in `folder`; it has to succeed.
inline RunResult expect_runs(const TemporaryFolder& folder,
                             const std::vector<std::string>& arguments) {
  RunOptions options;
  options.folder = folder.path().string();
  RunResult result = run(arguments, options);
  std::string command;
  for (const std::string& argument : arguments) command += argument + " ";
  EXPECT_EQ(result.code, 0) << command << "\n" << result.err;
  return result;
}

/// The box with its skeleton, and an output that must survive what goes wrong.
struct BoxFolder : TemporaryFolder {
  BoxFolder() {
    write_file(*this / "box.obj", box_obj());
    write_file(*this / "box.tgf", box_tgf());
    write_file(*this / "out.glb", "precious");
  }
};

}  // namespace skinfield_test
