// Access to a run's folder: two runs at a time, a resumable run, a finished one, one of another case or program.
#include "tests/system/real_run.hpp"

#include <chrono>
#include <map>
#include <thread>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Every file below a folder, with its text and time of last change.
std::map<std::string, std::pair<std::string, fs::file_time_type>> all_in(const fs::path& folder) {
  std::map<std::string, std::pair<std::string, fs::file_time_type>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[entry.path().string()] = {text_of(entry.path()), fs::last_write_time(entry.path())};
  return files;
}

class RunFolder : public RealRun {
 protected:
  using Moods = std::vector<std::pair<std::string, std::string>>;
  /// Runs `poretwin` with stand-ins for the three processes.
  Outcome played(const Moods& moods = {}, std::vector<std::string> more = {},
                 const std::function<void(pid_t)>& meanwhile = {}) const {
    Child::Environment environment;
    for (const auto& [process, mood] : moods) environment.emplace_back("PORETWIN_FAKE_" + process, mood);
    more.insert(more.end(), {"--programs", PORETWIN_FAKES});
    return poretwin(arguments(terzaghi(), std::move(more)), environment, meanwhile);
  }
  Outcome interrupted_run() const {
    return played(all_wait, {}, [&](pid_t command) {
      wait_until_started();
      ::kill(command, SIGINT);
    });
  }
  void wait_until_started() const {
    wait_for([&] { return fs::exists(out() / "log" / "solid.log"); });
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  /// Leaves a checkpoint, as a run that can be resumed does.
  void leave_checkpoint() const {
    fs::create_directories(out() / "checkpoints");
    std::ofstream(out() / "checkpoints" / "coupler-a-1.state") << "state";
  }
  const Moods all_wait{{"fluid", "wait"}, {"solid", "wait"}, {"coupler", "wait"}};
};

TEST_F(RunFolder, ASecondRunIsRefusedByTheNameOfTheFirst) {
  Outcome second;
  const auto first = played(all_wait, {}, [&](pid_t command) {
    wait_until_started();
    const auto before = all_in(out());
    Child other({PORETWIN_PROGRAM, "run", terzaghi().string(), "--out", out().string(), "--overwrite"},
                folder_ / "second");
    second.exit = other.wait();
    second.err = text_of(folder_ / "second");
    EXPECT_EQ(all_in(out()), before);
    EXPECT_THAT(second.err, AllOf(HasSubstr("another run writes into this folder: poretwin run terzaghi, process " +
                                            std::to_string(command)),
                                  HasSubstr("since 20")));
    ::kill(command, SIGINT);
  });
  EXPECT_EQ(second.exit, 5);
  EXPECT_EQ(first.exit, 130);
  EXPECT_EQ(played({}, {"--overwrite"}).exit, 0) << "the lock goes with the run";
}

/// When `poretwin` is killed by SIGKILL, its processes still write their checkpoints: the next run waits for their end.
TEST_F(RunFolder, WhatAKilledRunHasStartedIsWaitedFor) {
  std::chrono::steady_clock::time_point killed;
  const auto first = played({{"fluid", "linger"}, {"solid", "wait"}, {"coupler", "wait"}}, {}, [&](pid_t command) {
    wait_until_started();
    killed = std::chrono::steady_clock::now();
    ::kill(command, SIGKILL);
  });
  EXPECT_EQ(first.exit, 128 + SIGKILL);
  const auto second = played({}, {"--overwrite"});
  EXPECT_EQ(second.exit, 0) << second.err;
  EXPECT_THAT(second.err, HasSubstr("waiting for the end of what a killed process has started"));
  EXPECT_GT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(1));
}

TEST_F(RunFolder, ARunThatCanGoOnIsNotErased) {
  ASSERT_EQ(interrupted_run().exit, 130);
  leave_checkpoint();
  std::ofstream(out() / "gauges.fluid.csv") << "time_s,gauge,value,unit\n";
  const auto before = all_in(out());
  const auto refused = played();
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("a run of terzaghi that was interrupted at 20"), HasSubstr("--resume"),
                                 HasSubstr("--overwrite")));
  EXPECT_EQ(all_in(out()), before);
  EXPECT_EQ(played({}, {"--overwrite"}).exit, 0);
  EXPECT_FALSE(fs::exists(out() / "checkpoints"));
}

TEST_F(RunFolder, ResultsOfABrokenRunAreNotErasedEither) {
  ASSERT_EQ(interrupted_run().exit, 130);
  std::ofstream(out() / "solid.vtkhdf") << "frames";
  const auto refused = played();
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, HasSubstr("left results, but no checkpoint; begin anew with --overwrite"));
  EXPECT_EQ(text_of(out() / "solid.vtkhdf"), "frames");
}

TEST_F(RunFolder, AFinishedRunIsReplacedAndThatIsSaid) {
  ASSERT_EQ(played().exit, 0);
  const auto again = played();
  EXPECT_EQ(again.exit, 0);
  EXPECT_THAT(again.err, HasSubstr("replaces a run of terzaghi that finished at 20"));
}

TEST_F(RunFolder, AFinishedRunIsNotReplacedByAnotherCase) {
  ASSERT_EQ(played().exit, 0);
  const auto before = all_in(out());
  const auto other =
      poretwin(arguments(changed_case("porosity = 0.4", "porosity = 0.41"), {"--programs", PORETWIN_FAKES}));
  EXPECT_EQ(other.exit, 5);
  EXPECT_THAT(other.err, HasSubstr("holds a run of terzaghi that finished"));
  EXPECT_EQ(all_in(out()), before);
}

TEST_F(RunFolder, ResumingAFinishedRunTouchesNothing) {
  ASSERT_EQ(played().exit, 0);
  const auto before = all_in(out());
  const auto again = played({}, {"--resume"});
  EXPECT_EQ(again.exit, 0);
  EXPECT_THAT(again.err, HasSubstr("already finished"));
  EXPECT_EQ(all_in(out()), before);
  const auto longer = played({}, {"--resume", "--until", "7"});
  EXPECT_EQ(longer.exit, 2);
  EXPECT_THAT(longer.err, HasSubstr("--set: expected that of the run to be resumed, nothing, found case.end_time=7"));
  EXPECT_EQ(all_in(out()), before);
}

TEST_F(RunFolder, AFolderOfAnotherCaseIsNotResumed) {
  ASSERT_EQ(interrupted_run().exit, 130);
  leave_checkpoint();
  const auto before = all_in(out());
  const auto other = poretwin(
      arguments(changed_case("porosity = 0.4", "porosity = 0.41"), {"--resume", "--programs", PORETWIN_FAKES}));
  EXPECT_EQ(other.exit, 2);
  EXPECT_THAT(other.err, AllOf(HasSubstr("a run of terzaghi that was interrupted"), HasSubstr("nothing was touched")));
  EXPECT_EQ(all_in(out()), before);
}

TEST_F(RunFolder, ProcessesStartedByHandLookForThemselves) {
  const auto file = out() / "coupler.summary.json";
  {
    const auto coupler = short_process("coupler", socket(), {"--wait-deadline", "6"});
    wait_for([&] { return text_of(log("coupler")).find("listening") != std::string::npos; });
    const auto second_log = folder_ / "second.log";
    Child second({(fs::path(PORETWIN_PROGRAM).parent_path() / "poretwin-coupler").string(), "--case",
                  terzaghi().string(), "--out", out().string(), "--bind", socket() + "2"},
                 second_log);
    EXPECT_EQ(second.wait(), 5);
    EXPECT_THAT(text_of(second_log), HasSubstr("another coupler writes into this folder: poretwin-coupler, process " +
                                               std::to_string(coupler->pid())));
    EXPECT_FALSE(fs::exists(file)) << "the account is the first one's to give";
    coupler->signal(SIGINT);
    EXPECT_EQ(coupler->wait(), 130);
  }
  leave_checkpoint();
  const auto refused = short_process("coupler", socket());
  EXPECT_EQ(refused->wait(), 5);
  EXPECT_THAT(text_of(log("coupler")), AllOf(HasSubstr("go on with --resume"), HasSubstr("--overwrite")));
  EXPECT_TRUE(fs::exists(out() / "checkpoints" / "coupler-a-1.state"));
  EXPECT_THAT(text_of(file), HasSubstr("interrupted"));
}

TEST_F(RunFolder, AChangedProgramResumesOnlyWhenThatIsAccepted) {
  const auto programs = folder_ / "programs";
  fs::create_directories(programs);
  for (const char* name : {"coupler", "fluid", "solid"}) {
    const auto program = fmt::format("poretwin-{}", name);
    fs::copy_file(fs::path(PORETWIN_PROGRAM).parent_path() / program, programs / program);
  }
  const std::vector<std::string> words{"--programs", programs.string(), "--set", "case.end_time=0.1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), words.begin(), words.end());
    return arguments(terzaghi(), more);
  };
  const auto stopped = poretwin(with({}), {}, [&](pid_t command) {
    wait_for([&] { return text_of(out() / "gauges.solid.csv").find("\n0.01") != std::string::npos; });
    ::kill(command, SIGINT);
  });
  ASSERT_EQ(stopped.exit, 130) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("--resume goes on from the last checkpoint"));
  std::ofstream(programs / "poretwin-solid", std::ios::binary | std::ios::app) << "changed";
  const auto before = all_in(out());
  const auto refused = poretwin(with({"--resume"}));
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("program: expected"), HasSubstr("--accept-changed-program")));
  EXPECT_EQ(all_in(out()), before);
  // run.toml may lack the program: the checkpoint identifies it, too.
  auto text = text_of(out() / "run.toml");
  const auto entry = text.find("\n\"program\" = ");
  ASSERT_NE(entry, std::string::npos);
  std::ofstream(out() / "run.toml") << text.substr(0, text.find("[identity]"));
  const auto by_the_solid = poretwin(with({"--resume"}));
  EXPECT_EQ(by_the_solid.exit, 2);
  EXPECT_THAT(by_the_solid.err, AllOf(HasSubstr("checkpoints/solid-"), HasSubstr("program: expected")));
  const auto accepted = poretwin(with({"--resume", "--accept-changed-program"}));
  EXPECT_EQ(accepted.exit, 0) << accepted.err;
  EXPECT_NEAR(steps_in(out() / "solid.vtkhdf").back(), 0.1, 1e-12);
}

/// Signals arrive at every process, more than once, as schedulers and timeout(1) send them.
TEST_F(RunFolder, SignalsToAllProcessesLeaveAWholeCheckpoint) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const std::vector<std::string> piece{"--set", "case.end_time=0.1"};
    const auto stopped = poretwin(arguments(terzaghi(), piece), {}, [&](pid_t command) {
      wait_for([&] { return text_of(out() / "gauges.solid.csv").find("\n0.01") != std::string::npos; });
      std::vector<pid_t> all{command};
      for (const char* name : {"poretwin-couple", "poretwin-fluid", "poretwin-solid"})
        all.push_back(child_called(command, name));
      for (int again = 0; again < 3; ++again)
        for (const pid_t process : all)
          if (process > 0) ::kill(process, signal);
    });
    ASSERT_EQ(stopped.exit, 130) << stopped.err;
    EXPECT_THAT(stopped.err, HasSubstr("another signal ends at once after 10 s"));
    for (const char* process : {"coupler", "fluid", "solid"}) {
      EXPECT_THAT(text_of(out() / fmt::format("{}.summary.json", process)), HasSubstr("\"interrupted\"")) << process;
      long count = 0;
      for (const auto& entry : fs::directory_iterator(out() / "checkpoints"))
        count += entry.path().filename().string().starts_with(process) && entry.path().extension() == ".state" ? 1 : 0;
      EXPECT_EQ(count, 1) << process;
    }
    auto words = piece;
    words.emplace_back("--resume");
    const auto resumed = poretwin(arguments(terzaghi(), words));
    EXPECT_EQ(resumed.exit, 0) << resumed.err;
    fs::remove_all(out());
  }
}

}  // namespace
}  // namespace poretwin::testing_tools
