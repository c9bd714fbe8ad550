// What a loop promises about order, told to the thread sanitizer, which cannot see inside TBB:
// what precedes the loop happens before every body, every body before what follows the loop.
// Between bodies nothing is promised, so that their races are still found. The tsan preset builds
// parallel.cpp itself without the sanitizer, lest TBB's own headers be taken for ours.
#pragma once

#ifdef SKINFIELD_THREAD_SANITIZER
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
#endif

namespace skinfield {

class LoopOrder {
 public:
#ifdef SKINFIELD_THREAD_SANITIZER
  LoopOrder() { __tsan_release(&begun_); }
  ~LoopOrder() { __tsan_acquire(&ended_); }
  void body_begins() { __tsan_acquire(&begun_); }
  void body_ends() { __tsan_release(&ended_); }
#else
  LoopOrder() = default;
  void body_begins() const {}
  void body_ends() const {}
#endif
  LoopOrder(const LoopOrder&) = delete;
  LoopOrder& operator=(const LoopOrder&) = delete;

#ifdef SKINFIELD_THREAD_SANITIZER
 private:
  char begun_ = 0, ended_ = 0;  // only their addresses matter
#endif
};

}  // namespace skinfield
