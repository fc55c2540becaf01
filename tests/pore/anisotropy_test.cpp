// Soil that conducts better along its beds than across them.
#include "common/geometry/shapes.hpp"
#include "common/geometry/solid.hpp"
#include "pore_solver/network.hpp"
#include "tests/beds.hpp"
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::pore::test {
namespace {

using poretwin::test::turned;

constexpr double along = 1e-4, ratio = 10.0;  // m/s, 1

Soil bedded(const Point3& normal = Point3::Zero()) {
  Soil soil = sharp(0.4, along);
  soil.anisotropy = ratio;
  soil.bedding_normal = normal;
  return soil;
}

/// A point of the plane of x and y in space, where this plane is that of x and z.
Point3 in_space(const Point3& x) { return {x.x(), 0.0, x.y()}; }

/// Discharge per area through a rectangle of 1 x 0.5 m, turned by `angle`, from its left end to its right one, between
/// heads of 3 and 2 m; its beds rise at the angle `beds`. In space it is 0.4 m thick.
double through_turned(double angle, double beds, int dimension, double jitter) {
  const double dx = 0.05, thick = 0.4;
  Shape shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = {turned(0.0, 0.0, angle), turned(1.0, 0.0, angle), turned(1.0, 0.5, angle), turned(0.0, 0.5, angle)};
  const Point3 normal = turned(0.0, 2.0, beds);  // its length does not matter
  if (dimension == 3) {
    shape.along = {1};
    shape.to = thick;
    shape.solid = std::make_shared<const Solid>(
        std::vector<Solid::Part>{{TriangleMesh(surface_of(shape, dx, {})), false}}, 0.1 * dx);
  }
  Case scene = scene_of(bedded(dimension == 3 ? in_space(normal) : normal), shape, dx, 1e3);
  scene.fluid.jitter = jitter;
  scene.fluid.seed = 3;
  scene.fluid.initial_water_table = 2.0;
  Face left, right;
  if (dimension == 3) {
    scene.general.dimension = 3;
    scene.general.gravity = {0.0, 0.0, -9.81};
    left.point = Point3::Zero();
    left.normal = in_space(turned(1.0, 0.0, angle));
    right.point = in_space(turned(1.0, 0.0, angle));
    right.normal = -left.normal;
  } else {
    left.points = {turned(0.0, 0.5, angle), turned(0.0, 0.0, angle)};
    right.points = {turned(1.0, 0.0, angle), turned(1.0, 0.5, angle)};
  }
  scene.water_faces = {head_face(left, 3.0), head_face(right, 2.0)};
  scene.water_faces[1].name = "right";
  scene.gauges = {gauge("q", "discharge", {}, "right")};
  PoreWater water(scene);
  run_to(water, scene.general.end_time);
  return -reading(water, "q") / (dimension == 3 ? 0.5 * thick : 0.5);
}

TEST(Anisotropy, FlowAlongAndAcrossLevelBedsIsExact) {
  for (const int dimension : {2, 3}) {
    EXPECT_NEAR(through_turned(0.0, 0.0, dimension, 0.0), along, 1e-7 * along) << dimension;
    EXPECT_NEAR(through_turned(90.0, 0.0, dimension, 0.0), along / ratio, 1e-7 * along) << dimension;
  }
}

TEST(Anisotropy, FlowAlongAndAcrossInclinedBedsIsExactOnDisorderedPoints) {
  for (const int dimension : {2, 3})
    for (const double jitter : {0.0, 0.2}) {
      EXPECT_NEAR(through_turned(30.0, 30.0, dimension, jitter), along, 1e-6 * along) << dimension << " " << jitter;
      EXPECT_NEAR(through_turned(30.0, 120.0, dimension, jitter), along / ratio, 1e-6 * along)
          << dimension << " " << jitter;
    }
}

/// Error of Poisson's equation on a network of `rows` points a side, with beds that rise at 30 degrees.
double poisson_error(int rows, double jitter) {
  Case scene = scene_of(bedded(turned(0.0, 1.0, 30.0)), box(0.0, 0.0, 1.0, 1.0), 1.0 / rows, 1.0);
  scene.fluid.jitter = jitter;
  const Network net = make_network(scene);
  poretwin::test::PoissonsEquation equation{poretwin::test::bedded_tensor(30.0, ratio), 0.15, {}, net.volume};
  for (const Point3& x : net.position) equation.x.emplace_back(x.head<2>());
  std::vector<poretwin::test::PoissonsEquation::Link> links;
  for (const auto& link : net.links) {
    EXPECT_GT(link.transmissibility, 0.0);
    EXPECT_EQ(link.of_a, link.of_b);
    const double t = link.of_a * link.transmissibility;
    links.push_back({link.a, link.b, t});
    links.push_back({link.b, link.a, t});
  }
  return equation.error(links);
}

TEST(Anisotropy, PoissonsEquationConvergesAtSecondOrderOnJitteredPoints) {
  for (const double jitter : {0.0, 0.25}) {
    const double coarse = poisson_error(20, jitter), fine = poisson_error(40, jitter);
    EXPECT_LT(coarse, 4e-3) << jitter;
    EXPECT_GT(std::log2(coarse / fine), 1.7) << jitter << ": " << coarse << " " << fine;
  }
}

/// Discharge under a dam with a flat, impermeable base of width 2 b on a layer of depth T between heads: with the head
/// difference H it is k H K(m') / (2 K(m)), m = tanh(pi b / (2 T)), m' = sqrt(1 - m^2) (Pavlovsky 1922). In beds
/// lengths along them are divided by sqrt(k_h / k_v), and k is sqrt(k_h k_v). Half of the layer is computed; under the
/// middle of the dam the head is the mean of both.
TEST(Anisotropy, SeepageUnderADamFollowsPavlovskyInStretchedCoordinates) {
  const double dx = 0.05, b = 2.0, depth = 2.0, stretch = std::sqrt(ratio), far = b + 2.5 * depth * stretch;
  Case scene = scene_of(bedded(), box(0.0, 0.0, far, depth), dx, 1e5);
  scene.fluid.initial_water_table = 3.0;
  scene.water_faces = {head_face(line(0.0, depth, 0.0, 0.0), 3.5), head_face(line(far, depth, b, depth), 3.0)};
  scene.water_faces[1].name = "bed";
  scene.gauges = {gauge("q", "discharge", {}, "bed")};
  PoreWater water(scene);
  run_to(water, scene.general.end_time);
  const double m = std::tanh(M_PI * b / stretch / (2.0 * depth));
  const double exact = along / stretch * std::comp_ellint_1(std::sqrt(1.0 - m * m)) / (2.0 * std::comp_ellint_1(m));
  EXPECT_NEAR(-reading(water, "q"), exact, 0.01 * exact);
}

/// Beds over soil without beds: across them the layers are in series, along them they are parallel.
TEST(Anisotropy, LayersWithAndWithoutBedsConductAsTheyShould) {
  for (const bool capillary : {false, true})
    for (const bool upwards : {false, true}) {
      const double dx = 0.05;
      const Soil plain = capillary ? gardner(0.0, 0.4, 2.0, 2e-5) : sharp(0.4, 2e-5);
      Case scene = scene_of(plain, box(0.0, 0.0, 0.5, 0.5), dx, 1e3);
      scene.soils.push_back(plain);
      scene.soils[1].shape = box(0.0, 0.5, 0.5, 1.0);
      scene.soils[1].hydraulic_conductivity = along;
      scene.soils[1].anisotropy = ratio;
      scene.fluid.initial_water_table = 2.0;
      scene.water_faces = {head_face(upwards ? line(0.0, 0.0, 0.5, 0.0) : line(0.0, 1.0, 0.0, 0.0), 3.0),
                           head_face(upwards ? line(0.5, 1.0, 0.0, 1.0) : line(0.5, 0.0, 0.5, 1.0), 2.0)};
      scene.water_faces[1].name = "out";
      scene.gauges = {gauge("q", "discharge", {}, "out")};
      PoreWater water(scene);
      run_to(water, scene.general.end_time);
      const double series = 0.5 / (0.5 / 2e-5 + 0.5 / (along / ratio)), parallel = (0.5 * 2e-5 + 0.5 * along) / 0.5;
      EXPECT_NEAR(-reading(water, "q"), upwards ? series : parallel, 1e-6 * parallel) << capillary << upwards;
    }
}

/// Water at rest under suction stays at rest in inclined beds.
TEST(Anisotropy, WaterAtRestUnderSuctionStaysAtRest) {
  Soil soil = van_genuchten(0.05, 0.4, 2.0, 2.0, along);
  soil.anisotropy = ratio;
  soil.bedding_normal = turned(0.0, 1.0, 20.0);
  Case scene = scene_of(soil, box(0.0, 0.0, 1.0, 1.0), 0.1, 1e5);
  scene.fluid.initial_water_table = -1.0;
  PoreWater water(scene);
  const auto before = water.state().water;
  run_to(water, 1e5);
  for (std::size_t a = 0; a < before.size(); ++a) EXPECT_NEAR(water.state().water[a], before[a], 1e-12 * before[a]);
}

}  // namespace
}  // namespace poretwin::pore::test
