// Columns compared with exact solutions and with finite volumes on fine grids, whose results are given here.
#include "common/coupling/drive.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/mock.hpp"
#include "common/media/retention.hpp"
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>

namespace poretwin::pore::test {
namespace {

/// Steady infiltration q [m/s, downwards] above a water table at z = 0 in Gardner's soil: exp(alpha psi) = q/k + (1 -
/// q/k) exp(-alpha z).
double steady_head(double z, double q, double k, double alpha) {
  return std::log(q / k + (1.0 - q / k) * std::exp(-alpha * z)) / alpha;
}

TEST(PoreColumn, WaterAtRestUnderSuctionStaysAtRestExactly) {
  const double dx = 0.05;
  for (const Soil& soil : {van_genuchten(0.05, 0.4, 3.5, 2.8, 5e-5), van_genuchten(0.1, 0.43, 3.6, 1.56, 2.9e-6),
                           van_genuchten(0.05, 0.4, 14.5, 6.0, 1e-3), gardner(0.06, 0.4, 10.0, 2.8e-6)}) {
    Case scene = column(soil, 2.0, dx, 1e7);
    scene.fluid.initial_water_table = 0.5;
    scene.fluid.jitter = 0.0;
    PoreWater water(scene);
    run_to(water, 1e7);
    for (const double flow : water.state().flow) EXPECT_NEAR(flow, 0.0, 1e-13 * soil.hydraulic_conductivity);
    EXPECT_EQ(water.state().counts.iterations, 0.0);
  }
}

/// Srivastava & Yeh (1991): infiltration changes from q0 to q1; L 1 m, alpha 10 1/m, k 1 cm/h, theta 0.06 .. 0.4.
struct SrivastavaYeh {
  double k = 2.777777777777778e-06, alpha = 10.0, q0, q1;
  [[nodiscard]] double head(double z, double t) const {
    const double H = alpha, Z = alpha * z, T = alpha * k * t / 0.34, a = q0 / k, b = q1 / k;
    double sum = 0.0;
    for (int i = 1; i <= 200; ++i) {
      // Roots of tan(l H) + 2 l = 0: between (i - 1/2) pi / H and i pi / H.
      double lower = (i - 0.5) * M_PI / H + 1e-12, upper = i * M_PI / H;
      for (int step = 0; step < 100; ++step) {
        const double l = 0.5 * (lower + upper);
        (std::tan(l * H) + 2.0 * l > 0.0 ? upper : lower) = l;
      }
      const double l = 0.5 * (lower + upper);
      sum += std::sin(l * Z) * std::sin(l * H) * std::exp(-l * l * T) / (1.0 + 0.5 * H + 2.0 * l * l * H);
    }
    const double W = b - (b - 1.0) * std::exp(-Z) - 4.0 * (b - a) * std::exp(0.5 * (H - Z)) * std::exp(-0.25 * T) * sum;
    return std::log(W) / alpha;
  }
};

double srivastava_yeh_error(const SrivastavaYeh& exact, double dx, double time) {
  Case scene = column(gardner(0.06, 0.4, exact.alpha, exact.k), 1.0, dx, time);
  Series start;
  for (int i = 0; i <= 400; ++i)
    start.knots.emplace_back(i / 400.0, steady_head(i / 400.0, exact.q0, exact.k, exact.alpha));
  scene.fluid.initial_pressure_head = start;
  scene.water_faces = {pressure_face(base_of(dx), 0.0)};
  scene.rains = {rain(top_of(dx, 1.0), constant(exact.q1))};
  scene.gauges = {gauge("balance", "balance")};
  PoreWater water(scene);
  run_to(water, time);
  EXPECT_NEAR(reading(water, "balance_error") / (exact.q1 * time * dx), 0.0, 1e-9);
  const FlowModel& flow = water.flow();
  double most = 0.0;
  for (std::size_t a = 0; a < water.network().size(); ++a)
    most = std::max(
        most, std::abs(flow.pressure_head(static_cast<Index>(a)) - exact.head(water.network().elevation[a], time)));
  return most;
}

TEST(PoreColumn, InfiltrationThatChangesFollowsSrivastavaAndYeh) {
  // The bound is a thousandth of the range of psi, which is 0.2 m.
  SrivastavaYeh wetting;
  wetting.q0 = 2.777777777777778e-07;
  wetting.q1 = 2.5e-06;
  EXPECT_LT(srivastava_yeh_error(wetting, 0.01, 18000.0), 2e-4);
  SrivastavaYeh drying;
  drying.q0 = 2.5e-06;
  drying.q1 = 2.777777777777778e-07;
  EXPECT_LT(srivastava_yeh_error(drying, 0.01, 72000.0), 2e-4);
}

TEST(PoreColumn, CeliasColumnTakesInWhatItShould) {
  // Celia, Bouloutas & Zarba (1990). Finite volumes with 3200 cells, independent of this code: cumulative infiltration
  // 0.017401 m at 6 h, with a relative uncertainty of 4e-4; the front, where psi is the mean of initial and top value,
  // at 0.74518 m.
  const double dx = 0.01, end = 21600.0;
  Case scene = column(van_genuchten(0.102, 0.368, 3.35, 2.0, 9.22e-5), 1.0, dx, end);
  scene.fluid.initial_pressure_head = constant(-10.0);
  scene.water_faces = {pressure_face(top_of(dx, 1.0), -0.75), pressure_face(base_of(dx), -10.0)};
  scene.water_faces[0].name = "top";
  scene.gauges = {gauge("in", "passed_volume", {}, "top"),
                  gauge("front", "front", {{0.005, 1.0, 0.0}, {0.005, 0.0, 0.0}}), gauge("balance", "balance")};
  scene.gauges[1].pressure_head = -5.375;
  PoreWater water(scene);
  run_to(water, end);
  EXPECT_NEAR(reading(water, "in") / dx / 0.017401352, 1.0, 1e-3);
  EXPECT_NEAR(1.0 - reading(water, "front"), 0.745178, 0.1 * dx);
  EXPECT_NEAR(reading(water, "balance_error") / reading(water, "in"), 0.0, 1e-9);
}

TEST(PoreColumn, AfterRainWaterComesToRestWhereItsVolumeSays) {
  // Sand, 1 m, closed: rain of 1e-5 m/s for 2 h, then rest. The water is then hydrostatic with the table at 0.23640 m,
  // by quadrature of the retention curve.
  const double dx = 0.02;
  Case scene = column(van_genuchten(0.05, 0.4, 3.5, 2.8, 5e-5), 1.0, dx, 259200.0);
  scene.fluid.initial_water_table = 0.0;
  scene.rains = {rain(top_of(dx, 1.0), Series{{{0.0, 1e-5}, {7200.0, 1e-5}, {7200.001, 0.0}}})};
  scene.gauges = {gauge("table", "front", {{0.01, 0.0, 0.0}, {0.01, 1.0, 0.0}}), gauge("balance", "balance"),
                  gauge("soaked", "infiltration")};
  PoreWater water(scene);
  run_to(water, 259200.0);
  EXPECT_NEAR(reading(water, "soaked"), 0.072 * dx, 1e-7 * dx);
  EXPECT_NEAR(reading(water, "table"), 0.2364, 2e-3);
  EXPECT_NEAR(reading(water, "balance_error"), 0.0, 1e-12 * dx);
}

TEST(PoreColumn, LayersInSeriesPassTheFlowOfTheirHarmonicMean) {
  // Saturated soil: k = 1e-4 below k = 1e-6, half a metre each; a head difference of 1 m over 1 m.
  const double dx = 0.05;
  for (const bool capillary : {true, false}) {
    Case scene = column(capillary ? gardner(0.0, 0.4, 2.0, 1e-4) : sharp(0.4, 1e-4), 0.5, dx, 1000.0);
    scene.soils.push_back(scene.soils[0]);
    scene.soils[1].hydraulic_conductivity = 1e-6;
    scene.soils[1].shape = box(0.0, 0.5, dx, 1.0);
    scene.fluid.initial_water_table = 2.0;
    scene.water_faces = {head_face(base_of(dx), 1.0), head_face(top_of(dx, 1.0), 2.0)};
    scene.gauges = {gauge("q", "discharge", {{-1.0, 0.3, 0.0}, {1.0, 0.3, 0.0}})};
    PoreWater water(scene);
    run_to(water, 1000.0);
    EXPECT_NEAR(-reading(water, "q") / dx / (1.0 / (0.5 / 1e-4 + 0.5 / 1e-6)), 1.0, 1e-6) << capillary;
  }
}

TEST(PoreColumn, ASharpFrontSinksAsGreenAndAmpts) {
  // t = (n/k) [z - H0 ln(1 + z/H0)], with H0 = 0.1 m of water on top: z = 0.2 m at 327.1 s with n = 0.4, k = 1.1e-4
  // m/s.
  const double dx = 0.01, z = 0.2, H0 = 0.1, t = 0.4 / 1.1e-4 * (z - H0 * std::log(1.0 + z / H0));
  Case scene = column(sharp(0.4, 1.1e-4), 0.4, dx, t);
  scene.water_faces = {head_face(top_of(dx, 0.4), 0.5)};
  scene.gauges = {gauge("front", "front", {{0.005, 0.4, 0.0}, {0.005, 0.0, 0.0}}), gauge("water", "volume"),
                  gauge("balance", "balance")};
  PoreWater water(scene);
  run_to(water, t);
  EXPECT_NEAR(reading(water, "front"), z, 0.01 * z);
  EXPECT_NEAR(reading(water, "water"), 0.4 * z * dx, 0.01 * 0.4 * z * dx);
  EXPECT_NEAR(reading(water, "balance_error"), 0.0, 1e-12 * dx);
}

TEST(PoreColumn, WaterSeepsIntoDrySoilByItsWeight) {
  // Green and Ampt, with water of any depth H0 on top; without any the soil takes k t.
  const double k = 1.1e-4, n = 0.4, dx = 0.02, end = 1000.0;
  for (const double H0 : {0.0, 0.1 * dx, 0.5 * dx, 2.0 * dx}) {
    double low = 0.0, high = 2.0;  // m, the front
    for (int i = 0; i < 60; ++i) {
      const double z = 0.5 * (low + high), t = n / k * (H0 > 0.0 ? z - H0 * std::log(1.0 + z / H0) : z);
      (t < end ? low : high) = z;
    }
    for (const bool by_head : {false, true}) {
      if (by_head && H0 == 0.0) continue;
      Case scene = column(sharp(n, k), 1.0, dx, end);
      const Face top = top_of(dx, 1.0);
      scene.water_faces = {by_head ? head_face(top, 1.0 + H0) : pressure_face(top, H0)};
      scene.gauges = {gauge("water", "volume")};
      PoreWater water(scene);
      run_to(water, end);
      const double error = H0 > 0.0 ? 0.07 : 0.015;  // measured: 0.067 under half a spacing of water
      EXPECT_NEAR(reading(water, "water"), n * low * dx, error * n * low * dx) << H0 << ", head " << by_head;
    }
  }
}

TEST(PoreColumn, ASignalEndsTheWindowUnderWay) {
  Case scene = column(van_genuchten(0.05, 0.3, 2.0, 2.0, 1e-4), 1.0, 0.02, 1e4);
  scene.water_faces = {head_face(base_of(0.02), 0.5)};
  scene.fluid.initial_water_table = -1.0;
  static int questions;
  questions = 0;
  PoreWater water(scene, [] { return ++questions > 3; });
  water.save();
  const ScalarArray before = water.state().water;
  EXPECT_FALSE(water.advance({1, 0.0, 1e3}, {}).accepted);
  EXPECT_LE(questions, 5);  // the fourth, and that for the reason
  water.restore();
  EXPECT_EQ(water.state().water, before);
  EXPECT_EQ(water.state().time, 0.0);
}

TEST(PoreColumn, ASignalEndsARunAloneAtTheStartOfItsWindow) {
  Case scene = column(van_genuchten(0.05, 0.3, 2.0, 2.0, 1e-4), 1.0, 0.02, 1e4);
  scene.water_faces = {head_face(base_of(0.02), 0.5)};
  scene.fluid.initial_water_table = -1.0;
  const coupling::InterruptGuard guard;
  static int questions;
  questions = 0;
  PoreWater water(scene, [] {
    if (++questions == 1) std::raise(SIGTERM);
    return coupling::interrupted();
  });
  coupling::MemoryRecorder record;
  const auto report = coupling::drive_alone(water, scene, record);
  EXPECT_TRUE(report.interrupted);
  EXPECT_EQ(report.windows, 0u);
  EXPECT_EQ(report.time, 0.0);
  const coupling::InterruptGuard forgets;  // the signal
}

// Water rises from a base under a head of half a metre, or sinks to it, in soil whose water content jumps over a
// millimetre of suction, and with it the permeability, until it is at rest.
TEST(PoreColumn, WaterMovesThroughSoilWhoseContentJumps) {
  const Series even{{{-2.0, 0.1}, {-0.5, 0.4}, {0.0, 1.0}}};
  const Series at_zero{{{-2.0, 0.1}, {-0.5, 0.4}, {-0.001, 0.55}, {0.0, 1.0}}};
  const Series inside{{{-2.0, 0.1}, {-0.5, 0.4}, {-0.201, 0.55}, {-0.2, 1.0}}};
  const double dx = 0.05, height = 1.0, end = 4e5;
  for (const auto& [saturation, permeability] :
       {std::pair{at_zero, even}, {inside, even}, {at_zero, at_zero}, {inside, inside}, {even, inside}})
    for (const double table : {0.0, 1.0}) {
      Soil soil = van_genuchten(0.0, 0.4, 2.0, 2.0, 1e-4);
      soil.retention->law = law("table");
      soil.retention->saturation = saturation;
      soil.retention->permeability = permeability;
      Case scene = column(soil, height, dx, end);
      WaterFace face;
      face.face = base_of(dx);
      face.pressure = constant(0.5 * 9810.0);
      scene.water_faces = {face};
      scene.fluid.initial_water_table = table;
      PoreWater water(scene);
      water.initialise({});
      run_to(water, end);
      EXPECT_LT(water.counters().at("Newton iterations"), 1500.0);
      const auto curve = porous::retention_of(scene.soils[0]);
      double exact = 0.0;
      for (double z = 0.5 * dx; z < height; z += dx) exact += 0.4 * dx * dx * curve->saturation(0.5 - z).value;
      EXPECT_NEAR(water.stored(), exact, 1e-3 * exact);
    }
}

TEST(PoreColumn, AResumedRunGoesOnToTheBit) {
  const double dx = 0.02;
  Case scene = column(van_genuchten(0.05, 0.4, 3.5, 2.8, 5e-5), 1.0, dx, 7200.0);
  scene.fluid.initial_water_table = 0.0;
  scene.rains = {rain(top_of(dx, 1.0), constant(1e-5))};
  PoreWater whole(scene), first(scene), second(scene);
  run_to(first, 3600.0);
  Archive saved;
  first.archive(saved);
  Archive loaded(saved.bytes());
  second.archive(loaded);
  loaded.expect_end();
  run_to(whole, 3600.0);
  run_to(whole, 7200.0);
  run_to(second, 7200.0);
  EXPECT_EQ(whole.state().water, second.state().water);
  EXPECT_EQ(whole.state().variable, second.state().variable);
}

}  // namespace
}  // namespace poretwin::pore::test
