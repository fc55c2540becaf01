// Real runs that are killed, stopped or left without disk space: resumed, they end as if undisturbed, or say why they
// cannot.
#include "tests/system/real_run.hpp"

#include <sys/resource.h>

#include <random>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Everything that differs between two run folders.
std::string differences(const fs::path& one, const fs::path& other) {
  std::string found;
  for (const auto& entry : fs::directory_iterator(one)) {
    const auto name = entry.path().filename().string();
    if (entry.path().extension() == ".csv" || entry.path().extension() == ".xmf") {
      if (text_of(entry.path()) != text_of(other / name)) found += name + "\n";
    } else if (entry.path().extension() == ".vtkhdf") {
      const auto a = hdf5::File::open_to_read(entry.path()), b = hdf5::File::open_to_read(other / name);
      std::vector<std::string> sets{"VTKHDF/Points", "VTKHDF/Steps/Values"};
      for (const auto& field : a.names("VTKHDF/PointData")) sets.push_back("VTKHDF/PointData/" + field);
      for (const auto& gauge : a.names("gauges"))
        for (const char* part : {"/time", "/value"}) sets.push_back("gauges/" + gauge + part);
      for (const auto& set : sets) {
        const auto x = a.read_numbers(set), y = b.read_numbers(set);
        if (x.size() != y.size() || std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) != 0)
          found += name + ": " + set + "\n";
      }
      for (const char* set :
           {"VTKHDF/Offsets", "VTKHDF/Connectivity", "VTKHDF/NumberOfPoints", "VTKHDF/Steps/PointOffsets"})
        if (a.read_integers(set) != b.read_integers(set)) found += name + ": " + set + "\n";
    }
  }
  return found;
}

class RealResume : public RealRun {
 protected:
  const std::vector<std::string> piece{"--set", "case.end_time=0.1", "--set", "output.interval=0.01"};

  std::vector<std::string> with(std::vector<std::string> more, const std::vector<std::string>& set) const {
    more.insert(more.end(), set.begin(), set.end());
    return arguments(terzaghi(), std::move(more));
  }
  /// Makes an undisturbed run in a folder beside out().
  fs::path reference(const fs::path& file, const std::vector<std::string>& set) {
    const auto folder = folder_ / "reference";
    std::vector<std::string> words{"run", file.string(), "--out", folder.string(), "--no-pictures", "--quiet"};
    words.insert(words.end(), set.begin(), set.end());
    const auto outcome = poretwin(words);
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return folder;
  }
  /// Waits until the run has left a checkpoint, and then for a random time, before it kills a program.
  std::function<void(pid_t)> killer(const std::string& program, unsigned seed) {
    return [this, program, seed](pid_t command) {
      std::mt19937 random(seed);
      const int ms = std::uniform_int_distribution<int>(0, 300)(random);
      wait_for([&] { return checkpoints("coupler") > 0; });
      std::this_thread::sleep_for(std::chrono::milliseconds(ms));
      if (const pid_t victim = child_called(command, program); victim > 0) ::kill(victim, SIGKILL);
    };
  }
  /// Kills a program that runs a case alone, resumes it, and compares the results with those of an undisturbed run.
  void resumes_alone(const std::string& name, const std::string& program, const std::vector<std::string>& set) {
    const auto file = fs::path(PORETWIN_SOURCE_DIR) / "cases" / name / "case.toml";
    const auto whole = reference(file, set);
    auto words = arguments(file, {"--checkpoint-every", "0", "--restarts", "0"});
    words.insert(words.end(), set.begin(), set.end());
    const auto outcome = poretwin(words, {}, [&](pid_t command) {
      wait_for([&] { return checkpoints("fluid") > 1; });
      ::kill(child_called(command, program), SIGKILL);
    });
    EXPECT_EQ(outcome.exit, 1) << outcome.err;
    words = arguments(file, {"--resume"});
    words.insert(words.end(), set.begin(), set.end());
    const auto resumed = poretwin(words);
    EXPECT_EQ(resumed.exit, 0) << resumed.err;
    EXPECT_EQ(differences(whole, out()), "");
    expect_nothing_left();
  }
  [[nodiscard]] long checkpoints(const std::string& process) const {
    std::error_code none;
    long count = 0;
    for (const auto& entry : fs::directory_iterator(out() / "checkpoints", none)) {
      const auto name = entry.path().filename().string();
      if (name.starts_with(process) && name.ends_with(".state")) ++count;
    }
    return count;
  }
  void expect_nothing_left() const {
    EXPECT_TRUE(fs::is_empty(folder_ / "temporary")) << "a socket stayed behind";
    EXPECT_FALSE(fs::exists(out() / "checkpoints")) << "a run that has ended needs no checkpoints";
  }
};

/// Process names in the kernel, which are cut at 15 characters.
constexpr const char* programs[] = {"poretwin-couple", "poretwin-fluid", "poretwin-solid"};

TEST_F(RealResume, AKilledProcessIsStartedAgainFromTheLastCheckpoint) {
  const auto whole = reference(terzaghi(), piece);
  unsigned seed = 1;
  for (const std::string program : programs) {
    fs::remove_all(out());
    const auto outcome = poretwin(with({"--checkpoint-every", "0"}, piece), {}, killer(program, seed++));
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("was killed by signal 9 (Killed); restart 1 of 2, from the last checkpoint"));
    EXPECT_EQ(differences(whole, out()), "") << program;
    expect_nothing_left();
  }
}

TEST_F(RealResume, AKilledRunIsResumedByAPerson) {
  const auto whole = reference(terzaghi(), piece);
  const auto outcome =
      poretwin(with({"--checkpoint-every", "0", "--restarts", "0"}, piece), {}, killer("poretwin-solid", 7));
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_THAT(outcome.err, HasSubstr("solid was killed by signal 9"));
  // Before resuming, every file can be read.
  for (const char* name : {"fluid.vtkhdf", "solid.vtkhdf"}) EXPECT_GE(steps_in(out() / name).size(), 1u);
  const auto resumed = poretwin(with({"--resume"}, piece));
  EXPECT_EQ(resumed.exit, 0) << resumed.err;
  EXPECT_EQ(differences(whole, out()), "");
  expect_nothing_left();
}

TEST_F(RealResume, CtrlCLeavesACheckpoint) {
  const auto whole = reference(terzaghi(), piece);
  const auto outcome = poretwin(with({}, piece), {}, [&](pid_t command) {
    wait_for([&] { return text_of(out() / "gauges.solid.csv").find("\n0.03") != std::string::npos; });
    ::kill(command, SIGINT);
  });
  ASSERT_EQ(outcome.exit, 130) << outcome.err;
  EXPECT_EQ(checkpoints("coupler"), 1);
  const auto resumed = poretwin(with({"--resume"}, piece));
  EXPECT_EQ(resumed.exit, 0) << resumed.err;
  EXPECT_EQ(differences(whole, out()), "") << "the frame in which it was stopped does not belong to it";
  expect_nothing_left();
}

/// Rigid soil: the fluid alone, with few frames and few gauge readings.
TEST_F(RealResume, ASolverAloneResumesToo) {
  resumes_alone(
      "infiltration_horizontal", "poretwin-fluid",
      {"--set", "case.end_time=400.0", "--set", "output.interval=50.0", "--set", "output.gauge_interval=20.0"});
}

TEST_F(RealResume, AFieldHasAProgramOfItsOwnAndResumesToo) {
  resumes_alone("dam_unsaturated", "poretwin-pore",
                {"--set", "case.end_time=3456000.0", "--set", "fluid.particle_spacing=0.2"});
}

TEST_F(RealResume, AFieldAndSoilThatMovesResumeToo) {
  auto as_field = piece;
  as_field.insert(as_field.end(), {"--set", "fluid.representation='field'"});
  const auto whole = reference(terzaghi(), as_field);
  const auto outcome = poretwin(with({"--checkpoint-every", "0"}, as_field), {}, killer("poretwin-pore", 5));
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_EQ(differences(whole, out()), "");
  expect_nothing_left();
}

TEST_F(RealResume, WhatCannotBeResumedIsNamed) {
  EXPECT_THAT(poretwin(with({"--resume"}, piece)).err,
              HasSubstr("nothing to resume: expected the folder of an earlier"));
  ASSERT_EQ(poretwin(with({}, piece)).exit, 0);
  const auto ended = poretwin(with({"--resume"}, piece));
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.err, HasSubstr("already finished"));
  const auto stopped =
      poretwin(with({"--checkpoint-every", "0", "--restarts", "0"}, piece), {}, killer("poretwin-solid", 3));
  ASSERT_EQ(stopped.exit, 1) << stopped.err;
  auto other = piece;
  other.insert(other.end(), {"--set", "soil.0.porosity=0.41"});
  const auto changed = poretwin(with({"--resume"}, other));
  EXPECT_EQ(changed.exit, 2);
  EXPECT_THAT(changed.err, HasSubstr("--set: expected that of the run to be resumed, "));
  EXPECT_THAT(changed.err, HasSubstr("soil.0.porosity=0.41; resume with the same"));
  EXPECT_EQ(poretwin(with({"--resume"}, piece)).exit, 0) << "the checkpoint must have outlived the attempt";
}

/// A limit on the size of files acts as a full disk does, and needs no privileges.
TEST_F(RealResume, NoMoreRoomNamesTheFileAndLeavesWhatIsThere) {
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto small = [&](rlim_t bytes) {
    const rlimit limit{bytes, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  const std::vector<std::string> many{"--set", "case.end_time=0.1", "--set", "output.interval=0.002"};
  small(200'000);
  const auto frames = poretwin(with({"--checkpoint-every", "inf"}, many));
  small(before.rlim_cur);
  EXPECT_EQ(frames.exit, 5) << frames.err;
  EXPECT_THAT(frames.err, testing::AllOf(HasSubstr(".vtkhdf"), HasSubstr("File too large")));
  for (const char* name : {"fluid.vtkhdf", "solid.vtkhdf"}) {
    const auto times = steps_in(out() / name);
    EXPECT_GE(times.size(), 2u) << name;
    EXPECT_LT(times.size(), 50u) << name;
  }
  EXPECT_FALSE(read_gauges(out() / "gauges.csv").empty());

  // Space for the frames, but not for a checkpoint after the first ones.
  small(300'000);
  const auto state = poretwin(with({"--checkpoint-every", "0"}, {"--set", "case.end_time=0.01"}));
  small(before.rlim_cur);
  EXPECT_EQ(state.exit, 5) << state.err;
  EXPECT_THAT(state.err, testing::AllOf(HasSubstr("checkpoints/"), HasSubstr("File too large")));
  for (const auto& entry : fs::directory_iterator(out() / "checkpoints"))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
}

TEST_F(RealResume, ADeviceWithoutRoomIsNamed) {
  fs::create_directories(out());
  fs::create_symlink("/dev/full", out() / "gauges.fluid.csv");
  const auto coupler = short_process("coupler", socket()), solid = short_process("solid", socket()),
             fluid = short_process("fluid", socket());
  EXPECT_EQ(fluid->wait(), 5);
  EXPECT_NE(coupler->wait(), 0);
  EXPECT_NE(solid->wait(), 0);
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("gauges.fluid.csv: cannot be written: No space left on device"));
}

TEST_F(RealResume, AFolderThatMayNotBeWrittenIsNamed) {
  const auto proc = poretwin({"run", terzaghi().string(), "--out", "/proc/poretwin-run"});
  EXPECT_EQ(proc.exit, 5);
  EXPECT_THAT(proc.err, HasSubstr("/proc/poretwin-run"));
  // As an ordinary user, in another user's folder.
  if (::geteuid() == 0) {
    const auto mine = folder_ / "mine";
    fs::create_directories(mine);
    fs::permissions(folder_, fs::perms::owner_all | fs::perms::group_exec | fs::perms::others_exec);
    fs::permissions(mine, fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
    Child child({"/usr/bin/setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", PORETWIN_PROGRAM, "run",
                 terzaghi().string(), "--out", (mine / "run").string()},
                folder_ / "nobody");
    const int code = child.wait();
    if (code == 127 || code == 126) GTEST_SKIP() << "no other user can be played here: " << text_of(folder_ / "nobody");
    EXPECT_EQ(code, 5);
    EXPECT_THAT(text_of(folder_ / "nobody"), HasSubstr("Permission denied"));
    return;
  }
  fs::create_directories(folder_ / "mine");
  fs::permissions(folder_ / "mine", fs::perms::owner_read | fs::perms::owner_exec);
  const auto refused = poretwin({"run", terzaghi().string(), "--out", (folder_ / "mine" / "run").string()});
  fs::permissions(folder_ / "mine", fs::perms::owner_all);
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, HasSubstr("Permission denied"));
}

TEST_F(RealResume, ATakenPortAndAnAddressWithoutAnybodyAreNamed) {
  const std::string address = "tcp://127.0.0.1:" + std::to_string(free_port());
  const auto first = short_process("coupler", address, {"--wait-deadline", "8"});
  wait_for([&] { return text_of(log("coupler")).find("listening") != std::string::npos; });
  const auto second_log = folder_ / "second.log";
  const auto folder = fs::path(PORETWIN_PROGRAM).parent_path();
  Child second({(folder / "poretwin-coupler").string(), "--case", terzaghi().string(), "--out",
                (folder_ / "second").string(), "--bind", address},
               second_log);
  EXPECT_EQ(second.wait(), 5) << text_of(second_log);
  EXPECT_THAT(text_of(second_log), testing::AllOf(HasSubstr(address), HasSubstr("Address already in use")));
  const auto nobody = "tcp://127.0.0.1:" + std::to_string(free_port());
  const auto lonely = short_process("fluid", nobody);
  EXPECT_EQ(lonely->wait(), 3);
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("no coupler answered at " + nobody));
}

}  // namespace
}  // namespace poretwin::testing_tools
