// The real `poretwin` with the real processes on a short part of a real case: the files of a run, and its exit when
// input, partners or machine are faulty.
#include "common/core/file_lock.hpp"
#include "tests/system/real_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double soon = 0.02;  // s, ten windows
const std::vector<std::string> briefly{"--set", "case.end_time=0.02"};

TEST_F(RealRun, LeavesReadableFilesAndTheRightPressure) {
  const auto outcome = poretwin(arguments(terzaghi(), briefly));
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  expect_results(soon);
  const auto gauges = read_gauges(out() / "gauges.csv");
  // Immediately after loading, the water carries the whole load: 1 kPa.
  EXPECT_NEAR(gauges.at("base_pressure").value.back(), 1000.0, 50.0);
  EXPECT_NEAR(gauges.at("base_pressure").time.back(), soon, 1e-12);
  EXPECT_LT(gauges.at("settlement").value.back(), 0.0);
  const auto run = text_of(out() / "run.toml");
  for (const char* part : {"case = \"terzaghi\"", "overrides = [\"case.end_time=0.02\"]", "exit = 0", "[exits]"})
    EXPECT_THAT(run, HasSubstr(part));
  EXPECT_THAT(outcome.out, HasSubstr("where the time went"));
}

TEST_F(RealRun, AProfilePutsAllThreeProcessesOnOneTimeLine) {
  auto profiled = briefly;
  profiled.emplace_back("--profile");
  const auto outcome = poretwin(arguments(terzaghi(), profiled));
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const auto trace = nlohmann::json::parse(text_of(out() / "trace.json"));
  std::map<int, std::string> names;
  for (const auto& event : trace["traceEvents"])
    if (event["name"] == "process_name") names[event["pid"].get<int>()] = event["args"]["name"].get<std::string>();
  using Spans = std::vector<std::pair<double, double>>;
  std::map<std::string, std::map<std::string, Spans>> spans;
  for (const auto& event : trace["traceEvents"])
    if (event["ph"] == "X") {
      const double begin = event["ts"].get<double>(), end = begin + event["dur"].get<double>();
      spans[names.at(event["pid"].get<int>())][event["name"].get<std::string>()].emplace_back(begin, end);
    }
  for (const char* process : {"coupler", "fluid", "solid"}) {
    const auto summary = nlohmann::json::parse(text_of(out() / (std::string(process) + ".summary.json")));
    for (const auto& [what, seconds] : summary["seconds"].items()) {
      std::string name = what;
      std::replace(name.begin(), name.end(), '_', ' ');
      double sum = 0.0;
      for (const auto& [begin, end] : spans[process][name]) sum += 1e-6 * (end - begin);
      EXPECT_NEAR(sum, seconds.get<double>(), 1e-6 + 1e-3 * sum) << process << ' ' << name;
    }
  }
  // The fluid crosses ten windows, and the coupler waits for it during each.
  const auto& waits = spans["coupler"]["waiting for fluid"];
  int seen = 0;
  for (const auto& [begin, end] : spans["fluid"]["computing"]) {
    const double middle = 0.5 * (begin + end);
    seen +=
        std::any_of(waits.begin(), waits.end(), [&](const auto& w) { return w.first < middle && middle < w.second; });
  }
  EXPECT_GE(seen, 10);
}

TEST_F(RealRun, ThreeProcessesMeetOverTcp) {
  const std::string address = "tcp://127.0.0.1:" + std::to_string(free_port());
  const auto solid = short_process("solid", address), fluid = short_process("fluid", address),
             coupler = short_process("coupler", address);
  EXPECT_EQ(coupler->wait(), 0) << text_of(log("coupler"));
  EXPECT_EQ(fluid->wait(), 0) << text_of(log("fluid"));
  EXPECT_EQ(solid->wait(), 0) << text_of(log("solid"));
  expect_results(soon);
  EXPECT_NEAR(read_gauges(out() / "gauges.fluid.csv").at("base_pressure").value.back(), 1000.0, 50.0);
}

TEST_F(RealRun, BadInputIsNamedBeforeAnythingStarts) {
  struct Bad {
    std::string from, to, message;
  };
  const std::vector<Bad> all{
      {"porosity", "porosty", "changed.toml:13: key 'soil[0].porosty' is not known; did you mean 'porosity'?"},
      {"porosity = 0.4", "porosity = -0.4", "expected a number in (0, 1), found -0.4"},
      {"[[0.1, 0], [0.1, 0.4]]", "[[0.05, 0], [0.3, 0]]", "wall[1] \"right\" lies on wall[0] \"base\""}};
  for (const auto& bad : all) {
    const auto outcome = poretwin(arguments(changed_case(bad.from, bad.to)));
    EXPECT_EQ(outcome.exit, 2);
    EXPECT_THAT(outcome.err, HasSubstr(bad.message));
    EXPECT_FALSE(fs::exists(out()));
  }
  const auto missing = poretwin(arguments(folder_ / "absent.toml"));
  EXPECT_EQ(missing.exit, 5);
  EXPECT_THAT(missing.err, HasSubstr("absent.toml"));
  const auto overridden = poretwin(arguments(terzaghi(), {"--set", "soil.0.porosity=2"}));
  EXPECT_EQ(overridden.exit, 2);
  EXPECT_THAT(overridden.err, HasSubstr("--set"));
}

TEST_F(RealRun, AFluidWithAnotherCaseIsRefused) {
  const auto coupler = short_process("coupler", socket()), solid = short_process("solid", socket()),
             fluid = short_process("fluid", socket(), {"--set", "water.density=900.0"});
  EXPECT_EQ(fluid->wait(), 3);
  EXPECT_EQ(coupler->wait(), 3);
  EXPECT_EQ(solid->wait(), 3);
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("refused by the coupler: case_digest: expected"));
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("refused meanwhile: fluid: case_digest"));
}

TEST_F(RealRun, ASecondFluidIsRefusedAndTheRunGoesOn) {
  const auto coupler = short_process("coupler", socket(), {"--wait-deadline", "5"}),
             first = short_process("fluid", socket());
  wait_for([&] { return text_of(log("coupler")).find("fluid") != std::string::npos; });
  const auto second_log = folder_ / "second.log";
  Child second({(fs::path(PORETWIN_PROGRAM).parent_path() / "poretwin-fluid").string(), "--case", terzaghi().string(),
                "--out", (folder_ / "second").string(), "--connect", socket(), "--set", "case.end_time=0.02"},
               second_log);
  EXPECT_EQ(second.wait(), 3);
  EXPECT_THAT(text_of(second_log), HasSubstr("a second fluid"));
  const auto solid = short_process("solid", socket());
  EXPECT_EQ(coupler->wait(), 0) << text_of(log("coupler"));
  EXPECT_EQ(first->wait(), 0);
  EXPECT_EQ(solid->wait(), 0);
}

TEST_F(RealRun, APeerOfAnotherDimensionIsRefused) {
  const auto coupler = short_process("coupler", socket()), solid = short_process("solid", socket()),
             fluid = short_process("fluid", socket(), {}, {{"PORETWIN_MOCK_DIMENSION", "3"}},
                                   programs_with_mock("fluid") / "poretwin-fluid");
  EXPECT_EQ(fluid->wait(), 3);
  EXPECT_EQ(coupler->wait(), 3);
  EXPECT_EQ(solid->wait(), 3);
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("dimension: expected 2, got 3"));
}

TEST_F(RealRun, NanFromAPeerEndsEverybodyAndFilesStayWhole) {
  const auto outcome = poretwin(arguments(terzaghi(), {"--programs", programs_with_mock("fluid").string(), "--set",
                                                       "case.end_time=0.2", "--set", "output.interval=0.0005"}),
                                {{"PORETWIN_MOCK_NAN_AT", "6"}});
  EXPECT_EQ(outcome.exit, 3) << outcome.err;
  EXPECT_LT(outcome.seconds, 15.0);
  EXPECT_THAT(outcome.err, HasSubstr("expected a finite number, got nan"));
  EXPECT_THAT(outcome.err, HasSubstr("pore_pressure"));
  for (const char* name : {"fluid.vtkhdf", "solid.vtkhdf"}) {
    const auto times = steps_in(out() / name);
    ASSERT_GE(times.size(), 2u) << name;
    EXPECT_LE(times.back(), 0.012 + 1e-12) << name;
  }
  const auto gauges = read_gauges(out() / "gauges.csv");
  EXPECT_FALSE(gauges.empty());
  EXPECT_THAT(text_of(out() / "run.toml"), HasSubstr("exit = 3"));
}

TEST_F(RealRun, AKilledSolidEndsTheRunWithItsName) {
  std::chrono::steady_clock::time_point killed;
  const auto outcome =
      poretwin(arguments(terzaghi(), {"--set", "output.interval=0.004", "--restarts", "0"}), {}, [&](pid_t command) {
        wait_for([&] { return text_of(out() / "gauges.solid.csv").find("\n0.01") != std::string::npos; });
        const pid_t solid = child_called(command, "poretwin-solid");
        ASSERT_GT(solid, 0);
        killed = std::chrono::steady_clock::now();
        ::kill(solid, SIGKILL);
      });
  EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(5));
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_THAT(outcome.err, HasSubstr("solid was killed by signal 9 (Killed)"));
  EXPECT_GE(steps_in(out() / "fluid.vtkhdf").size(), 2u);
  EXPECT_GE(steps_in(out() / "solid.vtkhdf").size(), 2u);
}

TEST_F(RealRun, SafetyBracketsTheFactorAndListsItsTrials) {
  const auto slope = fs::path(PORETWIN_SOURCE_DIR) / "cases" / "cohesive_slope" / "case.toml";
  const auto outcome = poretwin({"safety", slope.string(), "--out", out().string(), "--no-pictures", "--tolerance",
                                 "0.2", "--set", "solid.particle_spacing=1", "--set", "soil.0.friction_angle=25",
                                 "--json", (folder_ / "safety.json").string()});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("F = 1.0000   stands"));
  EXPECT_THAT(outcome.out, HasSubstr("F = 2.0000   fails"));
  EXPECT_THAT(outcome.out, HasSubstr("factor of safety 1."));
  const auto factor = read_gauges(out() / "gauges.csv").at("factor_of_safety").value.front();
  EXPECT_GT(factor, 1.4);
  EXPECT_LT(factor, 1.8);
  const auto written = nlohmann::json::parse(text_of(folder_ / "safety.json"));
  EXPECT_NEAR(written["factor"], factor, 1e-5);
  EXPECT_EQ(written["trials"][0]["stands"], true);
  EXPECT_LT(written["stands"], written["fails"]);
  EXPECT_THAT(text_of(out() / "safety.csv"), HasSubstr("1,1,"));
  EXPECT_TRUE(fs::exists(out() / "F_1.0000" / "run.toml"));
}

/// Uniform suction in soil with a degree of saturation S acts as a cohesion of S gamma_w |psi| tan(phi) (Bishop 1959).
TEST_F(RealRun, SuctionHoldsASlopeAsItsCohesionWould) {
  const auto factor = [&](double cohesion, double grains, const std::string& water) {
    const auto file = folder_ / "slope.toml";
    std::ofstream(file) << fmt::format(
        "[case]\nend_time = 1\n"
        "[[soil]]\nshape = \"polygon\"\npoints = [[0, 0], [8, 0], [8, 1], [6, 1], [4, 3], [0, 3]]\n"
        "porosity = 0.3\ngrain_density = {}\nhydraulic_conductivity = 1e-9\nyoungs_modulus = 50e6\n"
        "cohesion = {}\nfriction_angle = 20\n{}"
        "[[wall]]\npoints = [[0, 4], [0, 0]]\n[[wall]]\npoints = [[0, 0], [8, 0]]\nsoil = \"fixed\"\n"
        "[[wall]]\npoints = [[8, 0], [8, 2]]\n[solid]\nmodel = \"mohr_coulomb\"\nparticle_spacing = 0.25\n",
        grains, cohesion, water);
    const auto outcome = poretwin({"safety", file.string(), "--out", out().string(), "--no-pictures", "--quiet",
                                   "--tolerance", "0.02", "--json", (folder_ / "safety.json").string()});
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return nlohmann::json::parse(text_of(folder_ / "safety.json"))["factor"].get<double>();
  };
  const double suction = 0.5 * 9810.0;  // Pa, S gamma_w times 1 m
  const double wet = factor(2000.0, 2900.0,
                            "retention = { model = \"gardner\", alpha = 0.6931472 }\n[fluid]\n"
                            "representation = \"field\"\nparticle_spacing = 0.25\ninitial_pressure_head = -1\n"),
               dry = factor(2000.0 + suction * std::tan(20.0 * std::numbers::pi / 180.0),
                            2900.0 + 0.5 * 0.3 / 0.7 * 1000.0, "");
  EXPECT_NEAR(wet, dry, 0.025);
}

/// A dam whose reservoir is filled, coarse, with readings of its factor of safety and frames every 432000 s.
class SafetyOfARun : public RealRun {
 protected:
  void SetUp() override {
    RealRun::SetUp();
    fs::copy_file(fs::path(PORETWIN_SOURCE_DIR) / "cases" / "rapid_drawdown" / "case.toml", folder_ / "dam.toml");
    const auto outcome = poretwin({"run", (folder_ / "dam.toml").string(), "--out", out().string(), "--until", "864000",
                                   "--set", "fluid.particle_spacing=1", "--set", "gauge.0.every=432000", "--set",
                                   "output.interval=432000", "--no-pictures", "--quiet"});
    ASSERT_EQ(outcome.exit, 0) << outcome.err;
  }
  Outcome safety(std::vector<std::string> more) const {
    more.insert(more.begin(), {"safety", out().string(), "--no-pictures"});
    return poretwin(more);
  }
};

TEST_F(SafetyOfARun, IsWhatItsGaugeRead) {
  const auto outcome = safety({"--every", "432000", "--json", (folder_ / "safety.json").string()});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("dam fails at '"));
  EXPECT_THAT(outcome.out, HasSubstr("least factor of safety 1."));
  const auto gauge = read_gauges(out() / "gauges.csv");
  const auto found = read_gauges(out() / "safety" / "gauges.csv");
  EXPECT_EQ(found.at("factor_of_safety").time, gauge.at("F").time);
  EXPECT_EQ(found.at("factor_of_safety").value, gauge.at("F").value);
  EXPECT_EQ(found.at("factor_of_safety_error").value, gauge.at("F_error").value);
  const auto written = nlohmann::json::parse(text_of(folder_ / "safety.json"));
  ASSERT_EQ(written["instants"].size(), 3U);
  EXPECT_NEAR(written["instants"][2]["factor"], gauge.at("F").value.back(), 1e-7);
  EXPECT_EQ(written["instants"][2]["failing"]["soil"], "dam");
  // Filled to eight of ten metres, the dam fails on the dry side.
  EXPECT_EQ(written["instants"][2]["failing"]["face"], "downstream slope");
  EXPECT_GT(written["instants"][2]["failing"]["towards"][0], 0.5);
  EXPECT_THAT(text_of(out() / "safety" / "safety.csv"), HasSubstr("\n2,864000,"));
  EXPECT_EQ(steps_in(out() / "safety" / "solid.vtkhdf").size(), 3U);
}

TEST_F(SafetyOfARun, TakesTheNearestFrameAndSaysSo) {
  const auto nearest = safety({"--at", "436000", "--tolerance", "0.2", "--out", (folder_ / "elsewhere").string()});
  EXPECT_EQ(nearest.exit, 0) << nearest.err;
  EXPECT_THAT(nearest.err, HasSubstr("no frame at 436000 s: the nearest is taken, at 432000 s"));
  EXPECT_THAT(nearest.out, HasSubstr("t = 432000"));
  const auto last = safety({"--tolerance", "0.2"});
  EXPECT_EQ(last.exit, 0) << last.err;
  EXPECT_THAT(last.out, HasSubstr("t = 864000"));
  EXPECT_THAT(last.out, HasSubstr("; 1 instant"));
}

TEST_F(SafetyOfARun, IsRefusedWithTheReason) {
  auto refused = safety({"--at", "432000,900000"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("--at: expected times from 0 to 864000 s"));
  EXPECT_THAT(refused.err, HasSubstr("found 900000"));
  refused = safety({"--set", "soil.0.cohesion=0"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("--set: the soil is that of the run"));
  refused = safety({"--out", out().string()});
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, HasSubstr("expected a folder that is not a run's"));
  EXPECT_FALSE(read_gauges(out() / "gauges.csv").empty());
  {
    const FileLock run(out() / "run.lock", "a test", FileLock::Inherited::no);
    run.sign("a run");
    refused = safety({});
    EXPECT_EQ(refused.exit, 5);
    EXPECT_THAT(refused.err, HasSubstr("a run writes into this folder"));
  }
  fs::remove(out() / "solid.vtkhdf");
  refused = safety({});
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, HasSubstr("solid.vtkhdf: expected the frames of the soil"));
  std::ofstream(folder_ / "dam.toml", std::ios::app) << "# changed\n";
  refused = safety({});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("the case has changed since the run"));
}

TEST_F(RealRun, SafetyOfARunNeedsSoilThatCanFailAndARun) {
  auto refused = poretwin({"safety", terzaghi().string(), "--at", "1"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("--at, --every: expected the folder of a run that has ended"));
  ASSERT_EQ(poretwin(arguments(terzaghi(), {"--until", "0.001"})).exit, 0);
  refused = poretwin({"safety", out().string()});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("a factor of safety needs soil that can fail"));
}

}  // namespace
}  // namespace poretwin::testing_tools
