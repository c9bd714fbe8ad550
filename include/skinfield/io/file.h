// Whole files in and out. Outputs appear complete or not at all.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace skinfield {

/// The bytes of a file. Throws InputError where it is missing, a folder or unreadable.
std::string read_file(const std::filesystem::path& path);

/// Writes `bytes` beside `path` and renames, so that no half-written file is ever seen and an
/// existing one survives a failure. A path that names a device or pipe is written directly.
/// Throws IoError (folder missing, read-only, disk full) and leaves nothing behind.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

struct OutputFile {
  std::filesystem::path path;
  std::string bytes;
};

/// The same for files that belong together: all of them appear, or none. (Should renaming fail
/// after the first, which only a change of the folder in that moment can bring, the first stay.)
void write_files_atomically(std::span<const OutputFile> files);

/// Throws the IoError that writing there would, but for a full disk: so that a long computation
/// does not end in one. Leaves nothing behind.
void check_writable(const std::filesystem::path& path);

/// The extension in lower case with its dot, or "".
std::string lower_extension(const std::filesystem::path& path);

}  // namespace skinfield
