// Where the shared test data is, if it is there at all: SKINFIELD_DATA, else ../shared/data.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace skinfield_test {

inline std::optional<std::filesystem::path> data(const std::string& relative) {
  const char* given = std::getenv("SKINFIELD_DATA");
  const std::filesystem::path root =
      given ? std::filesystem::path(given)
            : std::filesystem::path(SKINFIELD_SOURCE_DIR) / ".." / "shared" / "data";
  std::error_code ignored;
  if (!std::filesystem::exists(root / relative, ignored)) return std::nullopt;
  return root / relative;
}

}  // namespace skinfield_test

/// Skips a test, with a line that says why, where the shared data is absent.
#define SKINFIELD_NEEDS_DATA(variable, relative)                               \
  const auto variable##_found = skinfield_test::data(relative);                \
  if (!variable##_found) GTEST_SKIP() << "shared data absent: " << (relative); \
  const std::filesystem::path variable = *variable##_found
