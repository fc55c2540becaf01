// Factor of safety of soil during a run.
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

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
  const auto field = std::ranges::find_if(frame.fields, [](const auto& f) { return f.name == "failing_strain"; });
  ASSERT_NE(field, frame.fields.end());
  double below = 0.0, above = 0.0;
  for (std::size_t i = 0; i < frame.count; ++i) {
    double strain = 0.0;
    field->tell(i, &strain);
    double& largest = dry.state().particles.position[i].y() < 0.5 ? below : above;
    largest = std::max(largest, strain);
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

}  // namespace
}  // namespace poretwin::solid
