// One window: momentum to rounding, tracking of the prediction, consolidation with an analytic partner, save and
// restore to the bit.
#include "common/core/error.hpp"
#include "common/coupling/interrupt.hpp"
#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/numerics/steps.hpp"
#include "solid_solver/window/motion_control.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <numbers>
#include <random>

namespace poretwin::solid {
namespace {

using namespace coupling;
using test::column;
using test::ColumnSpec;
using test::values;

TEST(Window, MomentumIsAccountedForToRounding) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;  // no walls: only gravity and water can change the sum
  spec.sides = false;
  Case scene = column(spec);
  scene.solid.initial_rest = false;
  scene.solid.jitter = 0.1;
  Solid<2> solid(scene);
  auto inbox = test::wet_inbox<2>(
      solid, [](const Vec<2>&) { return 0.0; }, 0.8);
  solid.initialise(inbox);
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (auto& v : values(inbox, field::drag_impulse)) v = any(generator);
  for (auto& v : values(inbox, field::predicted_solid_velocity)) v = 0.1 * any(generator);
  auto momentum = [&] {
    Vec<2> sum = Vec<2>::Zero();
    const auto& p = solid.state().particles;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p.mass[i] * p.velocity[i];
    return sum;
  };
  double mass = 0.0;
  for (const double m : solid.state().particles.mass) mass += m;
  for (const double interval : {3e-4, 5e-3}) {  // less than one substep, and several
    const Vec<2> before = momentum();
    solid.advance({0, solid.state().time, interval}, inbox);
    Vec<2> given = mass * interval * Vec<2>(0.0, -9.81), returned = Vec<2>::Zero();
    const auto& impulse = values(inbox, field::drag_impulse);
    double scale = 0.0;
    for (std::size_t i = 0; i < impulse.size() / 2; ++i) {
      given += Vec<2>(impulse[2 * i], impulse[2 * i + 1]);
      scale += std::abs(impulse[2 * i]) + solid.state().returned_impulse[i].norm();
    }
    const auto publication = solid.publish();
    const auto& r = test::field_of(publication, field::returned_impulse).values;
    for (std::size_t i = 0; i < publication.points.size(); ++i) returned += Vec<2>(r[2 * i], r[2 * i + 1]);
    EXPECT_LT((momentum() - before - given - returned).norm(), 1e-12 * scale);
    EXPECT_GT(returned.norm(), 1e-6 * scale);
  }
}

// Soil that departs from the prediction carries its water along, with the impedance Z = C a / (a + C), a = n rho_w /
// Dt; without other forces it moves as predicted. Uniform soil, no gravity.
TEST(Window, SoilMeetsTheInertiaOfTheWaterItTakesAlong) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  spec.gravity = 0.0;
  for (const bool drag : {false, true}) {
    Case scene = column(spec);
    scene.fluid.drag = drag;
    scene.solid.initial_velocity = Point3(0.02, 0.0, 0.0);
    Solid<2> solid(scene);
    auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
    solid.initialise(inbox);
    const double change = 0.003, interval = 1e-3, rho = 0.6 * 2600.0, a = 0.4 * 1000.0 / interval;
    for (std::size_t i = 0; i < solid.state().particles.size(); ++i) {
      values(inbox, field::predicted_solid_velocity)[2 * i] = 0.02 + change;
      values(inbox, field::predicted_change)[2 * i] = change;
    }
    ASSERT_TRUE(solid.advance({0, 0.0, interval}, inbox).accepted);
    const double C = drag ? 9810.0 * 0.4 * 0.4 / scene.soils[0].hydraulic_conductivity : 0.0;
    // Every substep is backward Euler towards the part of the change that is due.
    const double steps = solid.state().substeps, dt = interval / steps,
                 Z = 2.0 * steps / (steps + 1.0) * C * a / (a + C);
    double v = 0.02, returned = 0.0;
    for (double k = 1.0; k <= steps; k += 1.0) {
      const double target = 0.02 + change * k / steps;
      v = (v + dt * Z / rho * target) / (1.0 + dt * Z / rho);
      returned += dt * Z * (target - v);
    }
    for (const auto& u : solid.state().particles.velocity) EXPECT_NEAR(u.x(), v, 1e-12);
    // At the window's end, departure times Z is the force in the window, up to the curvature of the departure.
    if (drag) {
      EXPECT_NEAR(returned / interval, C * a / (a + C) * (0.02 + change - v), 0.1 * returned / interval);
    }
  }
  // Without water there is no impedance.
  Case scene = column(spec);
  Solid<2> dry(scene);
  auto inbox = test::wet_inbox<2>(dry, [](const Vec<2>&) { return 0.0; });
  for (auto& v : values(inbox, field::predicted_change)) v = 0.01;
  inbox.coverage.assign(inbox.coverage.size(), 0.0);
  dry.initialise(inbox);
  dry.advance({0, 0.0, 1e-3}, inbox);
  for (const auto& v : dry.state().particles.velocity) EXPECT_EQ(v.norm(), 0.0);
}

// What evens out the points of soil and water is no strain. Soil at rest that should have expanded at a rate r has been
// compressed by r dt: the stress is that of this strain in the plane, and the volume has fallen by it.
TEST(Window, SpreadingThatEvensOutThePointsIsNoStrain) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  spec.gravity = 0.0;
  Solid<2> solid(column(spec));
  auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
  solid.initialise(inbox);
  const ScalarArray volume = solid.state().particles.volume;
  const double rate = 1e-3, interval = 1e-5;
  for (auto& r : values(inbox, field::spreading_rate)) r = rate;
  ASSERT_TRUE(solid.advance({0, 0.0, interval}, inbox).accepted);
  ASSERT_EQ(solid.state().substeps, 1.0);
  const Elasticity elasticity = Elasticity::of(column(spec).soils[0]);
  const double strain = -rate * interval, mean = elasticity.bulk * strain, deviator = elasticity.shear * strain / 3.0;
  for (std::size_t i = 0; i < volume.size(); ++i) {
    const Tensor& stress = solid.state().particles.stress[i];
    EXPECT_NEAR(stress[0], mean + deviator, 1e-9 * std::abs(mean));
    EXPECT_NEAR(stress[2], mean - 2.0 * deviator, 1e-9 * std::abs(mean));
    EXPECT_NEAR(solid.state().particles.volume[i] / volume[i], 1.0 + strain, 1e-15);
  }
}

// At the free surface of the water the soil takes the part surface_share of the pressure gradient from
// surface_gradient: here half of it is 3000 Pa/m, the other half its own, 1000 Pa/m. The pressure grows as a ramp.
TEST(Window, SoilTakesTheGradientItIsToldAtTheWatersSurface) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  spec.gravity = 0.0;
  Case scene = column(spec);
  scene.fluid.drag = false;
  Solid<2> solid(scene);
  solid.initialise(test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; }));
  auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>& x) { return 1000.0 * x.x(); });
  for (std::size_t i = 0; i < solid.state().particles.size(); ++i) {
    values(inbox, field::surface_gradient)[2 * i] = 3000.0;
    values(inbox, field::surface_share)[i] = 0.5;
  }
  const double interval = 5e-4, rho = 0.6 * 2600.0;
  ASSERT_TRUE(solid.advance({0, 0.0, interval}, inbox).accepted);
  const double steps = solid.state().substeps, ramp = (steps + 1.0) / (2.0 * steps);
  for (const auto& v : solid.state().particles.velocity)
    EXPECT_NEAR(v.x(), -0.6 * 2000.0 * ramp * interval / rho, 1e-9);
}

/// Terzaghi (1923): pressure and settlement of a layer drained at the top, loaded with p0 at t = 0.
struct Terzaghi {
  double p0, height, cv, modulus;
  template <class Term>
  static double sum(Term&& term) {
    double total = 0.0;
    for (int m = 0; m < 200; ++m) total += term(std::numbers::pi / 2.0 * (2.0 * m + 1.0), m % 2 == 0 ? 1.0 : -1.0);
    return total;
  }
  [[nodiscard]] double decay(double a, double t) const { return std::exp(-a * a * cv * t / (height * height)); }
  [[nodiscard]] double pressure(double y, double t) const {
    return t <= 0.0 ? p0 : sum([&](double a, double sign) {
      return 2.0 * p0 / a * sign * std::cos(a * y / height) * decay(a, t);
    });
  }
  /// Upward displacement: minus the integral of (p0 - p) / M from the base.
  [[nodiscard]] double displacement(double y, double t) const {
    if (t <= 0.0) return 0.0;
    return -(p0 * y - sum([&](double a, double sign) {
               return 2.0 * p0 * height / (a * a) * sign * std::sin(a * y / height) * decay(a, t);
             })) /
           modulus;
  }
};

TEST(Window, ConsolidatesWithAnAnalyticPartner) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  spec.width = 0.2;
  Case scene = column(spec);
  scene.soils[0].hydraulic_conductivity = 1e-3;
  scene.fluid.regions = {scene.soils[0].shape};  // coupled: long windows end in equilibrium
  scene.loads = {test::top_load(spec, 1e3, 0.0)};
  scene.gauges = {test::point_gauge<2>("top", "displacement_y", {Point3(0.1, 1.0, 0.0)}),
                  test::point_gauge<2>("base", "effective_stress_yy", {Point3(0.1, 0.0, 0.0)})};
  Solid<2> solid(scene);
  const double modulus = 3e6 * 0.7 / (1.3 * 0.4), k = 1e-3, n = 0.4, gamma = 9810.0;
  const Terzaghi exact{1e3, 1.0, k * modulus / gamma, modulus};
  auto inbox = test::wet_inbox<2>(solid, [&](const Vec<2>&) { return 0.0; });
  solid.initialise(inbox);
  const double period = 1.0 / exact.cv, interval = period / 200.0;
  double worst = 0.0, worst_base = 0.0;
  for (int window = 0; window < 120; ++window) {
    const double t = window * interval, end = t + interval;
    const auto& p = solid.state().particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double y = p.position[i].y() - p.displacement[i].y();
      // Darcy at the window's end, like the pressure: q = n v_w + n_s v_s = 0 over an impermeable base.
      const double h = 1e-4, v = k / gamma * (exact.pressure(y + h, end) - exact.pressure(y - h, end)) / (2.0 * h);
      values(inbox, field::pore_pressure)[i] = exact.pressure(y, end);
      values(inbox, field::predicted_solid_velocity)[2 * i + 1] = v;
      values(inbox, field::drag_impulse)[2 * i + 1] = -p.volume[i] * gamma * n / k * v * interval;
    }
    ASSERT_TRUE(solid.advance({0, t, interval}, inbox).accepted);
    const auto readings = solid.gauges();
    const double error = std::abs(readings[0].value - exact.displacement(1.0, end)) / (1e3 / modulus);
    if (window > 4) worst = std::max(worst, error);
    if (window > 4)
      worst_base = std::max(worst_base, std::abs(readings[1].value + 1e3 - exact.pressure(0.0, end)) / 1e3);
  }
  std::printf("settlement error %.5f, base stress error %.5f of the final values\n", worst, worst_base);
  EXPECT_LT(worst, 0.01);
  EXPECT_LT(worst_base, 0.02);
}

/// A column with water, for which the test plays the fluid.
Case wet_column(const ColumnSpec& spec = {}) {
  Case scene = column(spec);
  scene.gauges = {test::point_gauge<2>("base", "effective_stress_yy", {Point3(0.2, 0.0, 0.0)})};
  Shape water;
  water.max = Point3(0.4, 1.0, 0.0);
  scene.fluid.particle_spacing = 0.02;
  scene.fluid.regions = {water};
  scene.fluid.drag = false;  // else the drag would not let the soil move within a second
  return scene;
}

double standing_water(const Vec<2>& x) { return 9810.0 * (1.0 - x.y()); }

TEST(LongWindow, EndsInEquilibrium) {
  Solid<2> solid(wet_column());
  solid.initialise(test::wet_inbox<2>(
      solid, [](const Vec<2>&) { return 0.0; }, 0.0));
  const double dry = 1560.0 * 9.81, buoyant = dry - 0.6 * 9810.0;
  EXPECT_NEAR(solid.gauges()[0].value, -dry, 0.005 * dry);
  const auto inbox = test::wet_inbox<2>(solid, standing_water);
  const auto outcome = solid.advance({0, 0.0, 1.0}, inbox);
  ASSERT_TRUE(outcome.accepted) << outcome.reason;
  EXPECT_NEAR(solid.gauges()[0].value, -buoyant, 0.005 * buoyant);
  EXPECT_EQ(solid.counters().at("windows relaxed"), 1.0);
  EXPECT_EQ(solid.counters().at("substeps"), 0.0);
  // Another window with the same water passes asleep, and no impulse is returned.
  ASSERT_TRUE(solid.advance({1, 1.0, 1.0}, inbox).accepted);
  EXPECT_EQ(solid.counters().at("windows at rest"), 1.0);
  for (const auto& r : solid.state().returned_impulse) EXPECT_EQ(r.norm(), 0.0);
}

/// A column without walls whose weight is applied in the first window: it stands, but its foot yields.
Case yielding_column(double cohesion) {
  ColumnSpec spec;
  spec.sides = false;
  Case scene = wet_column(spec);
  scene.solid.initial_rest = false;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.soils[0].friction_angle = 30.0;
  scene.soils[0].cohesion = cohesion;
  scene.soils[0].hydraulic_conductivity = 1e-4;  // m/s
  scene.soils[0].youngs_modulus = 1e6;           // Pa, with nu = 0.3: drained after 9810 / (1e-4 1.35e6) = 73 s
  scene.soils[0].poissons_ratio = 0.3;
  return scene;
}

// The plastic shear ratio is published in full for windows of the consolidation time (73 s) or more, as zero for a
// fifth of it, and linearly between them.
TEST(LongWindow, TellsWhichShareOfTheShearWasPlasticAsFarAsItIsDrained) {
  std::vector<double> published;
  for (const double interval : {14.0, 44.0, 80.0}) {
    Solid<2> solid(yielding_column(5000.0));
    const auto dry = test::wet_inbox<2>(
        solid, [](const Vec<2>&) { return 0.0; }, 0.0);
    solid.initialise(dry);
    ASSERT_TRUE(solid.advance({0, 0.0, interval}, dry).accepted);
    ASSERT_EQ(solid.counters().at("windows relaxed"), 1.0);
    const auto publication = solid.publish();
    const auto& yielding = test::field_of(publication, field::yielding).values;
    const auto& p = solid.state().particles;
    for (std::size_t i = 0; i < p.size(); ++i)
      EXPECT_EQ(yielding[i] > 0.0, interval > 0.2 * 73.0 && p.plastic_strain[i] > 0.0);
    published.push_back(*std::max_element(yielding.begin(), yielding.begin() + static_cast<int>(p.size())));
  }
  EXPECT_EQ(published[0], 0.0);
  EXPECT_NEAR(published[1] / published[2], (44.0 / 72.87 - 0.2) / 0.8, 0.01);
  EXPECT_GT(published[2], 0.05);
  EXPECT_LT(published[2], 1.0);  // the stress before the particle yielded was elastic
}

// Water must fill the volume changes of shear: the next window is so long that 95 % of the soil shears by at most 2e-3,
// but at least 0.3 of this one.
TEST(LongWindow, TheNextFollowsWhatSoilHasSheared) {
  const double interval = 80.0;
  std::vector<double> shears, next;
  for (const double cohesion : {5000.0, 4500.0, 4000.0}) {
    Solid<2> solid(yielding_column(cohesion));
    const auto dry = test::wet_inbox<2>(
        solid, [](const Vec<2>&) { return 0.0; }, 0.0);
    solid.initialise(dry);
    ASSERT_TRUE(solid.advance({0, 0.0, interval}, dry).accepted);
    const auto& p = solid.state().particles;
    std::vector<double> sheared(p.plastic_strain.begin(), p.plastic_strain.begin() + static_cast<int>(p.free()));
    std::sort(sheared.begin(), sheared.end());
    shears.push_back(sheared[static_cast<std::size_t>(0.95 * static_cast<double>(p.free()))]);
    next.push_back(solid.publish().proposed_interval);
    EXPECT_EQ(solid.publish().limited_by, shears.back() > 0.0 ? "the soil creeps" : "");
  }
  std::printf("sheared by %.2g, %.2g, %.2g\n", shears[0], shears[1], shears[2]);
  EXPECT_EQ(shears[0], 0.0);  // except in a few particles at its foot
  EXPECT_GT(next[0], 1e9 * interval);
  EXPECT_GT(shears[1], 2e-3);
  EXPECT_DOUBLE_EQ(next[1], interval * 2e-3 / shears[1]);
  EXPECT_GT(shears[2], 2e-3 / 0.3);
  EXPECT_DOUBLE_EQ(next[2], 0.3 * interval);
}

TEST(LongWindow, IsRefusedWhereSoilCannotStandAndTakenAgainOnceItIsCalm) {
  Case scene = wet_column();
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.soils[0].friction_angle = 30.0;
  Solid<2> solid(scene);
  const auto still = test::wet_inbox<2>(solid, standing_water);
  solid.initialise(still);
  auto boiling = still;  // seepage lifts with twice the buoyant weight
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.size(); ++i)
    values(boiling, field::drag_impulse)[2 * i + 1] = 2.0 * p.volume[i] * 960.0 * 9.81;
  solid.save();
  // A shorter window is tried first: in it, creep that the water limits finds its equilibrium.
  auto refused = solid.advance({0, 0.0, 1.0}, boiling);
  EXPECT_FALSE(refused.accepted);
  EXPECT_EQ(refused.suggested_interval, 0.25);
  solid.restore();
  EXPECT_FALSE(solid.state().motion.moving);
  EXPECT_EQ(solid.publish().limited_by, "the soil creeps");
  EXPECT_EQ(solid.publish().proposed_interval, 0.25);
  for (const double shorter : {0.25, 0.0625}) {  // down to the time of a wave across and back
    refused = solid.advance({0, 0.0, shorter}, boiling);
    EXPECT_FALSE(refused.accepted);
    solid.restore();
  }
  EXPECT_LT(refused.suggested_interval, 0.015);  // ten substeps
  EXPECT_EQ(solid.state().time, 0.0);
  EXPECT_TRUE(solid.state().motion.moving);
  EXPECT_EQ(solid.publish().limited_by, "the soil moves");
  // The limit remains however often the window is repeated.
  ASSERT_TRUE(solid.advance({0, 0.0, refused.suggested_interval}, boiling).accepted);
  solid.restore();
  EXPECT_TRUE(solid.state().motion.moving);
  for (int k = 0; k < 200 && solid.state().motion.moving; ++k)
    ASSERT_TRUE(solid.advance({1, solid.state().time, solid.publish().proposed_interval}, still).accepted);
  EXPECT_FALSE(solid.state().motion.moving);
  EXPECT_EQ(solid.counters().at("times the soil began to move"), 1.0);
  EXPECT_TRUE(solid.advance({2, solid.state().time, 1.0}, still).accepted);
}

/// Grains that ravel and creep keep the rest of the soil vibrating. A long window is tried again all the same once the
/// energy of the vibration is small compared with the dissipated energy, and only then.
TEST(LongWindow, IsTakenAgainThoughCreepingSoilVibrates) {
  for (const bool creeps : {true, false}) {
    Solid<2> solid(yielding_column(4000.0));
    solid.initialise(test::wet_inbox<2>(
        solid, [](const Vec<2>&) { return 0.0; }, 0.0));
    const auto& setup = solid.setup();
    State<2> state = solid.state();
    const double slow = statics::woken_by * 9.81 / near_critical_damping(setup), interval = followed_window(setup);
    double kinetic = 0.0;
    for (std::size_t i = 0; i < state.particles.free(); ++i) {
      state.particles.velocity[i] = (i % 2 == 0 ? 2.0 : -2.0) * slow * Vec<2>::UnitY();
      kinetic += 0.5 * state.particles.mass[i] * state.particles.velocity[i].squaredNorm();
    }
    state.any_yielded = true;
    state.motion.begins(long_window(setup));
    const double dissipated = creeps ? 2.0 * kinetic / steps::noticed * interval / long_window(setup) : 0.0;
    for (double t = 0.0; t < 10.0 * long_window(setup); t += interval)
      control_motion(setup, Drive<2>{}, interval, dissipated, state);
    EXPECT_EQ(state.motion.moving, !creeps);
  }
}

TEST(SaveAndRestore, RepeatToTheBit) {
  ColumnSpec spec;
  Case scene = column(spec);
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.solid.initial_velocity = Point3(0.5, 0.0, 0.0);
  spec.height = 0.5;
  scene.walls.pop_back();  // the right side is free: it slumps
  Solid<2> solid(scene);
  solid.initialise({});
  test::run_dry(solid, 0.05, 0.01);
  solid.save();
  test::run_dry(solid, 0.25, 0.05);
  const auto first = solid.state().particles;
  EXPECT_TRUE(solid.state().any_yielded);
  EXPECT_GT(solid.counters().at("list rebuilds"), 1.0);
  EXPECT_LT(solid.publish().proposed_interval, 0.1);
  solid.restore();
  EXPECT_NEAR(solid.state().time, 0.05, 1e-12);
  test::run_dry(solid, 0.25, 0.05);
  const auto& second = solid.state().particles;
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first.position[i], second.position[i]);
    ASSERT_EQ(first.velocity[i], second.velocity[i]);
    ASSERT_EQ(first.stress[i], second.stress[i]);
  }
}

/// Expects that the soil leaves a window of `interval` [s] where the process is to stop and the window's start is
/// saved, and only there.
void expect_to_be_given_up(Solid<2>& solid, double interval, const Inbox& inbox) {
  const InterruptGuard guard;
  Window window{.step = 0, .time = solid.state().time, .interval = interval, .saved = true};
  solid.save();
  const auto before = solid.state().particles.position;
  std::raise(SIGTERM);
  EXPECT_THROW(solid.advance(window, inbox), WindowGivenUp);
  solid.restore();
  EXPECT_EQ(solid.state().time, window.time);
  EXPECT_EQ(solid.state().particles.position, before);
  window.saved = false;
  EXPECT_TRUE(solid.advance(window, inbox).accepted);
  const InterruptGuard forgets;  // the signal
}

TEST(Signal, EndsAFollowedWindow) {
  Solid<2> solid(column({}));
  solid.initialise({});
  expect_to_be_given_up(solid, 0.01, {});
}

TEST(Signal, EndsALongWindow) {
  Solid<2> solid(wet_column());
  solid.initialise(test::wet_inbox<2>(
      solid, [](const Vec<2>&) { return 0.0; }, 0.0));
  expect_to_be_given_up(solid, 1.0, test::wet_inbox<2>(solid, standing_water));
}

TEST(Errors, DivergenceNamesParticleStressAndTime) {
  ColumnSpec spec;
  Solid<2> solid(column(spec));
  auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
  solid.initialise(inbox);
  values(inbox, field::drag_impulse)[7] = std::nan("");
  try {
    solid.advance({0, 0.25, 1e-3}, inbox);
    FAIL() << "no error";
  } catch (const DivergedError& error) {
    EXPECT_NE(std::string(error.what()).find("last good time 0.25 s"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("particle"), std::string::npos);
  }
}

TEST(Errors, MissingFieldIsNamed) {
  ColumnSpec spec;
  Solid<2> solid(column(spec));
  auto inbox = test::wet_inbox<2>(solid, [](const Vec<2>&) { return 0.0; });
  inbox.fields.erase(inbox.fields.begin());
  EXPECT_THROW(solid.initialise(inbox), PeerError);
}

TEST(Frame, ShowsTheDocumentedFields) {
  ColumnSpec spec;
  Solid<2> solid(column(spec));
  solid.initialise({});
  const auto frame = solid.frame();
  EXPECT_EQ(frame.count, 160u);
  std::vector<std::string> names;
  for (const auto& f : frame.fields) {
    names.push_back(f.name);
    std::array<double, 7> written;
    written.fill(std::nan(""));
    f.write(frame.count - 1, written.data());
    EXPECT_EQ(std::count_if(written.begin(), written.end(), [](double x) { return std::isfinite(x); }), f.components)
        << f.name;
    EXPECT_FALSE(f.unit.empty());
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"displacement", "velocity", "effective_stress", "pore_pressure", "water_force",
                                      "void_fraction", "degree_of_saturation", "coverage", "accumulated_plastic_strain",
                                      "mobilised_friction", "pore_pressure_ratio", "volume"}));
}

// Elastic soil that has settled under its weight is published in its position as the case draws it, unless it can flow;
// later displacements are published for both.
TEST(Publication, ShowsElasticSoilAsItWasDrawn) {
  for (const auto model : {SolidCase::Model::elastic, SolidCase::Model::drucker_prager}) {
    ColumnSpec spec;
    Case scene = column(spec);
    scene.solid.model = model;
    scene.soils[0].youngs_modulus = 1e5;
    scene.soils[0].cohesion = 1e6;
    scene.solid.initial_velocity = Point3(0.0, -0.1, 0.0);
    Solid<2> solid(scene);
    const VecArray<2> drawn = solid.state().particles.position;
    solid.initialise({});
    const VecArray<2> settled = solid.state().particles.position;
    const auto farthest = [&](const VecArray<2>& right) {
      const auto published = solid.publish();
      double most = 0.0;
      for (std::size_t i = 0; i < right.size(); ++i)
        most = std::max(most, (Eigen::Map<const Vec<2>>(published.points.position.data() + 2 * i) - right[i]).norm());
      return most;
    };
    const bool elastic = model == SolidCase::Model::elastic;
    EXPECT_GT((settled.back() - drawn.back()).norm(), 0.5 * spec.spacing);
    EXPECT_LT(farthest(elastic ? drawn : settled), 1e-12);
    solid.advance({0, 0.0, 1e-3}, {});
    const VecArray<2>& now = solid.state().particles.position;
    VecArray<2> expected = now;
    for (std::size_t i = 0; i < now.size() && elastic; ++i) expected[i] = drawn[i] + (now[i] - settled[i]);
    EXPECT_GT((now.back() - settled.back()).norm(), 1e-5);
    EXPECT_LT(farthest(expected), 1e-12);
  }
}

TEST(Publication, MatchesTheContract) {
  ColumnSpec spec;
  Solid<2> solid(column(spec));
  solid.initialise({});
  const auto publication = solid.publish();
  const auto contract = solid.contract();
  ASSERT_EQ(publication.fields.size(), contract.gives.size());
  EXPECT_GT(publication.points.size(), publication.points.n_active);
  for (std::size_t k = 0; k < contract.gives.size(); ++k) {
    EXPECT_EQ(publication.fields[k].name, contract.gives[k].name);
    EXPECT_EQ(publication.fields[k].components, contract.gives[k].components);
    EXPECT_EQ(publication.fields[k].values.size(),
              publication.points.size() * static_cast<std::size_t>(contract.gives[k].components));
  }
}

}  // namespace
}  // namespace poretwin::solid
