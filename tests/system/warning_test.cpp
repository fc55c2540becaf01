// Warnings of real runs that concern the result: shown at once, counted, exit code 6; and Ctrl-C during a search.
#include "tests/system/real_run.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <thread>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Warned : public RealRun {
 protected:
  Outcome run(const std::string& text, const std::vector<std::string>& more = {},
              const std::function<void(pid_t)>& meanwhile = {}) {
    std::ofstream(folder_ / "scene.toml") << text;
    std::vector<std::string> all{"run", (folder_ / "scene.toml").string(), "--out", out().string(), "--no-pictures"};
    all.insert(all.end(), more.begin(), more.end());
    return poretwin(all, {}, meanwhile);
  }
  [[nodiscard]] nlohmann::json warnings(const std::string& process) const {
    return nlohmann::json::parse(text_of(out() / (process + ".summary.json")))["warnings"];
  }
};

/// A slope of soil whose modulus is given in kPa by mistake: it cannot stand.
const std::string soft = R"([case]
end_time = 0.05
[[soil]]
shape = "polygon"
points = [[0, 0], [6, 0], [6, 1], [3, 1], [2, 2], [0, 2]]
porosity = 0.3
grain_density = 2700
youngs_modulus = 1e4
friction_angle = 20
cohesion = 5
[[wall]]
points = [[0, 3], [0, 0]]
[[wall]]
points = [[0, 0], [6, 0]]
soil = "fixed"
[[wall]]
points = [[6, 0], [6, 3]]
[solid]
model = "drucker_prager"
particle_spacing = 0.2
[[gauge]]
name = "d"
phase = "solid"
kind = "max_displacement"
)";

TEST_F(Warned, LostWaterIsSaidAndCounted) {
  const auto outcome = run(R"([case]
title = "a drop that nothing holds falls out of the scene"
end_time = 2
[fluid]
particle_spacing = 0.1
[[fluid.region]]
min = [0, 0]
max = [0.5, 0.5]
[solid]
model = "rigid"
[[gauge]]
name = "n"
phase = "fluid"
kind = "particles"
)");
  EXPECT_EQ(outcome.exit, 6) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("fluid: warning: water particles lost ("));
  EXPECT_THAT(outcome.err, HasSubstr("put the result in doubt: fluid: water particles lost (25)"));
  const auto said = warnings("fluid");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0]["what"], "water particles lost");
  EXPECT_EQ(said[0]["count"], 25);
  EXPECT_EQ(said[0]["result_in_doubt"], true);
  EXPECT_FALSE(fs::exists(out() / "checkpoints")) << "the run has ended";
}

TEST_F(Warned, ARestThatIsNotFoundIsSaid) {
  const auto outcome = run(soft);
  EXPECT_EQ(outcome.exit, 6) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("youngs_modulus is in Pa, found 10000")) << "the check says what is behind it";
  EXPECT_THAT(outcome.err, HasSubstr("solid: warning: the soil's rest was not found"));
}

/// Clay over an artesian gravel (cases/blow_out): it must lift once the pressure below equals its weight, 7259 Pa.
const std::string clay_floor = R"([case]
end_time = 6.5
[[soil]]
min = [0, 0]
max = [0.4, 0.3]
porosity = 0.4
grain_density = 2650
hydraulic_conductivity = 1e-3
youngs_modulus = 2e7
[[soil]]
min = [0, 0.3]
max = [0.4, 0.7]
porosity = 0.5
grain_density = 2700
hydraulic_conductivity = 1e-6
youngs_modulus = 5e6
friction_angle = 20
cohesion = 0
[[wall]]
points = [[0, 1.2], [0, 0]]
[[wall]]
points = [[0.4, 0], [0.4, 1.2]]
[[wall]]
points = [[0, 0], [0.4, 0]]
water = "none"
soil = "fixed"
[[water_face]]
name = "artesian"
points = [[0, 0], [0.4, 0]]
head = [[0, 0.7], [10, 1.5]]
[[water_face]]
name = "pit floor"
points = [[0.4, 0.7], [0, 0.7]]
head = 0.7
[fluid]
particle_spacing = 0.1
[[fluid.region]]
min = [0, 0]
max = [0.4, 0.7]
[solid]
model = "drucker_prager"
[[gauge]]
name = "p"
phase = "fluid"
kind = "point"
quantity = "pore_pressure"
points = [[0.2, 0.3]]
)";

TEST_F(Warned, SoilHeldByWhatNeitherPhaseBearsIsSaid) {
  const auto once = run(clay_floor, {"--set", "coupling.scheme=serial"});
  EXPECT_EQ(once.exit, 6) << once.err;
  EXPECT_THAT(once.err, HasSubstr("solid: warning: windows in which a force held the soil that neither phase bears"));
  EXPECT_THAT(once.err, HasSubstr("coupling.scheme = \"iterated\" repeats such windows"));
  fs::remove_all(out());
  const auto repeated = run(clay_floor);
  EXPECT_EQ(repeated.exit, 0) << repeated.err;
  EXPECT_THAT(repeated.err, Not(HasSubstr("neither phase bears")));
}

TEST_F(Warned, AGaugeThatNeverHadAValueIsSaid) {
  const auto outcome = run(R"([case]
end_time = 0.02
[fluid]
particle_spacing = 0.1
[[fluid.region]]
min = [0, 0]
max = [1, 0.5]
[solid]
model = "rigid"
[[wall]]
points = [[0, 1], [0, 0], [1, 0], [1, 1]]
[[gauge]]
name = "above"
phase = "fluid"
kind = "point"
quantity = "pore_pressure"
points = [[0.5, 0.95], [0.5, 0.2]]
)");
  EXPECT_EQ(outcome.exit, 0) << "a dry place is no error";
  EXPECT_THAT(outcome.err,
              HasSubstr("fluid: warning: gauges without a value in any reading (1 by t = 0.02 s): above[0]"));
}

TEST_F(Warned, CtrlCEndsASearchForRestAtOnce) {
  // Fine enough that the search takes longer than anyone would wait.
  const auto outcome = run(soft, {"--set", "solid.particle_spacing=0.04"}, [&](pid_t child) {
    const auto searching = [&] {
      return text_of(out() / "log" / "solid.log").find("rest of the soil: largest") != std::string::npos;
    };
    for (int k = 0; k < 3000 && (!fs::exists(out() / "log" / "solid.log") || !searching()); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ::kill(child, SIGINT);
  });
  EXPECT_EQ(outcome.exit, 130);
  EXPECT_THAT(outcome.err, HasSubstr("stopping: "));
  EXPECT_THAT(text_of(out() / "log" / "solid.log"), HasSubstr("interrupted in the search for the soil's rest"));
  EXPECT_THAT(text_of(out() / "solid.summary.json"), HasSubstr("\"exit\": 130"));
}

TEST_F(Warned, ASceneFarFromTheOriginIsWrittenWhereItLies) {
  const auto scene = [](long by) {
    return fmt::format(R"([case]
end_time = 0.02
[fluid]
particle_spacing = 0.1
[[fluid.region]]
min = [{0}, 0]
max = [{1}, 0.5]
[solid]
model = "rigid"
[[wall]]
points = [[{0}, 1], [{0}, 0], [{1}, 0], [{1}, 1]]
[[gauge]]
name = "p"
phase = "fluid"
kind = "point"
quantity = "pore_pressure"
points = [[{0}.25, 0.2]]
)",
                       by, by + 1);
  };
  ASSERT_EQ(run(scene(0)).exit, 0);
  const auto gauges = text_of(out() / "gauges.csv");
  const auto points = hdf5::File::open_to_read(out() / "fluid.vtkhdf").read_numbers("VTKHDF/Points");
  fs::remove_all(out());
  ASSERT_EQ(run(scene(10000000)).exit, 0);
  EXPECT_EQ(text_of(out() / "gauges.csv"), gauges);
  const auto moved = hdf5::File::open_to_read(out() / "fluid.vtkhdf").read_numbers("VTKHDF/Points");
  ASSERT_EQ(moved.size(), points.size());
  for (std::size_t k = 0; k < points.size(); ++k) EXPECT_NEAR(moved[k], points[k] + (k % 3 == 0 ? 1e7 : 0.0), 1e-8);
}

TEST_F(Warned, SafetySaysWhatItDoesNotLookAt) {
  std::string stands = soft;
  stands.replace(stands.find("1e4"), 3, "1e7");
  stands.replace(stands.find("cohesion = 5"), 12, "cohesion = 5e3");
  std::ofstream(folder_ / "scene.toml") << stands
                                        << "[[load]]\npoints = [[2, 2], [0, 2]]\ntraction = [0, -1]\nstart = 1\n";
  const auto outcome = poretwin({"safety", (folder_ / "scene.toml").string(), "--out", out().string(), "--no-pictures",
                                 "--tolerance", "0.4", "--set", "case.end_time=5"});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("a factor of safety is that of the rest at time zero; without effect: --set "
                                     "case.end_time=5, load[0] (it has a start)"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("rest was not found"))) << "a trial that fails is an answer";
}

}  // namespace
}  // namespace poretwin::testing_tools
