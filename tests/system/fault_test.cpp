// Rare failures of the system (opening a file, disk space, sending, memory), injected one by one into each process of a
// short coupled run: the cause is reported, all processes end in time by themselves, and what was written can be read.
#include "tests/system/real_run.hpp"

#include <map>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;

struct Refusal {
  int exit;
  std::string cause;  ///< part of the last message
};

class Faults : public RealRun, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(Processes, Faults, testing::Values("coupler", "fluid", "solid"),
                         [](const auto& process) { return std::string(process.param); });

TEST_P(Faults, AreNamedAndEndTheRunInOrder) {
  const std::map<std::string, Refusal> refusals{{"open", {5, "Too many open files"}},
                                                {"write", {5, "No space left on device"}},
                                                {"send", {1, "No buffer space available"}},
                                                {"map", {0, ""}},  // large messages then go through the socket
                                                {"allocate", {1, "out of memory"}}};
  for (const auto& [what, refusal] : refusals)
    // HDF5 looks for a file before it creates it: the first opening may fail.
    for (const std::string when : {what == "open" ? "2" : "1", "9+"}) {
      fs::remove_all(out());
      const std::string fault = fmt::format("{} {} {}", GetParam(), what, when);
      SCOPED_TRACE(fault);
      const auto outcome =
          poretwin(arguments(terzaghi(), {"--set", "case.end_time=0.01", "--set", "output.interval=0.002",
                                          "--checkpoint-every", "0", "--restarts", "0", "--quiet"}),
                   {{"PORETWIN_FAIL", fault}});
      EXPECT_EQ(outcome.exit, refusal.exit) << outcome.err;
      EXPECT_THAT(outcome.err, testing::HasSubstr(refusal.cause));
      EXPECT_LT(outcome.seconds, 40.0) << "on a busy machine a run of a second takes that of ten";
      EXPECT_TRUE(fs::is_empty(folder_ / "temporary"));
      for (const char* name : {"fluid.vtkhdf", "solid.vtkhdf"})
        // The side-car is written with the first frame: without it the file has none.
        if (fs::exists((out() / name).replace_extension(".xmf"))) {
          EXPECT_FALSE(steps_in(out() / name).empty());
        }
    }
}

}  // namespace
}  // namespace poretwin::testing_tools
