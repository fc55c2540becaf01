// Checkpoints of all three processes: which are written, which are valid, which are refused.
#include "tests/child.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <gmock/gmock.h>

namespace poretwin::coupling {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Points that move and fields that depend on time, so that results cannot agree by chance.
MockPhase::Formula moving(Role role, double speed = 0.04) {
  return [=](double t) {
    auto points = lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.1);
    // Each point moves differently, so that the order of neighbours changes with every search.
    for (std::size_t k = 0; k < points.position.size(); ++k)
      points.position[k] += (0.03 + speed * t) * std::sin(17.0 * static_cast<double>(k * k % 97));
    points.revision = static_cast<std::uint64_t>(1e6 * t);
    return formula_publication(role, t, points, [=](const std::string& name, int c, const double* x, double time) {
      return within_bounds(name, std::sin(3.0 * x[0] + 5.0 * x[1] + time + c));
    });
  };
}

class Resume : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  struct Ending {
    std::vector<Inbox> inboxes;
    std::string records;
    ScheduleReport report;
    std::string fluid_error, solid_error, coupler_error;
    std::vector<std::string> log;
  };
  static std::string bytes_of(MemoryRecorder& a, MemoryRecorder& b) {
    Archive archive;
    a.archive(archive);
    b.archive(archive);
    return archive.bytes();
  }

  Ending run(const std::function<void(CoupledRun&)>& set, MockKnobs fluid_knobs = {}, double solid_speed = 0.04) {
    CoupledRun run;
    run.settings = {1.0, 0.05, 0.25, 0.0};
    run.checkpoints = folder_;
    set(run);
    MockPhase fluid(Role::fluid, 2, moving(Role::fluid), fluid_knobs),
        solid(Role::solid, 2, moving(Role::solid, solid_speed));
    run.run(&fluid, &solid);
    return {solid.seen().inboxes,
            bytes_of(run.fluid_record, run.solid_record),
            run.report,
            run.fluid.error,
            run.solid.error,
            run.coupler.error,
            run.log};
  }
  [[nodiscard]] std::vector<fs::path> files(const std::string& process) const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_ / "checkpoints"))
      if (entry.path().filename().string().starts_with(process)) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
  /// A run that dies in step 13, with a checkpoint after every window.
  Ending die() {
    MockKnobs knobs;
    knobs.die_at = 13;
    return run([](CoupledRun& r) { r.checkpoint_every = 0.0; }, knobs);
  }

  fs::path folder_ = testing_tools::fresh_folder("poretwin-resume");
};

void expect_same(const std::vector<Inbox>& tail, const std::vector<Inbox>& whole) {
  ASSERT_LE(tail.size(), whole.size());
  for (std::size_t k = 0; k < tail.size(); ++k) {
    const auto &a = tail[tail.size() - 1 - k], &b = whole[whole.size() - 1 - k];
    ASSERT_EQ(a.coverage, b.coverage) << k << " windows before the end";
    for (std::size_t f = 0; f < a.fields.size(); ++f)
      ASSERT_EQ(a.fields[f].values, b.fields[f].values) << a.fields[f].name;
  }
}

TEST_F(Resume, ADeadPeersRunGoesOnAsIfNothingHadBeen) {
  MockKnobs refusing;
  refusing.rejections = {{3, 2}, {17, 1}};
  const auto whole = run([](CoupledRun& r) { r.checkpoints.clear(); }, refusing);
  EXPECT_EQ(whole.coupler_error, "");
  const auto watched = run([](CoupledRun& r) { r.checkpoint_every = 0.0; }, refusing);
  EXPECT_EQ(watched.coupler_error, "");
  EXPECT_EQ(watched.records, whole.records) << "taking checkpoints changes the result";
  EXPECT_GT(watched.report.checkpoints, 15u);
  auto dying = refusing;
  dying.die_at = 13;
  const auto dead = run([](CoupledRun& r) { r.checkpoint_every = 0.0; }, dying);
  EXPECT_EQ(dead.fluid_error, "died");
  EXPECT_THAT(dead.coupler_error, HasSubstr("fluid died"));
  // Two complete checkpoints, and files of an incomplete one.
  EXPECT_EQ(files("coupler").size(), 2u);
  EXPECT_LE(files("solid").size(), 3u);
  MockKnobs later;
  later.rejections = {{17, 1}};
  const auto resumed = run([](CoupledRun& r) { r.resume = true; }, later);
  EXPECT_EQ(resumed.coupler_error, "");
  EXPECT_EQ(resumed.fluid_error, "");
  EXPECT_EQ(resumed.records, whole.records);
  EXPECT_EQ(resumed.report.windows, whole.report.windows);
  EXPECT_EQ(resumed.report.rejected_by_fluid, whole.report.rejected_by_fluid);
  EXPECT_EQ(resumed.report.limited_by, whole.report.limited_by);
  for (std::size_t k = 0; k < whole.report.accounts.size(); ++k) {
    EXPECT_EQ(resumed.report.accounts[k].delivered, whole.report.accounts[k].delivered);
    EXPECT_EQ(resumed.report.accounts[k].undelivered, whole.report.accounts[k].undelivered);
  }
  EXPECT_LT(resumed.inboxes.size(), whole.inboxes.size());
  expect_same(resumed.inboxes, whole.inboxes);
}

TEST_F(Resume, SoDoesAParallelRun) {
  const auto parallel = [&](const std::function<void(CoupledRun&)>& set, MockKnobs knobs = {}) {
    return run(
        [&](CoupledRun& r) {
          r.scheme = Parallel{};
          set(r);
        },
        std::move(knobs));
  };
  const auto whole = parallel([](CoupledRun& r) { r.checkpoints.clear(); });
  MockKnobs dying;
  dying.die_at = 13;
  parallel([](CoupledRun& r) { r.checkpoint_every = 0.0; }, dying);
  const auto resumed = parallel([](CoupledRun& r) { r.resume = true; });
  EXPECT_EQ(resumed.coupler_error, "");
  EXPECT_EQ(resumed.records, whole.records);
  EXPECT_LT(resumed.inboxes.size(), whole.inboxes.size());
  expect_same(resumed.inboxes, whole.inboxes);
}

TEST_F(Resume, ADamagedCheckpointGivesWayToTheOneBefore) {
  const auto whole = run([](CoupledRun& r) { r.checkpoints.clear(); });
  die();
  // The solid's newest complete one.
  const auto newest = files("coupler").back().filename().string().substr(7);
  std::ofstream(folder_ / "checkpoints" / ("solid" + newest), std::ios::app) << "x";
  const auto resumed = run([](CoupledRun& r) { r.resume = true; });
  EXPECT_EQ(resumed.coupler_error, "");
  EXPECT_EQ(resumed.records, whole.records);
}

/// Fluid and solid wrote the checkpoint, but the coupler died before it completed its own.
TEST_F(Resume, WithoutTheCouplersWordACheckpointDoesNotCount) {
  const auto whole = run([](CoupledRun& r) { r.checkpoints.clear(); });
  die();
  fs::remove(files("coupler").back());
  const auto resumed = run([](CoupledRun& r) { r.resume = true; });
  EXPECT_EQ(resumed.coupler_error, "");
  EXPECT_EQ(resumed.records, whole.records);
}

TEST_F(Resume, WhoLacksItIsNamed) {
  die();
  for (const auto& file : files("solid")) fs::remove(file);
  const auto resumed = run([](CoupledRun& r) { r.resume = true; });
  EXPECT_THAT(resumed.coupler_error, HasSubstr("nothing to resume from"));
  EXPECT_THAT(resumed.coupler_error, HasSubstr("solid none"));
  EXPECT_EQ(files("coupler").size(), 2u) << "they must stay";
}

TEST_F(Resume, AnotherStateThanThatOfTheCheckpointIsRefused) {
  die();
  const auto resumed = run([](CoupledRun& r) { r.resume = true; }, {}, 0.02);
  EXPECT_THAT(resumed.coupler_error, HasSubstr("the solid came back from checkpoint"));
}

TEST_F(Resume, WithAPeerThatKeepsNoneTheRunGoesOnAndSaysSo) {
  CoupledRun run;
  run.checkpoints = folder_;
  run.checkpoint_every = 0.0;
  run.only_coupler_keeps = true;
  MockPhase fluid(Role::fluid, 2, moving(Role::fluid)), solid(Role::solid, 2, moving(Role::solid));
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_THAT(run.log, testing::Contains(HasSubstr("no checkpoints in this run: the fluid keeps none")));
  EXPECT_EQ(run.report.checkpoints, 0u);
}

}  // namespace
}  // namespace poretwin::coupling
