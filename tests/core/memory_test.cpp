// Large arrays that are allocated and freed, beside small ones that are kept.
#include "common/core/memory.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <new>
#include <random>
#include <thread>
#include <vector>

namespace poretwin {
namespace {

/// Allocates and frees arrays of random sizes; none may overlap another that is still allocated.
void come_and_go(unsigned seed) {
  std::mt19937 generator(seed);
  std::vector<std::vector<std::uint32_t>> held(40);
  std::vector<std::uint32_t> names(held.size(), 0);
  for (std::uint32_t k = 1; k < 4000; ++k) {
    const std::size_t which = generator() % held.size();
    for (const std::uint32_t x : held[which]) ASSERT_EQ(x, names[which]);
    names[which] = 100000 * seed + k;
    held[which] = std::vector<std::uint32_t>(std::size_t{1} << generator() % 19, names[which]);
  }
}

TEST(Memory, ArraysAreTheirOwners) {
  const std::vector<std::uint32_t> from_before(1 << 20, 7);
  keep_freed_memory();
  std::vector<std::thread> threads;
  for (unsigned k = 1; k <= 3; ++k) threads.emplace_back(come_and_go, k);
  for (auto& thread : threads) thread.join();
  for (const std::uint32_t x : from_before) ASSERT_EQ(x, 7u);
}

TEST(Memory, ArraysAreAligned) {
  keep_freed_memory();
  struct alignas(64) Line {
    char x[64];
  };
  struct alignas(4096) Page {
    char x[4096];
  };
  for (std::size_t n = 1; n < 200000; n = 3 * n + 1) {
    const auto lines = std::make_unique<Line[]>(n);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.get()) % 64, 0u);
    const auto pages = std::make_unique<Page[]>(n / 64 + 1);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pages.get()) % 4096, 0u);
  }
}

TEST(Memory, MoreThanThereIsIsRefused) {
#ifdef PORETWIN_SANITIZED
  GTEST_SKIP() << "sanitizers end the process";
#endif
  keep_freed_memory();
  EXPECT_THROW(static_cast<void>(::operator new (std::size_t{1} << 60)), std::bad_alloc);
}

}  // namespace
}  // namespace poretwin
