// Soil full of water, with both solvers joined by the coupler's mapping, without processes or sockets.
#include "common/core/error.hpp"
#include "coupler/mapping.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "solid_solver/phase.hpp"
#include "tests/fluid/both_solvers.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

namespace poretwin::fluid {
namespace {

using namespace test;

/// One exchange after the other: the fluid first, then the solid with the fluid's result.
struct Joined {
  explicit Joined(const Case& scene)
      : fluid(scene),
        solid(scene),
        mapping(coupling::make_mapping(2)),
        to_solid(fluid.publish()),
        to_fluid(solid.publish()) {
    fluid.initialise(at_fluid());
    to_solid = fluid.publish();
    solid.initialise(at_solid());
    to_fluid = solid.publish();
  }
  coupling::Inbox at_fluid() {
    return mapping->map(coupling::Role::solid, to_fluid.points, to_fluid.fields,
                        coupling::standard_fields(coupling::Role::solid, 2), to_solid.points);
  }
  coupling::Inbox at_solid() {
    return mapping->map(coupling::Role::fluid, to_solid.points, to_solid.fields,
                        coupling::standard_fields(coupling::Role::fluid, 2), to_fluid.points);
  }
  void window(double interval) {
    fluid.advance({step, time, interval}, at_fluid());
    to_solid = fluid.publish();
    solid.advance({step, time, interval}, at_solid());
    to_fluid = solid.publish();
    ++step;
    time += interval;
  }
  double proposed() const { return std::min(to_solid.proposed_interval, to_fluid.proposed_interval); }

  Fluid<2> fluid;
  solid::Solid<2> solid;
  std::unique_ptr<coupling::SpatialMapping> mapping;
  coupling::Publication to_solid, to_fluid;
  std::uint64_t step = 0;
  double time = 0.0;
};

constexpr double bed = 4.0, level = 5.0, width = 2.0, spacing = 0.2;

Case submerged_bed() {
  Case scene;
  scene.fluid.particle_spacing = scene.solid.particle_spacing = spacing;
  scene.fluid.regions = {box(0.0, 0.0, width, level)};
  scene.solid.model = SolidCase::Model::elastic;
  Soil sand;
  sand.shape = box(0.0, 0.0, width, bed);
  sand.porosity = 0.3;
  sand.grain_density = 2650.0;
  sand.hydraulic_conductivity = 1e-4;
  sand.youngs_modulus = 100e6;
  sand.poissons_ratio = 0.3;
  scene.soils = {sand};
  scene.walls = {wall(line(0.0, 7.0, 0.0, 0.0)), wall(line(0.0, 0.0, width, 0.0)), wall(line(width, 0.0, width, 7.0))};
  scene.walls[0].soil = scene.walls[2].soil = Wall::ForSoil::roller;
  scene.walls[1].soil = Wall::ForSoil::fixed;
  for (auto& w : scene.walls) w.water = Wall::ForWater::no_slip;
  return scene;
}

struct Extremes {
  double water = 0.0, soil = 0.0, pressure = 0.0;
};

Extremes extremes(const Joined& pair) {
  Extremes e;
  const auto& p = pair.fluid.state().particles;
  for (std::size_t a = 0; a < p.size(); ++a) {
    e.water = std::max(e.water, p.velocity[a].norm());
    const double hydrostatic = 9810.0 * (level - p.position[a].y());
    e.pressure = std::max(e.pressure, std::abs(pair.to_solid.fields[0].values[a] - hydrostatic) / (9810.0 * level));
  }
  for (const auto& v : pair.solid.state().particles.velocity) e.soil = std::max(e.soil, v.norm());
  return e;
}

/// Runs windows of one length, or of the length that the phases propose, up to a time; returns the worst values.
Extremes run(const Case& scene, double interval, double end) {
  Joined pair(scene);
  Extremes worst;
  while (pair.time < end * (1.0 - 1e-9)) {
    pair.window(std::min(interval > 0.0 ? interval : pair.proposed(), end - pair.time));
    const auto now = extremes(pair);
    worst.water = std::max(worst.water, now.water);
    worst.soil = std::max(worst.soil, now.soil);
    worst.pressure = std::max(worst.pressure, now.pressure);
    if (worst.water > 1.0) break;
  }
  return worst;
}

TEST(Submerged, RestIsKeptUnderFreeWater) {
  // The impulse that the soil returns must not reach the free water, nor act at once where drag dominates: in either
  // case the run blew up from exact rest within 20 to 300 windows.
  struct Row {
    double conductivity, interval, end;
  };
  for (const auto& row :
       {Row{1e-4, 0.0, 2.0}, Row{1e-4, 1e-2, 2.0}, Row{1e-4, 4e-2, 8.0}, Row{1e-6, 4e-2, 4.0}, Row{1e-2, 1e-2, 2.0}}) {
    auto scene = submerged_bed();
    scene.soils[0].hydraulic_conductivity = row.conductivity;
    const auto worst = run(scene, row.interval, row.end);
    std::printf("k %.0e window %.0e: water %.1e m/s, soil %.1e m/s, pressure %.1e\n", row.conductivity, row.interval,
                worst.water, worst.soil, worst.pressure);
    EXPECT_LT(worst.water, 1e-4);
    EXPECT_LT(worst.soil, 1e-4);
    EXPECT_LT(worst.pressure, 1e-3);
  }
}

TEST(Submerged, UnevenWaterSettles) {
  auto scene = submerged_bed();
  scene.fluid.jitter = 0.05;
  const auto worst = run(scene, 0.0, 4.0);
  std::printf("jittered: water %.1e m/s, soil %.1e m/s, pressure %.1e\n", worst.water, worst.soil, worst.pressure);
  EXPECT_LT(worst.water, 0.1);
  EXPECT_LT(worst.soil, 1e-3);
  EXPECT_LT(worst.pressure, 0.05);
}

TEST(Submerged, SeepageAlongASlopeLeavesTightSoilAtRest) {
  // A slope without ends: gravity is turned by 20 degrees, the sides are periodic, and the water table lies at the
  // surface. Soil and water are at rest from the start, but for what the search for equilibrium leaves.
  auto scene = submerged_bed();
  scene.general.gravity = 9.81 * Point3(std::sin(0.349), -std::cos(0.349), 0.0);
  scene.general.periodic = {0};
  scene.general.domain_max = Point3(width, 2.0 * bed, 0.0);
  scene.general.end_time = 0.1;
  scene.solid.initial_seepage = true;
  scene.solid.model = SolidCase::Model::drucker_prager;
  scene.soils[0].cohesion = 1e7;
  scene.soils[0].friction_angle = 30.0;
  scene.soils[0].hydraulic_conductivity = 1e-5;
  scene.walls = {scene.walls[1]};
  scene.fluid.regions = {scene.soils[0].shape};
  scene.water_faces = {pressure_face(line(width, bed, 0.0, bed), 0.0)};
  BothSolvers both(scene);
  both.run_to_end();
  const Fluid<2>& fluid = both.fluid;
  double worst = 0.0;
  const coupling::Publication water = fluid.publish();
  const auto& pressure = coupling::field_named(water.fields, std::string(coupling::field::pore_pressure)).values;
  const auto& p = fluid.state().particles;
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double depth = bed - p.position[a].y();
    worst = std::max(worst, std::abs(pressure[a] / (9810.0 * std::cos(0.349) * bed) - depth / bed));
  }
  std::printf("%.0f windows, %.0f solves missed their tolerance, pressure %.1e\n",
              static_cast<double>(both.run.report.windows), fluid.counters().at("solves that missed their tolerance"),
              worst);
  EXPECT_EQ(fluid.counters().at("solves that missed their tolerance"), 0.0);
  EXPECT_LT(worst, 1e-3);
}

TEST(Submerged, WaterInTightSoilThatSlidesKeepsItsPlaces) {
  // A layer without ends that slides on a smooth floor carries its unevenly spaced water along: what evens out the
  // spacing does not have the speed of the slide (which would move particles by 0.12 spacings).
  auto scene = submerged_bed();
  scene.general.periodic = {0};
  scene.general.domain_max = Point3(width, 2.0 * bed, 0.0);
  scene.general.end_time = 0.4;
  scene.solid.initial_velocity = scene.fluid.initial_velocity = Point3(2.0, 0.0, 0.0);
  scene.soils[0].hydraulic_conductivity = 1e-6;
  scene.walls = {wall(line(0.0, 0.0, width, 0.0))};
  scene.walls[0].soil = Wall::ForSoil::roller;
  scene.fluid.regions = {scene.soils[0].shape};
  scene.fluid.jitter = 0.1;
  scene.water_faces = {pressure_face(line(width, bed, 0.0, bed), 0.0)};
  BothSolvers both(scene);
  const VecArray<2> before = both.fluid.state().particles.position;
  both.run_to_end();
  const auto& after = both.fluid.state().particles.position;
  double worst = 0.0;
  for (std::size_t a = 0; a < before.size(); ++a) {
    Vec<2> d = after[a] - before[a] - Vec<2>(2.0 * 0.4, 0.0);
    d.x() -= width * std::round(d.x() / width);
    worst = std::max(worst, d.norm());
  }
  std::printf("%.0f windows, displaced by %.1e spacings\n", static_cast<double>(both.run.report.windows), worst / spacing);
  EXPECT_LT(worst, 0.03 * spacing);
}

TEST(Submerged, ABlockThatSinksGainsNoEnergy) {
  // A stiff block of coarse gravel is let go 6 cm above the floor of a tank, all of it under water. What it loses in
  // height becomes motion, waves and drag; only some of that comes back when it lands. In water inside the soil whose
  // balance of volume may lag, the energy of block and water rises four hundredfold.
  Case scene;
  scene.general.end_time = 0.3;
  scene.fluid.particle_spacing = scene.solid.particle_spacing = 0.02;
  scene.soils.resize(1);
  scene.soils[0].shape = box(0.1, 0.06, 0.3, 0.16);
  scene.soils[0].porosity = 0.3;
  scene.soils[0].hydraulic_conductivity = 0.1;
  scene.soils[0].youngs_modulus = 1e7;
  scene.walls = {wall(line(0.0, 0.5, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.0, 0.4, 0.5))};
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.26)};
  scene.solid.initial_rest = false;
  scene.gauges = {gauge("water", "energy"), gauge("soil", "energy")};
  scene.gauges[1].phase = "solid";
  BothSolvers both(scene);
  const auto energy = [&] { return both.fluid.gauges().at(0).value + both.soil->gauges().at(0).value; };
  const double before = energy();
  both.run_to_end();
  std::printf("energy %.1f J, %.1f J at first\n", energy(), before);
  EXPECT_LT(energy(), before);
  EXPECT_GT(energy(), 0.9 * before);
}

TEST(Submerged, PressureUnderSoilThatFlowsDoesNotAlternate) {
  // A column of water, let go on a bed of sand without cohesion, pushes the bed aside. The pressure stays below that of
  // the column at rest, 3.9 kPa, and nowhere is there suction of more than a tenth of it.
  const Case scene = read_case(PORETWIN_CASES "/dam_break_on_soil/case.toml", {"case.end_time=0.04"});
  BothSolvers both(scene);
  both.run.scheme = coupling::Settled{scene.coupling.settled_below()};
  both.run_to_end();
  const coupling::Publication water = both.fluid.publish();
  const auto& pressure = coupling::field_named(water.fields, std::string(coupling::field::pore_pressure)).values;
  const auto [least, most] = std::ranges::minmax_element(pressure);
  std::printf("%.0f windows, pressures from %.0f to %.0f Pa\n", static_cast<double>(both.run.report.windows), *least, *most);
  EXPECT_GT(*least, -390.0);
  EXPECT_LT(*most, 3900.0);
}

}  // namespace
}  // namespace poretwin::fluid
