// Every case of the project, stopped after a few windows and resumed by new phases: bit by bit the same as the run that
// was not stopped and wrote no checkpoints, whatever state its features have.
#include "common/case/case.hpp"
#include "common/coupling/interrupt.hpp"
#include "fluid_solver/fluid.hpp"
#include "joint_solver/joint_water.hpp"
#include "pore_solver/pore_phase.hpp"
#include "solid_solver/solid.hpp"
#include "tests/child.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <csignal>

namespace poretwin {
namespace {

namespace fs = std::filesystem;
using namespace coupling;

constexpr std::uint64_t middle = 4, last = 8;  // windows

std::string bytes_of(Phase& phase) {
  Archive archive;
  phase.archive(archive);
  return archive.bytes();
}

std::string bytes_of(MemoryRecorder& recorder) {
  Archive archive;
  recorder.archive(archive);
  return archive.bytes();
}

/// All results of a run.
struct Result {
  std::vector<std::string> states, records;
  std::uint64_t windows = 0;
  double time = 0.0;
};

class CaseRun : public testing::Test {
 protected:
  void read(const std::string& name, const std::vector<std::string>& overrides = {}) {
    scene_ = read_case(fs::path(PORETWIN_SOURCE_DIR) / "cases" / name / "case.toml", overrides);
    scene_.output.interval = 0.0;  // windows as long as the phases propose
    // Each of these readings is a search of seconds.
    std::erase_if(scene_.gauges, [](const Gauge& gauge) { return gauge.kind == "factor_of_safety"; });
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] CheckpointStore store(const char* process) const { return {folder_, process, {}}; }

  /// Whether checkpoints are written after every window until `stop`.
  enum class Taking { none, all };
  Result run(std::uint64_t stop, Taking taking, bool resume) {
    every_ = taking == Taking::all ? 0.0 : no_limit;
    return scene_.coupled() ? coupled(stop, resume) : alone(stop, resume);
  }

  std::unique_ptr<Phase> water() const {
    if (scene_.is_both()) return joint::make_joint_water(scene_);
    return scene_.is_field() ? pore::make_pore_water(scene_) : fluid::make_fluid(scene_);
  }

  Result coupled(std::uint64_t stop, bool resume) {
    const auto fluid = water(), solid = solid::make_solid(scene_);
    CoupledRun run;
    run.paired = scene_.is_field();
    run.dimension = scene_.general.dimension;
    run.settings = {scene_.general.end_time, scene_.coupling.interval, 0.0, 0.0};
    run.broker.case_digest = scene_.digest();
    run.broker.frozen_deadline = Milliseconds(60'000);
    run.stop_after = stop;
    run.scheme = scheme_;
    run.checkpoints = folder_;
    run.checkpoint_every = every_;
    run.resume = resume;
    run.run(fluid.get(), solid.get());
    run.expect_success();
    passes_ = run.report.passes;
    at_rest_ = solid->counters().at("windows at rest");
    return {{bytes_of(*fluid), bytes_of(*solid)},
            {bytes_of(run.fluid_record), bytes_of(run.solid_record)},
            run.report.windows,
            run.report.time};
  }

  Result alone(std::uint64_t stop, bool resume) {
    const auto phase = scene_.deformable() ? solid::make_solid(scene_) : water();
    const InterruptGuard guard;
    const auto kept = store("alone");
    MemoryRecorder recorder;
    DriveReport report;
    drive_alone(*phase, scene_, recorder,
                [&](const Progress& progress) {
                  if (progress.step == stop) std::raise(SIGINT);
                },
                report, {&kept, every_, resume});
    if (scene_.deformable()) asleep_ = phase->counters().at("share asleep beside soil that flows");
    return {{bytes_of(*phase)}, {bytes_of(recorder)}, report.windows, report.time};
  }

  /// Expects that the run, stopped in the middle and resumed, gives the same as `whole`.
  void expect_the_same_resumed(const Result& whole) {
    ASSERT_EQ(whole.windows, last_);
    run(middle_, Taking::all, false);
    const Result resumed = run(last_, Taking::none, true);
    EXPECT_EQ(resumed.windows, whole.windows);
    EXPECT_EQ(resumed.time, whole.time);
    // Not EXPECT_EQ, which would print megabytes.
    for (std::size_t k = 0; k < whole.states.size(); ++k) {
      EXPECT_TRUE(resumed.states[k] == whole.states[k]) << "the states differ: phase " << k;
      EXPECT_TRUE(resumed.records[k] == whole.records[k]) << "the records differ: phase " << k;
    }
  }

  Case scene_;
  Scheme scheme_;
  std::uint64_t middle_ = middle, last_ = last;  // windows until the checkpoint, and in all
  std::uint64_t passes_ = 0;                     // passes of the last coupled run
  double at_rest_ = 0.0;                         // windows in which its soil slept
  double asleep_ = 0.0;                          // fraction of the soil asleep beside flowing soil, last run of a soil
                                                 // alone
  double every_ = no_limit;                      // s
  fs::path folder_ = testing_tools::fresh_folder("poretwin-resume");
};

class EveryCase : public CaseRun, public testing::WithParamInterface<std::string> {};

TEST_P(EveryCase, ResumesToTheBit) {
  read(GetParam());
  Result whole = run(last, Taking::none, false);
  if (whole.windows < last) {
    scene_.coupling.interval = scene_.general.end_time / (last + 2);
    whole = run(last, Taking::none, false);
  }
  expect_the_same_resumed(whole);
}

/// Both solvers cross every window several times; the acceleration's state belongs to a single window.
TEST_F(CaseRun, ResumesIteratedToTheBit) {
  for (const auto kind : {AccelerationKind::aitken, AccelerationKind::quasi_newton}) {
    read("terzaghi", {"fluid.particle_spacing=0.05", "solid.particle_spacing=0.05"});
    scheme_ = IterationSettings{kind, 1e-4};
    const Result whole = run(last, Taking::none, false);
    EXPECT_GT(passes_, last);
    expect_the_same_resumed(whole);
    fs::remove_all(folder_);
  }
}

/// Impulses in transfer between two windows are part of the checkpoint.
TEST_F(CaseRun, ResumesParallelToTheBit) {
  read("terzaghi", {"fluid.particle_spacing=0.05", "solid.particle_spacing=0.05", "coupling.interval=1e-5",
                    "coupling.scheme=\"parallel\""});
  scheme_ = Parallel{};
  const Result whole = run(last, Taking::none, false);
  expect_the_same_resumed(whole);
}

/// Long windows in which undisturbed soil sleeps.
TEST_F(CaseRun, ResumesAsleepToTheBit) {
  read("embankment_seepage", {"fluid.particle_spacing=0.04"});
  scene_.coupling.interval = 0.1;
  const Result whole = run(last, Taking::none, false);
  EXPECT_GT(at_rest_, static_cast<double>(middle)) << "the soil was to sleep, before and after the checkpoint";
  expect_the_same_resumed(whole);
}

/// A collapse with a sleeping core: the checkpoints come after many windows, when some regions sleep.
TEST_F(CaseRun, ResumesRegionsAsleepToTheBit) {
  read("column_collapse",
       {"soil.0.max=[0.2, 0.05]", "solid.particle_spacing=0.005", "solid.quiet.regions=0.005", "case.end_time=10"});
  middle_ = 250;
  last_ = 350;
  const Result whole = run(last_, Taking::none, false);
  EXPECT_GT(asleep_, 0.05) << "some soil was to sleep";
  expect_the_same_resumed(whole);
}

std::vector<std::string> all_cases() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(PORETWIN_SOURCE_DIR) / "cases"))
    if (fs::exists(entry.path() / "case.toml")) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Cases, EveryCase, testing::ValuesIn(all_cases()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace poretwin
