// Columns with exact solutions: under their own weight, under water, loaded at the top.
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;
using test::whole;

struct Errors {
  double vertical = 0.0, horizontal = 0.0;  ///< largest error, over the value at the base
  double vertical_l2 = 0.0, horizontal_l2 = 0.0;
};

/// Errors against sigma_v = -weight (H - y), sigma_h = nu / (1 - nu) sigma_v.
template <int D>
Errors stress_errors(const Solid<D>& solid, double weight, double height, double nu) {
  Errors e;
  const auto& p = solid.state().particles;
  const double base = weight * height;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double v = -weight * (height - (p.position[i][D - 1] - p.displacement[i][D - 1]));
    const double dv = (p.stress[i][D - 1] - v) / base,
                 dh = (p.stress[i][0] - nu / (1.0 - nu) * v) / base * (1.0 - nu) / nu;
    e.vertical = std::max(e.vertical, std::abs(dv));
    e.horizontal = std::max(e.horizontal, std::abs(dh));
    e.vertical_l2 += dv * dv / static_cast<double>(p.size());
    e.horizontal_l2 += dh * dh / static_cast<double>(p.size());
  }
  e.vertical_l2 = std::sqrt(e.vertical_l2);
  e.horizontal_l2 = std::sqrt(e.horizontal_l2);
  std::printf("stress errors: vertical max %.5f L2 %.5f, horizontal max %.5f L2 %.5f\n", e.vertical, e.vertical_l2,
              e.horizontal, e.horizontal_l2);
  return e;
}

double gauge(const Phase& solid, const std::string& name) {
  for (const auto& reading : solid.gauges())
    if (reading.gauge == name) return reading.value;
  ADD_FAILURE() << "no gauge " << name;
  return NAN;
}

TEST(GravityColumn, StressAndSettlementAndFiveSecondsOfRest) {
  for (const auto base : {Wall::ForSoil::fixed, Wall::ForSoil::roller}) {
    ColumnSpec spec;
    spec.base = base;
    spec.spacing = 0.04;
    Case scene = column(spec);
    scene.gauges = {test::point_gauge<2>("top", "displacement_y", {Point3(0.2, 1.0, 0.0)}),
                    test::point_gauge<2>("bottom", "effective_stress_yy", {Point3(0.2, 0.0, 0.0)}),
                    test::point_gauge<2>("outside", "effective_stress_yy", {Point3(0.2, 1.2, 0.0)}), whole("uplift"),
                    whole("max_speed")};
    Solid<2> solid(scene);
    solid.initialise({});
    const double weight = 0.6 * 2600.0 * 9.81, m = 3e6 * 0.7 / (1.3 * 0.4);
    const double settlement = weight / (2.0 * m);
    auto expect_rest = [&] {
      const Errors e = stress_errors<2>(solid, weight, 1.0, 0.3);
      EXPECT_LT(e.vertical, 0.01);
      EXPECT_LT(e.horizontal, 0.01);
      std::printf("settlement error %.5f, base stress error %.5f\n", -gauge(solid, "top") / settlement - 1.0,
                  -gauge(solid, "bottom") / weight - 1.0);
      EXPECT_NEAR(-gauge(solid, "top") / settlement, 1.0, 0.02);
      EXPECT_NEAR(-gauge(solid, "bottom") / weight, 1.0, 0.02);
      EXPECT_TRUE(std::isnan(gauge(solid, "outside")));
    };
    std::printf("rest steps %.0f\n", solid.counters().at("rest steps"));
    expect_rest();
    test::run_dry(solid, 5.0, 0.1);
    expect_rest();
    std::printf("uplift %.3g m, speed %.3g m/s\n", gauge(solid, "uplift"), gauge(solid, "max_speed"));
    EXPECT_LT(gauge(solid, "uplift"), 1e-2 * settlement);
    EXPECT_LT(gauge(solid, "max_speed"), 1e-2 * settlement * 67.0);  // over settlement x frequency of the slowest mode
  }
}

// Residual water loads moist soil with its own weight, n s_r0 rho_w g per volume.
TEST(GravityColumn, ResidualWaterWeighsOnTheSoil) {
  ColumnSpec spec;
  spec.spacing = 0.04;
  Case scene = column(spec);
  scene.soils[0].initial_saturation = 0.195;
  Solid<2> solid(scene);
  solid.initialise({});
  const Errors e = stress_errors<2>(solid, (0.6 * 2600.0 + 0.4 * 0.195 * 1000.0) * 9.81, 1.0, 0.3);
  EXPECT_LT(e.vertical, 0.01);  // 0.048 without it
}

TEST(GravityColumn, InThreeDimensions) {
  ColumnSpec spec;
  spec.dimension = 3;
  spec.width = 0.3;
  spec.height = 0.6;
  spec.spacing = 0.06;
  Solid<3> solid(column(spec));
  solid.initialise({});
  test::run_dry(solid, 0.2, 0.1);
  const Errors e = stress_errors<3>(solid, 0.6 * 2600.0 * 9.81, 0.6, 0.3);
  EXPECT_LT(e.vertical, 0.025);  // the surface row of ten rows; all others are ten times better
  EXPECT_LT(e.vertical_l2, 0.01);
  EXPECT_LT(e.horizontal_l2, 0.01);
}

/// Section 5.1 of the paper: soil 10 m deep, its base under 12 m of still water, with coarser particles than in the
/// paper.
Case submerged(SolidCase::PressureGradient form) {
  ColumnSpec spec;
  spec.width = 4.0;
  spec.height = 10.0;
  spec.spacing = 0.5;
  Case scene = column(spec);
  scene.soils[0].youngs_modulus = 1e8;
  scene.soils[0].porosity = 0.3;
  scene.soils[0].grain_density = 26000.0 / 9.81;
  scene.solid.pressure_gradient = form;
  scene.fluid.drag = false;
  scene.gauges = {whole("uplift"), whole("max_speed")};
  return scene;
}

double still_water(const Vec<2>& x) { return 9810.0 * (12.0 - x.y()); }

TEST(SubmergedColumn, BuoyantStressesAndRest) {
  Solid<2> solid(submerged(SolidCase::PressureGradient::difference));
  const auto inbox = test::wet_inbox<2>(solid, still_water);
  solid.initialise(inbox);
  const double weight = 0.7 * (26000.0 - 9810.0);
  std::printf("rest steps %.0f\n", solid.counters().at("rest steps"));
  stress_errors<2>(solid, weight, 10.0, 0.3);
  // In equilibrium no force is unbalanced, with the water's pressure and ghosts included.
  const auto publication = solid.publish();
  const auto& r = test::field_of(publication, coupling::field::unbalanced_force);
  for (std::size_t i = 0; i < publication.points.size(); ++i) {
    EXPECT_NEAR(r.values[2 * i + 1], 0.0, 60.0);
    EXPECT_NEAR(r.values[2 * i], 0.0, 60.0);
  }
  for (int k = 0; k < 50; ++k) solid.advance({0, solid.state().time, 0.1}, inbox);
  const Errors e = stress_errors<2>(solid, weight, 10.0, 0.3);
  EXPECT_LT(e.vertical_l2, 0.015);
  EXPECT_LT(e.horizontal_l2, 0.015);
  std::printf("uplift %.3g m\n", gauge(solid, "uplift"));
  EXPECT_LT(gauge(solid, "uplift"), 0.01 * 0.5);
}

/// Stress of the top row under still water; the exact one is -2.8 kPa, the buoyant weight of half a spacing.
double surface_stress(const Solid<2>& solid) {
  const auto& p = solid.state().particles;
  std::size_t top = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.position[i].y() > p.position[top].y()) top = i;
  return p.stress[top][1];
}

TEST(SubmergedColumn, SumFormPullsAtAnElasticSurface) {
  for (const auto form : {SolidCase::PressureGradient::difference, SolidCase::PressureGradient::sum}) {
    Solid<2> solid(submerged(form));
    solid.initialise(test::wet_inbox<2>(solid, still_water));
    std::printf("surface stress %.0f Pa\n", surface_stress(solid));
    if (form == SolidCase::PressureGradient::sum)
      EXPECT_GT(surface_stress(solid), 4e3);
    else
      EXPECT_NEAR(surface_stress(solid), -2833.0, 1500.0);
  }
}

TEST(SubmergedColumn, SumFormExpelsSurfaceParticlesThatNoTensionHolds) {
  for (const auto form : {SolidCase::PressureGradient::difference, SolidCase::PressureGradient::sum}) {
    Case scene = submerged(form);
    scene.solid.model = SolidCase::Model::drucker_prager;
    Solid<2> solid(scene);
    solid.initialise(test::wet_inbox<2>(solid, still_water));
    for (int k = 0; k < 10; ++k) solid.advance({0, solid.state().time, 0.1}, test::wet_inbox<2>(solid, still_water));
    double highest = 0.0;
    for (const auto& x : solid.state().particles.position) highest = std::max(highest, x.y());
    std::printf("highest particle %.3f m, speed %.3g m/s\n", highest, gauge(solid, "max_speed"));
    if (form == SolidCase::PressureGradient::sum)
      EXPECT_GT(highest, 9.75 + 0.3 * 0.5);  // a gap opens above the second row
    else
      EXPECT_NEAR(highest, 9.75, 0.01 * 0.5);
  }
}

TEST(LoadedColumn, StressIsTheTractionAndSettlementIsElastic) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = column(spec);
  scene.loads = {test::top_load(spec, 1e4)};
  scene.gauges = {test::point_gauge<2>("top", "displacement_y", {Point3(0.2, 1.0, 0.0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  const double m = 3e6 * 0.7 / (1.3 * 0.4);
  double worst = 0.0;
  for (const auto& s : solid.state().particles.stress) worst = std::max(worst, std::abs(s[1] / -1e4 - 1.0));
  const double settlement = -gauge(solid, "top") / (1e4 / m);
  std::printf("stress error %.5f, settlement error %.5f, steps %.0f\n", worst, settlement - 1.0,
              solid.counters().at("rest steps"));
  EXPECT_LT(worst, 0.01);
  EXPECT_NEAR(settlement, 1.0, 0.01);
}

TEST(LoadedColumn, DisorderCostsLittleStiffness) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = column(spec);
  scene.solid.jitter = 0.1;
  scene.loads = {test::top_load(spec, 1e4)};
  scene.gauges = {test::point_gauge<2>("top", "displacement_y", {Point3(0.2, 1.0, 0.0)})};
  Solid<2> solid(scene);
  solid.initialise({});
  const double settlement = -gauge(solid, "top") / (1e4 / (3e6 * 0.7 / (1.3 * 0.4)));
  std::printf("settlement error with a jitter of 0.1 dx %.5f\n", settlement - 1.0);
  EXPECT_NEAR(settlement, 1.0, 0.1);
}

TEST(LoadedColumn, LoadsWaitForTheirStart) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = column(spec);
  scene.loads = {test::top_load(spec, 1e4, 0.01)};
  Solid<2> solid(scene);
  solid.initialise({});
  auto publication = solid.publish();
  EXPECT_NEAR(publication.proposed_interval, 0.01, 1e-12);
  solid.advance({0, 0.0, 0.01}, {});
  for (const auto& v : solid.state().particles.velocity) ASSERT_EQ(v.norm(), 0.0);
  publication = solid.publish();
  EXPECT_EQ(publication.limited_by, "soil alone: gauges and prescribed water are seen between windows");
  // Now the load acts: the unbalanced force r contains the traction, and sums to traction times area.
  const auto& r = test::field_of(publication, coupling::field::unbalanced_force);
  double sum = 0.0;
  for (std::size_t i = 0; i < publication.points.n_active; ++i)
    sum += r.values[2 * i + 1] * publication.points.volume[i];
  EXPECT_NEAR(sum, -1e4 * 0.4, 1e-3 * 1e4 * 0.4);
  solid.advance({1, 0.01, 0.01}, {});
  // Until the wave reaches the base (19 ms), the bar's momentum comes from the load alone.
  double momentum = 0.0;
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.size(); ++i) momentum += p.mass[i] * p.velocity[i].y();
  EXPECT_NEAR(momentum, -1e4 * 0.4 * 0.01, 2e-3 * 1e4 * 0.4 * 0.01);
}

// The momentum from a load is the integral of its factor, here (1 - cos(w t)) / 2 in straight pieces.
TEST(LoadedColumn, LoadsFollowTheirFactor) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  Case scene = column(spec);
  scene.loads = {test::top_load(spec, 1e4, 0.0)};
  scene.loads[0].factor.emplace();
  constexpr double end = 0.01;  // s: before the wave reaches the base
  for (int i = 0; i <= 20; ++i)
    scene.loads[0].factor->knots.emplace_back(0.05 * i * end, 0.5 - 0.5 * std::cos(0.1 * i * 3.141592653589793));
  Solid<2> solid(scene);
  solid.initialise({});
  solid.advance({0, 0.0, end}, {});
  double momentum = 0.0;
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.size(); ++i) momentum += p.mass[i] * p.velocity[i].y();
  EXPECT_NEAR(momentum, -1e4 * 0.4 * 0.5 * end, 0.01 * 1e4 * 0.4 * 0.5 * end);
}

// Velocities of the sloshing mode: cosh and sinh over the height, without divergence or flow through walls and bottom.
TEST(SloshingMode, StartsTheSoil) {
  ColumnSpec spec;
  Case scene = column(spec);
  scene.solid.initial_wave = 0.1;
  scene.solid.initial_rest = false;
  const Solid<2> solid(scene);
  const double k = 3.141592653589793 / 0.4;
  const auto& p = solid.state().particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const auto& x = p.position[i];
    EXPECT_NEAR(p.velocity[i].x(), 0.1 * std::sin(k * x.x()) * std::cosh(k * x.y()) / std::sinh(k), 1e-12);
    EXPECT_NEAR(p.velocity[i].y(), -0.1 * std::cos(k * x.x()) * std::sinh(k * x.y()) / std::sinh(k), 1e-12);
  }
}

double fastest(const Solid<2>& solid) {
  double most = 0.0;
  for (const auto& v : solid.state().particles.velocity) most = std::max(most, v.norm());
  return most;
}

// Corrected gradients are large where neighbours are missing: tips of wedges need the shortest substeps (2 / omega of
// the highest mode is 1.07 to 1.09 dx / c there, 1.24 at plane faces, 1.94 inside).
TEST(GravityColumn, EdgesOfAWedgeLeaveRoom) {
  const auto growth = [](double courant, double run) {
    ColumnSpec spec;
    spec.width = 2.0;
    spec.gravity = 0.0;
    spec.sides = false;
    Case scene = column(spec);
    scene.soils[0].shape.kind = Shape::Kind::polygon;
    scene.soils[0].shape.points = {{0.0, 0.0, 0.0}, {run, 0.0, 0.0}, {0.0, 0.5, 0.0}};
    scene.solid.initial_velocity = {1e-4, -2e-4, 0.0};
    scene.solid.courant = courant;
    Solid<2> solid(scene);
    solid.initialise({});
    const double before = fastest(solid);
    test::run_dry(solid, 2.0, 0.01);
    return fastest(solid) / before;
  };
  for (const double run : {0.5, 1.0}) {
    const double within = growth(1.05, run);
    std::printf("wedge of %g:1 at a Courant number of 1.05: fastest particle %.3f of the first\n", run / 0.5, within);
    EXPECT_LT(within, 1.0) << "the default, 1, leaves a twentieth";
  }
  EXPECT_ANY_THROW(growth(1.2, 1.0)) << "else the default is too careful";
}

// Where stress vanishes at all surfaces, these may be as soft as their corrected gradients make them.
TEST(GravityColumn, AWedgeOfGrainsOnARoughWallTakesLongerSteps) {
  const auto scene = [](Wall::ForSoil kind, double cohesion, std::optional<double> courant) {
    ColumnSpec spec;
    spec.base = Wall::ForSoil::none;
    spec.sides = false;
    Case wedge = column(spec);
    Soil& soil = wedge.soils[0];
    soil.shape.kind = Shape::Kind::polygon;
    soil.shape.points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.5, 0.0}};
    soil.friction_angle = 35.0;
    soil.cohesion = cohesion;
    wedge.solid.model = SolidCase::Model::drucker_prager;
    wedge.solid.courant = courant;
    wedge.solid.jitter = 0.1;
    Wall base, back;
    base.name = "base";
    base.face.points = {{0.0, 0.0, 0.0}, {1.4, 0.0, 0.0}};
    base.soil = kind;
    back.name = "back";
    back.face.points = {{0.0, 0.8, 0.0}, {0.0, -0.2, 0.0}};
    back.soil = Wall::ForSoil::roller;
    wedge.walls = {base, back};
    return wedge;
  };
  const auto courant = [](const Case& wedge) {
    const auto setup = set_up<2>(wedge).first;
    return setup.longest_substep * setup.stabilisers.sound_speed / setup.spacing;
  };
  EXPECT_NEAR(courant(scene(Wall::ForSoil::rough, 0.0, {})), 1.4, 1e-12);
  EXPECT_NEAR(courant(scene(Wall::ForSoil::rough, 100.0, {})), 1.0, 1e-12) << "its surface bears stress";
  EXPECT_NEAR(courant(scene(Wall::ForSoil::fixed, 0.0, {})), 1.0, 1e-12);
  const auto fastest_at_rest = [&](double steps) {
    Solid<2> solid(scene(Wall::ForSoil::rough, 0.0, steps));
    solid.initialise({});
    test::run_dry(solid, 1.0, 0.01);
    return fastest(solid);
  };
  EXPECT_LT(fastest_at_rest(1.6), 1e-5) << "the default, 1.4, leaves a seventh";
  EXPECT_GT(fastest_at_rest(1.8), 1e-3) << "else the default is too careful";
}

}  // namespace
}  // namespace poretwin::solid
