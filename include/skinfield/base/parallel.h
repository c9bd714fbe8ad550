// Deterministic parallel loops: blocks depend on the problem size only, never on the threads,
// and reductions are summed in block order, so results are the same bytes at any thread count.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace skinfield {

/// Calls body(begin, end) for consecutive blocks of at most `block` items of [0,n), in parallel.
/// The first exception thrown by a body is rethrown here.
void parallel_blocks(std::size_t n, std::size_t block,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// body(i) for every i in [0,n), in blocks of `block`.
template <class Body>
void parallel_for(std::size_t n, std::size_t block, const Body& body) {
  parallel_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Folds the blocks' partial results in block order: value = join(value, part(begin, end)).
template <class Value, class Part, class Join>
Value parallel_reduce(std::size_t n, std::size_t block, Value value, const Part& part,
                      const Join& join) {
  if (n == 0) return value;
  block = std::max<std::size_t>(block, 1);
  std::vector<Value> parts((n + block - 1) / block, value);
  parallel_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    parts[begin / block] = part(begin, end);
  });
  for (Value& p : parts) value = join(std::move(value), std::move(p));
  return value;
}

/// Limits the worker threads of all loops while it lives. 0 = all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Threads that loops may use now.
int thread_count();

}  // namespace skinfield
