// Whole files in and out. Outputs appear complete or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace skinfield {

/// The bytes of a file. Throws InputError where it is missing, a folder or unreadable.
std::string read_file(const std::filesystem::path& path);

/// Writes `bytes` beside `path` and renames, so that no half-written file is ever seen and an
/// existing one survives a failure. A path that names a device or pipe is written directly.
/// Throws IoError (folder missing, read-only, disk full) and leaves nothing behind.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// The extension in lower case with its dot, or "".
std::string lower_extension(const std::filesystem::path& path);

}  // namespace skinfield
