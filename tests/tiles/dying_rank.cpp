// A run in which one rank dies, is stopped or is slow while the others exchange with it, or none
// does: dying_rank kill|throw|stop|slow|wait. Started by dying_rank_test.py.
#include "common/core/error.hpp"
#include "common/tiles/mpi_ranks.hpp"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

using namespace poretwin;

int main(int argc, char** argv) {
  const std::string way = argc > 1 ? argv[1] : "";
  return tiles::run_as_rank(argc, argv, [&](const tiles::Communicator& all) {
    // Rank 1 holds a copy of rank 0's particle and the other way round; further ranks wait in the sum.
    tiles::HaloPlan plan{{}, 1, 0};
    if (all.rank() < 2) plan = {{{1 - all.rank(), {0}, 1}}, 1, 1};
    const tiles::MpiRanks ranks(all, plan);
    ScalarArray value(plan.owned + plan.halo, 1.0);
    for (int step = 0;; ++step) {
      all.at_step(static_cast<std::uint64_t>(step));
      ranks.exchange(value, 1);
      static_cast<void>(ranks.domain().sum(1.0));
      if (step < 100 || all.rank() != 1) continue;
      if (way == "wait") {
        if (step == 100) std::puts("steps");
        std::fflush(stdout);
        continue;
      }
      // The instant, for the test: seconds since 1970, as its clock has them, too.
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      std::printf("dies at %.6f\n", std::chrono::duration<double>(now).count());
      std::fflush(stdout);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));  // for the line to reach mpirun
      if (way == "kill") std::raise(SIGKILL);
      if (way == "stop") std::raise(SIGSTOP);
      if (way == "slow") {
        std::this_thread::sleep_for(std::chrono::seconds(4));
        std::puts("rank 1 was waited for");
      }
      throw DivergedError("particle 7 is at (nan, 0) m");
    }
    return 0;
  });
}
