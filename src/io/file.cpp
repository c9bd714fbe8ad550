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
#include <utility>
#include <vector>

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

/// A file on its way: written beside its target (straight into a device or pipe), and gone unless
/// it is committed.
class Staged {
 public:
  explicit Staged(const fs::path& path) : path_(path), target_(path) {
    std::error_code error;
    if (fs::is_symlink(path, error)) {
      const fs::path real = fs::canonical(path, error);
      if (!error) target_ = real;
    }
    status_ = fs::status(target_, error);
    if (fs::is_directory(status_)) {
      throw IoError("is a folder", path.string(), "name a file in it");
    }
    if (fs::exists(status_) && !fs::is_regular_file(status_)) return;
    const fs::path folder = target_.parent_path();
    if (!folder.empty() && !fs::is_directory(folder, error)) {
      throw IoError("the output folder does not exist", path.string(), "create it first");
    }
    temporary_ = temporary_beside(target_);
    errno = 0;
    file_ = std::fopen(temporary_.c_str(), "wbx");
    if (!file_) fail_to_write(path, errno);
  }
  ~Staged() {
    if (file_) std::fclose(file_);
    std::error_code ignored;
    if (!temporary_.empty()) fs::remove(temporary_, ignored);
  }
  Staged(const Staged&) = delete;
  Staged& operator=(const Staged&) = delete;

  void write(std::string_view bytes) {
    if (temporary_.empty()) file_ = std::fopen(target_.c_str(), "wb");
    if (!file_) fail_to_write(path_, errno);
    if (const int code = write_all(std::exchange(file_, nullptr), bytes)) {
      fail_to_write(path_, code);
    }
  }
  void commit() {
    if (temporary_.empty()) return;
    std::error_code error;
    if (fs::exists(status_)) fs::permissions(temporary_, status_.permissions(), error);
    fs::rename(temporary_, target_, error);
    if (error) fail_to_write(path_, error.value());
    temporary_.clear();
  }

 private:
  fs::path path_, target_, temporary_;
  fs::file_status status_;
  std::FILE* file_ = nullptr;
};

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
  Staged staged(path);
  staged.write(bytes);
  staged.commit();
}

void write_files_atomically(std::span<const OutputFile> files) {
  std::vector<std::unique_ptr<Staged>> all;
  for (const OutputFile& file : files) all.push_back(std::make_unique<Staged>(file.path));
  for (std::size_t i = 0; i < files.size(); ++i) all[i]->write(files[i].bytes);
  for (const auto& staged : all) staged->commit();
}

void check_writable(const fs::path& path) { const Staged staged(path); }

}  // namespace skinfield
