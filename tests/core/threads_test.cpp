#include "common/core/threads.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace poretwin {
namespace {

TEST(Parts, AreEachWorkedOnOnce) {
  for (int call = 0; call < 20000; ++call) {
    std::vector<int> visits(static_cast<std::size_t>(call % 17), 0);
    for_each_part(visits.size(), [&](std::size_t part) { ++visits[part]; });
    ASSERT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(visits.size())) << call;
  }
}

TEST(Parts, WithinPartsAndOfSeveralCallersAreWorkedOnToo) {
  std::atomic<int> done = 0;
  const auto call = [&] {
    for (int k = 0; k < 2000; ++k)
      for_each_part(3, [&](std::size_t) { for_each_part(5, [&](std::size_t) { ++done; }); });
  };
  std::thread other(call);
  call();
  other.join();
  EXPECT_EQ(done, 2 * 2000 * 15);
}

TEST(Parts, ThatLastHoldUpNoOther) {
  if (threads() < 2) GTEST_SKIP() << "one thread";
  std::vector<std::thread::id> by(64);
  for (int call = 0; call < 200; ++call) {  // on a busy machine the other threads may not get a core at once
    for_each_part(by.size(), [&](std::size_t part) {
      if (part == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      by[part] = std::this_thread::get_id();
    });
    if (std::count(by.begin() + 1, by.end(), by[0]) < 63) return;
  }
  ADD_FAILURE() << "one thread did all";
}

}  // namespace
}  // namespace poretwin
