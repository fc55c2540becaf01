// Water as particles in rigid soil in beds, which conducts better along the beds than across them.
#include "tests/beds.hpp"
#include "fluid_solver/discretisation/bedded_cells.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace poretwin::fluid {
namespace {

using namespace test;
using poretwin::test::PoissonsEquation, poretwin::test::bedded_tensor, poretwin::test::turned;

constexpr double along = 1e-4, ratio = 10.0;  // m/s, 1

/// A line between two points of a plane that is turned by an angle [degrees].
Face turned_line(double x0, double y0, double x1, double y1, double angle) {
  Face face;
  face.points = {turned(x0, y0, angle), turned(x1, y1, angle)};
  return face;
}

/// Soil whose beds rise at an angle [degrees].
Soil bedded(double angle, double times = ratio) {
  Soil soil = sand();
  soil.hydraulic_conductivity = along;
  soil.anisotropy = times;
  soil.bedding_normal = turned(0.0, 2.0, angle);  // its length does not matter
  return soil;
}

/// A box of 1 x 0.5 m, turned by `angle`, between walls along its sides and heads of 3 m at its left end, 2 m at its
/// right one.
Case turned_box(double angle, double beds, double jitter) {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = 0.05;
  scene.fluid.jitter = jitter;
  scene.fluid.seed = 3;
  scene.soils = {bedded(beds)};
  Shape& shape = scene.soils[0].shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = {turned(0.0, 0.0, angle), turned(1.0, 0.0, angle), turned(1.0, 0.5, angle), turned(0.0, 0.5, angle)};
  scene.fluid.regions = {shape};
  scene.walls = {wall(turned_line(0.0, 0.0, 1.0, 0.0, angle)), wall(turned_line(1.0, 0.5, 0.0, 0.5, angle))};
  scene.water_faces = {head_face(turned_line(0.0, 0.5, 0.0, 0.0, angle), 3.0),
                       head_face(turned_line(1.0, 0.0, 1.0, 0.5, angle), 2.0)};
  scene.gauges = {gauge("q", "discharge", {turned(0.5, 0.5, angle), turned(0.5, 0.0, angle)})};
  return scene;
}

/// Particles in a unit square, `rows` a side, displaced by up to `jitter` spacings, without walls.
VecArray<2> square(int rows, double jitter) {
  VecArray<2> x;
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> noise(-jitter, jitter);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < rows; ++i) x.push_back(Vec<2>(i + 0.5 + noise(generator), j + 0.5 + noise(generator)) / rows);
  return x;
}

/// The cells of particles in a unit square without walls.
struct Cells {
  Cells(int rows, double jitter, const Mat<2>& K)
      : x(square(rows, jitter)),
        volume(x.size(), 1.0 / (rows * rows)),
        stencil(make_stencil<2>(x, volume, std::span<const Buffer<2>>(), {})),
        cells(
            stencil, {}, K, [](std::size_t) { return true; }, [](std::size_t) { return 0.0; }) {}
  VecArray<2> x;
  ScalarArray volume;
  Stencil<2> stencil;
  BeddedCells<2> cells;
};

TEST(BeddedSoil, CellsPassUniformFlowUnchanged) {
  constexpr int rows = 40;
  for (const double times : {0.01, 0.1, 3.0, 10.0, 30.0, 100.0})
    for (const double angle : {0.0, 17.0, 30.0, 45.0, 90.0})
      for (const double jitter : {0.0, 0.2}) {
        const Mat<2> K = bedded_tensor(angle, times);
        const Cells made(rows, jitter, K);
        const auto& x = made.x;
        for (const double direction : {0.0, 90.0}) {
          const Vec<2> g = turned(1.0, 0.0, angle + direction).head<2>(), flux = -K * g;
          for (std::size_t a = 0; a < x.size(); ++a) {
            if ((x[a] - Vec<2>(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.2) continue;
            double out = 0.0;
            Vec<2> sum = Vec<2>::Zero();
            for (const auto& side : made.cells.sides(a)) {
              const double difference = g.dot(x[a] - x[side.other]);
              out += side.shared * difference;
              sum += side.conductance * difference * side.middle;
            }
            EXPECT_NEAR(out * rows, 0.0, 1e-11 * flux.norm()) << times << " " << angle << " " << jitter;
            EXPECT_LT((made.cells.flux(a, sum) - flux).norm(), 1e-11 * flux.norm()) << times << " " << angle;
          }
        }
      }
}

/// Error of Poisson's equation on cells of `rows` particles a side, with beds that rise at 30 degrees.
double poisson_error(int rows, double jitter) {
  const Mat<2> K = bedded_tensor(30.0, ratio);
  const Cells made(rows, jitter, K);
  const PoissonsEquation equation{K, 0.2, made.x, made.volume};
  std::vector<PoissonsEquation::Link> links;
  for (std::size_t a = 0; a < made.x.size(); ++a) {
    if (equation.on_rim(a)) continue;
    for (const auto& side : made.cells.sides(a)) {
      EXPECT_GE(side.shared, 0.0);
      links.push_back({a, side.other, side.shared});
    }
  }
  return equation.error(links);
}

TEST(BeddedSoil, CellsSolvePoissonsEquationAtSecondOrder) {
  for (const double jitter : {0.0, 0.2}) {
    const double coarse = poisson_error(20, jitter), fine = poisson_error(80, jitter);
    EXPECT_LT(coarse, 3e-3) << jitter;
    EXPECT_GT(0.5 * std::log2(coarse / fine), 1.5) << jitter << ": " << coarse << " " << fine;
  }
}

TEST(BeddedSoil, UniformFlowAlongAndAcrossInclinedBedsIsExact) {
  for (const double angle : {0.0, 17.0, 30.0, 90.0})
    for (const double beds : {0.0, 90.0})
      for (const double jitter : {0.0, 0.2}) {
        Fluid<2> fluid(turned_box(angle, angle + beds, jitter));
        fluid.initialise({});
        fluid.advance({0, 0.0, 0.1}, {});
        const double exact = beds == 0.0 ? along : along / ratio;
        EXPECT_NEAR(reading(fluid, "q"), 0.5 * exact, 1e-6 * exact) << angle << " " << beds << " " << jitter;
        const Vec<2> velocity = exact / 0.4 * turned(1.0, 0.0, angle).head<2>();
        for (const auto& v : fluid.state().particles.velocity)
          EXPECT_LT((v - velocity).norm(), 1e-5 * velocity.norm()) << angle << " " << beds << " " << jitter;
      }
}

/// Until the water has crossed the box, whose particles are then all others.
TEST(BeddedSoil, UniformFlowStaysSoWhileTheWaterPasses) {
  for (const double angle : {0.0, 17.0, 30.0, 90.0})
    for (const double beds : {0.0, 90.0}) {
      Fluid<2> fluid(turned_box(angle, angle + beds, 0.0));
      fluid.initialise({});
      const double exact = beds == 0.0 ? along : along / ratio;
      double time = 0.0, worst = 0.0;
      while (time < 0.4 / exact) {
        run_to(fluid, time, time + 0.02 / exact);
        worst = std::max(worst, std::abs(reading(fluid, "q") / (0.5 * exact) - 1.0));
      }
      EXPECT_LT(worst, 2e-3) << angle << " " << beds;
      EXPECT_EQ(fluid.state().counts.lost, 0.0);
    }
}

/// A long box between walls, with beds that rise at an angle. Far from its ends the water flows along it, although the
/// gradient of the head is oblique: the discharge is that of K_xx - K_xy^2 / K_yy, and the head falls across the box by
/// K_xy / K_yy times its fall along it.
TEST(BeddedSoil, BetweenWallsWaterFlowsAlongThemWhereBedsAreOblique) {
  for (const double beds : {17.0, 30.0, 120.0})
    for (const double jitter : {0.0, 0.2}) {
      Case scene = turned_box(0.0, beds, jitter);
      constexpr double length = 8.0;
      scene.soils[0].shape = scene.fluid.regions[0] = box(0.0, 0.0, length, 0.5);
      scene.walls = {wall(line(0.0, 0.0, length, 0.0)), wall(line(length, 0.5, 0.0, 0.5))};
      scene.water_faces = {head_face(line(0.0, 0.5, 0.0, 0.0), 3.0), head_face(line(length, 0.0, length, 0.5), 2.0)};
      scene.gauges = {gauge("q", "discharge", {Point3(4.0, 0.5, 0.0), Point3(4.0, 0.0, 0.0)}),
                      gauge("left", "point", {Point3(3.5, 0.0, 0.0)}, "head"),
                      gauge("right", "point", {Point3(4.5, 0.0, 0.0)}, "head"),
                      gauge("low", "point", {Point3(4.0, 0.0, 0.0)}, "head"),
                      gauge("high", "point", {Point3(4.0, 0.5, 0.0)}, "head")};
      Fluid<2> fluid(scene);
      fluid.initialise({});
      fluid.advance({0, 0.0, 0.1}, {});
      const Mat<2> K = along * bedded_tensor(beds, ratio);
      const double fall = reading(fluid, "left") - reading(fluid, "right");
      EXPECT_NEAR(reading(fluid, "q"), 0.5 * fall * (K(0, 0) - K(0, 1) * K(0, 1) / K(1, 1)), 2e-3 * along * fall);
      EXPECT_NEAR(reading(fluid, "low") - reading(fluid, "high"), -0.5 * fall * K(0, 1) / K(1, 1), 2e-3 * fall);
      for (std::size_t a = 0; a < fluid.state().particles.size(); ++a) {
        const auto& v = fluid.state().particles.velocity[a];
        if (std::abs(fluid.state().particles.position[a].x() - 4.0) > 0.3) continue;
        EXPECT_LT(std::abs(v.y()), 2e-3 * v.x());
      }
    }
}

/// Discharge past a sheet pile of depth s in a layer of depth T with level beds: k H K(m') / (2 K(m)), m = sin(pi s /
/// (2 T)), m' = sqrt(1 - m^2), k = sqrt(k_h k_v) (Pavlovsky 1922, in coordinates in which the soil is isotropic).
TEST(BeddedSoil, SeepagePastASheetPileFollowsPavlovskyInStretchedCoordinates) {
  constexpr double depth = 1.0, pile = 0.5, far = 8.0;
  const double m = std::sin(0.5 * M_PI * pile / depth);
  const double exact =
      along / std::sqrt(ratio) * std::comp_ellint_1(std::sqrt(1.0 - m * m)) / (2.0 * std::comp_ellint_1(m));
  const auto error = [&](double spacing) {
    Case scene = turned_box(0.0, 0.0, 0.0);
    scene.fluid.particle_spacing = spacing;
    scene.soils[0].shape = scene.fluid.regions[0] = box(-far, 0.0, far, depth);
    scene.walls = {wall(line(-far, 0.0, far, 0.0)), wall(line(far, 0.0, far, depth)),
                   wall(line(-far, depth, -far, 0.0)), wall(line(0.0, depth, 0.0, depth - pile))};
    scene.water_faces = {head_face(line(0.0, depth, -far, depth), 2.0), head_face(line(far, depth, 0.0, depth), 1.0)};
    scene.gauges = {gauge("q", "discharge", {Point3(0.0, depth - pile, 0.0), Point3(0.0, 0.0, 0.0)})};
    Fluid<2> fluid(scene);
    fluid.initialise({});
    fluid.advance({0, 0.0, 0.1}, {});
    return reading(fluid, "q") / exact - 1.0;
  };
  const double coarse = error(0.05), fine = error(0.025);
  EXPECT_NEAR(coarse, 0.0, 0.05);  // 10 spacings along the pile
  EXPECT_NEAR(fine, 0.0, 0.025);
}

/// Water enters dry soil from above as into soil without beds of the conductivity in that direction.
TEST(BeddedSoil, AFrontAcrossLevelBedsIsThatOfSoilWithTheirConductivity) {
  const auto depth_after = [](double beds, double conductivity, bool plain) {
    Case scene = ponded_column(0.02);
    scene.soils[0] = plain ? sand() : bedded(beds);
    scene.soils[0].shape = box(0.0, 0.0, 0.1, 0.4);
    scene.soils[0].hydraulic_conductivity = conductivity;
    scene.soils[0].suction_head = 0.05;
    Fluid<2> fluid(scene);
    fluid.initialise({});
    double time = 0.0;
    run_to(fluid, time, 0.12 / (plain ? conductivity : conductivity / (beds == 0.0 ? ratio : 1.0)) * 0.4);
    return std::pair(reading(fluid, "front"), reading(fluid, "volume"));
  };
  const auto plain = depth_after(0.0, 1e-5, true), level = depth_after(0.0, 1e-4, false),
             upright = depth_after(90.0, 1e-5, false);
  EXPECT_NEAR(level.second, plain.second, 0.01 * plain.second);
  EXPECT_NEAR(upright.second, plain.second, 0.01 * plain.second);
  EXPECT_NEAR(level.first, plain.first, 0.1 * 0.02);
  EXPECT_NEAR(upright.first, plain.first, 0.1 * 0.02);
}

/// Layers with the same beds and another conductivity: in series across the flow, side by side along it.
TEST(BeddedSoil, LayersWithTheSameBedsConductAsTheyShould) {
  for (const bool series : {true, false}) {
    Case scene = turned_box(0.0, 0.0, 0.0);
    scene.soils.push_back(scene.soils[0]);
    scene.soils[0].shape = series ? box(0.0, 0.0, 0.5, 0.5) : box(0.0, 0.0, 1.0, 0.25);
    scene.soils[1].shape = series ? box(0.5, 0.0, 1.0, 0.5) : box(0.0, 0.25, 1.0, 0.5);
    scene.soils[1].hydraulic_conductivity = 0.2 * along;
    Fluid<2> fluid(scene);
    fluid.initialise({});
    fluid.advance({0, 0.0, 0.1}, {});
    const double exact = 0.5 * along * (series ? 2.0 / (1.0 + 5.0) : 0.5 * (1.0 + 0.2));
    EXPECT_NEAR(reading(fluid, "q"), exact, 1e-4 * exact) << series;
  }
}

}  // namespace
}  // namespace poretwin::fluid
