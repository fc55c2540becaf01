// Factor of safety of soil, during a run and from its frames.
#include "common/core/error.hpp"
#include "common/output/run_recorder.hpp"
#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/output/failing_mass.hpp"
#include "solid_solver/output/stored_state.hpp"
#include "solid_solver/statics/initial_state.hpp"
#include "tests/child.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace poretwin::solid {
namespace {

constexpr double g = 9.81, along = 0.34202014, across = 0.93969262;  // sine and cosine of 20 degrees

constexpr double cohesion = 1000.0;

/// An endless layer, 1 m thick, on a slope of 20 degrees; friction 30 degrees on its slip planes.
Case layer() {
  Case scene = test::column({});
  scene.walls.resize(1);
  scene.general.periodic = {0};
  scene.general.domain_max = {0.4, 2.0, 0.0};
  scene.general.gravity = {g * along, -g * across, 0.0};
  scene.general.end_time = 10.0;
  scene.solid.model = MaterialName::drucker_prager;
  scene.soils[0].friction_angle = 30.0;
  scene.soils[0].cohesion = cohesion;
  scene.soils[0].cone = Soil::Cone::repose;
  scene.output.gauge_interval = 0.1;
  Gauge factor;
  factor.name = "F";
  factor.phase = "solid";
  factor.kind = "factor_of_safety";
  factor.every = 0.2;
  scene.gauges = {factor};
  return scene;
}

std::map<std::string, double> readings(const Phase& solid) {
  std::map<std::string, double> values;
  for (const auto& r : solid.gauges()) values[r.gauge] = r.value;
  return values;
}

/// Field `name` of a frame, one number per particle.
std::vector<double> field_of(const OutputFrame& frame, const std::string& name) {
  const auto found = std::ranges::find(frame.fields, name, &OutputField::name);
  if (found == frame.fields.end()) throw std::out_of_range("the frame has no field " + name);
  std::vector<double> values(frame.count);
  for (std::size_t i = 0; i < frame.count; ++i) found->write(i, &values[i]);
  return values;
}

/// Factor of an infinite slope (Skempton & Delory 1957) that slips in the lowest row; arguments: its density, and the
/// part of it that gives effective stress on the slip plane [kg/m3].
double infinite_slope(double density, double pressing) {
  constexpr double depth = 0.975;
  return (cohesion / depth + pressing * g * across * std::tan(30.0 * M_PI / 180.0)) / (density * g * along);
}

TEST(FactorOfSafety, OfALayerOnASlope) {
  Solid<2> dry(layer());
  dry.initialise({});
  const auto found = readings(dry);
  const double exact = infinite_slope(1560.0, 1560.0);
  std::printf("dry %.3f +- %.3f of %.3f\n", found.at("F"), found.at("F_error"), exact);
  EXPECT_NEAR(found.at("F"), exact, 0.02 * exact);
  EXPECT_LT(found.at("F_error"), 0.006 * found.at("F"));
  // The failing strain grows towards the base.
  const OutputFrame frame = dry.frame();
  const auto strain = field_of(frame, "failing_strain");
  double below = 0.0, above = 0.0;
  for (std::size_t i = 0; i < frame.count; ++i) {
    double& largest = dry.state().particles.position[i].y() < 0.5 ? below : above;
    largest = std::max(largest, strain[i]);
  }
  EXPECT_GT(below, 3.0 * above);

  // The water table is at the surface, with flow along the slope.
  Case scene = layer();
  scene.solid.initial_seepage = true;
  Solid<2> wet(scene);
  wet.initialise(test::wet_inbox<2>(wet, [](const Vec<2>& x) { return 1000.0 * g * across * (1.0 - x.y()); }));
  const double below_one = infinite_slope(1960.0, 960.0), read = readings(wet).at("F");
  std::printf("wet %.3f of %.3f\n", read, below_one);
  EXPECT_NEAR(read, below_one, 0.02 * below_one);
}

// An elastic layer without cohesion, on a slope of 20 degrees. With Poisson's ratio nu the normal stress along the
// slope is K = nu / (1 - nu) times the one across it, so that the factor is the same at every depth. The two
// uppermost rows are left out: their stress is less exact (factor 3 % off in the lower one).
TEST(LocalFactor, IsWrittenToFramesAtEveryDepthOfALayer) {
  constexpr double nu = 0.4;
  Case scene = layer();
  scene.gauges.clear();
  scene.soils[0].cohesion = 0.0;
  scene.soils[0].friction_angle = 45.0;
  scene.soils[0].poissons_ratio = nu;
  Solid<2> solid(scene);
  solid.initialise({});
  const double k = nu / (1.0 - nu), out = nu * (1.0 + k), p = (1.0 + k + out) / 3.0, slope = along / across;
  const double j2 = 0.5 * ((1.0 - p) * (1.0 - p) + (k - p) * (k - p) + (out - p) * (out - p)) + slope * slope;
  const double exact = p / std::sqrt(j2);
  const auto found = field_of(solid.frame(), "local_factor_of_safety");
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double y = solid.state().particles.position[i].y();
    if (y > 0.9) continue;
    EXPECT_NEAR(found[i], exact, 0.02 * exact) << "at y = " << y;
  }
}

// Soil that cannot yield has no factor, beside soil that has one; without shear stress the factor is the largest one.
TEST(LocalFactor, IsMissingInElasticSoilAndLimitedWithoutShear) {
  test::ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = test::column(spec);
  scene.solid.initial_rest = false;
  scene.soils.push_back(scene.soils[0]);
  scene.soils[0].shape.max.y() = 0.5;
  scene.soils[1].shape.min.y() = 0.5;
  scene.soils[1].model = MaterialName::mohr_coulomb;
  scene.soils[1].cohesion = 1000.0;
  Solid<2> solid(scene);
  solid.initialise({});
  const auto found = field_of(solid.frame(), "local_factor_of_safety");
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (solid.state().particles.position[i].y() < 0.5) {
      EXPECT_TRUE(std::isnan(found[i]));
    } else {
      EXPECT_EQ(found[i], 100.0);
    }
  }
}

// The water comes later: the reading follows, and reading it does not change the soil.
TEST(FactorOfSafety, FollowsTheWaterAndLeavesTheSoilAsItIs) {
  Case scene = layer();
  scene.solid.initial_seepage = true;
  Solid<2> solid(scene);
  scene.gauges.clear();
  Solid<2> twin(scene);
  const auto inbox = [](double share) {
    return [share](const Vec<2>& x) { return share * 1000.0 * g * across * (1.0 - x.y()); };
  };
  for (Solid<2>* each : {&solid, &twin}) each->initialise(test::wet_inbox<2>(*each, inbox(0.0)));
  const double before = readings(solid).at("F");
  double after = 0.0;
  for (std::uint64_t k = 1; k <= 20; ++k) {
    for (Solid<2>* each : {&solid, &twin})
      each->advance({k, each->state().time, 0.01}, test::wet_inbox<2>(*each, inbox(0.05 * static_cast<double>(k))));
    const auto found = readings(solid);
    EXPECT_EQ(found.empty(), k < 20) << "every 0.2 s";
    if (k == 20) after = found.at("F");
  }
  std::printf("F %.3f without pressure, %.3f with\n", before, after);
  EXPECT_NEAR(after, infinite_slope(1960.0, 960.0), 0.03);
  EXPECT_GT(before, 1.5 * after);
  for (std::size_t i = 0; i < twin.state().particles.size(); ++i) {
    EXPECT_EQ(solid.state().particles.position[i], twin.state().particles.position[i]);
    EXPECT_EQ(solid.state().particles.stress[i], twin.state().particles.stress[i]);
  }
}

/// The inbox of water that seeps along the slope with a share of the pressure below a water table at the surface.
coupling::Inbox seeping(const Solid<2>& solid, double share) {
  return test::wet_inbox<2>(solid, [share](const Vec<2>& x) { return share * 1000.0 * g * across * (1.0 - x.y()); });
}

/// Runs a scene with a gauge of the factor for 0.4 s under pressure that grows from zero to `pressure` of that water;
/// returns the gauge's readings. The frames of those instants are in the folder.
std::vector<std::pair<double, double>> run_and_read(const Case& scene, double pressure,
                                                    const std::filesystem::path& folder) {
  std::vector<std::pair<double, double>> read;
  auto recorder = make_run_recorder(folder, "solid", scene);
  Solid<2> solid(scene);
  solid.initialise(seeping(solid, 0.0));
  for (std::uint64_t k = 0; k <= 40; ++k) {
    if (k > 0) solid.advance({k, solid.state().time, 0.01}, seeping(solid, pressure * 0.025 * static_cast<double>(k)));
    const auto found = readings(solid);
    if (k % 20 != 0) continue;
    read.emplace_back(found.at("F"), found.at("F_error"));
    recorder->frame(solid.frame());
  }
  return read;
}

/// Opens those frames and compares the factors that they give, each with the guess that the gauge had, with what the
/// gauge has read.
void expect_the_same_from_frames(const Case& scene, double pressure) {
  const auto folder = testing_tools::fresh_folder("poretwin-safety");
  const auto read = run_and_read(scene, pressure, folder);
  const FrameFile frames(folder / "solid.vtkhdf");
  ASSERT_EQ(frames.times().size(), read.size());
  auto [setup, particles] = set_up<2>(scene);
  const State<2> initial = laid_out(setup, std::move(particles));
  double last = 0.0;
  for (std::size_t k = 0; k < read.size(); ++k) {
    const auto stored = stored_state(setup, initial, frames, k, scene.general.origin);
    const auto found =
        factor_of_safety(setup, stored.state, stored.water, search_near(last, statics::safety_tolerance));
    ASSERT_TRUE(found);
    std::printf("t = %.1f s: gauge %.17g +- %.2g, frame %.17g +- %.2g\n", frames.times()[k], read[k].first,
                read[k].second, found->factor(), found->error());
    EXPECT_DOUBLE_EQ(found->factor(), read[k].first);
    EXPECT_DOUBLE_EQ(found->error(), read[k].second);
    last = found->factor();
    // By itself, from another first guess, within the widths of both brackets.
    if (k + 1 < read.size()) continue;
    const auto alone = factor_of_safety(setup, stored.state, stored.water, search_near(0.0, statics::safety_tolerance));
    EXPECT_NEAR(alone->factor(), read[k].first, alone->error() + read[k].second);
    // Down the slope, in the only soil there is.
    const auto failing = failing_mass(setup, stored.state, found->failing_displacement);
    ASSERT_TRUE(failing);
    EXPECT_EQ(failing->soil, 0U);
    EXPECT_GT(failing->share, 0.95);
    EXPECT_GT(failing->towards.x(), 0.95);
    EXPECT_GT(failing->volume, 0.3 * 0.4);
    EXPECT_LE(failing->volume, 1.05 * 0.4);
  }
  std::filesystem::remove_all(folder);
}

TEST(FactorOfSafety, FromFramesIsThatOfTheRun) {
  Case scene = layer();
  scene.solid.initial_seepage = true;
  expect_the_same_from_frames(scene, 1.0);
}

// Soil that has yielded and remembers it, with peak and residual strength, in frames whose origin is moved.
TEST(FactorOfSafety, FromFramesOfSoilThatHasSoftenedIsThatOfTheRun) {
  Case scene = layer();
  scene.solid.initial_seepage = true;
  scene.general.origin = {3.0, -2.0, 0.0};
  scene.solid.model = MaterialName::mohr_coulomb;
  scene.soils[0].residual_cohesion = 0.2 * cohesion;
  scene.soils[0].softening_slip = 0.05;
  scene.soils[0].band_width = 0.05;
  expect_the_same_from_frames(scene, 1.05);
}

// A layer that slides on its base, with water, softening: every array that the factor follows from.
TEST(FactorOfSafety, FramesHoldTheSoilWithNothingLost) {
  const auto folder = testing_tools::fresh_folder("poretwin-safety");
  Case scene = layer();
  scene.solid.initial_seepage = true;
  scene.gauges.clear();
  scene.walls[0].soil = Wall::ForSoil::frictional;
  scene.walls[0].friction_angle = 10.0;
  scene.solid.model = MaterialName::mohr_coulomb;
  scene.soils[0].cohesion = 0.3 * cohesion;
  scene.soils[0].residual_cohesion = 0.0;
  scene.soils[0].softening_slip = 0.05;
  scene.soils[0].band_width = 0.05;
  Solid<2> solid(scene);
  solid.initialise(seeping(solid, 0.0));
  for (std::uint64_t k = 1; k <= 20; ++k)
    solid.advance({k, solid.state().time, 0.01}, seeping(solid, 0.04 * static_cast<double>(k)));
  make_run_recorder(folder, "solid", scene)->frame(solid.frame());
  auto [setup, particles] = set_up<2>(scene);
  const State<2> initial = laid_out(setup, std::move(particles));
  const auto stored = stored_state(setup, initial, FrameFile(folder / "solid.vtkhdf"), 0, scene.general.origin);
  const Particles<2>&here = solid.state().particles, &there = stored.state.particles;
  EXPECT_EQ(stored.state.time, solid.state().time);
  double slipped = 0.0, softened = 0.0, pushed = 0.0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(there.position[i], here.position[i]);
    EXPECT_EQ(there.displacement[i], here.displacement[i]);
    EXPECT_EQ(there.stress[i], here.stress[i]);
    EXPECT_EQ(there.volume[i], here.volume[i]);
    EXPECT_EQ(there.plastic_strain[i], here.plastic_strain[i]);
    EXPECT_EQ(there.rubbing[i], here.rubbing[i]);
    EXPECT_EQ(there.slipped[i], here.slipped[i]);
    EXPECT_EQ(there.state_of(i)[0], here.state_of(i)[0]);
    EXPECT_EQ(stored.state.external.saturation[i], solid.state().external.saturation[i]);
    EXPECT_EQ(stored.state.external.coverage[i], solid.state().external.coverage[i]);
    const Vec<2> water = here.volume[i] * standing_water_force(solid.setup(), solid.state(), i);
    EXPECT_EQ(stored.water[i], water);
    slipped = std::max(slipped, here.slipped[i].norm());
    softened = std::max(softened, here.state_of(i)[0]);
    pushed = std::max(pushed, water.norm());
  }
  std::printf("slipped by %.3g m, state variable %.3g, pushed by %.3g N\n", slipped, softened, pushed);
  EXPECT_GT(slipped, 0.01);
  EXPECT_GT(softened, 0.0);
  EXPECT_GT(pushed, 0.0);
  std::filesystem::remove_all(folder);
}

TEST(FactorOfSafety, FromFramesOfOtherSoilIsRefused) {
  const auto folder = testing_tools::fresh_folder("poretwin-safety");
  {
    Case scene = layer();
    Solid<2> solid(scene);
    solid.initialise({});
    make_run_recorder(folder, "solid", scene)->frame(solid.frame());
  }
  const FrameFile frames(folder / "solid.vtkhdf");
  Case other = layer();
  other.solid.particle_spacing = 0.1;
  auto [setup, particles] = set_up<2>(other);
  const State<2> initial = laid_out(setup, std::move(particles));
  EXPECT_THROW(stored_state(setup, initial, frames, 0, Point3::Zero()), FileError);
  EXPECT_THROW(static_cast<void>(frames.values("no such field", 0)), FileError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace poretwin::solid
