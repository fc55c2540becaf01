// The operations of verify.toml, and the verify.toml of all cases.
#include "cli/metrics.hpp"
#include "cli/locate.hpp"
#include "common/case/case.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace poretwin::cli {
namespace {

Gauges sampled(const std::string& name, double (*f)(double)) {
  GaugeSeries series;
  series.unit = "m";
  for (int i = 0; i <= 100; ++i) {
    series.time.push_back(0.01 * i);
    series.value.push_back(f(0.01 * i));
  }
  return {{name, series}};
}

Metric metric(const std::string& op, double reference, double tolerance) {
  Metric m;
  m.op = op;
  m.gauge = "g";
  m.reference = reference;
  m.tolerance = tolerance;
  return m;
}

const Gauges ramp = sampled("g", [](double t) { return 2.0 * t; });
const Gauges decay = sampled("g", [](double t) { return 1.0 + 3.0 * std::exp(-5.0 * t); });

TEST(Metrics, ValueInterpolatesAndScales) {
  auto m = metric("value", 10.1, 1e-9);
  m.at = 0.505;
  m.scale = 10.0;
  EXPECT_NEAR(judge(m, ramp, 0).value, 10.1, 1e-12);
  EXPECT_TRUE(judge(m, ramp, 0).passed);
  m.at = 1.5;
  EXPECT_FALSE(judge(m, ramp, 0).passed) << "outside the readings is no value";
  m.gauge = "absent";
  EXPECT_EQ(judge(m, ramp, 0).complaint, "no readings of gauge 'absent'");
}

// A pressure gauge is dry until the water comes.
TEST(Metrics, ReadingsOutsideThePhaseHaveAValueWhereItIsGiven) {
  Gauges dry = ramp;
  for (std::size_t i = 0; i < 50; ++i) dry["g"].value[i] = std::nan("");
  auto m = metric("mean", 0.75, 0.02);
  EXPECT_EQ(judge(m, dry, 0).complaint, "gauge 'g' is not a number in the range");
  m.absent = 0.0;
  EXPECT_NEAR(judge(m, dry, 0).value, 0.75, 0.01) << "zero up to 0.5 s, then 2 t";
  m.scale = 10.0;
  m.absent = 1.0;
  EXPECT_NEAR(judge(m, dry, 0).value, 12.5, 0.1) << "in the unit of the gauge";
}

TEST(Metrics, HistoriesAreJudgedByTheirMeanAndTheirSpread) {
  auto m = metric("relative", 10.0, 0.02);
  const auto of = [&](double value) {
    Verdict v;
    v.value = value;
    v.reference = 10.0;
    return v;
  };
  // No single history is within 2 %, but their mean is.
  auto v = judge_mean(m, {of(9.7), of(10.3), of(10.0)});
  EXPECT_NEAR(v.value, 10.0, 1e-12);
  EXPECT_NEAR(v.spread, 0.3, 1e-12);
  EXPECT_EQ(v.histories, 3u);
  EXPECT_TRUE(v.passed);
  m.spread = 0.02;  // relative to the reference
  v = judge_mean(m, {of(9.7), of(10.3), of(10.0)});
  EXPECT_FALSE(v.passed);
  EXPECT_EQ(v.complaint, "the histories spread by 0.3, 0.2 allowed");
  m.spread = 0.04;
  EXPECT_TRUE(judge_mean(m, {of(9.7), of(10.3), of(10.0)}).passed);
  EXPECT_FALSE(judge_mean(m, {of(10.5), of(10.3), of(10.4)}).passed) << "a mean that is off";
  Verdict none = of(std::nan(""));
  none.complaint = "no readings of gauge 'g'";
  v = judge_mean(m, {of(10.0), none});
  EXPECT_FALSE(v.passed);
  EXPECT_EQ(v.complaint, none.complaint);
}

TEST(Metrics, AHistoryDiffersByItsSeedAndWhatVaries) {
  VerifyRun run;
  run.vary = {"soil.0.cohesion=550"};
  Case scene;
  scene.soils.resize(1);
  scene.fluid.regions.resize(1);
  EXPECT_TRUE(history(run, scene, 0).empty()) << "the first is the case as it is";
  std::set<std::string> all;
  for (std::size_t number = 1; number < 9; ++number) {
    const auto set = history(run, scene, number);
    ASSERT_EQ(set.size(), 5u);
    EXPECT_EQ(set[0], "fluid.jitter=1e-6");
    EXPECT_EQ(set[3], "solid.seed=" + std::to_string(number));
    const double cohesion = std::stod(set[4].substr(set[4].find('=') + 1));
    EXPECT_LE(std::abs(cohesion - 550.0), 5.5);
    all.insert(set[4]);
  }
  EXPECT_EQ(all.size(), 8u);
  scene.fluid.regions.clear();
  EXPECT_EQ(history(run, scene, 1).front(), "solid.jitter=1e-6") << "there is no water to displace";
}

// Two modes sin(pi s / 2) and sin(3 pi s / 2) at the centres of ten intervals: the weights select the first.
TEST(Metrics, WeightsAddTheGaugesOfALine) {
  Gauges gauges;
  auto m = metric("value", 3.0, 1e-12);
  for (int i = 0; i < 10; ++i) {
    const double s = 0.05 + 0.1 * i, q = 0.5 * 3.14159265358979323846;
    GaugeSeries series;
    series.time = {0.0, 1.0};
    series.value = {0.0, 3.0 * std::sin(q * s) + 5.0 * std::sin(3.0 * q * s)};
    gauges["g[" + std::to_string(i) + "]"] = series;
    m.weights.push_back(0.2 * std::sin(q * s));
  }
  EXPECT_NEAR(judge(m, gauges, 0).value, 3.0, 1e-12);
  EXPECT_TRUE(judge(m, gauges, 0).passed);
  m.at = 0.5;
  EXPECT_NEAR(judge(m, gauges, 0).value, 1.5, 1e-12);
  m.weights.pop_back();
  EXPECT_EQ(judge(m, gauges, 0).complaint, "10 gauges 'g' and 9 weights do not match");
}

TEST(Metrics, WhatTheBaselineHasIsSubtracted) {
  auto m = metric("decay_rate", 3.0, 1e-9);
  m.limit = 0.0;
  m.baseline = "sealed";
  const Gauges fast = sampled("g", [](double t) { return 7.0 * std::exp(-5.0 * t); });
  const Gauges slow = sampled("g", [](double t) { return 2.0 * std::exp(-2.0 * t); });
  const Verdict base = judge(m, slow, 0);
  EXPECT_NEAR(judge(m, fast, 0, {}, &base).value, 3.0, 1e-9);
  EXPECT_TRUE(judge(m, fast, 0, {}, &base).passed);
  const Verdict none = judge(m, {}, 0);
  EXPECT_EQ(judge(m, fast, 0, {}, &none).complaint, "'sealed': no readings of gauge 'g'");
}

TEST(Metrics, DampingIsThatOfWholeSwings) {
  GaugeSeries series;
  for (int i = 0; i <= 400; ++i) {
    series.time.push_back(0.01 * i);
    series.value.push_back(1.0 + 3.0 * std::exp(-0.2 * 0.01 * i) * std::cos(7.0 * 0.01 * i));
  }
  auto m = metric("damping", 0.2, 1e-3);
  m.limit = 1.0;
  EXPECT_TRUE(judge(m, {{"g", series}}, 0).passed) << judge(m, {{"g", series}}, 0).value;
  m.to = 1.2;
  EXPECT_EQ(judge(m, {{"g", series}}, 0).complaint, "fewer than three whole swings of gauge 'g'");
}

TEST(Metrics, ValueOfARangeIsItsMean) {
  auto m = metric("value", 1.7, 1e-9);
  m.from = 0.8;
  m.to = 0.9;
  EXPECT_NEAR(judge(m, ramp, 0).value, 1.7, 1e-12);
  m.reference = 0.0;
  m.tolerance = 1.69;
  EXPECT_FALSE(judge(m, ramp, 0).passed) << "held against zero as a single reading is";
}

TEST(Metrics, MarksStandWhereReadingsShouldBeInTheirOwnUnit) {
  auto m = metric("value", 10.0, 0.2);
  m.at = 0.5;
  m.scale = 10.0;
  auto marks = judge(m, ramp, 0).marks;
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0].gauge, "g");
  EXPECT_EQ(marks[0].time, 0.5);
  EXPECT_DOUBLE_EQ(marks[0].value, 1.0);
  EXPECT_DOUBLE_EQ(marks[0].value_error, 0.02);
  EXPECT_EQ(marks[0].time_error, 0.0);
  m = metric("crossing", 0.4, 0.1);
  m.limit = 0.8;
  marks = judge(m, ramp, 0).marks;
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_DOUBLE_EQ(marks[0].time, 0.4);
  EXPECT_DOUBLE_EQ(marks[0].value, 0.8);
  EXPECT_DOUBLE_EQ(marks[0].time_error, 0.04);
  m = metric("curve", 0.0, 1.0);
  m.curve.emplace();
  m.curve->knots = {{0.1, 0.3}, {0.3, 0.7}};  // the ramp, a twentieth of a second earlier
  m.align = 0.5;
  marks = judge(m, ramp, 0).marks;
  ASSERT_EQ(marks.size(), 2U);
  EXPECT_NEAR(marks[0].time, 0.15, 1e-9) << "by the clock of the readings";
  EXPECT_TRUE(judge(metric("max_abs", 0.0, 3.0), ramp, 0).marks.empty());
}

TEST(Metrics, RelativeAndLast) { EXPECT_NEAR(judge(metric("relative", 1.6, 0.3), ramp, 0).error, 0.25, 1e-12); }

TEST(Metrics, NotANumberNeverPasses) {
  Gauges gauges = ramp;
  gauges["g"].value.back() = std::nan("");
  EXPECT_FALSE(judge(metric("value", 2.0, 1e9), gauges, 0).passed);
  EXPECT_FALSE(judge(metric("max_abs", 0.0, 1e9), gauges, 0).passed);
  EXPECT_FALSE(judge(metric("exceeds", -1e9, 0.0), gauges, 0).passed);
}

TEST(Metrics, DecayRateOfAnExponential) {
  auto m = metric("decay_rate", 5.0, 1e-9);
  m.limit = 1.0;
  EXPECT_NEAR(judge(m, decay, 0).value, 5.0, 1e-9);
  EXPECT_TRUE(judge(m, decay, 0).passed);
}

TEST(Metrics, MonotoneSeesReversalsAndOvershoot) {
  auto m = metric("monotone", 0.0, 0.0);
  m.limit = 1.0;
  EXPECT_TRUE(judge(m, decay, 0).passed);
  const Gauges ringing = sampled("g", [](double t) { return 1.0 + std::exp(-5.0 * t) * std::cos(40.0 * t); });
  EXPECT_GT(judge(m, ringing, 0).value, 0.05);
  const Gauges overshooting = sampled("g", [](double t) { return t < 0.005 ? 3.0 : 0.9; });
  EXPECT_NEAR(judge(m, overshooting, 0).value, 0.01, 1e-12);
}

TEST(Metrics, TimeOfTheLargestIsThatOfAParabola) {
  Gauges hill = sampled("g", [](double t) { return 1.0 - (t - 0.437) * (t - 0.437); });
  const auto m = metric("time_of_largest", 0.4, 0.1);
  EXPECT_NEAR(judge(m, hill, 0).value, 0.437, 1e-9);
  EXPECT_TRUE(judge(m, hill, 0).passed) << "0.0925 of the reference off";
  auto& series = hill["g"];  // readings at uneven times
  series.time.erase(series.time.begin() + 44);
  series.value.erase(series.value.begin() + 44);
  EXPECT_NEAR(judge(m, hill, 0).value, 0.437, 1e-9);
  EXPECT_THAT(judge(m, ramp, 0).complaint, testing::HasSubstr("is the first or the last"));
}

TEST(Metrics, MaxAbsDriftAndExceeds) {
  auto m = metric("max_abs", 0.5, 2.0);
  m.from = 0.2;
  EXPECT_NEAR(judge(m, ramp, 0).error, 1.5, 1e-12);
  m = metric("drift", 0.0, 0.5);
  m.normaliser = 4.0;
  EXPECT_NEAR(judge(m, ramp, 0).error, 0.5, 1e-12);
  EXPECT_TRUE(judge(metric("exceeds", 1.9, 0.0), ramp, 0).passed);
  EXPECT_FALSE(judge(metric("exceeds", 2.1, 0.0), ramp, 0).passed);
  EXPECT_TRUE(judge(metric("smallest", -0.5, 0.0), ramp, 0).passed);
  EXPECT_NEAR(judge(metric("smallest", 0.5, 0.4), ramp, 0).error, 0.5, 1e-12);
}

TEST(Metrics, SumsOfGauges) {
  Gauges gauges = ramp;
  gauges["h"] = sampled("h", [](double t) { return -2.0 * t; })["h"];
  auto m = metric("drift", 0.0, 1e-12);
  m.plus = "h";
  EXPECT_TRUE(judge(m, gauges, 0).passed);
}

TEST(Metrics, L2OverAnArrayOfGauges) {
  Gauges gauges;
  for (int i = 0; i < 3; ++i) gauges["p[" + std::to_string(i) + "]"] = {"Pa", {0.0}, {10.0 * i}};
  auto m = metric("l2", 0.0, 0.1);
  m.gauge = "p";
  m.references = {3.0, 10.0, 20.0};
  m.normaliser = 20.0;
  EXPECT_NEAR(judge(m, gauges, 0).error, std::sqrt(3.0) / 20.0, 1e-12);
  m.references.pop_back();
  EXPECT_FALSE(judge(m, gauges, 0).passed) << "the counts differ";
}

TEST(Metrics, CrossingPeriodAndCounter) {
  auto m = metric("crossing", 0.25, 0.01);
  m.limit = 0.5;
  EXPECT_NEAR(judge(m, ramp, 0).value, 0.25, 1e-9);
  m.limit = 5.0;
  EXPECT_EQ(judge(m, ramp, 0).complaint, "gauge 'g' never reaches 5");
  Gauges lost = ramp;  // NaN is allowed after the crossing, not before it
  lost["g"].value.back() = NAN;
  m.limit = 0.5;
  EXPECT_NEAR(judge(m, lost, 0).value, 0.25, 1e-9);
  lost["g"].value[1] = NAN;
  EXPECT_FALSE(judge(m, lost, 0).passed);
  lost["g"].value[0] = NAN;
  EXPECT_EQ(judge(m, lost, 0).complaint, "gauge 'g' is not a number in the range");
  const Gauges wave = sampled("g", [](double t) { return 1.0 + std::sin(2.0 * 3.14159265358979 * (t - 0.05) / 0.3); });
  m = metric("period", 0.3, 0.01);
  m.limit = 1.0;
  EXPECT_NEAR(judge(m, wave, 0).value, 0.3, 1e-3);
  const Gauges trembling = sampled("g", [](double t) {
    return 1.0 + std::cos(2.0 * 3.14159265358979 * t / 0.3) + 0.15 * std::sin(2.0 * 3.14159265358979 * t / 0.007);
  });
  EXPECT_NEAR(judge(m, trembling, 0).value, 0.3, 0.02);
  EXPECT_FALSE(judge(m, ramp, 0).passed);
  m = metric("counter", 500.0, 0.0);
  m.counter = "solid.steps";
  EXPECT_TRUE(judge(m, ramp, 0, {{"solid.steps", 499.0}}).passed);
  EXPECT_FALSE(judge(m, ramp, 0, {{"solid.steps", 501.0}}).passed);
  EXPECT_EQ(judge(m, ramp, 0).complaint, "the run has no counter 'solid.steps'");
}

TEST(Metrics, CurveAndExit) {
  auto m = metric("curve", 0.0, 0.02);
  m.curve = Series{{{0.25, 0.5}, {0.5, 1.01}, {2.0, 5.0}}};
  m.to = 1.0;
  EXPECT_NEAR(judge(m, ramp, 0).error, 0.01 / 1.01, 1e-12);
  // The same ramp half a second later: times count from where both pass 0.5.
  m.curve = Series{{{0.5, 0.0}, {1.25, 1.5}}};
  m.to = 1.3;
  EXPECT_FALSE(judge(m, ramp, 0).passed);
  m.align = 0.5;
  m.from = 1.0;
  EXPECT_NEAR(judge(m, ramp, 0).error, 0.0, 1e-12);
  EXPECT_TRUE(judge(metric("exit", 4.0, 0.0), {}, 4).passed);
  EXPECT_FALSE(judge(metric("exit", 4.0, 0.0), {}, 0).passed);
}

/// Names of the cases that ship with a verify.toml.
std::vector<std::string> verified_cases() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases"))
    if (std::filesystem::exists(entry.path() / "verify.toml")) names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

struct VerifyFile : testing::TestWithParam<std::string> {};

TEST_P(VerifyFile, IsSoundAsItsRunsAre) {
  const auto folder = std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases" / GetParam();
  for (const auto& run : read_verify(folder / "verify.toml").runs) {
    auto overrides = run.set;
    EXPECT_NO_THROW(read_case(folder / run.case_file, overrides)) << run.name;
    if (run.short_set.empty()) continue;
    overrides.insert(overrides.end(), run.short_set.begin(), run.short_set.end());
    EXPECT_NO_THROW(read_case(folder / run.case_file, overrides)) << run.name;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "README.md"));
}
INSTANTIATE_TEST_SUITE_P(Cases, VerifyFile, testing::ValuesIn(verified_cases()),
                         [](const auto& name) { return name.param; });

/// The message on a verify.toml with these lines.
std::string said_of(const std::string& lines) {
  const auto path = std::filesystem::temp_directory_path() / fmt::format("poretwin-verify-{}.toml", ::getpid());
  std::ofstream(path) << lines;
  std::string said;
  try {
    read_verify(path);
  } catch (const CaseError& error) {
    said = error.what();
  }
  std::filesystem::remove(path);
  return said;
}

constexpr const char* a_metric = "[[metric]]\nname = \"m\"\nop = \"max_abs\"\ngauge = \"g\"\n";

/// The message on a verify.toml with this [[figure]].
std::string said_of_figure(const std::string& lines) {
  return said_of(std::string("[[run]]\nname = \"whole\"\n[[run]]\nname = \"other\"\n") + a_metric +
                 "[[figure]]\nname = \"one\"\n" + lines);
}

TEST(VerifyFiles, RunsAreNamedAsFoldersEachOnce) {
  using testing::HasSubstr;
  const auto said = [](const std::string& first, const std::string& second) {
    return said_of("[[run]]\nhistories = 3\nname = \"" + first + "\"\n[[run]]\nname = \"" + second + "\"\n" + a_metric);
  };
  EXPECT_EQ(said("k 1e-3, 2 cm", "fine"), "");
  EXPECT_EQ(said("a", "a.4"), "");
  for (const std::string name : {"a/b", "/tmp/a", "../a", "..", ".", ""})
    EXPECT_THAT(said("fine", name),
                HasSubstr("run[1].name': expected the name of a folder without '/', found \"" + name));
  EXPECT_THAT(said("fine", "fine"), HasSubstr("run[1].name': \"fine\" is the name of another [[run]], too"));
  EXPECT_THAT(said("a", "a.3"), HasSubstr("\"a.3\" is the folder of history 3 of run \"a\""));
}

TEST(VerifyFiles, FiguresThatCannotBeDrawnAreNamed) {
  using testing::HasSubstr;
  EXPECT_EQ(said_of_figure("kind = \"history\"\ngauges = [\"g\"]\n"), "");
  EXPECT_EQ(said_of_figure("kind = \"outlines\"\nruns = [\"whole\", \"other\"]\nlabels = [\"a\", \"b\"]\n"), "");
  EXPECT_THAT(said_of_figure("kind = \"map\"\n"), HasSubstr("figure[0].kind': expected \"fields\" or \"outlines\""));
  EXPECT_THAT(said_of_figure("kind = \"fields\"\n"), HasSubstr("figure[0].fields': is missing"));
  EXPECT_THAT(said_of_figure("kind = \"profile\"\n"), HasSubstr("figure[0].gauges': is missing"));
  EXPECT_THAT(said_of_figure("kind = \"outlines\"\nruns = [\"absent\"]\n"),
              HasSubstr("no [[run]] is named \"absent\""));
  EXPECT_THAT(said_of_figure("kind = \"fields\"\nfields = [\"velocity\"]\nruns = [\"whole\", \"other\"]\n"),
              HasSubstr("\"fields\" shows one run, found 2"));
  EXPECT_THAT(said_of_figure("kind = \"history\"\ngauges = [\"g\", \"h\"]\nlabels = [\"a\"]\n"),
              HasSubstr("expected one for each of the 2, found 1"));
}

}  // namespace
}  // namespace poretwin::cli
