#include "skinfield/io/file.h"

#include "skinfield/base/error.h"

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>

namespace skinfield {
namespace fs = std::filesystem;
namespace {

std::string remedy_for(int error) {
  switch (error) {
    case ENOSPC:
      return "free some space or choose another folder";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that you may write to";
    case ENOENT:
      return "create the folder first";
    default:
      return "choose another place for the output";
  }
}

[[noreturn]] void fail_to_write(const fs::path& path, int error) {
  const std::string why = error ? std::strerror(error) : "unknown reason";
  throw IoError("cannot write the file: " + why, path.string(), remedy_for(error));
}

/// Writes and closes; 0 or the error number. Closing counts: some disks report "full" only then.
int write_all(std::FILE* file, std::string_view bytes) {
  errno = 0;
  bool good = bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  good = good && std::fflush(file) == 0;
  int error = good ? 0 : (errno ? errno : EIO);
  errno = 0;
  if (std::fclose(file) != 0 && !error) error = errno ? errno : EIO;
  return error;
}

/// A name beside the target that no other process uses (it is opened exclusively as well).
fs::path temporary_beside(const fs::path& target) {
  std::random_device device;
  std::ostringstream name;
  name << '.' << target.filename().string() << '.' << std::hex << device() << device() << ".part";
  return target.parent_path() / name.str();
}

}  // namespace

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string read_file(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) {
    throw InputError("no such file", path.string(), "check the path");
  }
  if (fs::is_directory(status)) {
    throw InputError("is a folder, not a file", path.string(), "name a file in it");
  }
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw InputError(std::string("cannot be opened: ") + std::strerror(errno), path.string(),
                     "check its permissions");
  }
  std::string bytes;
  if (fs::is_regular_file(status)) {
    const auto size = fs::file_size(path, ignored);
    if (!ignored) bytes.reserve(size);
  }
  char block[1 << 16];
  while (in.read(block, sizeof block) || in.gcount() > 0) {
    bytes.append(block, static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) throw InputError("reading failed", path.string(), "check the disk");
  return bytes;
}

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  fs::path target = path;
  if (fs::is_symlink(path, error)) {
    const fs::path real = fs::canonical(path, error);
    if (!error) target = real;
  }
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) {
    throw IoError("is a folder", path.string(), "name a file in it");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    std::FILE* device = std::fopen(target.c_str(), "wb");
    if (!device) fail_to_write(path, errno);
    if (const int code = write_all(device, bytes)) fail_to_write(path, code);
    return;
  }
  const fs::path folder = target.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    throw IoError("the output folder does not exist", path.string(), "create it first");
  }
  const fs::path temporary = temporary_beside(target);
  errno = 0;
  std::FILE* file = std::fopen(temporary.c_str(), "wbx");
  if (!file) fail_to_write(path, errno);
  std::error_code ignored;
  if (const int code = write_all(file, bytes)) {
    fs::remove(temporary, ignored);
    fail_to_write(path, code);
  }
  if (fs::exists(status)) fs::permissions(temporary, status.permissions(), ignored);
  fs::rename(temporary, target, error);
  if (error) {
    fs::remove(temporary, ignored);
    fail_to_write(path, error.value());
  }
}

}  // namespace skinfield
