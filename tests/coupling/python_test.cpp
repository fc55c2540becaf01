// Peers in Python under the real processes: a rigid solid for the real fluid, a finite-difference fluid for the real
// solid.
#include "common/output/gauge_log.hpp"
#include "tests/system/command.hpp"

#include <fmt/format.h>

namespace poretwin::testing_tools {
namespace {

using testing::HasSubstr;

// clients/python/examples/seepage.toml
constexpr double gamma_w = 9810.0, porosity = 0.4, grain = 2650.0, conductivity = 1e-3, height = 0.4, width = 0.2,
                 gradient = 0.25;
constexpr double buoyant_weight = (1.0 - porosity) * (grain * 9.81 - gamma_w);

class Python : public Command {
 protected:
  static std::filesystem::path examples() {
    return std::filesystem::path(PORETWIN_SOURCE_DIR) / "clients" / "python" / "examples";
  }
  /// The system's Python: pyzmq, protobuf and numpy are its packages.
  static std::string command(const std::string& script) {
    return "/usr/bin/python3 '" + (examples() / script).string() + "'";
  }
  Outcome run(std::vector<std::string> more, double end) const {
    more.insert(more.begin(), {"run", (examples() / "seepage.toml").string(), "--out", out().string(), "--no-pictures",
                               "--until", std::to_string(end)});
    return poretwin(std::move(more));
  }
  [[nodiscard]] std::string log(const std::string& name) const { return text_of(out() / "log" / (name + ".log")); }
};

TEST_F(Python, ARigidSolidTakesTheDragOfTheRealFluid) {
  const auto outcome = run({"--solid", command("rigid_solid.py")}, 0.5);
  ASSERT_EQ(outcome.exit, 0) << outcome.err << log("solid");
  const auto gauges = read_gauges(out() / "gauges.csv");
  // Darcy, and the pressure of a uniform gradient.
  for (const int i : {0, 1, 2}) {
    const double depth = 0.1 * (i + 1);
    const auto n = fmt::format("[{}]", i);
    EXPECT_NEAR(gauges.at("water_velocity" + n).value.back(), conductivity * gradient / porosity,
                1e-4 * conductivity * gradient / porosity);
    EXPECT_NEAR(gauges.at("water_pressure" + n).value.back(), gamma_w * (1.0 + gradient) * depth,
                1e-3 * gamma_w * height);
  }
  // What drives the water through the grains is what they feel: n i gamma_w of every volume.
  const double drag = porosity * gradient * gamma_w * width * height;
  EXPECT_NEAR(gauges.at("drag_y").value.back(), drag, 1e-4 * drag);
  EXPECT_NEAR(gauges.at("drag_x").value.back(), 0.0, 1e-6 * drag);
}

/// A peer in another language keeps checkpoints as well: killed, the run ends with the same readings.
TEST_F(Python, AKilledPeerIsResumed) {
  const std::vector<std::string> words{"--solid", command("rigid_solid.py"), "--checkpoint-every", "0"};
  ASSERT_EQ(run(words, 0.5).exit, 0) << log("solid");
  const auto whole = text_of(out() / "gauges.csv");
  std::filesystem::remove_all(out());
  const auto killed = poretwin({"run", (examples() / "seepage.toml").string(), "--out", out().string(), "--no-pictures",
                                "--until", std::to_string(0.5), words[0], words[1], words[2], words[3]},
                               {}, [&](pid_t) {
                                 const auto half = [&] {
                                   return text_of(out() / "gauges.solid.csv").find("\n0.2") != std::string::npos;
                                 };
                                 for (int k = 0; k < 4000 && !half(); ++k)
                                   std::this_thread::sleep_for(std::chrono::milliseconds(5));
                                 // The solid's own word for its process id stands in the coupler's log.
                                 const auto said = log("coupler");
                                 const auto at = said.find("process ", said.find("solid is here"));
                                 ::kill(std::atoi(said.c_str() + at + 8), SIGKILL);
                               });
  EXPECT_EQ(killed.exit, 0) << killed.err << log("solid");
  EXPECT_THAT(killed.err, testing::HasSubstr("solid was killed by signal 9 (Killed); restart 1 of 2"));
  EXPECT_EQ(text_of(out() / "gauges.csv"), whole);
}

TEST_F(Python, AGridOfFiniteDifferencesSeepsThroughTheRealSolid) {
  const auto outcome = run({"--fluid", command("seepage_grid.py")}, 1.0);
  ASSERT_EQ(outcome.exit, 0) << outcome.err << log("fluid");
  const auto gauges = read_gauges(out() / "gauges.csv");
  const double darcy = conductivity * gradient * width;
  EXPECT_NEAR(gauges.at("discharge").value.back(), darcy, 0.01 * darcy);
  for (const int i : {0, 1, 2}) {
    const double depth = 0.1 * (i + 1);
    const auto n = fmt::format("[{}]", i);
    EXPECT_NEAR(gauges.at("soil_pressure" + n).value.back(), gamma_w * (1.0 + gradient) * depth,
                1e-3 * gamma_w * height);
    // The seepage carries i gamma_w of the buoyant weight.
    const double stress = -(buoyant_weight - gradient * gamma_w) * depth;
    EXPECT_NEAR(gauges.at("effective_stress" + n).value.back(), stress, 2e-3 * buoyant_weight * height);
  }
}

TEST_F(Python, AFailureInsideAPeerIsNamedToEverybody) {
  std::ofstream(folder_ / "bad.py") << "import sys\nsys.path.insert(0, '" << (examples().parent_path()).string()
                                    << "')\nsys.path.insert(0, '" << examples().string()
                                    << "')\nimport poretwin, rigid_solid\n"
                                       "class Bad(rigid_solid.RigidSolid):\n"
                                       "  def advance(self, window, inbox):\n"
                                       "    if window.step == 3: raise ValueError('no grains left')\n"
                                       "sys.exit(poretwin.main('solid', Bad))\n";
  const auto outcome = run({"--solid", "/usr/bin/python3 " + (folder_ / "bad.py").string()}, 0.5);
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_THAT(outcome.err, HasSubstr("ValueError: no grains left"));
  EXPECT_THAT(log("coupler"), HasSubstr("solid gave up at step 3"));
  EXPECT_THAT(log("fluid"), HasSubstr("aborted by solid"));
}

TEST_F(Python, ARefusedWindowIsRestoredAndRepeated) {
  std::ofstream(folder_ / "cautious.py")
      << "import sys\nsys.path.insert(0, '" << (examples().parent_path()).string() << "')\nsys.path.insert(0, '"
      << examples().string()
      << "')\nimport poretwin, rigid_solid\n"
         "class Cautious(rigid_solid.RigidSolid):\n"
         "  def advance(self, window, inbox):\n"
         "    super().advance(window, inbox)\n"
         "    if window.interval > 0.004: raise poretwin.Refused(0.004, 'too long')\n"
         "sys.exit(poretwin.main('solid', Cautious))\n";
  const auto outcome =
      run({"--solid", "/usr/bin/python3 " + (folder_ / "cautious.py").string(), "--set", "output.interval=0.02"}, 0.04);
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_THAT(text_of(out() / "coupler.summary.json"), HasSubstr("\"rejected_by_solid\": "));
  // Taken and taken back: the drag counts once per window that stands.
  const auto gauges = read_gauges(out() / "gauges.csv");
  const auto& taken = gauges.at("impulse_taken_y");
  const auto& drag = gauges.at("drag_y");
  double sum = 0.0;
  for (std::size_t k = 0; k < drag.time.size(); ++k)
    sum += drag.value[k] * (drag.time[k] - (k == 0 ? 0.0 : drag.time[k - 1]));
  EXPECT_NEAR(taken.value.back(), sum, 1e-9 * std::abs(sum));
}

TEST_F(Python, ReadsAndWritesTheGoldenBytes) {
  std::ofstream(folder_ / "golden.py")
      << "import sys, pathlib\nsys.path.insert(0, '" << examples().parent_path().string()
      << "')\nfrom poretwin import wire\n"
         "files = sorted(pathlib.Path(sys.argv[1]).glob('*.hex'))\n"
         "for file in files:\n"
         "  frames = [bytes.fromhex(line) for line in file.read_text().split('\\n')[:-1]]\n"
         "  header, arrays = wire.decode(frames)\n"
         "  again = wire.pb.Header(); again.CopyFrom(header); del again.arrays[:]\n"
         "  out = []\n"
         "  for a in header.arrays: wire.add_array(again, out, a.name, a.unit, "
         "arrays[a.name])\n"
         "  assert [bytes(f) for f in wire.encode(again, out)] == frames, file\n"
         "print(len(files))\n";
  const auto golden = std::filesystem::path(PORETWIN_SOURCE_DIR) / "tests" / "coupling" / "golden";
  Child child({"/usr/bin/python3", (folder_ / "golden.py").string(), golden.string()}, folder_ / "golden.log");
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(text_of(folder_ / "golden.log"), "16\n");
}

TEST_F(Python, AForeignSolidNeedsASoilThatMayMove) {
  const auto outcome = run({"--solid", "/bin/false", "--set", "solid.model=\"rigid\""}, 0.1);
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("solid.model"));
}

}  // namespace
}  // namespace poretwin::testing_tools
