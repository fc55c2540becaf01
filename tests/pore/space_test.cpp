// The field in 3D: cells and faces of lattice bodies are exact, and flow agrees with 2D and with closed forms.
#include "common/core/archive.hpp"
#include "common/geometry/solid.hpp"
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

namespace poretwin::pore::test {
namespace {

constexpr double pi = std::numbers::pi;

double sum(const ScalarArray& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

Shape block(const Point3& min, const Point3& max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}
Shape cylinder(const Point3& from, const Point3& to, double radius) {
  Shape shape;
  shape.kind = Shape::Kind::cylinder;
  shape.ends = {from, to};
  shape.radius = radius;
  return shape;
}
/// A body of shapes within one another and without others, as read_case() makes it.
Shape made(Shape shape, double spacing, const std::vector<Shape>& within = {}, const std::vector<Shape>& without = {}) {
  std::vector<Solid::Part> parts;
  parts.push_back({TriangleMesh(surface_of(shape, spacing, {})), false});
  for (const auto& other : within) parts.push_back({TriangleMesh(surface_of(other, spacing, {})), false});
  for (const auto& other : without) parts.push_back({TriangleMesh(surface_of(other, spacing, {})), true});
  shape.solid = std::make_shared<const Solid>(std::move(parts), 0.1 * spacing);
  return shape;
}
Face plane(const Point3& point, const Point3& normal) {
  Face face;
  face.point = point;
  face.normal = normal;
  return face;
}
Face surface_in(Shape shape) {
  Face face;
  face.within = std::move(shape);
  return face;
}
Case scene_in_space(Soil soil, const Shape& shape, double spacing, double end) {
  Case scene = scene_of(std::move(soil), shape, spacing, end);
  scene.general.dimension = 3;
  scene.general.gravity = {0.0, 0.0, -9.81};
  return scene;
}
/// The trapezium of embankment_seepage, extruded along y.
Shape slab(double spacing) {
  Shape shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = {{0.0, 0.0, 0.0}, {1.2, 0.0, 0.0}, {0.8, 0.4, 0.0}, {0.4, 0.4, 0.0}};
  shape.along = {1};
  shape.from = 0.0;
  shape.to = 0.2;
  return made(shape, spacing);
}

TEST(NetworkInSpace, OfALatticeEachPointHasItsCube) {
  Case scene = scene_in_space(sharp(0.4, 1e-4), block({0, 0, 0}, {0.5, 0.4, 0.3}), 0.1, 1.0);
  scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, 0}), 0.3)};
  // A drain below a part of the base; its end lies within a row of cells.
  scene.water_faces.push_back(head_face(plane({0, 0, 0}, {0, 0, 1}), 0.0));
  scene.water_faces[1].face.within = block({0.23, -1, -1}, {1, 1, 1});
  const Network net = make_network(scene);
  ASSERT_EQ(net.size(), 60u);
  for (const double v : net.volume) EXPECT_NEAR(v, 1e-3, 1e-14);
  EXPECT_EQ(net.links.size(), 4u * 4u * 3u + 5u * 3u * 3u + 5u * 4u * 2u);
  for (const auto& link : net.links) EXPECT_NEAR(link.transmissibility, 0.1, 1e-9);
  std::array<double, 2> area{};
  for (const auto& s : net.segments) {
    area[s.face] += s.area;
    EXPECT_NEAR(s.transmissibility, s.area / 0.05, 1e-9);
    EXPECT_NEAR(s.high - s.low, s.face == 0 ? 0.1 : 0.0, 1e-9);
  }
  EXPECT_NEAR(area[0], 0.4 * 0.3, 1e-9);
  EXPECT_NEAR(area[1], 0.4 * 0.27, 1e-6);
}

TEST(NetworkInSpace, CellsFillASlabToItsSlopes) {
  for (const double jitter : {0.0, 0.2}) {
    Case scene = scene_in_space(sharp(0.4, 1e-4), slab(0.04), 0.04, 1.0);
    scene.fluid.jitter = jitter;
    scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, -1}), 0.3), head_face(plane({1.2, 0, 0}, {-1, 0, -1}), 0.0)};
    const Network net = make_network(scene);
    EXPECT_NEAR(sum(net.volume), 0.32 * 0.2, 1e-9);
    double area = 0.0, level = 0.0;
    for (const auto& s : net.segments) {
      area += s.area;
      level += s.level_area;
      EXPECT_GT(s.transmissibility, 0.0);
    }
    EXPECT_NEAR(area, 0.2 * 2.0 * std::sqrt(0.32), 1e-6);
    EXPECT_NEAR(level, 0.2 * 0.8, 1e-6);
    for (Index a = 0; a < net.size(); ++a) {
      const auto filling = net.filling(a);
      EXPECT_EQ(filling.front().share, 0.0);
      EXPECT_EQ(filling.back().share, 1.0);
      for (std::size_t i = 1; i < filling.size(); ++i) EXPECT_GE(filling[i].share, filling[i - 1].share);
    }
  }
}

/// The facets' area is that of the circle, so that their surface is the cylinder's up to the facets' size.
TEST(NetworkInSpace, CellsFillACylinderAndLeaveItsHole) {
  const double dx = 0.1;
  const Shape ring = made(cylinder({0, 0, 0}, {0, 0, 0.3}, 2.0), dx, {}, {cylinder({0, 0, -1}, {0, 0, 1}, 0.8)});
  Case scene = scene_in_space(sharp(0.4, 1e-4), ring, dx, 1.0);
  scene.water_faces = {head_face(surface_in(made(cylinder({0, 0, -1}, {0, 0, 1}, 0.9), dx)), 0.1)};
  const Network net = make_network(scene);
  const double volume = pi * (4.0 - 0.64) * 0.3;
  EXPECT_NEAR(sum(net.volume), volume, 1e-3 * volume);
  double area = 0.0;
  for (const auto& s : net.segments)
    if (std::abs(s.level_area) < 1e-9 && s.high - s.low > 1e-9) area += s.area;
  EXPECT_NEAR(area, 2.0 * pi * 0.8 * 0.3, 0.01 * 2.0 * pi * 0.8 * 0.3);
}

TEST(NetworkInSpace, NothingIsLostWhereSoilsMeetOnASlope) {
  for (const double dx : {0.2, 0.1, 0.07}) {
    Case scene = scene_in_space(sharp(0.4, 1e-4), block({0, 0, 0}, {1, 1, 1}), dx, 1.0);
    scene.soils.push_back(scene.soils[0]);
    Shape left, right;
    left.kind = right.kind = Shape::Kind::polygon;
    left.points = {{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.75, 0.0}, {0.0, 1.0, 0.0}};
    right.points = {{0.5, 0.0, 0.0}, {1.4, 0.0, 0.0}, {1.4, 0.3, 0.0}, {0.5, 0.75, 0.0}};
    left.along = right.along = {1};
    left.to = right.to = 0.6;
    scene.soils[0].shape = made(left, dx);
    scene.soils[1].shape = made(right, dx);
    scene.rains = {rain(plane({0, 0, 1}, {-0.5, 0, -1}), constant(1e-6))};
    const Network net = make_network(scene);
    double covered = 0.0;
    for (const auto& s : net.segments) covered += s.level_area;
    EXPECT_NEAR(covered, 1.4 * 0.6, 1e-6) << dx;
    EXPECT_NEAR(sum(net.volume), (0.5 * 0.875 + 0.9 * 0.525) * 0.6, 1e-9) << dx;
  }
}

TEST(NetworkInSpace, ASlitInTheSoilIsACutOff) {
  // 1 mm wide, from the top half-way down between two rows of points.
  const double dx = 0.1;
  const Shape soil = made(block({0, 0, 0}, {1, 0.3, 0.6}), dx, {}, {block({0.4995, -1, 0.3}, {0.5005, 1, 1})});
  const Network net = make_network(scene_in_space(sharp(0.4, 1e-4), soil, dx, 1.0));
  std::size_t across = 0;
  for (const auto& link : net.links)
    if ((net.position[link.a].x() < 0.5) != (net.position[link.b].x() < 0.5)) {
      ++across;
      EXPECT_LT(net.elevation[link.a], 0.3);
    }
  EXPECT_EQ(across, 3u * 3u);
  EXPECT_NEAR(sum(net.volume), 0.18 - 0.001 * 0.3 * 0.3, 1e-9);
}

TEST(NetworkInSpace, SoilsThatTouchAreLinkedAndTheirBorderIsNone) {
  Case scene = scene_in_space(sharp(0.4, 1e-4), block({0, 0, 0}, {0.5, 0.3, 0.5}), 0.1, 1.0);
  scene.soils.push_back(scene.soils[0]);
  scene.soils[1].shape = block({0.5, 0, 0}, {1.0, 0.3, 1.0});  // higher: half its side touches
  scene.water_faces = {head_face(plane({0.5, 0, 0}, {1, 0, 0}), 0.0)};
  const Network net = make_network(scene);
  std::size_t across = 0;
  for (const auto& link : net.links) across += net.soil[link.a] != net.soil[link.b];
  EXPECT_EQ(across, 15u);
  EXPECT_EQ(net.segments.size(), 15u);
  EXPECT_NEAR(sum(net.volume), 0.225, 1e-9);
}

/// Readings of a column one point wide under rain that ponds and then dries. The factors of its matrix are complete, so
/// that 2D and 3D differ by rounding alone.
std::vector<double> infiltration(int dimension) {
  const double dx = 0.02;
  const Soil soil = van_genuchten(0.078, 0.43, 3.6, 1.56, 2.889e-6);
  Case scene;
  const Series rate{{{0.0, 2e-6}, {4e4, 2e-6}, {4.1e4, -2e-8}}};
  std::vector<Point3> places;
  if (dimension == 2) {
    scene = scene_of(soil, box(0.0, 0.0, dx, 1.0), dx, 2e5);
    scene.water_faces = {pressure_face(line(0.0, 0.0, dx, 0.0), 0.0)};
    scene.rains = {rain(line(dx, 1.0, 0.0, 1.0), rate)};
    for (int i = 1; i < 10; ++i) places.emplace_back(0.5 * dx, 0.1 * i, 0.0);
  } else {
    scene = scene_in_space(soil, block({0, 0, 0}, {dx, dx, 1.0}), dx, 2e5);
    scene.water_faces = {pressure_face(plane({0, 0, 0}, {0, 0, 1}), 0.0)};
    scene.rains = {rain(plane({0, 0, 1}, {0, 0, -1}), rate)};
    for (int i = 1; i < 10; ++i) places.emplace_back(0.5 * dx, 0.5 * dx, 0.1 * i);
  }
  scene.fluid.initial_water_table = 0.0;
  scene.gauges = {gauge("psi", "point", places, "pressure_head"), gauge("soaked", "infiltration"),
                  gauge("water", "balance")};
  PoreWater water(scene);
  run_to(water, 2e5);
  std::vector<double> readings;
  for (std::size_t i = 0; i < places.size(); ++i) readings.push_back(reading(water, "psi[" + std::to_string(i) + "]"));
  const double width = dimension == 2 ? 1.0 : dx;
  readings.push_back(reading(water, "soaked") / width);
  readings.push_back(reading(water, "water_stored") / width);
  EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * reading(water, "water_stored"));
  return readings;
}

TEST(PoreWaterInSpace, AColumnUnderRainEqualsThatIn2D) {
  const auto plane = infiltration(2), space = infiltration(3);
  for (std::size_t i = 0; i < plane.size(); ++i) EXPECT_NEAR(space[i], plane[i], 1e-6 * std::abs(plane[i]));
}

TEST(PoreWaterInSpace, AtRestStaysAtRest) {
  // In a slab with slopes and disordered points; with and without capillarity.
  for (const bool curve : {false, true}) {
    const Soil soil = curve ? van_genuchten(0.05, 0.4, 2.0, 2.0, 1e-4) : sharp(0.4, 1e-4);
    Case scene = scene_in_space(soil, slab(0.05), 0.05, 1e6);
    scene.fluid.jitter = 0.2;
    scene.fluid.initial_water_table = 0.23;
    scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, -1}), 0.23),
                         head_face(plane({1.2, 0, 0}, {-1, 0, -1}), 0.23)};
    scene.gauges = {gauge("h", "point", {{0.6, 0.1, 0.1}, {0.31, 0.02, 0.2}}, "head"), gauge("water", "balance")};
    PoreWater water(scene);
    const double before = reading(water, "water_stored");
    run_to(water, 1e6);
    for (const char* h : {"h[0]", "h[1]"}) EXPECT_NEAR(reading(water, h), 0.23, 1e-9);
    EXPECT_NEAR(reading(water, "water_stored"), before, 1e-12);
    EXPECT_NEAR(reading(water, "water_in"), 0.0, 1e-12);
  }
}

/// Readings of the dry slab whose reservoir is filled.
std::vector<double> seepage(int dimension) {
  const double dx = 0.04, width = dimension == 2 ? 1.0 : 0.2;
  Case scene;
  std::vector<Point3> places;
  const Series filled{{{0.0, 0.0}, {30.0, 0.3}}};
  if (dimension == 2) {
    Shape section;
    section.kind = Shape::Kind::polygon;
    section.points = {{0.0, 0.0, 0.0}, {1.2, 0.0, 0.0}, {0.8, 0.4, 0.0}, {0.4, 0.4, 0.0}};
    scene = scene_of(sharp(0.4, 1.1e-4), section, dx, 15000.0);
    scene.water_faces = {head_face(line(0.4, 0.4, 0.0, 0.0), 0.0), head_face(line(1.2, 0.0, 0.8, 0.4), 0.0)};
    for (const double x : {0.3, 0.6, 0.9}) places.emplace_back(x, 0.06, 0.0);
  } else {
    scene = scene_in_space(sharp(0.4, 1.1e-4), slab(dx), dx, 15000.0);
    scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, -1}), 0.0), head_face(plane({1.2, 0, 0}, {-1, 0, -1}), 0.0)};
    for (const double x : {0.3, 0.6, 0.9}) places.emplace_back(x, 0.1, 0.06);
  }
  scene.water_faces[0].name = "reservoir";
  scene.water_faces[0].head = filled;
  scene.gauges = {gauge("q", "discharge", {}, "reservoir"), gauge("water", "balance"),
                  gauge("psi", "point", places, "pressure_head")};
  PoreWater water(scene);
  std::vector<double> readings;
  for (const double time : {1000.0, 15000.0}) {
    run_to(water, time);
    readings.push_back(reading(water, "water_stored") / width);
  }
  // While the soil is wetted the discharge of an instant depends by 0.4 % on where the steps end; at last it is steady.
  readings.push_back(reading(water, "q") / width * 1e4);
  for (const char* psi : {"psi[0]", "psi[1]", "psi[2]"}) readings.push_back(reading(water, psi));
  EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * reading(water, "water_in"));
  return readings;
}

TEST(PoreWaterInSpace, ASlabSeepsAsIn2D) {
  const auto plane = seepage(2), space = seepage(3);
  for (std::size_t i = 0; i < plane.size(); ++i) EXPECT_NEAR(space[i], plane[i], 1e-3 * std::abs(plane[i])) << i;
}

/// A dam in a V-shaped valley that does not lie along the lattice: its cells are narrow at their bottoms, where water
/// enters them first. Newton's iteration finds the solutions of long steps all the same, and the flow is that along the
/// lattice.
TEST(PoreWaterInSpace, ADamThatLiesAcrossTheLatticeFillsInFewSteps) {
  std::vector<double> discharge;
  for (const double turn : {0.0, 30.0}) {
    const auto turned = [&](Shape shape) {
      shape.placement = Placement{.turn = turn};
      return shape;
    };
    Shape dam, rock;
    dam.kind = rock.kind = Shape::Kind::polygon;
    dam.points = {{0, 0, 0}, {44, 0, 0}, {24, 10, 0}, {20, 10, 0}};
    dam.along = {1};
    dam.from = -16;
    dam.to = 16;
    rock.points = {{0, 0, 0}, {18, 12, 0}, {18, -1, 0}, {-18, -1, 0}, {-18, 12, 0}};
    rock.along = {0};
    rock.from = -1;
    rock.to = 45;
    Case scene = scene_in_space(sharp(0.3, 1e-5), made(turned(dam), 1.0, {}, {turned(rock)}), 1.0, 1e8);
    const Point3 x(std::cos(turn * pi / 180.0), std::sin(turn * pi / 180.0), 0.0), z = Point3::UnitZ();
    scene.water_faces = {head_face(plane({0, 0, 0}, x - 2.0 * z), 8.0), head_face(plane(44.0 * x, -x - 2.0 * z), 0.0)};
    scene.water_faces[0].name = "reservoir";
    scene.gauges = {gauge("q", "discharge", {}, "reservoir")};
    PoreWater water(scene);
    run_to(water, 1e8);
    EXPECT_LT(water.state().counts.iterations, 1500.0);
    discharge.push_back(reading(water, "q"));
  }
  EXPECT_NEAR(discharge[1], discharge[0], 0.01 * discharge[0]);
}

/// Two runs of the same case are equal to the bit, and so is one that goes on from an archive.
/// Steady flow through a block, 1 m long, 0.4 m wide and high, along x: sections of any inclination pass it, parts of a
/// section pass their share, and each counts along its normal.
TEST(PoreWaterInSpace, SectionsReadTheDischargeThroughThem) {
  const double k = 1e-4, q = k * 0.4 * 0.4;
  Case scene = scene_in_space(sharp(0.3, k), block({0, 0, 0}, {1, 0.4, 0.4}), 0.1, 1e5);
  scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, 0}), 3.0), head_face(plane({1, 0, 0}, {-1, 0, 0}), 2.0)};
  scene.fluid.initial_water_table = 2.0;
  const auto section = [](const char* name, std::vector<Point3> corners) { return gauge(name, "discharge", corners); };
  scene.gauges = {
      section("across", {{0.5, -1, -1}, {0.5, 1, -1}, {0.5, 1, 1}, {0.5, -1, 1}}),
      section("turned", {{0.5, -1, 1}, {0.5, 1, 1}, {0.5, 1, -1}, {0.5, -1, -1}}),
      section("inclined", {{0.1, -1, -0.2}, {0.1, 1, -0.2}, {0.9, 1, 0.6}, {0.9, -1, 0.6}}),
      section("left", {{0.5, -1, -1}, {0.5, 0.1, -1}, {0.5, 0.1, 1}, {0.5, -1, 1}}),
      section("right", {{0.5, 0.1, -1}, {0.5, 1, -1}, {0.5, 1, 1}, {0.5, 0.1, 1}}),
      section("along", {{0, 0, 0.2}, {1, 0, 0.2}, {1, 0.4, 0.2}, {0, 0.4, 0.2}}),
      section("l", {{0.55, -1, -1}, {0.55, 1, -1}, {0.55, 1, 0.1}, {0.55, 0.2, 0.1}, {0.55, 0.2, 1}, {0.55, -1, 1}})};
  PoreWater water(scene);
  run_to(water, 1e5);
  EXPECT_NEAR(reading(water, "across"), q, 1e-6 * q);
  EXPECT_EQ(reading(water, "turned"), -reading(water, "across"));
  EXPECT_NEAR(reading(water, "inclined"), q, 1e-6 * q);
  EXPECT_NEAR(reading(water, "left"), 0.25 * q, 1e-6 * q);
  EXPECT_NEAR(reading(water, "right"), 0.75 * q, 1e-6 * q);
  EXPECT_NEAR(reading(water, "along"), 0.0, 1e-6 * q);
  EXPECT_NEAR(reading(water, "l"), (0.5 + 0.25 * 0.5) * q, 1e-6 * q);
}

TEST(PoreWaterInSpace, ARunThatGoesOnFromItsArchiveIsTheSame) {
  Case scene = scene_in_space(van_genuchten(0.05, 0.4, 2.0, 2.0, 1e-4), block({0, 0, 0}, {0.8, 0.64, 0.4}), 0.08, 1e4);
  scene.water_faces = {head_face(plane({0, 0, 0}, {1, 0, 0}), 0.3)};
  scene.fluid.initial_water_table = 0.0;
  Well well;  // its level is a part of the state
  well.points = {{0.4, 0.32, 0.02}, {0.4, 0.32, 0.3}};
  well.radius = 0.005;
  well.discharge = constant(1e-6);
  scene.wells = {well};
  PoreWater first(scene), second(scene), third(scene);
  run_to(first, 3000.0);
  Archive out;
  first.archive(out);
  run_to(first, 6000.0);
  run_to(second, 3000.0);
  run_to(second, 6000.0);
  Archive in(out.bytes());
  third.archive(in);
  run_to(third, 6000.0);
  EXPECT_EQ(first.state().water, second.state().water);
  EXPECT_EQ(first.state().water, third.state().water);
  EXPECT_EQ(first.state().level, third.state().level);
}

/// Radial flow to a well that is drawn as a hole, between heads at r = 0.8 and 4 m under a sealed roof (Thiem 1906).
TEST(PoreWaterInSpace, FlowsToADrawnWellAsThiem) {
  const double dx = 0.2, k = 1e-4, inner = 0.8, outer = 4.0, high = 0.6;
  const Shape ring = made(cylinder({0, 0, 0}, {0, 0, high}, outer), dx, {}, {cylinder({0, 0, -1}, {0, 0, 1}, inner)});
  Case scene = scene_in_space(sharp(0.3, k), ring, dx, 1e4);
  Shape inside = made(cylinder({0, 0, 1e-3}, {0, 0, high - 1e-3}, 1.2), dx);
  Shape outside = made(block({-5, -5, 1e-3}, {5, 5, high - 1e-3}), dx, {}, {cylinder({0, 0, -1}, {0, 0, 1}, 3.6)});
  scene.water_faces = {head_face(surface_in(inside), 1.0), head_face(surface_in(outside), 2.0)};
  scene.water_faces[0].name = "well";
  scene.fluid.initial_water_table = 2.0;
  scene.gauges = {gauge("q", "discharge", {}, "well"), gauge("h", "point", {{2, 0, 0.3}, {0, -2, 0.3}}, "head")};
  PoreWater water(scene);
  run_to(water, 1e4);
  const double exact = 2.0 * pi * k * high * 1.0 / std::log(outer / inner);
  EXPECT_NEAR(-reading(water, "q"), exact, 0.01 * exact);
  const double at_2 = 1.0 + std::log(2.0 / inner) / std::log(outer / inner);
  for (const char* h : {"h[0]", "h[1]"}) EXPECT_NEAR(reading(water, h), at_2, 0.01);
}

}  // namespace
}  // namespace poretwin::pore::test
