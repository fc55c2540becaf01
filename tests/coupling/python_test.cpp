// Solvers in Python in runs of the real processes: a rigid solid for the real fluid, a finite-difference fluid for the
// real solid.
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
  /// Uses the system's Python, whose packages include pyzmq, protobuf and numpy.
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
  // Darcy's law, and the pressure of a uniform gradient.
  for (const int i : {0, 1, 2}) {
    const double depth = 0.1 * (i + 1);
    const auto n = fmt::format("[{}]", i);
    EXPECT_NEAR(gauges.at("water_velocity" + n).value.back(), conductivity * gradient / porosity,
                1e-4 * conductivity * gradient / porosity);
    EXPECT_NEAR(gauges.at("water_pressure" + n).value.back(), gamma_w * (1.0 + gradient) * depth,
                1e-3 * gamma_w * height);
  }
  // The drag on the grains is the force that drives the water through them: n i gamma_w per volume.
  const double drag = porosity * gradient * gamma_w * width * height;
  EXPECT_NEAR(gauges.at("drag_y").value.back(), drag, 1e-4 * drag);
  EXPECT_NEAR(gauges.at("drag_x").value.back(), 0.0, 1e-6 * drag);
}

/// Soil properties that the solid publishes are used at faces, too, whatever the case says.
TEST_F(Python, AnotherSoilThanTheCaseDrawsIsUsedAtFacesToo) {
  std::ofstream(folder_ / "other.py") << "import sys\nsys.path.insert(0, '" << (examples().parent_path()).string()
                                      << "')\nsys.path.insert(0, '" << examples().string()
                                      << "')\nimport poretwin, rigid_solid\n"
                                         "class Other(rigid_solid.RigidSolid):\n"
                                         "  def __init__(self, case):\n"
                                         "    super().__init__(case)\n"
                                         "    self.fields['hydraulic_conductivity'] *= 2\n"
                                         "    self.fields['solid_volume_fraction'][:] = 0.7\n"
                                         "sys.exit(poretwin.main('solid', Other))\n";
  auto scene = text_of(examples() / "seepage.toml");
  for (const std::string y : {"0", "0.2", "0.4"})
    scene += "\n[[gauge]]\nname = \"q_" + y + "\"\nphase = \"fluid\"\nkind = \"discharge\"\npoints = [[0, " + y +
             "], [0.2, " + y + "]]\n";
  std::ofstream(folder_ / "other.toml") << scene;
  const auto outcome =
      poretwin({"run", (folder_ / "other.toml").string(), "--out", out().string(), "--no-pictures", "--until", "0.5",
                "--solid", "/usr/bin/python3 " + (folder_ / "other.py").string()});
  ASSERT_EQ(outcome.exit, 0) << outcome.err << log("solid");
  const auto gauges = read_gauges(out() / "gauges.csv");
  const double discharge = 2.0 * conductivity * gradient * width;
  for (const std::string y : {"0", "0.2", "0.4"})
    EXPECT_NEAR(gauges.at("q_" + y).value.back(), discharge, 1e-3 * discharge) << y;
}

/// A solver in another language can also keep checkpoints: killed and resumed, the run ends with the same readings.
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
                                 // The coupler's log contains the process id that the solid announced.
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
    // The seepage carries i gamma_w of the buoyant unit weight.
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
  // The impulse received in a rejected window is undone: the drag counts once per accepted window.
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

/// A checkpoint contains data only: one that names code, as a pickle does, is refused, and no code is run.
TEST_F(Python, ACheckpointThatHoldsCodeIsRefused) {
  const auto trace = folder_ / "ran";
  std::ofstream(folder_ / "pickled.py")
      << "import sys, os, pickle, hashlib, pathlib\nsys.path.insert(0, '" << examples().parent_path().string()
      << "')\nfrom poretwin import PeerError, state\nfrom poretwin.participant import Checkpoints\n"
         "class Code:\n"
         "  def __reduce__(self): return (os.mkdir, ('"
      << trace.string()
      << "',))\n"
         "out = pathlib.Path(sys.argv[1])\n"
         "(out / 'checkpoints').mkdir(parents=True)\n"
         "data = pickle.dumps(Code())\n"
         "(out / 'checkpoints' / 'solid-a-1.state').write_bytes(hashlib.sha256(data).digest() + data)\n"
         "store = Checkpoints(out, 'solid')\n"
         "assert store.names() == ['a-1']\n"
         "try:\n"
         "  store.read('a-1')\n"
         "except PeerError as error:\n"
         "  print(error.code, error)\n"
         "try:\n"
         "  state.dump({'a': [Code()]})\n"
         "except state.StateError as error:\n"
         "  print(error)\n";
  Child child({"/usr/bin/python3", (folder_ / "pickled.py").string(), (folder_ / "run").string()}, folder_ / "log");
  EXPECT_EQ(child.wait(), 0);
  const auto said = text_of(folder_ / "log");
  EXPECT_THAT(said, HasSubstr("solid-a-1.state: cannot be resumed from: not a state of this program"));
  EXPECT_THAT(said, HasSubstr("5 "));
  EXPECT_THAT(said, HasSubstr(".a[0] is a Code: expected numbers, text, arrays"));
  EXPECT_FALSE(std::filesystem::exists(trace));
}

TEST_F(Python, AStateComesBackBitByBit) {
  std::ofstream(folder_ / "state.py")
      << "import sys\nsys.path.insert(0, '" << examples().parent_path().string()
      << "')\nimport numpy as np, poretwin\nfrom poretwin import state\n"
         "field = np.random.default_rng(1).normal(size=(7, 3))\n"
         "a = {'x': 0.1 + 0.2, 'inf': float('-inf'), 'flags': (True, None, -7, 2**70), 'text': 'n\\u00e4',\n"
         "     'raw': b'\\x00a', 'points': poretwin.lattice((0, 0), (1, 1), 0.1), 'field': field,\n"
         "     'one': np.float64(1 / 3), 'none': np.zeros((0, 2)), 'few': {'k': [np.arange(3, dtype='>i4')]}}\n"
         "b = state.load(state.dump(a))\n"
         "assert list(a) == list(b)\n"
         "for key in ('x', 'inf', 'flags', 'text', 'raw', 'one'):\n"
         "  assert a[key] == b[key] and type(a[key]) is type(b[key]), key\n"
         "assert b['field'].tobytes() == a['field'].tobytes() and b['field'].flags.writeable\n"
         "assert b['none'].shape == (0, 2) and list(b['few']['k'][0]) == [0, 1, 2]\n"
         "assert (b['points'].position == a['points'].position).all() and b['points'].n_active == 100\n"
         "data = state.dump(a)\n"
         "for k in range(len(data)):\n"
         "  for bad in (data[:k], data[:k] + bytes([data[k] ^ 16]) + data[k + 1:]):\n"
         "    try: state.load(bad)\n"
         "    except state.StateError: pass\n"
         "print('done')\n";
  Child child({"/usr/bin/python3", (folder_ / "state.py").string()}, folder_ / "log");
  EXPECT_EQ(child.wait(std::chrono::seconds(60)), 0);
  EXPECT_EQ(text_of(folder_ / "log"), "done\n");
}

/// Installed where it cannot write, the library must not run files of a folder to which all users can write.
TEST_F(Python, NobodyElsesModuleIsRun) {
  const auto place = folder_ / "read-only", temporary = folder_ / "temporary";
  std::filesystem::create_directories(place);
  const auto source = std::filesystem::path(PORETWIN_SOURCE_DIR);
  std::filesystem::copy(source / "clients", place / "clients", std::filesystem::copy_options::recursive);
  std::filesystem::copy(source / "proto", place / "proto", std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(place / "clients" / "python" / "poretwin" / "generated");
  std::ofstream(place / "clients" / "python" / "poretwin" / "generated") << "no folder can be made here";
  const auto theirs = temporary / ("poretwin-python-" + std::to_string(::getuid()));
  std::filesystem::create_directories(theirs);
  std::ofstream(theirs / "poretwin_pb2.py") << "print('code of a stranger')\nraise SystemExit(7)\n";
  std::filesystem::last_write_time(theirs / "poretwin_pb2.py",
                                   std::filesystem::file_time_type::clock::now() + std::chrono::hours(1000));
  Child child({"/usr/bin/python3", (place / "clients" / "python" / "examples" / "rigid_solid.py").string(), "--help"},
              folder_ / "log", folder_ / "log", {{"TMPDIR", temporary.string()}});
  EXPECT_EQ(child.wait(), 0) << text_of(folder_ / "log");
  EXPECT_THAT(text_of(folder_ / "log"), HasSubstr("A solid for poretwin."));
  EXPECT_THAT(text_of(folder_ / "log"), testing::Not(HasSubstr("stranger")));
}

TEST_F(Python, AForeignSolidNeedsASoilThatMayMove) {
  const auto outcome = run({"--solid", "/bin/false", "--set", "solid.model=\"rigid\""}, 0.1);
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("solid.model"));
}

}  // namespace
}  // namespace poretwin::testing_tools
