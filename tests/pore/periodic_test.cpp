// Fields between periodic sides: against the same field between impermeable sides, and flow along the period.
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::pore::test {
namespace {

constexpr double dx = 0.05;

Case periodic_along_x(Case scene, double width) {
  scene.general.periodic = {0};
  scene.general.domain_max = {width, 10.0, 0.0};
  return scene;
}

TEST(PeriodicField, UprightFlowIsThatBetweenImpermeableSides) {
  // Rain on a column of one, two and four points across: links with images of itself, of the neighbour twice, of
  // others.
  for (const int across : {1, 2, 4}) {
    const double width = across * dx;
    Case closed = scene_of(gardner(0.06, 0.4, 10.0, 2.78e-6), box(0.0, 0.0, width, 1.0), dx, 7200.0);
    closed.fluid.initial_water_table = 0.0;
    closed.water_faces = {head_face(line(0.0, 0.0, width, 0.0), 0.0)};
    closed.rains = {rain(line(width, 1.0, 0.0, 1.0), constant(2e-6))};
    PoreWater one(closed), other(periodic_along_x(closed, width));
    EXPECT_EQ(other.network().links.size(), one.network().links.size() + 20);
    run_to(one, 7200.0);
    run_to(other, 7200.0);
    double farthest = 0.0;
    for (std::size_t a = 0; a < one.network().size(); ++a)
      farthest = std::max(farthest, std::abs(one.flow().pressure_head(a) - other.flow().pressure_head(a)));
    // With several points across, the linear solves end at other residuals.
    EXPECT_LT(farthest, across == 1 ? 1e-12 : 1e-4) << across;
  }
}

TEST(PeriodicField, WaterFlowsEvenlyDownAnEndlessSlope) {
  // Gravity inclined by 20 degrees: psi = (H - y) cos(20), q = K sin(20) everywhere.
  const double H = 0.5, width = 0.4, angle = M_PI / 9.0, k = 1e-4;
  for (const bool curve : {false, true}) {
    Case scene = periodic_along_x(
        scene_of(curve ? van_genuchten(0.05, 0.4, 3.5, 2.8, k) : sharp(0.4, k), box(0.0, 0.0, width, H), dx, 1e4),
        width);
    scene.general.gravity = 9.81 * Point3(std::sin(angle), -std::cos(angle), 0.0);
    scene.fluid.regions = {box(0.0, 0.0, width, H)};
    if (curve) scene.fluid.initial_pressure_head = constant(0.0);
    scene.water_faces = {pressure_face(line(width, H, 0.0, H), 0.0)};
    // A section in the middle, and one on the side itself.
    scene.gauges = {gauge("middle", "discharge", line(0.21, H, 0.21, 0.0).points),
                    gauge("side", "discharge", line(0.0, H, 0.0, 0.0).points),
                    gauge("psi", "point", up(0.5 * dx, {0.5 * dx, 0.225}), "pressure_head"), gauge("water", "balance")};
    PoreWater water(scene);
    run_to(water, 1e4);
    // Without capillarity the surface of cells that lie across gravity is level in each of them.
    const double q = k * std::sin(angle) * H, error = curve ? 1e-6 : 2e-3, head_error = curve ? 1e-6 : 0.1 * dx;
    EXPECT_NEAR(reading(water, "middle"), q, error * q) << curve;
    EXPECT_NEAR(reading(water, "side"), q, error * q) << curve;
    EXPECT_NEAR(reading(water, "psi[0]"), (H - 0.5 * dx) * std::cos(angle), head_error) << curve;
    EXPECT_NEAR(reading(water, "psi[1]"), (H - 0.225) * std::cos(angle), head_error) << curve;
    // The flux at each point is that of the slope, also in the cells at the sides.
    const OutputFrame frame = water.frame();
    const auto flux = std::ranges::find(frame.fields, "relative_flux", &OutputField::name);
    ASSERT_NE(flux, frame.fields.end());
    for (std::size_t a = 0; a < frame.count; ++a) {
      double along[3];
      flux->write(a, along);
      EXPECT_NEAR(along[0], k * std::sin(angle), (curve ? 1e-6 : 1e-2) * k);
    }
  }
}

TEST(PeriodicField, WaterFlowsEvenlyDownAnEndlessSlopeInSpace) {
  const double H = 0.4, width = 0.2, angle = M_PI / 9.0, k = 1e-4;
  Shape shape;
  shape.max = {width, 0.15, H};
  Case scene = scene_of(sharp(0.4, k), shape, dx, 1e4);
  scene.general.dimension = 3;
  scene.general.periodic = {0, 1};
  scene.general.domain_max = {width, 0.15, 1.0};
  scene.general.gravity = 9.81 * Point3(std::sin(angle), 0.0, -std::cos(angle));
  scene.fluid.regions = {shape};
  WaterFace top;
  top.face.point = {0.0, 0.0, H};
  top.face.normal = {0.0, 0.0, -1.0};
  top.pressure = constant(0.0);
  scene.water_faces = {top};
  scene.gauges = {gauge("q", "discharge", {{0.1, 0, 0}, {0.1, 0.15, 0}, {0.1, 0.15, H}, {0.1, 0, H}})};
  PoreWater water(scene);
  run_to(water, 1e4);
  const double q = k * std::sin(angle) * H * 0.15;
  EXPECT_NEAR(std::abs(reading(water, "q")), q, 2e-3 * q);
  for (std::size_t a = 0; a < water.network().size(); ++a)
    EXPECT_NEAR(water.flow().pressure_head(a), (H - water.network().position[a].z()) * std::cos(angle), 0.1 * dx);
}

TEST(PeriodicField, AWavySurfaceRepeatsItself) {
  // The same layer with its period begun elsewhere: shifted by half a period, all readings are the same.
  double q[2], psi[2];
  for (const bool shifted : {false, true}) {
    const double s = shifted ? 0.4 : 0.0;
    Shape layer;
    layer.kind = Shape::Kind::polygon;
    layer.points = shifted ? std::vector<Point3>{{0, 0, 0}, {0.8, 0, 0}, {0.8, 0.6, 0}, {0.4, 0.4, 0}, {0, 0.6, 0}}
                           : std::vector<Point3>{{0, 0, 0}, {0.8, 0, 0}, {0.8, 0.4, 0}, {0.4, 0.6, 0}, {0, 0.4, 0}};
    Case scene = periodic_along_x(scene_of(sharp(0.4, 1e-4), layer, dx, 1e4), 0.8);
    scene.general.gravity = {2.0, -9.0, 0.0};
    scene.fluid.regions = {layer};
    WaterFace top = pressure_face({}, 0.0);
    top.face.points = {layer.points[2], layer.points[3], layer.points[4]};
    scene.water_faces = {top};
    scene.gauges = {gauge("q", "discharge", line(0.2 + s, 1.0, 0.2 + s, 0.0).points),
                    gauge("psi", "point", up(0.225 + s, {0.225}), "pressure_head")};
    PoreWater water(scene);
    run_to(water, 1e4);
    q[shifted] = reading(water, "q");
    psi[shifted] = reading(water, "psi");
  }
  EXPECT_GT(q[0], 0.0);
  EXPECT_NEAR(q[1], q[0], 1e-6 * q[0]);
  EXPECT_NEAR(psi[1], psi[0], 1e-6);
}

}  // namespace
}  // namespace poretwin::pore::test
