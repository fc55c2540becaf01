// Soil at rest: how it gets there and stays there (K0 start, symmetric and periodic sides, prescribed water, sleep),
// and its gauges.
#include "common/core/error.hpp"
#include "solid_solver/output/readout.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;

constexpr double weight = 0.6 * 2600.0 * 9.81, modulus = 3e6 * 0.7 / (1.3 * 0.4);  // of the column in scenes.hpp

Tensor principal(double a, double b, double c) {
  Tensor t = Tensor::Zero();
  t.head<3>() << a, b, c;
  return t;
}

double reading(const Phase& solid, const std::string& name) {
  for (const auto& r : solid.gauges())
    if (r.gauge == name) return r.value;
  ADD_FAILURE() << "no gauge " << name;
  return NAN;
}

TEST(Rest, StartsFromEarthPressure) {
  Case scene = column({});
  Solid<2> loaded(scene);
  loaded.initialise({});
  scene.soils[0].earth_pressure_at_rest = 0.8;
  Solid<2> solid(scene);
  solid.initialise({});
  const auto& p = solid.state().particles;
  double worst = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double vertical = -weight * (1.0 - p.position[i].y());
    const Tensor right = principal(0.8 * vertical, vertical, 0.8 * vertical);
    worst += (p.stress[i] - right).squaredNorm() / static_cast<double>(p.size());
    moved = std::max(moved, p.displacement[i].norm());
  }
  worst = std::sqrt(worst);
  std::printf("stress error (L2) %.5f of the base value, moved by %.5f of the settlement, %.0f steps against %.0f\n",
              worst / weight, moved / (weight / 2.0 / modulus), solid.counters().at("rest steps"),
              loaded.counters().at("rest steps"));
  EXPECT_LT(worst, 0.01 * weight);
  EXPECT_LT(moved, 0.01 * weight / (2.0 * modulus));
  EXPECT_LT(solid.counters().at("rest steps"), 0.5 * loaded.counters().at("rest steps"));
}

TEST(Rest, SoilThatIsNotAtRestStartsUnderItsEarthPressureToo) {
  Case scene = column({});
  scene.solid.initial_rest = false;
  scene.soils[0].earth_pressure_at_rest = 0.8;
  Solid<2> solid(scene);
  solid.initialise({});
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const double vertical = -weight * (1.0 - p.position[i].y());
    EXPECT_LT((p.stress[i] - principal(0.8 * vertical, vertical, 0.8 * vertical)).norm(), 1e-9 * weight);
    EXPECT_EQ(p.displacement[i].norm(), 0.0);
  }
}

TEST(Rest, ReportsItsCriterion) {
  Solid<2> solid(column({}));
  solid.initialise({});
  EXPECT_EQ(solid.counters().at("rest criterion"), 1e-3);
  EXPECT_LT(solid.counters().at("rest residual"), 1e-3);
  EXPECT_GT(solid.counters().at("rest residual"), 0.0);
  ColumnSpec falling;
  falling.base = Wall::ForSoil::none;
  Solid<2> lost(column(falling));
  lost.initialise({});
  EXPECT_GT(lost.counters().at("rest residual"), 0.5) << "without support there is no rest";
  const auto warned = [](const Phase& phase) {
    for (const auto& w : phase.warnings())
      if (w.what == "the soil's rest was not found" && w.count > 0.0) return w.result_in_doubt ? 2 : 1;
    return 0;
  };
  EXPECT_EQ(warned(solid), 0);
  EXPECT_EQ(warned(lost), 1) << "said, and not in doubt: it fell by less than half its height";
}

TEST(Rest, DivergenceIsNamed) {
  Case scene = column({});
  scene.solid.courant = 5.0;  // unstable
  Solid<2> solid(scene);
  try {
    solid.initialise({});
    FAIL() << "no error";
  } catch (const DivergedError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("particle"), std::string::npos) << what;
    EXPECT_NE(what.find("stress xx"), std::string::npos) << what;
    EXPECT_NE(what.find("last good time 0 s"), std::string::npos) << what;
  }
}

/// An embankment 2 m wide and 0.5 m high, or its right half beside a plane of symmetry.
Case embankment(bool half) {
  Case scene = column({});
  scene.walls.resize(1);
  scene.soils[0].shape.kind = Shape::Kind::polygon;
  scene.soils[0].shape.points = half ? std::vector<Point3>{{1, 0, 0}, {2, 0, 0}, {1.48, 0.5, 0}, {1, 0.5, 0}}
                                     : std::vector<Point3>{{0, 0, 0}, {2, 0, 0}, {1.48, 0.5, 0}, {0.52, 0.5, 0}};
  if (half) {
    Wall side;
    side.face = test::plane(Point3::UnitX(), Point3::UnitX());
    side.soil = Wall::ForSoil::roller;
    scene.walls.push_back(side);
  }
  return scene;
}

TEST(Sides, HalfAnEmbankmentAgainstSymmetryIsTheWholeOne) {
  Solid<2> whole(embankment(false)), half(embankment(true));
  whole.initialise({});
  half.initialise({});
  const auto &a = whole.state().particles, &b = half.state().particles;
  ASSERT_EQ(a.size(), 2 * b.size());
  double stress = 0.0, moved = 0.0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < b.size(); ++i)
    for (std::size_t j = 0; j < a.size(); ++j) {
      const Vec<2> here = b.position[i] - b.displacement[i], there = a.position[j] - a.displacement[j];
      if ((here - there).norm() > 1e-6) continue;
      ++found;
      stress = std::max(stress, (a.stress[j] - b.stress[i]).norm());
      moved = std::max(moved, (a.displacement[j] - b.displacement[i]).norm());
    }
  EXPECT_EQ(found, b.size());
  std::printf("largest difference: stress %.2g of gamma H, displacement %.2g m\n", stress / (0.5 * weight), moved);
  EXPECT_LT(stress, 1e-3 * 0.5 * weight);
  EXPECT_LT(moved, 1e-3 * 0.25 * weight / modulus);
}

TEST(Sides, PeriodicGroundRestsAsBetweenRollers) {
  ColumnSpec spec;
  Case scene = column(spec);
  Solid<2> rollers(scene);
  rollers.initialise({});
  scene.walls.resize(1);
  scene.general.periodic = {0};
  scene.general.domain_max = {spec.width, 2.0, 0.0};
  Solid<2> periodic(scene);
  periodic.initialise({});
  const auto &a = rollers.state().particles, &b = periodic.state().particles;
  double stress = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    stress = std::max(stress, (a.stress[i] - b.stress[i]).norm());
    moved = std::max(moved, (a.displacement[i] - b.displacement[i]).norm());
  }
  std::printf("largest difference: stress %.2g Pa, displacement %.2g m\n", stress, moved);
  EXPECT_LT(stress, 1e-6 * weight);
  EXPECT_LT(moved, 1e-6 * weight / modulus);
}

PorePressure still(double level) {
  PorePressure water;
  water.head = Series{{{0.0, level}}};
  return water;
}

TEST(PrescribedWater, AtRestActsAsAFluidDoes) {
  Case scene = column({});
  Solid<2> coupled(scene);
  coupled.initialise(test::wet_inbox<2>(coupled, [](const Vec<2>& x) { return 9810.0 * (1.5 - x.y()); }));
  scene.pore_pressures = {still(1.5)};
  Solid<2> alone(scene);
  alone.initialise({});
  double stress = 0.0;
  for (std::size_t i = 0; i < alone.state().particles.size(); ++i)
    stress = std::max(stress, (alone.state().particles.stress[i] - coupled.state().particles.stress[i]).norm());
  std::printf("largest difference %.2g Pa\n", stress);
  EXPECT_LT(stress, 1e-3 * weight);
}

TEST(PrescribedWater, GroundIsDryAboveTheWaterTable) {
  Case scene = column({});
  scene.pore_pressures = {still(0.5)};
  scene.gauges = {test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0.75, 0), Point3(0.2, 0, 0)}),
                  test::point_gauge<2>("pressure", "pore_pressure", {Point3(0.2, 0.75, 0), Point3(0.2, 0, 0)}),
                  test::point_gauge<2>("ratio", "pore_pressure_ratio", {Point3(0.2, 0, 0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  const double buoyant = 0.6 * 1600.0 * 9.81, base = 0.5 * (weight + buoyant);
  EXPECT_NEAR(reading(solid, "stress[0]"), -0.25 * weight, 0.01 * base);
  EXPECT_NEAR(reading(solid, "stress[1]"), -base, 0.01 * base);
  EXPECT_EQ(reading(solid, "pressure[0]"), 0.0);
  EXPECT_NEAR(reading(solid, "pressure[1]"), 0.5 * 9810.0, 1.0);
  EXPECT_NEAR(reading(solid, "ratio"), 0.5 * 9810.0 / (0.5 * 9810.0 + base), 0.01);
}

TEST(PrescribedWater, FlowsBetweenTwoHeads) {
  Case scene = column({});
  PorePressure water = still(1.2);
  water.from = {0, 1, 0};
  water.to_head = Series{{{0.0, 1.5}}};
  scene.pore_pressures = {water};
  scene.gauges = {test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0, 0)}),
                  test::point_gauge<2>("pressure", "pore_pressure", {Point3(0.2, 0.5, 0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  EXPECT_NEAR(reading(solid, "pressure"), 9810.0 * (1.35 - 0.5), 1.0);
  EXPECT_NEAR(reading(solid, "stress"), -(0.6 * 1600.0 * 9.81 - 0.3 * 9810.0), 0.01 * weight);
}

// An infinite slope with its water table at the surface: at depth d the shear stress is (rho_sat g sin) d, the
// effective normal stress (rho_sat - rho_w) g cos d (Skempton & Delory 1957); also where part of the water was in the
// ground before.
TEST(SolvedWater, SeepageAlongASlopeIsBorne) {
  constexpr double g = 9.81, along = 0.34202014, across = 0.93969262;  // sine and cosine of 20 degrees
  for (const double residual : {0.0, 0.3}) {
    Case scene = column({});
    scene.walls.resize(1);
    scene.general.periodic = {0};
    scene.general.domain_max = {0.4, 2.0, 0.0};
    scene.general.gravity = {g * along, -g * across, 0.0};
    scene.soils[0].initial_saturation = residual;
    const auto water = [&](const Vec<2>& x) { return 1000.0 * g * across * (1.0 - x.y()); };
    Solid<2> buoyant(scene);
    buoyant.initialise(test::wet_inbox<2>(buoyant, water));
    scene.solid.initial_seepage = true;
    Solid<2> solid(scene);
    solid.initialise(test::wet_inbox<2>(solid, water));
    const double saturated = 0.6 * 2600.0 + 0.4 * 1000.0;
    double normal = 0.0, shear = 0.0, without = 0.0;
    for (std::size_t i = 0; i < solid.state().particles.size(); ++i) {
      const double depth = 1.0 - solid.state().particles.position[i].y();
      const Tensor& s = solid.state().particles.stress[i];
      normal = std::max(normal, std::abs(s[1] + (saturated - 1000.0) * g * across * depth));
      shear = std::max(shear, std::abs(s[3] - saturated * g * along * depth));
      without = std::max(without, std::abs(buoyant.state().particles.stress[i][3] - saturated * g * along * depth));
    }
    const double base_normal = (saturated - 1000.0) * g * across, base_shear = saturated * g * along;
    std::printf("largest error over that at the base: normal %.4f, shear %.4f (%.4f with buoyancy alone)\n",
                normal / base_normal, shear / base_shear, without / base_shear);
    EXPECT_LT(normal, 0.02 * base_normal);
    EXPECT_LT(shear, 0.02 * base_shear);
    // Without the seepage force, the weight of the flowing water, 0.4 (1 - residual) of 1960 kg/m3, is not carried.
    EXPECT_GT(without, 0.9 * (1.0 - residual) * 0.4 * 1000.0 / saturated * base_shear);
  }
}

/// Runs windows of 20 ms until `end`; returns the last reading of the solid's gauge "stress".
double run_quietly(Solid<2>& solid, double end) {
  test::run_dry(solid, end, 0.02);
  return reading(solid, "stress");
}

TEST(Sleep, ErrsLittleAndSkipsMuch) {
  Case scene = column({});
  PorePressure water;
  water.head = Series{{{0.0, 0.0}, {2.0, 1.5}}};  // the water rises through the soil
  scene.pore_pressures = {water};
  scene.gauges = {test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0, 0)})};
  Solid<2> awake(scene);
  scene.solid.quiet.emplace();
  Solid<2> sleepy(scene);
  awake.initialise({});
  sleepy.initialise({});
  double worst = 0.0;
  for (double t = 0.2; t < 3.0; t += 0.2)
    worst = std::max(worst, std::abs(run_quietly(sleepy, t) - run_quietly(awake, t)));
  const double computed = sleepy.counters().at("substeps"), all = awake.counters().at("substeps");
  std::printf("largest stress error %.4f of the base value, %.0f of %.0f substeps computed\n", worst / weight, computed,
              all);
  EXPECT_LT(worst, 0.02 * weight);
  EXPECT_LT(computed, 0.6 * all);
  EXPECT_NEAR(sleepy.counters().at("substeps asleep") + computed, all, 1.0);
}

TEST(Sleep, WakesForALoad) {
  ColumnSpec spec;
  Case scene = column(spec);
  scene.solid.quiet.emplace();
  scene.loads = {test::top_load(spec, 50.0, 0.2)};
  scene.gauges = {test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0, 0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  const double before = run_quietly(solid, 0.2);
  EXPECT_TRUE(solid.state().sleep.asleep);
  EXPECT_NEAR(before, -weight, 0.01 * weight);
  test::run_dry(solid, 0.22, 0.02);
  EXPECT_FALSE(solid.state().sleep.asleep);
  EXPECT_NEAR(run_quietly(solid, 1.0), before - 50.0, 2.0);
  EXPECT_TRUE(solid.state().sleep.asleep);
}

TEST(Sleep, DampingEndsWithTheFirstYielding) {
  Case scene = column({});
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.solid.quiet.emplace();
  PorePressure water = still(1.2);  // from zero to twice the critical gradient: the soil lifts
  water.from = {0, 1, 0};
  water.to_head = Series{{{0.0, 1.2}, {0.1, 1.2}, {0.2, 3.2}}};
  scene.pore_pressures = {water};
  scene.gauges = {test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0, 0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  run_quietly(solid, 0.2);
  EXPECT_TRUE(solid.state().still_yields);
  const double damped = solid.counters().at("substeps damped");
  test::run_dry(solid, 0.22, 0.02);
  EXPECT_EQ(solid.counters().at("substeps damped"), damped);
  EXPECT_FALSE(solid.state().sleep.asleep);
  // Without damping and effective stress it is accelerated by the remaining force over the mass of the grains.
  double momentum = 0.0, mass = 0.0;
  const auto& p = solid.state().particles;
  const auto mean_velocity = [&] {
    momentum = mass = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      momentum += p.mass[i] * p.velocity[i].y();
      mass += p.mass[i];
    }
    return momentum / mass;
  };
  const double first = mean_velocity();
  test::run_dry(solid, 0.26, 0.02);
  const double force = 2.0 * 9810.0 - 0.6 * 1600.0 * 9.81;  // N/m3
  EXPECT_NEAR((mean_velocity() - first) / 0.04, force / 1560.0, 0.1 * force / 1560.0);
}

TEST(Readout, MobilisedFriction) {
  EXPECT_NEAR(mobilised_friction(principal(-1.0, -3.0, -2.0)), 30.0, 1e-9);  // sin phi = (3 - 1) / (3 + 1)
  EXPECT_EQ(mobilised_friction(principal(-2.0, -2.0, -2.0)), 0.0);
  EXPECT_EQ(mobilised_friction(Tensor::Zero()), 0.0);
  EXPECT_NEAR(mobilised_friction(principal(1.0, -3.0, -2.0)), 90.0, 1e-9);
  Tensor turned = Tensor::Zero();  // (-1, -3) turned by 45 degrees
  turned << -2.0, -2.0, -2.0, 1.0, 0.0, 0.0;
  EXPECT_NEAR(mobilised_friction(turned), 30.0, 1e-6);
}

TEST(Readout, PorePressureRatioAndStrainEnergy) {
  EXPECT_NEAR(pore_pressure_ratio(4.0, -6.0), 0.4, 1e-12);
  EXPECT_EQ(pore_pressure_ratio(4.0, 0.0), 1.0);
  EXPECT_EQ(pore_pressure_ratio(0.0, 0.0), 0.0);
  const Elasticity e{2e6, 1e6};
  Tensor strain = Tensor::Zero(), stress = Tensor::Zero();
  strain << 1e-3, -2e-3, 0.0, 5e-4, 0.0, 0.0;
  e.add_stress(strain.data(), stress.data());
  EXPECT_NEAR(strain_energy(stress, e), 0.5 * contract(stress, strain), 1e-9);
}

TEST(Readout, CrestSettlesUnderALoad) {
  ColumnSpec spec;
  Case scene = column(spec);
  scene.loads = {test::top_load(spec, 50.0, 0.0)};
  scene.solid.quiet.emplace();
  scene.gauges = {test::whole("crest_settlement"),
                  test::point_gauge<2>("stress", "effective_stress_yy", {Point3(0.2, 0, 0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  EXPECT_EQ(reading(solid, "crest_settlement"), 0.0);
  run_quietly(solid, 1.0);
  EXPECT_NEAR(reading(solid, "crest_settlement"), 50.0 / modulus * 0.975, 0.02 * 50.0 / modulus);  // of the top row
}

}  // namespace
}  // namespace poretwin::solid
