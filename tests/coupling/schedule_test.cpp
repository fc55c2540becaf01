// The coupler with two mocks: order of messages, windows, output times, rejections, changing point sets; over every
// transport.
#include "common/coupling/interrupt.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <atomic>
#include <cmath>
#include <csignal>

namespace poretwin::coupling {
namespace {

class EveryLine : public testing::TestWithParam<Line> {};
INSTANTIATE_TEST_SUITE_P(Lines, EveryLine, testing::Values(Line::in_process, Line::ipc, Line::tcp),
                         [](const auto& line) { return line_name(line.param); });

TEST_P(EveryLine, RunsFromHandshakeToGoodbye) {
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid)), solid(Role::solid, 2, still_square(Role::solid, 0.125));
  CoupledRun run;
  run.line = GetParam();
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.windows, 10u);
  EXPECT_EQ(fluid.seen().windows.size(), 10u);
  EXPECT_EQ(solid.seen().windows.size(), 10u);
  EXPECT_DOUBLE_EQ(fluid.time(), 1.0);
  EXPECT_EQ(run.fluid_record.frames.size(), 2u);  // first and last
  EXPECT_EQ(run.solid_record.frames.size(), 2u);
  EXPECT_EQ(run.fluid.report.windows, 10u);
  EXPECT_EQ(run.fluid_record.series.size(), 11u);
  // Points at rest are sent once by each side.
  EXPECT_EQ(run.report.points_unchanged, 22u);
}

TEST(Schedule, TheSolidSeesTheFluidsNewFieldsTheFluidTheSolidsOld) {
  const FieldFormula time_everywhere = [](const std::string& name, int, const double*, double t) {
    return within_bounds(name, t);
  };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid, 0.1, time_everywhere));
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.1, time_everywhere));
  CoupledRun run;
  run.run(&fluid, &solid);
  run.expect_success();
  for (std::size_t k = 0; k < 10; ++k) {
    const auto& window = fluid.seen().windows[k];
    const auto& to_fluid = fluid.seen().inboxes[k + 1];  // the first is that of initialise
    const auto& to_solid = solid.seen().inboxes[k + 1];
    EXPECT_NEAR(to_fluid.at(field::constrained_modulus).values[55], window.time, 1e-12);
    EXPECT_NEAR(to_solid.at(field::pore_pressure).values[55], window.time + window.interval, 1e-12);
  }
}

/// The coupler is informed during the present window, however rare heartbeats are.
TEST_P(EveryLine, ASolversInterruptEndsTheRunWithinTwoWindows) {
  std::atomic<bool> pressed = false;
  const auto square = still_square(Role::fluid);
  MockPhase fluid(Role::fluid, 2, [&](double t) {
    if (t > 0.35) pressed = true;
    return square(t);
  });
  MockPhase solid(Role::solid, 2, still_square(Role::solid));
  CoupledRun run;
  run.line = GetParam();
  run.settings = {100.0, 0.1, 0.0, 0.0};
  run.broker.heartbeat = Milliseconds(10000);
  run.participant.interrupted = [&] { return pressed.load(); };
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_TRUE(run.report.interrupted);
  EXPECT_TRUE(run.fluid.report.interrupted);
  EXPECT_GE(run.report.windows, 4u);
  EXPECT_LE(run.report.windows, 6u);
}

/// A solver that is asked to stop gives up the window under way: both sides end at its start, whoever refused it.
TEST_P(EveryLine, AWindowThatIsRefusedAfterAnInterruptIsNotRepeated) {
  for (const Role who : {Role::fluid, Role::solid}) {
    MockKnobs knobs;
    knobs.rejections = {{4, 1000}};
    std::atomic<bool> pressed = false;
    const auto pressing = [&](Role role) {
      return [&pressed, square = still_square(role)](double t) {
        if (t > 0.25) pressed = true;
        return square(t);
      };
    };
    MockPhase fluid(Role::fluid, 2, pressing(Role::fluid), who == Role::fluid ? knobs : MockKnobs{});
    MockPhase solid(Role::solid, 2, still_square(Role::solid), who == Role::solid ? knobs : MockKnobs{});
    CoupledRun run;
    run.line = GetParam();
    run.participant.interrupted = [&] { return pressed.load(); };
    run.run(&fluid, &solid);
    run.expect_success();
    EXPECT_TRUE(run.report.interrupted);
    EXPECT_LE(run.report.windows, 3u);
    EXPECT_EQ(fluid.time(), solid.time());
  }
}

/// Each side receives the other's fields of the window's start, and impulses one window later, without losing any.
TEST(Parallel, EachSeesTheOthersOldFields) {
  const FieldFormula time_everywhere = [](const std::string& name, int, const double*, double t) {
    return within_bounds(name, t);
  };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid, 0.1, time_everywhere));
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.1, time_everywhere));
  CoupledRun run;
  run.scheme = Parallel{};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.passes, 10u);
  const auto sum = [](const Inbox& inbox, std::string_view name) {
    double out = 0.0;
    for (const double value : inbox.at(name).values) out += value;
    return out;
  };
  for (std::size_t k = 0; k < 10; ++k) {
    const double start = fluid.seen().windows[k].time;
    const auto& to_fluid = fluid.seen().inboxes[k + 1];  // the first is that of initialise
    const auto& to_solid = solid.seen().inboxes[k + 1];
    EXPECT_NEAR(to_fluid.at(field::constrained_modulus).values[55], start, 1e-12);
    EXPECT_NEAR(to_solid.at(field::pore_pressure).values[55], start, 1e-12);
    // 100 points with two components, an amount of t each.
    EXPECT_NEAR(sum(to_fluid, field::returned_impulse), 200.0 * start, 1e-9);
    EXPECT_NEAR(sum(to_solid, field::drag_impulse), 200.0 * start, 1e-9);
  }
}

/// Neither solver would get past its third window unless the other one were in it at the same time.
TEST_P(EveryLine, ParallelWindowsAreCrossedAtTheSameTime) {
  std::atomic<int> here{0}, met{0};
  MockKnobs knobs;
  knobs.freeze_at = 3;
  knobs.on_freeze = [&] {
    ++here;
    for (int k = 0; k < 3000 && here < 2; ++k) std::this_thread::sleep_for(Milliseconds(1));
    met += here == 2;
  };
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), knobs),
      solid(Role::solid, 2, still_square(Role::solid), knobs);
  CoupledRun run;
  run.line = GetParam();
  run.scheme = Parallel{};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(met, 2);
}

/// Whichever side refuses, or both, both return to the window's start, with their points.
TEST(Parallel, ARefusedWindowIsRestoredOnBothSides) {
  MockKnobs of_fluid, of_solid;
  of_fluid.rejections = {{2, 1}, {6, 2}};
  of_solid.rejections = {{4, 2}, {6, 1}};
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), of_fluid),
      solid(Role::solid, 2, still_square(Role::solid), of_solid);
  CoupledRun run;
  run.scheme = Parallel{};
  run.settings = {1.0, 0.1, 0.1, 0.0};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.rejected_by_fluid, 3u);
  EXPECT_EQ(run.report.rejected_by_solid, 3u);
  EXPECT_EQ(fluid.seen().restores, 5);  // both refused one of the windows
  EXPECT_EQ(solid.seen().restores, 5);
  EXPECT_EQ(run.fluid.report.windows, run.report.windows);
  EXPECT_EQ(run.solid.report.windows, run.report.windows);
  ASSERT_EQ(run.fluid_record.frames.size(), 11u);
  ASSERT_EQ(run.solid_record.frames.size(), 11u);
  for (std::size_t k = 0; k <= 10; ++k)
    for (const auto* record : {&run.fluid_record, &run.solid_record})
      EXPECT_NEAR(record->frames[k], 0.1 * static_cast<double>(k), 1e-12);
}

TEST(Schedule, HitsOutputInstantsExactly) {
  auto formula = still_square(Role::fluid, 0.25);
  MockPhase fluid(Role::fluid, 2, [&](double t) {
    auto out = formula(t);
    out.proposed_interval = 0.0137 + 0.01 * t;
    out.limited_by = "mock";
    return out;
  });
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.25));
  CoupledRun run;
  run.settings = {1.0, std::nullopt, 0.1, 0.25};
  run.run(&fluid, &solid);
  run.expect_success();
  for (const auto* record : {&run.fluid_record, &run.solid_record}) {
    ASSERT_EQ(record->frames.size(), 11u);
    for (std::size_t k = 0; k <= 10; ++k) EXPECT_NEAR(record->frames[k], 0.1 * static_cast<double>(k), 1e-15);
    EXPECT_EQ(record->series.size(), 5u);
  }
  double time = 0.0;
  for (const auto& window : fluid.seen().windows) {
    EXPECT_NEAR(window.time, time, 1e-15);
    EXPECT_LE(window.interval, 0.0137 + 0.01 * time + 1e-12);
    EXPECT_GT(window.interval, 0.0);
    time = window.time + window.interval;
  }
}

TEST(Schedule, CountsWhatHasSetEveryWindow) {
  auto formula = still_square(Role::fluid, 0.25);
  MockPhase fluid(Role::fluid, 2, [&](double t) {
    auto out = formula(t);
    out.proposed_interval = t < 0.4 ? 0.25 : 0.125;
    out.limited_by = t < 0.4 ? "early" : "late";
    return out;
  });
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.25));
  CoupledRun run;
  run.settings = {1.0, std::nullopt, 0.0, 0.0};
  run.run(&fluid, &solid);
  run.expect_success();
  const std::map<std::string, std::uint64_t> expected = {{"early", 2}, {"late", 4}};
  EXPECT_EQ(run.report.limited_by, expected);
}

TEST_P(EveryLine, ARejectedWindowIsRestoredOnBothSidesAndRepeatedShorter) {
  MockKnobs fluid_knobs, solid_knobs;
  fluid_knobs.rejections = {{2, 1}};
  solid_knobs.rejections = {{4, 2}};
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid), fluid_knobs);
  MockPhase solid(Role::solid, 2, still_square(Role::solid), solid_knobs);
  CoupledRun run;
  run.line = GetParam();
  run.settings = {1.0, 0.1, 0.1, 0.0};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.rejected_by_fluid, 1u);
  EXPECT_EQ(run.report.rejected_by_solid, 2u);
  EXPECT_EQ(fluid.seen().restores, 3);  // once for its own refusal, twice for the solid's
  EXPECT_EQ(solid.seen().restores, 2);
  EXPECT_DOUBLE_EQ(fluid.time(), 1.0);
  EXPECT_DOUBLE_EQ(solid.time(), 1.0);
  ASSERT_EQ(run.fluid_record.frames.size(), 11u);
  ASSERT_EQ(run.solid_record.frames.size(), 11u);
  for (std::size_t k = 0; k <= 10; ++k) EXPECT_NEAR(run.fluid_record.frames[k], 0.1 * static_cast<double>(k), 1e-12);
  EXPECT_EQ(run.fluid.report.windows, run.report.windows);
  EXPECT_EQ(run.solid.report.windows, run.report.windows);
  // The repeated attempt starts at the same time as the refused one, and is shorter.
  const auto& windows = solid.seen().windows;
  for (std::size_t k = 1; k < windows.size(); ++k) {
    if (windows[k].step != windows[k - 1].step) continue;
    EXPECT_EQ(windows[k].time, windows[k - 1].time);
    EXPECT_LE(windows[k].interval, 0.5 * windows[k - 1].interval + 1e-15);
  }
}

TEST(Schedule, GivesUpAWindowThatIsAlwaysRefused) {
  MockKnobs knobs;
  knobs.rejections = {{3, 1000}};
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid, 0.25)),
      solid(Role::solid, 2, still_square(Role::solid, 0.25), knobs);
  CoupledRun run;
  run.run(&fluid, &solid);
  EXPECT_EQ(run.coupler.code, ExitCode::peer);
  EXPECT_NE(run.coupler.error.find("was rejected 21 times"), std::string::npos) << run.coupler.error;
  EXPECT_NE(run.solid.error.find("was rejected"), std::string::npos) << run.solid.error;
  EXPECT_NE(run.fluid.error.find("was rejected"), std::string::npos) << run.fluid.error;
}

/// A fluid that flows in from nothing, fills the square, and drains again: in every step another number of points, all
/// moved.
Publication tide(double t) {
  const double width = std::max(0.0, std::sin(3.1 * t));
  auto points = lattice_points(2, {0.05 * t, 0.0}, {width, 1.0}, 0.1);
  points.revision = static_cast<std::uint64_t>(1e9 * t);
  return formula_publication(Role::fluid, t, std::move(points),
                             [](const std::string& name, int c, const double* x, double) {
                               if (name == field::soil_fraction) return 1.0;
                               return name == field::drag_impulse ? 1.0 + c : x[0];
                             });
}

TEST_P(EveryLine, CopesWithMovingGrowingShrinkingAndEmptySets) {
  MockPhase fluid(Role::fluid, 2, tide), solid(Role::solid, 2, still_square(Role::solid));
  CoupledRun run;
  run.line = GetParam();
  run.settings = {1.0, 0.02, 0.0, 0.0};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(solid.seen().inboxes.front().coverage.size(), 100u);
  for (const double covered : solid.seen().inboxes.front().coverage) EXPECT_EQ(covered, 0.0);
  for (const auto& account : run.report.accounts)
    for (std::size_t c = 0; c < account.given.size(); ++c)
      EXPECT_NEAR(account.given[c], account.delivered[c] + account.undelivered[c],
                  1e-12 * (1.0 + std::abs(account.given[c])));
}

/// A refused window also undoes its change of points: the next attempt receives values at the points of the window's
/// start.
TEST(Schedule, ARefusedWindowTakesItsPointsBack) {
  const auto accepted = [](MockKnobs fluid_knobs, MockKnobs solid_knobs, Scheme scheme = {}) {
    MockPhase fluid(Role::fluid, 2, tide, std::move(fluid_knobs)),
        solid(Role::solid, 2, still_square(Role::solid), std::move(solid_knobs));
    CoupledRun run;
    run.scheme = scheme;
    run.settings = {1.0, 0.1, 0.1, 0.0};
    run.run(&fluid, &solid);
    run.expect_success();
    const auto& windows = fluid.seen().windows;
    const auto& inboxes = fluid.seen().inboxes;  // the first is that of initialise
    EXPECT_EQ(inboxes.size(), windows.size() + 1);
    for (std::size_t k = 0; k < windows.size(); ++k)
      EXPECT_EQ(inboxes[k + 1].coverage.size(), tide(windows[k].time).points.n_active) << "step " << windows[k].step;
    return run.report.rejected_by_fluid + run.report.rejected_by_solid;
  };
  EXPECT_EQ(accepted({}, {}), 0u);
  MockKnobs refusing;
  refusing.rejections = {{2, 1}, {4, 2}, {9, 1}};  // at steps in which the set grows, and shrinks
  EXPECT_EQ(accepted({}, refusing), 4u);
  EXPECT_EQ(accepted(refusing, {}), 4u);
  EXPECT_EQ(accepted({}, refusing, Parallel{}), 4u);
  EXPECT_EQ(accepted(refusing, {}, Parallel{}), 4u);
}

TEST(Schedule, BothSetsMayBeEmpty) {
  auto empty = [](Role role) {
    return [role](double t) { return formula_publication(role, t, lattice_points(2, {0.0, 0.0}, {0.0, 0.0}, 0.1)); };
  };
  MockPhase fluid(Role::fluid, 2, empty(Role::fluid)), solid(Role::solid, 2, empty(Role::solid));
  CoupledRun run;
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.windows, 10u);
}

TEST(Schedule, ThreeDimensions) {
  auto cube = [](Role role) {
    return [role](double t) {
      return formula_publication(role, t, lattice_points(3, {0.0, 0.0, 0.0}, {0.5, 0.5, 0.5}, 0.1));
    };
  };
  MockPhase fluid(Role::fluid, 3, cube(Role::fluid)), solid(Role::solid, 3, cube(Role::solid));
  CoupledRun run;
  run.dimension = 3;
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_NEAR(fluid.seen().inboxes.back().at(field::solid_volume_fraction).values[62], 0.6, 1e-12);
}

TEST(Alone, HitsOutputsAndRepeatsRejectedWindows) {
  MockKnobs knobs;
  knobs.rejections = {{3, 2}};
  MockPhase fluid(Role::fluid, 2, still_square(Role::fluid, 0.25), knobs);
  Case scene;
  scene.general.end_time = 1.0;
  scene.coupling.interval = 0.07;
  scene.output.interval = 0.2;
  MemoryRecorder record;
  std::vector<Progress> seen;
  const auto report = drive_alone(fluid, scene, record, [&](const Progress& p) { seen.push_back(p); });
  EXPECT_EQ(report.rejected, 2u);
  EXPECT_DOUBLE_EQ(report.time, 1.0);
  ASSERT_EQ(record.frames.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(record.frames[k], 0.2 * static_cast<double>(k), 1e-15);
  EXPECT_EQ(seen.size(), report.windows);
  EXPECT_TRUE(fluid.seen().inboxes.front().fields.empty());
}

/// A phase that never rejects a window, but leaves one whose start is saved when the process is to stop.
class Steady : public MockPhase {
 public:
  Steady(bool signals, std::chrono::milliseconds per_step)
      : MockPhase(Role::fluid, 2, still_square(Role::fluid, 0.25), knobs(per_step)), signals_(signals) {}
  [[nodiscard]] bool may_reject() const override { return false; }
  Outcome advance(const Window& window, const Inbox& inbox) override {
    const auto outcome = MockPhase::advance(window, inbox);
    if (signals_) std::raise(SIGTERM);
    if (window.saved) give_up_if_interrupted();
    return outcome;
  }

 private:
  static MockKnobs knobs(std::chrono::milliseconds per_step) {
    MockKnobs k;
    k.per_step = per_step;
    return k;
  }
  bool signals_;
};

/// A signal to stop need not wait for the end of a long window, whose start is saved also if the phase never rejects.
TEST(Alone, ASignalEndsLongWindowsAtTheirStart) {
  using std::chrono::milliseconds;
  const InterruptGuard guard;
  Case scene;
  scene.general.end_time = 0.1;
  scene.coupling.interval = 0.05;
  const auto is_second_saved = [&](milliseconds per_step) {
    Steady phase(false, per_step);
    MemoryRecorder record;
    EXPECT_EQ(drive_alone(phase, scene, record).windows, 2u);
    return phase.seen().windows[1].saved;
  };
  EXPECT_FALSE(is_second_saved(milliseconds(0)));
  EXPECT_TRUE(is_second_saved(milliseconds(600)));
  Steady phase(true, milliseconds(0));
  MemoryRecorder record;
  const auto report = drive_alone(phase, scene, record);
  EXPECT_TRUE(report.interrupted);
  EXPECT_EQ(report.windows, 0u);
  EXPECT_EQ(phase.seen().restores, 1);
  EXPECT_EQ(phase.time(), 0.0);
  const InterruptGuard forgets;  // the signal
}

/// A run of thirty years may begin with windows of a tenth of a millisecond; only windows lost in rounding are an
/// error.
TEST(Schedule, OnlyWindowsThatRoundingLosesHaveCollapsed) {
  WindowClock::Settings settings;
  settings.end = 1e9;
  const WindowClock clock(settings);
  EXPECT_DOUBLE_EQ(clock.plan(1e-4).interval, 1e-4);
  EXPECT_THROW((void)clock.plan(1e-7), Error);
}

/// A square at rest whose windows have this length from t = 0.4 s on.
MockPhase::Formula square_that_crawls(Role role, double interval, const std::string& why) {
  return [=, square = still_square(role, 0.25)](double t) {
    auto out = square(t);
    out.proposed_interval = t < 0.4 ? 0.1 : interval;
    out.limited_by = why;
    return out;
  };
}

/// A thousand windows far below the characteristic time of the scene: an error that names what limited them, and why.
TEST(Schedule, WindowsThatAreStuckEndTheRun) {
  MockPhase fluid(Role::fluid, 2, square_that_crawls(Role::fluid, 0.9e-6, "the highest speed of free water"));
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.25));
  CoupledRun run;
  run.settings = {1.0, std::nullopt, 0.0, 0.0, 0.01, "a fall through one spacing"};
  run.run(&fluid, &solid);
  EXPECT_EQ(run.coupler.code, ExitCode::diverged);
  for (const char* said :
       {"1000 in a row", "the fluid: the highest speed of free water (1000 windows)", "a fall through one spacing"})
    EXPECT_NE(run.coupler.error.find(said), std::string::npos) << run.coupler.error;
  EXPECT_EQ(run.report.windows, 1004u);
}

/// Windows that are less short, or interrupted by longer ones, are allowed.
TEST(Schedule, ShortWindowsAreNotStuck) {
  MockPhase fluid(Role::fluid, 2, square_that_crawls(Role::fluid, 1.1e-4, "mock"));
  MockPhase solid(Role::solid, 2, still_square(Role::solid, 0.25));
  CoupledRun run;
  run.settings = {0.6, std::nullopt, 0.0, 0.0, 1.0, "mock"};
  run.run(&fluid, &solid);
  run.expect_success();
}

TEST(Alone, WindowsThatAreStuckEndTheRun) {
  MockPhase fluid(Role::fluid, 2, square_that_crawls(Role::fluid, 0.9e-6, "the highest speed of free water"));
  Case scene;
  scene.general.end_time = 1.0;
  MemoryRecorder record;
  DriveReport report;
  try {
    drive_alone(fluid, scene, record, {}, report, {}, {0.01, "a fall through one spacing"});
    FAIL() << "it ended";
  } catch (const DivergedError& error) {
    EXPECT_NE(std::string(error.what()).find("the highest speed of free water (1000 windows)"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace poretwin::coupling
