#include "common/core/memory.hpp"

#include <malloc.h>
#include <sys/mman.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <map>
#include <mutex>
#include <new>

namespace poretwin {
namespace {

/// A memory region for large arrays only. In a common heap, small strings that outlive a window, and blocks that malloc
/// caches, would fragment the space that the arrays of a window leave, and the arrays of the next window would not fit
/// into it.
class LargeArrays {
 public:
  /// Memory for an array in the smallest gap that suffices, or in the lowest of several such gaps. nullptr where the
  /// array is not large or no gap suffices.
  void* take(std::size_t size, std::size_t alignment = line) {
    if (size < least || alignment > line || begin_ == nullptr) return nullptr;
    const std::lock_guard lock(busy_);
    const std::size_t whole = (size + 2 * line - 1) / line * line;  // plus a line before the array for this size
    auto best = gaps_.end();
    for (auto gap = gaps_.begin(); gap != gaps_.end(); ++gap)
      if (gap->second >= whole && (best == gaps_.end() || gap->second < best->second)) best = gap;
    if (best == gaps_.end()) return nullptr;
    char* const at = best->first;
    const std::size_t left = best->second - whole;
    gaps_.erase(best);
    if (left > 0) gaps_.emplace(at + whole, left);
    *reinterpret_cast<std::size_t*>(at) = whole;
    return at + line;
  }
  void give_back(void* array) {
    const std::lock_guard lock(busy_);
    char* const at = static_cast<char*>(array) - line;
    auto gap = gaps_.emplace(at, *reinterpret_cast<std::size_t*>(at)).first;
    if (const auto next = std::next(gap); next != gaps_.end() && gap->first + gap->second == next->first) {
      gap->second += next->second;
      gaps_.erase(next);
    }
    if (gap == gaps_.begin()) return;
    if (const auto before = std::prev(gap); before->first + before->second == gap->first) {
      before->second += gap->second;
      gaps_.erase(gap);
    }
  }
  [[nodiscard]] bool has(const void* array) const {
    const char* const begin = begin_;
    return begin != nullptr && array >= begin && array < begin + room;
  }
  /// Reserves the region; arrays are placed in it from now on. Pages become resident when first written, and stay so.
  void open() {
    if (begin_ != nullptr) return;
    void* const found =
        ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (found == MAP_FAILED) return;
    gaps_.emplace(static_cast<char*>(found), room);
    begin_ = static_cast<char*>(found);
  }

 private:
  static constexpr std::size_t least = 64 << 10, line = 64, room = std::size_t{1} << 38;
  std::atomic<char*> begin_{nullptr};
  std::mutex busy_;
  std::map<char*, std::size_t> gaps_;  ///< gaps: first address, bytes
};

LargeArrays& large_arrays() {
  alignas(LargeArrays) static char place[sizeof(LargeArrays)];
  static auto* const here = ::new (static_cast<void*>(place)) LargeArrays;  // never destroyed: used until the end
  return *here;
}

[[maybe_unused]] void release(void* array) {
  if (auto& large = large_arrays(); large.has(array))
    large.give_back(array);
  else
    std::free(array);
}

}  // namespace

void return_freed_memory() { ::mallopt(M_MMAP_THRESHOLD, 128 << 10); }

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest value that glibc accepts
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  large_arrays().open();
}

}  // namespace poretwin

// Sanitizers check only the memory that their own allocator returns.
#ifndef PORETWIN_SANITIZED
void* operator new(std::size_t size) {
  if (void* const array = poretwin::large_arrays().take(size)) return array;
  if (void* const array = std::malloc(size)) return array;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  if (void* const array = poretwin::large_arrays().take(size, step)) return array;
  if (void* const array = std::aligned_alloc(step, (size + step - 1) / step * step)) return array;
  throw std::bad_alloc();
}
void operator delete(void* array) noexcept { poretwin::release(array); }
void operator delete(void* array, std::align_val_t) noexcept { poretwin::release(array); }
void operator delete(void* array, std::size_t) noexcept { poretwin::release(array); }
void operator delete(void* array, std::size_t, std::align_val_t) noexcept { poretwin::release(array); }
#endif
