// Wells: the equivalent radius of a pierced cell, and flow to a screen against Thiem (1906).
#include "pore_solver/wells.hpp"

#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace poretwin::pore::test {
namespace {

constexpr double pi = std::numbers::pi;

/// Radius of the circle that stands for a square of side 1 around its centre: the square's conformal radius,
/// 4 sqrt(pi) / Gamma(1/4)^2.
double conformal_radius() { return 4.0 * std::sqrt(pi) / std::pow(std::tgamma(0.25), 2); }

Face plane(const Point3& point, const Point3& normal) {
  Face face;
  face.point = point;
  face.normal = normal;
  return face;
}

/// A confined layer: a square of 2 m x 2 m, 0.5 m thick, with a head of 2 m at its four sides, saturated.
Case layer(Soil soil, double dx) {
  Shape shape;
  shape.min = {0, 0, 0};
  shape.max = {2, 2, 0.5};
  Case scene = scene_of(std::move(soil), shape, dx, 1e5);
  scene.general.dimension = 3;
  scene.general.gravity = {0.0, 0.0, -9.81};
  scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, 0}), 2.0), head_face(plane({2, 0, 0}, {-1, 0, 0}), 2.0),
                       head_face(plane({0, 0, 0}, {0, 1, 0}), 2.0), head_face(plane({0, 2, 0}, {0, -1, 0}), 2.0)};
  scene.fluid.initial_water_table = 2.0;
  return scene;
}
Well well_at(double x, double y, double radius) {
  Well well;
  well.name = "well";
  well.points = {{x, y, 0.0}, {x, y, 0.5}};
  well.radius = radius;
  return well;
}

TEST(Wells, OnALatticeTheEquivalentRadiusIsThatOfPeaceman) {
  const double exact = std::exp(-std::numbers::egamma) / std::sqrt(8.0);  // of the Green's function of a square lattice
  const Case space = layer(sharp(0.3, 1e-4), 0.1);
  const Network net = make_network(space);
  const auto pierced = pierced_by(space, net, well_at(0.95, 0.95, 0.005));
  ASSERT_EQ(pierced.size(), 5u);
  double length = 0.0;
  for (const auto& p : pierced) {
    length += p.to - p.from;
    EXPECT_NEAR(p.equivalent_radius, exact * 0.1, 0.005 * exact * 0.1);
  }
  EXPECT_NEAR(length, 0.5, 1e-9);
  // A screen that ends inside cells.
  Well part = well_at(0.95, 0.95, 0.005);
  part.points[0].z() = 0.08;
  part.points[1].z() = 0.41;
  const auto cells = pierced_by(space, net, part);
  ASSERT_EQ(cells.size(), 5u);
  EXPECT_NEAR(cells.front().to - cells.front().from, 0.02, 1e-6);
  EXPECT_NEAR(cells.back().to - cells.back().from, 0.01, 1e-6);
  for (const auto& p : cells) EXPECT_NEAR(p.equivalent_radius, exact * 0.1, 0.005 * exact * 0.1);

  const Case section = scene_of(sharp(0.3, 1e-4), box(0, 0, 2, 2), 0.1, 1.0);
  Well drain = well_at(0.95, 0.95, 0.005);
  drain.points.pop_back();
  const auto cell = pierced_by(section, make_network(section), drain);
  ASSERT_EQ(cell.size(), 1u);
  EXPECT_NEAR(cell[0].equivalent_radius, exact * 0.1, 0.005 * exact * 0.1);
}

TEST(Wells, AConfinedLayerYieldsWhatThiemGives) {
  // At the middle of a cell and at a corner of four, with and without a retention curve.
  const double k = 1e-4, radius = 0.005, level = 1.0;
  const double exact = 2.0 * pi * k * 0.5 * (2.0 - level) / std::log(2.0 * conformal_radius() / radius);
  for (const bool curve : {false, true})
    for (const int rows : {19, 20}) {
      Case scene = layer(curve ? van_genuchten(0.05, 0.3, 2.0, 2.0, k) : sharp(0.3, k), 2.0 / rows);
      Well well = well_at(1.0, 1.0, radius);
      well.head = constant(level);
      scene.wells = {well};
      scene.gauges = {gauge("q", "discharge", {}, "well"), gauge("passed", "passed_volume", {}, "well"),
                      gauge("water", "balance")};
      PoreWater water(scene);
      run_to(water, 1e5);
      EXPECT_NEAR(reading(water, "q"), exact, 0.01 * exact) << rows << " rows, curve " << curve;
      EXPECT_NEAR(reading(water, "passed"), -1e5 * exact, 0.01 * 1e5 * exact);
      EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * reading(water, "water_in"));
    }
}

/// Water flows along level beds to a well across them.
TEST(Wells, AWellAcrossBedsYieldsAsMuchAsWithoutBeds) {
  double q[2];
  for (const bool beds : {false, true}) {
    Case scene = layer(sharp(0.3, 1e-4), 0.1);
    if (beds) scene.soils[0].anisotropy = 10.0;
    scene.wells = {well_at(0.95, 0.95, 0.005)};
    scene.wells[0].head = constant(1.0);
    scene.gauges = {gauge("q", "discharge", {}, "well")};
    PoreWater water(scene);
    run_to(water, scene.general.end_time);
    q[beds] = reading(water, "q");
  }
  EXPECT_GT(q[0], 0.0);
  EXPECT_NEAR(q[1], q[0], 1e-6 * q[0]);
}

TEST(Wells, ADischargeIsPumpedExactlyAndTheLevelFollows) {
  const double k = 1e-4, radius = 0.005, q = 2e-5;
  const double fall = q / (2.0 * pi * k * 0.5) * std::log(2.0 * conformal_radius() / radius);
  for (const bool curve : {false, true}) {
    Case scene = layer(curve ? van_genuchten(0.05, 0.3, 2.0, 2.0, k) : sharp(0.3, k), 2.0 / 19);
    Well well = well_at(1.0, 1.0, radius);
    well.discharge = Series{{{0.0, q}, {6e4, q}, {6.1e4, -q}}};
    scene.wells = {well};
    scene.gauges = {gauge("q", "discharge", {}, "well"), gauge("level", "level", {}, "well"),
                    gauge("passed", "passed_volume", {}, "well")};
    PoreWater water(scene);
    run_to(water, 6e4);
    EXPECT_NEAR(reading(water, "q"), q, 1e-9 * q);
    EXPECT_NEAR(reading(water, "passed"), -6e4 * q, 1e-9 * 6e4 * q);
    EXPECT_NEAR(2.0 - reading(water, "level"), fall, 0.01 * fall);
    run_to(water, 1e5);  // it now lets in as much
    EXPECT_NEAR(reading(water, "level") - 2.0, fall, 0.01 * fall);
    EXPECT_NEAR(reading(water, "passed"), -(6e4 - 3.9e4) * q, 1e-6);
  }
}

TEST(Wells, AWellThatIsPumpedEmptyTakesWhatComes) {
  const double k = 1e-4, radius = 0.005;
  Case scene = layer(sharp(0.3, k), 0.1);
  Well well = well_at(0.95, 0.95, radius);
  well.discharge = constant(1e-3);  // ten times what the layer can give
  scene.wells = {well};
  scene.gauges = {gauge("q", "discharge", {}, "well"), gauge("level", "level", {}, "well"), gauge("water", "balance")};
  PoreWater water(scene);
  run_to(water, 1e5);
  EXPECT_NEAR(reading(water, "level"), 0.0, 1e-9);
  EXPECT_GT(reading(water, "q"), 5e-5);
  EXPECT_LT(reading(water, "q"), 2e-4);
  EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * reading(water, "water_in"));
}

/// Cells of disordered points need no other formula.
TEST(Wells, DisorderedPointsYieldWhatThiemGives) {
  const double k = 1e-4, radius = 0.005, level = 1.0;
  const double exact = 2.0 * pi * k * 0.5 * (2.0 - level) / std::log(2.0 * conformal_radius() / radius);
  for (const unsigned seed : {1u, 2u, 3u}) {
    Case scene = layer(sharp(0.3, k), 0.1);
    scene.fluid.jitter = 0.2;
    scene.fluid.seed = seed;
    Well well = well_at(1.0, 1.0, radius);
    well.head = constant(level);
    scene.wells = {well};
    scene.gauges = {gauge("q", "discharge", {}, "well")};
    PoreWater water(scene);
    run_to(water, 1e5);
    EXPECT_NEAR(reading(water, "q"), exact, 0.01 * exact) << seed;
  }
}

/// In a vertical section a well is a drain: a square, full of water under high heads at its sides.
TEST(Wells, ADrainAcrossASectionTakesWhatThiemGives) {
  const double k = 1e-4, radius = 0.005;
  for (const int rows : {19, 20}) {
    Case scene = scene_of(sharp(0.3, k), box(0, 0, 2, 2), 2.0 / rows, 1e5);
    for (const Face& side : {line(0, 2, 0, 0), line(2, 0, 2, 2), line(0, 0, 2, 0), line(2, 2, 0, 2)})
      scene.water_faces.push_back(head_face(side, 5.0));
    Well drain = well_at(1.0, 1.0, radius);
    drain.points.pop_back();
    drain.head = constant(3.0);
    scene.wells = {drain};
    scene.fluid.initial_water_table = 5.0;
    scene.gauges = {gauge("q", "discharge", {}, "well")};
    PoreWater water(scene);
    run_to(water, 1e5);
    const double exact = 2.0 * pi * k * 2.0 / std::log(2.0 * conformal_radius() / radius);
    EXPECT_NEAR(reading(water, "q"), exact, 0.01 * exact) << rows << " rows";
  }
}

}  // namespace
}  // namespace poretwin::pore::test
