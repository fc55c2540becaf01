// Warnings of a run: each is logged once, at once; all are counted; a rejected window adds none.
#include "common/coupling/warning_log.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <gmock/gmock.h>

namespace poretwin::coupling {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A phase that loses a particle in every window after the third.
class Loser : public MockPhase {
 public:
  using MockPhase::MockPhase;
  [[nodiscard]] std::vector<Warning> warnings() const override {
    const double lost = std::max(0.0, counters().at("windows") - 3.0);
    return {{"particles lost", lost, "through the floor", true}, {"never", 0.0, "", true}};
  }
  [[nodiscard]] std::vector<GaugeReading> gauges() const override {
    return {{"p[0]", counters().at("windows") < 5.0 ? NAN : 1.0, "Pa"}, {"dry", NAN, "Pa"}};
  }
};

PointSet square() { return lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.25); }
MockPhase::Formula still() {
  return [](double t) { return formula_publication(Role::fluid, t, square()); };
}

struct Said {
  std::vector<std::string> lines;
  DriveReport report;
  Said() {
    report.warnings.begin([this](const std::string& line) { lines.push_back(line); }, {"p", "dry", "absent"});
  }
};

TEST(Warnings, AreSaidOnceAndCounted) {
  MockKnobs knobs;
  knobs.rejections = {{6, 2}};
  Loser fluid(Role::fluid, 2, still(), knobs);
  Case scene;
  scene.general.end_time = 1.0;
  scene.coupling.interval = 0.1;
  MemoryRecorder record;
  Said said;
  drive_alone(fluid, scene, record, {}, said.report);
  ASSERT_EQ(said.lines.size(), 3u);
  EXPECT_EQ(said.lines[0], "warning: particles lost (1 by t = 0.4 s): through the floor");
  EXPECT_THAT(said.lines[1], HasSubstr("gauges without any reading (1 by t = 1 s): absent"));
  EXPECT_THAT(said.lines[2], HasSubstr("gauges without a value in any reading (1 by t = 1 s): dry"));
  const auto& all = said.report.warnings.all();
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].count, 8.0) << "eleven windows stand: a refused one is made up for by shorter ones";
  EXPECT_TRUE(all[0].result_in_doubt);
  EXPECT_FALSE(all[1].result_in_doubt);
  EXPECT_TRUE(said.report.warnings.result_in_doubt());
}

TEST(Warnings, OfARunWithoutAny) {
  MockPhase fluid(Role::fluid, 2, still());
  Case scene;
  scene.general.end_time = 1.0;
  scene.coupling.interval = 0.1;
  MemoryRecorder record;
  const DriveReport report = drive_alone(fluid, scene, record);
  EXPECT_TRUE(report.warnings.all().empty());
  EXPECT_FALSE(report.warnings.result_in_doubt());
}

TEST(Warnings, OfACoupledRun) {
  Loser fluid(Role::fluid, 2, still());
  MockPhase solid(Role::solid, 2, [](double t) { return formula_publication(Role::solid, t, square()); });
  CoupledRun run;
  run.run(&fluid, &solid);
  run.expect_success();
  const auto& all = run.fluid.report.warnings.all();
  ASSERT_GE(all.size(), 1u);
  EXPECT_EQ(all[0].what, "particles lost");
  EXPECT_EQ(all[0].count, 7.0);
}

TEST(Warnings, GoOnAfterARestart) {
  WarningLog before;
  std::vector<std::string> lines;
  before.begin([&](const std::string& line) { lines.push_back(line); }, {});
  before.note(1.0, {{"lost", 2.0, "there", true}});
  before.note_readings({{"p", NAN, "Pa"}});
  Archive state;
  before.archive(state);
  Archive loaded(state.bytes());
  WarningLog after;
  after.begin([&](const std::string& line) { lines.push_back(line); }, {});
  after.archive(loaded);
  loaded.expect_end();
  after.note(2.0, {{"lost", 5.0, "there", true}});
  after.note_gauges(2.0);
  EXPECT_THAT(lines,
              ElementsAre("warning: lost (2 by t = 1 s): there", HasSubstr("without a value in any reading (1 by")));
  ASSERT_EQ(after.all().size(), 2u);
  EXPECT_EQ(after.all()[0].count, 5.0);
  EXPECT_TRUE(after.result_in_doubt());
}

}  // namespace
}  // namespace poretwin::coupling
