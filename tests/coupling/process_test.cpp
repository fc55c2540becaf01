// The real coupler process and two mock solver processes: killed, stopped, interrupted, misconfigured. Every failure is
// reported, all processes end, files stay complete.
#include "tests/child.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

using Strings = std::vector<std::string>;
using poretwin::testing_tools::Child;
using namespace std::chrono_literals;

class Processes : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = poretwin::testing_tools::fresh_folder("poretwin-processes");
    std::ofstream(folder_ / "case.toml")
        << "[case]\ntitle = \"mocks\"\ndimension = 2\nend_time = 1.0\n"
           "[[soil]]\nname = \"all\"\nshape = \"box\"\nmin = [0, 0]\nmax = [1, 1]\n"
           "porosity = 0.4\ngrain_density = 2600\nhydraulic_conductivity = 0.001\n"
           "[[wall]]\npoints = [[0, 1], [0, 0], [1, 0], [1, 1]]\n"
           "[fluid]\nparticle_spacing = 0.1\n[[fluid.region]]\nshape = \"box\"\nmin = [0, 0]\nmax = [1, 1]\n"
           "[solid]\nmodel = \"elastic\"\nparticle_spacing = 0.1\n"
           "[coupling]\ninterval = 0.01\n[output]\ninterval = 0.1\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Strings arguments(const Strings& more) const {
    Strings out = {"--case", (folder_ / "case.toml").string(), "--out", (folder_ / "out").string()};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  std::unique_ptr<Child> start(Strings command, const Strings& more, const std::string& name) const {
    const auto all = arguments(more);
    command.insert(command.end(), all.begin(), all.end());
    const auto log = folder_ / (name + ".log");
    std::filesystem::remove(log);  // so that messages of an earlier run are not taken for this one's
    return std::make_unique<Child>(command, log);
  }
  std::unique_ptr<Child> coupler(Strings more = {}) const {
    more.insert(more.begin(), {"--bind", address()});
    return start({COUPLER}, more, "coupler");
  }
  std::unique_ptr<Child> peer(const std::string& role, Strings more = {}) const {
    more.insert(more.begin(), {"--connect", address()});
    return start({MOCK_PROCESS, role}, more, role);
  }
  /// Waits, however slow the machine is, until both solvers have joined and the run has begun.
  void wait_until_running() const {
    const auto here = [&](const std::string& who) {
      return text("coupler.log").find(who + " is here") != std::string::npos;
    };
    for (int k = 0; k < 1000 && !(here("fluid") && here("solid")); ++k) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(100ms);
  }
  std::string address() const { return "ipc://" + (folder_ / "socket").string(); }
  std::string text(const std::string& file) const { return poretwin::testing_tools::text_of(folder_ / file); }
  void expect_in(const std::string& file, const Strings& parts) const {
    const std::string all = text(file);
    for (const auto& part : parts)
      EXPECT_NE(all.find(part), std::string::npos) << "'" << part << "' is not in " << file << ":\n" << all;
  }

  const Strings endless{"--set", "case.end_time=1000.0"};  // on any machine it is stopped long before
  std::filesystem::path folder_;
};

TEST_F(Processes, RunToTheEndInAnyStartOrder) {
  auto solid = peer("solid"), fluid = peer("fluid");
  std::this_thread::sleep_for(200ms);
  auto c = coupler();
  EXPECT_EQ(c->wait(), 0) << text("coupler.log");
  EXPECT_EQ(fluid->wait(), 0) << text("fluid.log");
  EXPECT_EQ(solid->wait(), 0) << text("solid.log");
  expect_in("out/coupler.summary.json",
            {"\"exit\": 0", "\"windows\": 100", "\"mapping\"", "\"waiting_for_fluid\"", "drag_impulse x (N s) given"});
  expect_in("out/fluid.summary.json", {"\"exit\": 0", "\"windows\": 100", "\"computing\"", "fluid.vtkhdf"});
}

TEST_F(Processes, TheCaseFileChoosesTheIteratedScheme) {
  const Strings iterated = {"--set", "coupling.scheme=iterated",     "--set", "coupling.acceleration=aitken",
                            "--set", "fluid.skeleton_response=false"};
  auto c = coupler(iterated), fluid = peer("fluid", iterated), solid = peer("solid", iterated);
  EXPECT_EQ(c->wait(), 0) << text("coupler.log");
  expect_in("out/coupler.summary.json", {"\"exit\": 0", "\"windows\": 100", "\"passes\": 300"});
}

/// The coupler says so where the water predicts the skeleton's motion, but takes no `found` fields, as the mock does.
TEST_F(Processes, AFluidThatTakesNothingFoundIsToldSo) {
  const Strings iterated = {"--set", "coupling.scheme=iterated"};
  auto c = coupler(iterated), fluid = peer("fluid", iterated), solid = peer("solid", iterated);
  EXPECT_EQ(c->wait(), 0) << text("coupler.log");
  expect_in("out/coupler.summary.json", {"\"exit\": 0", "\"windows\": 100", "\"passes\": 100"});
  expect_in("coupler.log", {"the fluid does not take what a pass found"});
}

TEST_F(Processes, AKilledSolverEndsTheRunWithItsName) {
  auto c = coupler(endless), fluid = peer("fluid", endless), solid = peer("solid", endless);
  wait_until_running();
  solid->signal(SIGKILL);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(c->wait(), 3);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  EXPECT_EQ(fluid->wait(), 3);
  expect_in("coupler.log", {"solid died", "step", "last message PUBLICATION"});
  expect_in("out/fluid.summary.json", {"\"exit\": 3", "aborted by solid"});
}

TEST_F(Processes, AKilledCouplerEndsBothSolvers) {
  auto c = coupler(endless), fluid = peer("fluid", endless), solid = peer("solid", endless);
  wait_until_running();
  c->signal(SIGKILL);
  EXPECT_EQ(fluid->wait(), 3);
  EXPECT_EQ(solid->wait(), 3);
  expect_in("fluid.log", {"the coupler is gone"});
}

TEST_F(Processes, AStoppedSolverIsNamedWithinThreeSecondsAndGoesOnWhenItIsContinued) {
  auto c = coupler(), fluid = peer("fluid"), solid = peer("solid");
  wait_until_running();
  fluid->signal(SIGSTOP);
  const auto start = std::chrono::steady_clock::now();
  while (text("coupler.log").find("fluid is frozen") == std::string::npos &&
         std::chrono::steady_clock::now() - start < 10s)
    std::this_thread::sleep_for(20ms);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);
  expect_in("coupler.log", {"fluid is frozen", "at step", "last message"});
  fluid->signal(SIGCONT);
  EXPECT_EQ(c->wait(), 0) << text("coupler.log");
  EXPECT_EQ(fluid->wait(), 0);
  EXPECT_EQ(solid->wait(), 0);
  expect_in("coupler.log", {"fluid is back after"});
}

TEST_F(Processes, AStoppedSolverIsCalledFrozen) {
  auto c = coupler({"--frozen-deadline", "2.5", endless[0], endless[1]}), fluid = peer("fluid", endless),
       solid = peer("solid", endless);
  wait_until_running();
  fluid->signal(SIGSTOP);
  EXPECT_EQ(c->wait(), 3);
  EXPECT_EQ(solid->wait(), 3);
  expect_in("coupler.log", {"fluid is frozen: its connection stands"});
}

TEST_F(Processes, CtrlCOnAnyOneFinishesTheWindowEverywhere) {
  const Strings again{endless[0], endless[1], "--overwrite"};  // each run leaves its checkpoints
  for (const int who : {0, 1, 2}) {
    auto c = coupler(again), fluid = peer("fluid", again), solid = peer("solid", again);
    wait_until_running();
    (who == 0 ? c : who == 1 ? fluid : solid)->signal(SIGINT);
    EXPECT_EQ(c->wait(), 130) << text("coupler.log");
    EXPECT_EQ(fluid->wait(), 130) << text("fluid.log");
    EXPECT_EQ(solid->wait(), 130) << text("solid.log");
    expect_in("out/solid.summary.json", {"\"exit\": 130", "\"reason\": \"interrupted\""});
  }
}

TEST_F(Processes, AnotherCaseIsRefused) {
  auto c = coupler({"--wait-deadline", "2"}), fluid = peer("fluid"),
       solid = peer("solid", {"--set", "water.density=900.0"});
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(solid->wait(), 3);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  EXPECT_EQ(c->wait(), 3);
  EXPECT_EQ(fluid->wait(), 3);
  expect_in("solid.log", {"refused by the coupler: case_digest: expected"});
  expect_in("coupler.log", {"solid did not come within 2 s", "refused meanwhile: solid: case_digest"});
}

TEST_F(Processes, AloneAndBadArguments) {
  const std::vector<std::string> rigid{"--alone", "--set", "solid.model=\"rigid\""};
  auto alone = start({MOCK_PROCESS, "fluid"}, rigid, "alone");
  EXPECT_EQ(alone->wait(), 0) << text("alone.log");
  expect_in("out/fluid.summary.json", {"\"exit\": 0", "\"windows\": 100"});
  EXPECT_EQ(start({MOCK_PROCESS, "solid"}, {"--alone"}, "both")->wait(), 2);
  expect_in("both.log", {"case.toml: --alone: expected a case of the solid alone, found water and soil that moves"});
  EXPECT_EQ(start({MOCK_PROCESS, "solid"}, rigid, "other")->wait(), 2);
  expect_in("other.log", {"found no soil that moves; start poretwin-fluid"});
  EXPECT_EQ(start({MOCK_PROCESS, "fluid"}, {}, "bad")->wait(), 2);
  expect_in("bad.log", {"--connect ADDRESS or --alone is missing"});
  EXPECT_EQ(start({COUPLER}, {"--bind", "tcp://0.0.0.0:5555"}, "open")->wait(), 2);
  expect_in("open.log", {"--allow-any-address"});
}

}  // namespace
