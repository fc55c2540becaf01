// Moving soil beside walls of any shape (3D): in turned boxes as between planes; in cylinders.
#include "common/case/bodies.hpp"
#include "common/geometry/solid.hpp"
#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/statics/initial_state.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace poretwin::solid::test {
namespace {

constexpr double g = 9.81, dx = 0.05, degrees = std::numbers::pi / 180.0;

/// How the walls of a box are drawn: as one shape, as planes, or as planes along the axes with gravity turned instead.
enum class Drawn { shape, planes, aligned };

struct BoxSpec {
  Point3 corner = Point3::Zero();       ///< m, lower corner of the soil
  Point3 soil = Point3(0.4, 0.4, 0.4);  ///< m, extent of the soil from the box's corner at the origin
  Point3 room = Point3(0.4, 0.4, 0.8);  ///< m, extent of the box
  Placement placement{1.0, 25.0, Point3(1.0, 2.0, 0.5), Point3(0.3, -0.2, 0.1)};
  Wall::ForSoil kind = Wall::ForSoil::roller;
  double friction_angle = 0.0;
};

Mat<3> turn_of(const BoxSpec& spec) {
  return Eigen::AngleAxisd(spec.placement.turn * degrees, spec.placement.axis.normalized()).toRotationMatrix();
}

Case box(const BoxSpec& spec, Drawn drawn) {
  Case scene = column({.dimension = 3, .spacing = dx, .base = Wall::ForSoil::none, .sides = false});
  scene.soils[0].shape.min = spec.corner;
  scene.soils[0].shape.max = spec.corner + spec.soil;
  scene.general.gravity = Point3(0.0, 0.0, -g);
  const bool turned = drawn != Drawn::aligned;
  if (turned)
    scene.soils[0].shape.placement = spec.placement;
  else
    scene.general.gravity = turn_of(spec).transpose() * scene.general.gravity;
  Wall wall;
  wall.soil = spec.kind;
  wall.friction_angle = spec.friction_angle;
  if (drawn == Drawn::shape) {
    wall.shape = Shape{};
    wall.shape->max = spec.room;
    wall.shape->placement = spec.placement;
    scene.walls.push_back(wall);
  } else {
    for (int d = 0; d < 3; ++d)
      for (const double side : {1.0, -1.0}) {
        const Point3 at = side > 0.0 ? Point3(Point3::Zero()) : spec.room, inward = side * Point3::Unit(d);
        wall.face = turned ? plane(placed(spec.placement, at, 3), turn_of(spec) * inward) : plane(at, inward);
        scene.walls.push_back(wall);
      }
  }
  make_solids(scene, {});
  return scene;
}

/// Soil at time zero, before it comes to rest.
std::pair<Setup<3>, State<3>> laid(const Case& scene) {
  auto [setup, particles] = set_up<3>(scene);
  State<3> state = laid_out(setup, std::move(particles));
  return {std::move(setup), std::move(state)};
}

/// Coordinates along the box's sides of a point, and of a vector.
Vec<3> in_box(const BoxSpec& spec, Drawn drawn, const Vec<3>& x) {
  return drawn == Drawn::aligned ? x : Vec<3>(turn_of(spec).transpose() * (x - spec.placement.move));
}
Vec<3> along_box(const BoxSpec& spec, Drawn drawn, const Vec<3>& v) {
  return drawn == Drawn::aligned ? v : Vec<3>(turn_of(spec).transpose() * v);
}

// In a closed box with rollers, normal stresses that fall linearly along the sides balance any weight exactly.
TEST(SoilInShapedWalls, BearsALinearStressInATurnedBox) {
  BoxSpec spec;
  spec.room = spec.soil;
  for (const Drawn drawn : {Drawn::shape, Drawn::planes}) {
    auto [setup, state] = laid(box(spec, drawn));
    const Mat<3> turn = turn_of(spec);
    const Vec<3> gravity = along_box(spec, drawn, setup.gravity);
    auto& p = state.particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double density = p.mass[i] / p.volume[i];
      const Vec<3> x = in_box(spec, drawn, p.position[i]);
      Vec<3> along;
      for (int d = 0; d < 3; ++d) along[d] = -density * (gravity[d] * x[d] + (3.0 + d) * g);
      set_matrix<3>(turn * along.asDiagonal() * turn.transpose(), p.stress[i]);
      state.body[i] = density * setup.gravity;
    }
    evaluate_forces(setup, state);
    for (std::size_t i = 0; i < p.size(); ++i)
      EXPECT_LT((state.force[i].internal() + state.body[i]).norm(), 1e-9 * state.body[i].norm()) << "particle " << i;
  }
}

/// Displacements along the box's sides after some steps from a state of pressure, by the place at first.
std::map<std::array<long, 3>, Vec<3>> moved(const BoxSpec& spec, Drawn drawn, int steps) {
  Case scene = box(spec, drawn);
  scene.solid.initial_rest = false;
  auto [setup, state] = laid(scene);
  auto& p = state.particles;
  const VecArray<3> first = p.position;
  for (auto& stress : p.stress) set_matrix<3>(-1e4 * Mat<3>::Identity(), stress);
  evaluate_forces(setup, state);
  const Drive<3> drive;
  for (int k = 0; k < steps; ++k) substep(setup, setup.longest_substep, drive, state);
  std::map<std::array<long, 3>, Vec<3>> result;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec<3> x = in_box(spec, drawn, first[i]) / (0.1 * dx);
    result[{std::lround(x[0]), std::lround(x[1]), std::lround(x[2])}] = along_box(spec, drawn, p.displacement[i]);
  }
  return result;
}

TEST(SoilInShapedWalls, MovesInATurnedBoxAsBetweenPlanes) {
  for (const auto kind : {Wall::ForSoil::roller, Wall::ForSoil::fixed}) {
    BoxSpec spec;
    spec.kind = kind;
    const auto shape = moved(spec, Drawn::shape, 200), planes = moved(spec, Drawn::planes, 200),
               aligned = moved(spec, Drawn::aligned, 200);
    double farthest = 0.0;
    for (const auto& [place, way] : planes) farthest = std::max(farthest, way.norm());
    EXPECT_GT(farthest, 1e-4);
    for (const auto& [place, way] : planes) {
      EXPECT_LT((shape.at(place) - way).norm(), 1e-9 * farthest);
      EXPECT_LT((aligned.at(place) - way).norm(), 1e-9 * farthest);
    }
  }
}

Vec<3> mean_velocity(const Particles<3>& p) {
  Vec<3> mean = Vec<3>::Zero();
  for (const auto& v : p.velocity) mean += v / static_cast<double>(p.size());
  return mean;
}

TEST(SoilInShapedWalls, SlidesOnAFloorAsABlockDoes) {
  constexpr double slope = 30.0 * degrees, friction_angle = 20.0;
  for (const bool smooth : {true, false}) {
    BoxSpec spec;
    spec.room = Point3::Constant(4.0);
    spec.corner = Point3(1.0, 1.0, 0.0);
    spec.soil = Point3(0.6, 0.4, 0.2);
    spec.placement = {1.0, slope / degrees, Point3::UnitY(), Point3(0.3, -0.2, 0.1)};
    spec.kind = smooth ? Wall::ForSoil::roller : Wall::ForSoil::frictional;
    spec.friction_angle = smooth ? 0.0 : friction_angle;
    Case scene = box(spec, Drawn::shape);
    scene.solid.initial_rest = false;
    // Elastic blocks that slide with friction begin to rattle (docs/theory/walls.md).
    scene.solid.model = SolidCase::Model::drucker_prager;
    scene.soils[0].friction_angle = 31.0;
    scene.soils[0].cohesion = 1e3;
    auto [setup, state] = laid(scene);
    const Drive<3> drive;
    const auto speed_after = [&, &setup = setup, &state = state](int steps) {
      for (int k = 0; k < steps; ++k) substep(setup, setup.longest_substep, drive, state);
      return along_box(spec, Drawn::shape, mean_velocity(state.particles)).x();
    };
    const double before = speed_after(300), after = speed_after(400);
    const double exact = g * (std::sin(slope) - (smooth ? 0.0 : std::cos(slope) * std::tan(friction_angle * degrees)));
    EXPECT_NEAR((after - before) / (400 * setup.longest_substep), exact, smooth ? 1e-6 * g : 0.02 * exact);
  }
}

/// A lying cylinder with closed ends, full of soil or half full.
constexpr double radius = 0.3;
Case pipe(bool half, Wall::ForSoil kind) {
  Case scene = column({.dimension = 3, .spacing = dx, .base = Wall::ForSoil::none, .sides = false});
  Shape shape;
  shape.kind = Shape::Kind::cylinder;
  shape.ends = {Point3(-0.4, 0.0, 0.0), Point3(0.4, 0.0, 0.0)};
  shape.radius = radius;
  Wall wall;
  wall.shape = shape;
  wall.soil = kind;
  scene.walls = {wall};
  if (half) {
    Shape lower;
    lower.min = Point3::Constant(-1.0);
    lower.max = Point3(1.0, 1.0, 0.0);
    shape.within = {lower};
  }
  scene.soils[0].shape = shape;
  scene.general.gravity = Point3(0.0, 0.0, -g);
  make_solids(scene, {});
  return scene;
}

Vec<3> turning(const Vec<3>& x) { return {0.0, -x.z(), x.y()}; }

// With images that are mirrored at tangent planes the root mean square would be 0.2.
TEST(SoilInShapedWalls, IsNotStrainedWhereItTurnsInACylinder) {
  auto [setup, state] = laid(pipe(false, Wall::ForSoil::roller));
  auto& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) p.velocity[i] = turning(p.position[i]);
  fill_velocities(setup, state);
  velocity_gradient<3>(state.near.pairs, state.kernel, state.nodes);
  double square = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Mat<3> strain = 0.5 * (state.nodes[i].gradient + state.nodes[i].gradient.transpose());
    square += strain.squaredNorm() / static_cast<double>(p.size());
  }
  EXPECT_LT(std::sqrt(square), 0.015);
}

// Under pressures, beside which nothing is added to the mirrored stress on curved walls.
TEST(SoilInShapedWalls, DoesTheWorkThatItsStrainsStore) {
  Case scene = pipe(true, Wall::ForSoil::roller);
  auto [setup, state] = laid(scene);
  auto& p = state.particles;
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    set_matrix<3>(1e3 * any(generator) * Mat<3>::Identity(), p.stress[i]);
    for (int d = 0; d < 3; ++d) p.velocity[i][d] = any(generator);
  }
  evaluate_forces(setup, state);
  velocity_gradient<3>(state.near.pairs, state.kernel, state.nodes);
  double external = 0.0, stored = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    external += p.volume[i] * state.force[i].internal().dot(p.velocity[i]);
    const double power = p.volume[i] * matrix_of<3>(p.stress[i]).cwiseProduct(state.nodes[i].gradient).sum();
    stored -= power;
    scale += std::abs(power);
  }
  EXPECT_NEAR(external, stored, 1e-11 * scale);
}

TEST(SoilInShapedWalls, BearsItsWeightInAnUprightCylinder) {
  constexpr double height = 0.6;
  Case scene = pipe(false, Wall::ForSoil::roller);
  Shape& shape = *scene.walls[0].shape;
  shape.ends = {Point3::Zero(), Point3(0.0, 0.0, 2.0 * height)};
  shape.solid = nullptr;
  scene.soils[0].shape = shape;
  Shape lower;
  lower.min = Point3::Constant(-1.0);
  lower.max = Point3(1.0, 1.0, height);
  scene.soils[0].shape.within = {lower};
  make_solids(scene, {});
  Solid<3> solid(scene);
  const auto& p = solid.state().particles;
  const VecArray<3> first = p.position;
  solid.initialise({});
  double square = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double weight = p.mass[i] / p.volume[i] * g;
    const double error = (p.stress[i][2] + weight * (height - first[i].z())) / (weight * height);
    square += error * error / static_cast<double>(p.size());
    worst = std::max(worst, std::abs(error));
  }
  EXPECT_LT(std::sqrt(square), 0.02);
  EXPECT_LT(worst, 0.12);
}

// Half a cylinder of soil in a smooth pipe is a pendulum: its distance from the axis is 4 R / (3 pi), its moment of
// inertia m R^2 / 2.
TEST(SoilInShapedWalls, SwingsInAPipeLikeAPendulum) {
  constexpr double slope = 20.0 * degrees;
  Case scene = pipe(true, Wall::ForSoil::roller);
  scene.general.gravity = Point3(0.0, g * std::sin(slope), -g * std::cos(slope));
  scene.solid.initial_rest = false;
  auto [setup, state] = laid(scene);
  const auto& p = state.particles;
  const Drive<3> drive;
  const double arm = 4.0 * radius / (3.0 * std::numbers::pi),
               period =
                   2.0 * std::numbers::pi * std::sqrt(0.5 * radius * radius / (g * arm)) * (1.0 + slope * slope / 16.0);
  double time = 0.0;
  const auto centre_at = [&, &setup = setup, &state = state](double end) {
    for (; time < end; time += setup.longest_substep) substep(setup, setup.longest_substep, drive, state);
    Vec<3> centre = Vec<3>::Zero();
    for (const auto& x : p.position) centre += x / static_cast<double>(p.size());
    return centre;
  };
  const Vec<3> quarter = centre_at(0.25 * period);
  EXPECT_NEAR(std::atan2(quarter.y(), -quarter.z()), slope, 0.05 * slope);
  EXPECT_NEAR(quarter.norm(), arm, 0.01 * arm);
  const Vec<3> other_side = centre_at(0.5 * period);
  EXPECT_NEAR(std::atan2(other_side.y(), -other_side.z()), 2.0 * slope, 0.12 * slope);
  EXPECT_NEAR(other_side.norm(), arm, 0.01 * arm);
}

}  // namespace
}  // namespace poretwin::solid::test
