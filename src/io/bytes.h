// Reading and writing binary numbers at any alignment and byte order, bounds checked.
#pragma once

#include "skinfield/base/error.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace skinfield {

class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::string where, bool big_endian = false)
      : rest_(bytes), size_(bytes.size()), where_(std::move(where)), big_endian_(big_endian) {}

  template <class T>
  T get(const char* thing) {
    if (rest_.size() < sizeof(T)) end_of_file(thing);
    char raw[sizeof(T)];
    std::memcpy(raw, rest_.data(), sizeof(T));
    if (big_endian_ != (std::endian::native == std::endian::big))
      std::reverse(raw, raw + sizeof(T));
    rest_.remove_prefix(sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }
  std::string_view take(std::uint64_t n, const char* thing) {
    if (rest_.size() < n) end_of_file(thing);
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(n));
    rest_.remove_prefix(static_cast<std::size_t>(n));
    return taken;
  }
  /// Throws unless `n` things of `bytes_each` bytes are left, before anything is allocated.
  void expect(std::uint64_t n, std::size_t bytes_each, const char* thing) const {
    if (n > static_cast<std::uint64_t>(INT32_MAX) ||
        (bytes_each && n > rest_.size() / bytes_each)) {
      fail(std::string("claims ") + std::to_string(n) + " " + thing + ", more than the file holds",
           "it is truncated or damaged");
    }
  }
  std::size_t remaining() const { return rest_.size(); }
  std::string_view rest() const { return rest_; }
  std::size_t offset() const { return size_ - rest_.size(); }
  void set_big_endian(bool big) { big_endian_ = big; }

  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const {
    throw InputError(what, where_ + ": byte " + std::to_string(offset()), remedy);
  }

 private:
  [[noreturn]] void end_of_file(const char* thing) const {
    fail(std::string("the file ends inside ") + thing, "it is truncated");
  }
  std::string_view rest_;
  std::size_t size_;
  std::string where_;
  bool big_endian_;
};

/// Appends a number in little-endian order.
template <class T>
void put_little(std::string& out, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof(T));
  out.append(raw, sizeof(T));
}

}  // namespace skinfield
