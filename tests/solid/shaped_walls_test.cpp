// Moving soil beside walls of any shape (3D): in turned boxes as in boxes of planes.
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

namespace poretwin::solid::test {
namespace {

constexpr double g = 9.81, dx = 0.05;

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
  return Eigen::AngleAxisd(spec.placement.turn * std::numbers::pi / 180.0, spec.placement.axis.normalized())
      .toRotationMatrix();
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

TEST(ShapedWalls, BearALinearStressInATurnedBox) {
  BoxSpec spec;
  spec.room = spec.soil;
  for (const Drawn drawn : {Drawn::shape, Drawn::planes, Drawn::aligned}) {
    auto [setup, state] = laid(box(spec, drawn));
    const Mat<3> turn = drawn == Drawn::aligned ? Mat<3>(Mat<3>::Identity()) : turn_of(spec);
    const Vec<3> local = turn.transpose() * setup.gravity;
    auto& p = state.particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double density = p.mass[i] / p.volume[i];
      Vec<3> x = p.position[i];
      if (drawn != Drawn::aligned) x = turn.transpose() * (x - spec.placement.move);
      Vec<3> along;
      for (int d = 0; d < 3; ++d) along[d] = -density * (local[d] * x[d] + (3.0 + d) * g);
      set_matrix<3>(turn * along.asDiagonal() * turn.transpose(), p.stress[i]);
      state.body[i] = density * setup.gravity;
    }
    evaluate_forces(setup, state);
    std::array<double, 4> worst{};
    for (std::size_t i = 0; i < p.size(); ++i) {
      Vec<3> x = p.position[i];
      if (drawn != Drawn::aligned) x = turn.transpose() * (x - spec.placement.move);
      int near = 0;
      for (int d = 0; d < 3; ++d) near += (x[d] < 2.5 * dx) + (x[d] > spec.soil[d] - 2.5 * dx);
      const double error = (state.force[i].internal() + state.body[i]).norm() / state.body[i].norm();
      worst[static_cast<std::size_t>(near)] = std::max(worst[static_cast<std::size_t>(near)], error);
    }
    std::printf("%d images %zu: %.3g %.3g %.3g %.3g\n", static_cast<int>(drawn), state.near.images.size(), worst[0],
                worst[1], worst[2], worst[3]);
  }
}

TEST(ShapedWalls, OfATurnedBoxMoveSoilLikePlanes) {
  for (const bool wide : {false, true})
  for (const auto kind : {Wall::ForSoil::roller, Wall::ForSoil::fixed, Wall::ForSoil::frictional}) {
    BoxSpec spec;
    spec.kind = kind;
    if (wide) {
      spec.room = Point3(4.0, 4.0, 4.0);
      spec.corner = Point3(1.0, 1.0, 0.0);
    }
    spec.friction_angle = kind == Wall::ForSoil::frictional ? 10.0 : 0.0;
    std::vector<VecArray<3>> moved;
    for (const Drawn drawn : {Drawn::shape, Drawn::planes, Drawn::aligned}) {
      Case scene = box(spec, drawn);
      scene.solid.initial_rest = false;
      auto [setup, state] = laid(scene);
      for (auto& stress : state.particles.stress) set_matrix<3>(-1e4 * Mat<3>::Identity(), stress);
      evaluate_forces(setup, state);
      Drive<3> drive;
      for (int k = 0; k < (getenv("NS") ? atoi(getenv("NS")) : 200); ++k) substep(setup, setup.longest_substep, drive, state);
      const Mat<3> back = drawn == Drawn::aligned ? Mat<3>(Mat<3>::Identity()) : Mat<3>(turn_of(spec).transpose());
      VecArray<3> u;
      std::map<std::array<long, 3>, Vec<3>> byplace;
      for (std::size_t i = 0; i < state.particles.size(); ++i) {
        Vec<3> x = state.particles.position[i] - state.particles.displacement[i];
        if (drawn != Drawn::aligned) x = back * (x - spec.placement.move);
        byplace[{std::lround(10 * x[0] / dx), std::lround(10 * x[1] / dx), std::lround(10 * x[2] / dx)}] =
            back * state.particles.displacement[i];
      }
      for (const auto& [key, way] : byplace) u.push_back(way);
      moved.push_back(u);
      std::printf("rebuilds %g\n", state.rebuilds);
    }
    double scale = 0.0, shape = 0.0, planes = 0.0;
    for (std::size_t i = 0; i < moved[0].size(); ++i) {
      scale = std::max(scale, moved[2][i].norm());
      shape = std::max(shape, (moved[0][i] - moved[1][i]).norm());
      planes = std::max(planes, (moved[2][i] - moved[1][i]).norm());
    }
    std::printf("kind %d: moved %.3g, shape - planes %.3g, planes - aligned %.3g\n", static_cast<int>(kind), scale,
                shape / scale, planes / scale);
  }
}


TEST(ShapedWalls, LetABlockSlide) {
  for (const double friction : {0.0, 20.0})
    for (const Drawn drawn : {Drawn::shape, Drawn::planes}) {
      BoxSpec spec;
      spec.room = Point3(4.0, 4.0, 4.0);
      spec.corner = Point3(1.0, 1.0, 0.0);
      spec.soil = Point3(0.6, 0.4, getenv("HH") ? atof(getenv("HH")) : 0.2);
      spec.placement = {1.0, 30.0, Point3(0.0, 1.0, 0.0), Point3(0.3, -0.2, 0.1)};
      spec.kind = friction > 0.0 ? Wall::ForSoil::frictional : Wall::ForSoil::roller;
      spec.friction_angle = friction;
      Case scene = box(spec, drawn);
      scene.solid.initial_rest = false;
      if (getenv("DP")) {
        scene.solid.model = SolidCase::Model::drucker_prager;
        scene.soils[0].friction_angle = 31.0;
        scene.soils[0].cohesion = atof(getenv("DP"));
      }
      if (getenv("AV")) scene.solid.artificial_viscosity = atof(getenv("AV"));
      auto [setup, state] = laid(scene);
      Drive<3> drive;
      double time = 0.0;
      const double slope = spec.placement.turn * std::numbers::pi / 180.0;
      const double expected = g * (std::sin(slope) - std::cos(slope) * std::tan(friction * std::numbers::pi / 180.0));
      for (int k = 0; k < 1000; ++k) {
        substep(setup, setup.longest_substep, drive, state);
        time += setup.longest_substep;
        if (k % 100 == 99) {
          Vec<3> mean = Vec<3>::Zero();
          for (const auto& v : state.particles.velocity) mean += v / static_cast<double>(state.particles.size());
          const Vec<3> local = turn_of(spec).transpose() * mean;
          std::printf("friction %g drawn %d t %.3f speed/exact %.5f across %.3g normal %.3g\n", friction,
                      static_cast<int>(drawn), time, local[0] / (expected * time), local[1] / (expected * time),
                      local[2] / (expected * time));
        }
      }
    }
}

}  // namespace
}  // namespace poretwin::solid::test
