// The real `poretwin` with stand-ins for its processes: its output, its files, its exit.
#include "tests/system/command.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class CommandWithStandIns : public Command {
 protected:
  Outcome run(const std::vector<std::pair<std::string, std::string>>& moods,
              const std::function<void(pid_t)>& meanwhile = {}) {
    Child::Environment environment;
    for (const auto& [process, mood] : moods) environment.emplace_back("PORETWIN_FAKE_" + process, mood);
    return poretwin(
        {"run", terzaghi().string(), "--out", out().string(), "--programs", PORETWIN_FAKES, "--no-pictures"},
        environment, meanwhile);
  }
};

TEST_F(CommandWithStandIns, HelpAndVersion) {
  EXPECT_THAT(poretwin({"--help"}).out, HasSubstr("Exit codes:\n    0  done\n"));
  EXPECT_THAT(poretwin({"--version"}).out, HasSubstr("poretwin 0."));
  EXPECT_EQ(poretwin({"rnu"}).exit, 2);
}

TEST_F(CommandWithStandIns, UnexpectedArgumentsAreNamedInTheOrderGiven) {
  const auto outcome = poretwin({"check", terzaghi().string(), "second", "--untill", "3"});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("not expected: second --untill 3\n"));
}

TEST_F(CommandWithStandIns, CheckTellsWhatACaseIs) {
  const auto outcome = poretwin({"check", terzaghi().string()});
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_THAT(outcome.out, HasSubstr("400 particles"));
  EXPECT_THAT(outcome.out, HasSubstr("dx / sqrt(M / rho_bar_s)"));
}

TEST_F(CommandWithStandIns, SafetyNeedsSoilThatCanFail) {
  const auto outcome = poretwin({"safety", terzaghi().string(), "--out", out().string(), "--no-pictures"});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("'solid.model': a factor of safety needs soil that can fail"));
}

TEST_F(CommandWithStandIns, CheckNamesAWrongKey) {
  const auto outcome = poretwin({"check", changed_case("porosity", "porosty").string()});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("changed.toml:13: key 'soil[0].porosty' is not known; did you mean 'porosity'?"));
}

TEST_F(CommandWithStandIns, CheckNamesANegativePorosity) {
  const auto outcome = poretwin({"check", changed_case("porosity = 0.4", "porosity = -0.4").string()});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("expected a number in (0, 1), found -0.4"));
}

TEST_F(CommandWithStandIns, CheckNamesOverlappingWalls) {
  const auto outcome = poretwin({"check", changed_case("[[0.1, 0], [0.1, 0.4]]", "[[0.05, 0], [0.3, 0]]").string()});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("wall[1] \"right\" lies on wall[0] \"base\""));
}

TEST_F(CommandWithStandIns, CheckNamesAMissingFile) {
  const auto outcome = poretwin({"check", "terzagi"});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, HasSubstr("no case 'terzagi'"));
  EXPECT_THAT(outcome.err, HasSubstr("did you mean 'terzaghi'?"));
}

TEST_F(CommandWithStandIns, RunGathersWhatTheProcessesLeave) {
  const auto outcome = run({});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::ContainsRegex("fluid +3  steps asleep"));
  const auto gauges = text_of(out() / "gauges.csv");
  EXPECT_THAT(gauges, HasSubstr("fluid_ramp"));
  EXPECT_THAT(gauges, HasSubstr("solid_ramp"));
  EXPECT_THAT(text_of(out() / "run.toml"), HasSubstr("[exits]"));
  EXPECT_TRUE(fs::is_empty(folder_ / "temporary")) << "the socket's folder is removed";
  EXPECT_EQ(run({}).exit, 0) << "an older run's folder may be used again";
}

TEST_F(CommandWithStandIns, RigidSoilNeedsTheFluidOnly) {
  // The solid's gauge is removed: there is no solid to measure.
  auto text = text_of(changed_case("model = \"elastic\"", "model = \"rigid\""));
  const auto from = text.find("[[gauge]]"), to = text.find("[[gauge]]", from + 1);
  std::ofstream(folder_ / "rigid.toml") << text.erase(from, to - from);
  const auto outcome = poretwin({"run", (folder_ / "rigid.toml").string(), "--out", out().string(), "--programs",
                                 PORETWIN_FAKES, "--no-pictures"},
                                {{"PORETWIN_FAKE_solid", "fail 4"}});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(out() / "log" / "solid.log"));
}

TEST_F(CommandWithStandIns, ForeignFoldersAreRefused) {
  fs::create_directories(out());
  std::ofstream(out() / "thesis.tex") << "precious";
  const auto outcome = run({});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, HasSubstr("not the folder of an earlier run"));
  EXPECT_TRUE(fs::exists(out() / "thesis.tex"));
}

TEST_F(CommandWithStandIns, TheFirstFailureIsReportedNotWhatFollows) {
  const auto outcome = run({{"fluid", "fail 4"}, {"coupler", "follow"}, {"solid", "follow"}});
  EXPECT_EQ(outcome.exit, 4);
  EXPECT_THAT(outcome.err, HasSubstr("fluid failed with exit code 4"));
  EXPECT_THAT(outcome.err, HasSubstr("pressure is not finite at particle 17"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("gave up")));
}

TEST_F(CommandWithStandIns, WarningsAreShownCountedAndEndWithSix) {
  const auto outcome = run({{"fluid", "lossy"}});
  EXPECT_EQ(outcome.exit, 6);
  EXPECT_THAT(outcome.err, HasSubstr("fluid: warning: water particles lost (2 by t = 0.5 s): far outside\n"));
  EXPECT_THAT(outcome.err,
              HasSubstr("ended, with warnings that put the result in doubt: fluid: water particles lost (3)"));
  EXPECT_THAT(outcome.out, HasSubstr("warnings\nfluid: water particles lost (3)\nfluid: cavitation (1)"));
  const auto about = text_of(out() / "run.toml");
  EXPECT_THAT(about, HasSubstr("exit = 6"));
  EXPECT_THAT(about, HasSubstr("\"fluid: water particles lost (3): far outside\""));
  EXPECT_TRUE(fs::exists(out() / "gauges.csv")) << "the run has ended, and what it left is gathered";
  // Without doubts about the result the exit code is 0.
  EXPECT_EQ(run({}).exit, 0);
}

TEST_F(CommandWithStandIns, DoubtsAboutTheCaseAreShown) {
  const auto doubtful = changed_case("[solid]", "[solid]\ninitial_seepage = true");
  const auto checked = poretwin({"check", doubtful.string(), "--set", "solid.initial_rest=false"});
  EXPECT_EQ(checked.exit, 0);
  EXPECT_THAT(checked.out, HasSubstr("sound, with warnings"));
  EXPECT_THAT(checked.out, HasSubstr("key 'solid.initial_seepage': has no effect: solid.initial_rest = false"));
  const auto ran = poretwin({"run", doubtful.string(), "--set", "solid.initial_rest=false", "--out", out().string(),
                             "--programs", PORETWIN_FAKES, "--no-pictures"});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.err, HasSubstr("has no effect: solid.initial_rest = false"));
  EXPECT_THAT(text_of(out() / "run.toml"), HasSubstr("initial_seepage"));
}

TEST_F(CommandWithStandIns, CheckNamesWhatNoMachineHolds) {
  const auto outcome = poretwin({"check", terzaghi().string(), "--set", "fluid.particle_spacing=1.1e-5"});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("key 'fluid.particle_spacing': about 992 GB for 3.31e+08 particles"));
  EXPECT_LT(outcome.seconds, 20.0);
}

TEST_F(CommandWithStandIns, FoldersAndFilesWithoutACaseAreNamed) {
  EXPECT_THAT(poretwin({"check", folder_.string()}).err, HasSubstr("the folder has no case.toml"));
  const auto absent = poretwin({"check", (folder_ / "absent.toml").string()});
  EXPECT_EQ(absent.exit, 5);
  EXPECT_THAT(absent.err, HasSubstr("absent.toml: no such file"));
  EXPECT_THAT(absent.err, Not(HasSubstr("did you mean")));
}

TEST_F(CommandWithStandIns, ACrashIsNamed) {
  const auto outcome = run({{"solid", "crash"}, {"coupler", "follow"}, {"fluid", "follow"}});
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_THAT(outcome.err, HasSubstr("solid was killed by signal 6 (Aborted)"));
}

TEST_F(CommandWithStandIns, TheDeafAreKilledAfterAFailure) {
  const auto outcome = run({{"fluid", "fail 4"}, {"solid", "deaf"}, {"coupler", "wait"}});
  EXPECT_EQ(outcome.exit, 4);
  EXPECT_LT(outcome.seconds, 20.0);
}

TEST_F(CommandWithStandIns, InterruptionEndsAllCleanly) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto outcome = run({{"fluid", "wait"}, {"solid", "wait"}, {"coupler", "wait"}}, [&](pid_t child) {
      while (!fs::exists(out() / "log" / "solid.log")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      ::kill(child, signal);
    });
    EXPECT_EQ(outcome.exit, 130);
    EXPECT_LT(outcome.seconds, 5.0);
    EXPECT_THAT(outcome.err, HasSubstr("stopping: the window under way is given up"));
    EXPECT_THAT(text_of(out() / "run.toml"), HasSubstr("reason = \"interrupted"));
    EXPECT_TRUE(fs::is_empty(folder_ / "temporary"));
    fs::remove_all(out());
  }
}

TEST_F(CommandWithStandIns, AMissingProgramIsNamed) {
  const auto outcome =
      poretwin({"run", terzaghi().string(), "--out", out().string(), "--programs", (folder_ / "temporary").string()});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, HasSubstr("poretwin-coupler: cannot be started: No such file or directory"));
}

TEST_F(CommandWithStandIns, VerifyJudgesAndWritesJson) {
  const auto place = folder_ / "ramp";
  fs::create_directories(place);
  fs::copy_file(terzaghi(), place / "case.toml");
  const auto verify =
      [&](const std::string& tolerance) {
        std::ofstream(place / "verify.toml")
            << "[[metric]]\nname = \"ramp\"\nop = \"value\"\ngauge = \"fluid_ramp\"\nat = 0.5\nreference = 1.1\n"
            << "tolerance = " << tolerance << "\nunit = \"m\"\n";
        return poretwin({"verify", place.string(), "--json", (folder_ / "v.json").string(), "--out",
                         (folder_ / "verify").string(), "--programs", PORETWIN_FAKES});
      };
  EXPECT_EQ(verify("0.2").exit, 0);
  const auto json = text_of(folder_ / "v.json");
  EXPECT_THAT(json, HasSubstr("\"case\": \"ramp\""));
  EXPECT_THAT(json, HasSubstr("\"passed\": true"));
  EXPECT_THAT(json, HasSubstr("\"fluid.windows\": 10"));
  EXPECT_THAT(json, HasSubstr("\"reference\": 1.1"));
  const auto missed = verify("0.05");
  EXPECT_EQ(missed.exit, 6);
  EXPECT_THAT(missed.out, HasSubstr("FAIL"));
}

}  // namespace
}  // namespace poretwin::testing_tools
