// Memory for large arrays of numbers: not cleared, and in large pages where the system has them,
// since what walks over hundreds of megabytes spends a tenth of its time on looking up small ones.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace skinfield {

struct LargeMemoryRelease {
  void operator()(void* memory) const;
};
using LargeMemory = std::unique_ptr<void, LargeMemoryRelease>;

/// @throws std::bad_alloc
LargeMemory allocate_large(std::size_t bytes);

template <class T>
class LargeArray {
  static_assert(std::is_trivial_v<T>);

 public:
  LargeArray() = default;
  LargeArray(LargeArray&& other) noexcept
      : memory_(std::move(other.memory_)), size_(std::exchange(other.size_, 0)) {}
  LargeArray& operator=(LargeArray&& other) noexcept {
    memory_ = std::move(other.memory_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  /// At least so many values, whatever they are: the old ones are lost where there were fewer.
  T* resize(std::size_t size) {
    if (size > size_) {
      release();
      memory_ = allocate_large(size * sizeof(T));
      size_ = size;
    }
    return data();
  }
  void release() {
    memory_.reset();
    size_ = 0;
  }
  T* data() { return static_cast<T*>(memory_.get()); }
  const T* data() const { return static_cast<const T*>(memory_.get()); }

 private:
  LargeMemory memory_;
  std::size_t size_ = 0;
};

}  // namespace skinfield
