#include "skinfield/base/parallel.h"

#include "base/loop_order.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

namespace skinfield {

void parallel_blocks(std::size_t n, std::size_t block,
                     const std::function<void(std::size_t, std::size_t)>& body) {
  if (n == 0) return;
  block = std::max<std::size_t>(block, 1);
  const std::size_t blocks = (n + block - 1) / block;
  if (blocks == 1) return body(0, n);
  LoopOrder order;
  oneapi::tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    order.body_begins();
    body(b * block, std::min(n, (b + 1) * block));
    order.body_ends();
  });
}

struct ThreadLimit::Impl {
  explicit Impl(std::size_t threads)
      : control(oneapi::tbb::global_control::max_allowed_parallelism, threads) {}
  oneapi::tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(threads > 0 ? std::make_unique<Impl>(static_cast<std::size_t>(threads)) : nullptr) {}

ThreadLimit::~ThreadLimit() = default;

int thread_count() {
  return static_cast<int>(
      std::min<std::size_t>(oneapi::tbb::global_control::active_value(
                                oneapi::tbb::global_control::max_allowed_parallelism),
                            static_cast<std::size_t>(oneapi::tbb::info::default_concurrency())));
}

}  // namespace skinfield
