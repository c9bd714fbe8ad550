#include "base/large_array.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace skinfield {
namespace {
constexpr std::size_t kPage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 4 * kPage;  // less is not worth the rounding up
constexpr std::size_t kAlignment = 64;     // of a vector, and a line of memory
}  // namespace

void LargeMemoryRelease::operator()(void* memory) const { std::free(memory); }

LargeMemory allocate_large(std::size_t bytes) {
  const std::size_t unit = bytes < kLarge ? kAlignment : kPage;
  const std::size_t size = (bytes / unit + 1) * unit;
  LargeMemory memory(std::aligned_alloc(unit, size));
  if (!memory) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  // A wish: without it the memory is as good, only slower.
  if (unit == kPage) madvise(memory.get(), size, MADV_HUGEPAGE);
#endif
  return memory;
}

}  // namespace skinfield
