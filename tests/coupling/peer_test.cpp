// `poretwin peer`: mock, record, replay, conformance, with the real processes.
#include "common/output/gauge_log.hpp"
#include "common/output/hdf5.hpp"
#include "tests/system/command.hpp"

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Peer : public Command {
 protected:
  static std::string own(const std::string& words) { return std::string(PORETWIN_PROGRAM) + " peer " + words; }
  static std::string solver(const std::string& name) {
    return (fs::path(PORETWIN_PROGRAM).parent_path() / ("poretwin-" + name)).string();
  }
  Outcome run(const fs::path& to, std::vector<std::string> more, const std::string& end = "0.02") const {
    more.insert(more.begin(), {"run", terzaghi().string(), "--out", to.string(), "--no-pictures", "--until", end});
    return poretwin(std::move(more));
  }
  [[nodiscard]] fs::path wire() const { return folder_ / "solid.wire"; }
  Outcome record_solid(const fs::path& to) const {
    return run(to, {"--solid", own("record " + wire().string() + " " + solver("solid"))});
  }
  Outcome examine(std::vector<std::string> command) const {
    command.insert(command.begin(), {"peer", "conformance"});
    return poretwin(std::move(command));
  }
  /// Runs the conformance suite on the example of a rigid solid, with a fault added to it.
  Outcome examine_python(const std::string& body) const {
    const auto python = fs::path(PORETWIN_SOURCE_DIR) / "clients" / "python";
    std::ofstream(folder_ / "peer.py") << "import sys, os, time\nsys.path.insert(0, '" << python.string()
                                       << "')\nsys.path.insert(0, '" << (python / "examples").string()
                                       << "')\nimport poretwin, rigid_solid\n"
                                       << body << "\nsys.exit(poretwin.main('solid', Bad))\n";
    return examine(
        {(python / "examples" / "seepage.toml").string(), "/usr/bin/python3", (folder_ / "peer.py").string()});
  }
};

TEST_F(Peer, AReplayedSolidGivesTheFluidTheSameRunBitForBit) {
  const auto first = record_solid(folder_ / "first");
  ASSERT_EQ(first.exit, 0) << first.err;
  const auto again = run(folder_ / "again", {"--solid", own("replay " + wire().string())});
  ASSERT_EQ(again.exit, 0) << again.err << text_of(folder_ / "again" / "log" / "solid.log");
  EXPECT_EQ(text_of(folder_ / "first" / "gauges.fluid.csv"), text_of(folder_ / "again" / "gauges.fluid.csv"));
  const auto a = hdf5::File::open_to_read(folder_ / "first" / "fluid.vtkhdf"),
             b = hdf5::File::open_to_read(folder_ / "again" / "fluid.vtkhdf");
  EXPECT_EQ(a.read_numbers("VTKHDF/Points"), b.read_numbers("VTKHDF/Points"));
  for (const auto& field : a.names("VTKHDF/PointData"))
    EXPECT_EQ(a.read_numbers("VTKHDF/PointData/" + field), b.read_numbers("VTKHDF/PointData/" + field)) << field;
  EXPECT_THAT(text_of(folder_ / "again" / "solid.summary.json"), HasSubstr("\"inboxes that differ\": 0"));
}

TEST_F(Peer, AReplayTellsWhereTheOtherSideHasChanged) {
  ASSERT_EQ(record_solid(folder_ / "first").exit, 0);
  // The fluid's own section is not part of what both sides must agree on: the recording is admitted, and reports the
  // difference.
  const auto other =
      run(folder_ / "other", {"--solid", own("replay " + wire().string()), "--set", "fluid.jitter=0.01"});
  EXPECT_THAT(text_of(folder_ / "other" / "log" / "solid.log"), HasSubstr("what comes in differs from step"));
  EXPECT_EQ(other.exit == 0 || other.exit == 3, true) << other.exit;
  const auto another_case =
      run(folder_ / "case", {"--solid", own("replay " + wire().string()), "--set", "water.density=900.0"});
  EXPECT_EQ(another_case.exit, 3);
  EXPECT_THAT(text_of(folder_ / "case" / "log" / "solid.log"), HasSubstr("case_digest"));
}

TEST_F(Peer, ACutOrForeignLogIsNamed) {
  ASSERT_EQ(record_solid(folder_ / "first").exit, 0);
  fs::resize_file(wire(), fs::file_size(wire()) / 2);
  const auto cut = run(folder_ / "cut", {"--solid", own("replay " + wire().string())});
  EXPECT_EQ(cut.exit, 3);
  EXPECT_THAT(cut.err, HasSubstr("the recording ends here"));
  const auto foreign = poretwin({"peer", "replay", terzaghi().string()});
  EXPECT_EQ(foreign.exit, 5);
  EXPECT_THAT(foreign.err, HasSubstr("expected a wire log"));
}

TEST_F(Peer, MocksRestUnderTheRealSolvers) {
  const auto water = run(folder_ / "water", {"--fluid", own("mock fluid"), "--set", "case.gravity=[0, -9.81]"});
  ASSERT_EQ(water.exit, 0) << water.err;
  const auto soil = run(folder_ / "soil", {"--solid", own("mock solid")});
  ASSERT_EQ(soil.exit, 0) << soil.err;
  const auto both = run(folder_ / "both", {"--fluid", own("mock fluid"), "--solid", own("mock solid")});
  EXPECT_EQ(both.exit, 0) << both.err;
  EXPECT_EQ(poretwin({"peer", "mock", "gas"}).exit, 2);
}

TEST_F(Peer, TheSolversConform) {
  for (const char* name : {"fluid", "solid"}) {
    const auto outcome = examine({terzaghi().string(), solver(name)});
    EXPECT_EQ(outcome.exit, 0) << outcome.out << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("13 checks passed, 0 failed"));
  }
}

TEST_F(Peer, ThePythonExamplesConform) {
  const auto examples = fs::path(PORETWIN_SOURCE_DIR) / "clients" / "python" / "examples";
  for (const char* name : {"rigid_solid.py", "seepage_grid.py"}) {
    const auto outcome =
        examine({(examples / "seepage.toml").string(), "/usr/bin/python3", (examples / name).string()});
    EXPECT_EQ(outcome.exit, 0) << outcome.out << outcome.err;
  }
}

TEST_F(Peer, WhatDoesNotConformIsNamed) {
  struct Bad {
    std::string body;
    std::vector<std::string> complaints;
  };
  const std::vector<Bad> all{
      {"class Bad(rigid_solid.RigidSolid):\n  count = 0.0\n  def restore(self): pass\n"
       "  def advance(self, window, inbox):\n"
       "    if not inbox.coverage.any(): raise ValueError('where is the water')\n"
       "    self.count += 1.0\n"
       "  def publish(self):\n    p = super().publish()\n"
       "    p.fields = dict(p.fields, hydraulic_conductivity=p.fields['hydraulic_conductivity'] + self.count)\n"
       "    return p",
       {"FAILED  rejected step        after two RESTOREs the same window gave another result: hydraulic_conductivity",
        "FAILED  empty set            it gave up instead of sending an answer to ADVANCE step 2",
        "11 checks passed, 2 failed"}},
      {"class Bad(rigid_solid.RigidSolid):\n  def publish(self):\n    p = super().publish()\n"
       "    p.fields = dict(p.fields, solid_volume_fraction=p.fields['solid_volume_fraction'] + 1.0)\n    return p",
       {"field 'solid_volume_fraction', point 0 at (0.01, 0.01), component 0: expected a number in [0, 1), got 1.6"}},
      {"poretwin.participant.Participant.beat = lambda self, interval: None\nBad = rigid_solid.RigidSolid",
       {"FAILED  late answer          0 heartbeats in 3 s"}}};
  for (const auto& bad : all) {
    const auto outcome = examine_python(bad.body);
    EXPECT_EQ(outcome.exit, 3) << outcome.out << outcome.err;
    for (const auto& complaint : bad.complaints) EXPECT_THAT(outcome.out, HasSubstr(complaint));
  }
  const auto nobody = examine({terzaghi().string(), "/bin/false"});
  EXPECT_EQ(nobody.exit, 3);
  EXPECT_THAT(nobody.out, HasSubstr("it ended with exit code 1 before it said HELLO"));
}

}  // namespace
}  // namespace poretwin::testing_tools
