// Runs the tests on every rank. Rank 0 reports as usual, the others only what fails.
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace poretwin::tiles {
namespace {

const Communicator* all = nullptr;

class Failures final : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::printf("rank %d: %s:%d: %s\n", all->rank(), result.file_name() ? result.file_name() : "", result.line_number(),
                result.message());
    std::fflush(stdout);
  }
};

}  // namespace

const Communicator& all_ranks() { return *all; }

}  // namespace poretwin::tiles

int main(int argc, char** argv) {
  using namespace poretwin::tiles;
  testing::InitGoogleTest(&argc, argv);
  GTEST_FLAG_SET(catch_exceptions, false);  // an exception ends all ranks: the others would wait for this one
  return run_as_rank(argc, argv, [](const Communicator& ranks) {
    all = &ranks;
    if (ranks.rank() > 0) {
      auto& listeners = testing::UnitTest::GetInstance()->listeners();
      delete listeners.Release(listeners.default_result_printer());
      listeners.Append(new Failures);
    }
    return RUN_ALL_TESTS();
  });
}
