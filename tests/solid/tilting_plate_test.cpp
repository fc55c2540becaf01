// Plates that tilt and lift off, against closed forms and balances.
#include "solid_solver/discretisation/turning.hpp"
#include "solid_solver/dynamics/plate_motion.hpp"
#include "solid_solver/output/readout.hpp"
#include "solid_solver/statics/initial_state.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tuple>

namespace poretwin::solid::test {
namespace {

constexpr double youngs_modulus = 3e6, ratio = 0.3;  // those of scenes.hpp
constexpr double plane_modulus = youngs_modulus / (1.0 - ratio * ratio);
constexpr double density = 0.6 * 2600.0;
constexpr double width = 0.8, height = 1.0;
constexpr double second_moment = width * width * width / 12.0;  // m3, of the block's cross-section

/// A weightless block with free sides on a base as rough as the plate on all of its top.
Case block(double spacing, Plate::Surface surface = Plate::Surface::smooth) {
  ColumnSpec spec;
  spec.width = width;
  spec.height = height;
  spec.spacing = spacing;
  spec.gravity = 0.0;
  spec.base = surface == Plate::Surface::smooth ? Wall::ForSoil::roller : Wall::ForSoil::fixed;
  spec.sides = false;
  Case scene = column(spec);
  Plate plate;
  plate.name = "plate";
  plate.surface = surface;
  plate.face.points = {{width, height, 0.0}, {0.0, height, 0.0}};
  plate.tilts = true;
  plate.force = Series{{{0.0, 0.0}}};
  scene.plates = {plate};
  return scene;
}

const PlateMotion<2>& plate_of(const Solid<2>& solid, std::size_t k = 0) { return solid.state().particles.plates[k]; }

/// Angle [rad] at which the plate comes to rest under a force [N/m] that acts beyond its middle, or under a moment
/// alone.
double bent_by(double moment, double force, double spacing, Plate::Surface surface = Plate::Surface::smooth) {
  Case scene = block(spacing, surface);
  if (force > 0.0) {
    scene.plates[0].force = Series{{{0.0, force}}};
    scene.plates[0].eccentricity = moment / force;
  } else {
    scene.plates[0].moment = Series{{{0.0, moment}}};
  }
  Solid<2> solid(scene);
  solid.initialise({});
  const auto& plate = plate_of(solid);
  const double settled = force * height / (plane_modulus * width);
  EXPECT_NEAR(-plate.moment, moment, 1e-3 * moment);
  if (surface == Plate::Surface::smooth) {
    EXPECT_NEAR(-plate.displacement.y(), settled, 5e-3 * settled + 1e-3 * plate.angle * width);
  }
  EXPECT_NEAR(plate.reaction.y(), force, 2e-3 * std::max(force, moment / width));
  return plate.angle;
}

// A moment on smooth ends bends the block to a circle: theta = M H / (E' I). The block of particles is softer, by 10 %
// with 8 particles across and with the square of the spacing.
TEST(TiltingPlate, BendsABlockAsABeam) {
  constexpr double angle = 1e-3, moment = angle * plane_modulus * second_moment / height;
  for (const double force : {0.0, 400.0}) {
    const double coarse = bent_by(moment, force, 0.1), fine = bent_by(moment, force, 0.05);
    std::printf("angles over the exact one: %.4f, %.4f\n", coarse / angle, fine / angle);
    EXPECT_NEAR(fine, angle, 0.03 * angle);
    EXPECT_NEAR((4.0 * fine - coarse) / 3.0, angle, 3e-3 * angle);
  }
}

// Soil and plate that turn together are not strained, whatever the angle at which the plate already stands.
TEST(TiltingPlate, TurnsWithTheSoilWithoutStrain) {
  for (const auto surface : {Plate::Surface::smooth, Plate::Surface::rough}) {
    Case scene = block(0.1, surface);
    scene.walls.clear();
    auto [setup, particles] = set_up<2>(scene);
    const Vec<2> middle(0.5 * width, height), moves(0.1, -0.2);
    constexpr double angle = 0.3, spin = 0.7;
    const Mat<2> turned = rotation<2>(angle);
    State<2> state = laid_out(setup, std::move(particles));
    Particles<2>& p = state.particles;
    const auto turn = [&](double by) {
      for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec<2> at = rotation<2>(-p.plates[0].angle) * (p.position[i] - middle);
        const Vec<2> before = p.position[i];
        p.position[i] = middle + rotation<2>(by) * at;
        p.displacement[i] += p.position[i] - before;
        p.velocity[i] = moves + spin * spinning<2>() * (p.position[i] - middle);
        state.nodes[i].deformation = Mat<2>::Identity() - rotation<2>(-by);
      }
      p.plates[0].angle = by;
    };
    p.plates[0].velocity = moves;
    p.plates[0].spin = spin;
    turn(angle);
    rebuild(setup, state);
    turn(angle + 0.01);  // within the same lists
    fill_nodes(setup, state);
    velocity_gradient<2>(state.near.pairs, state.kernel, state.nodes);
    evaluate_forces(setup, state);
    double force = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Mat<2> strained = state.nodes[i].gradient - spin * spinning<2>();
      EXPECT_LT(strained.norm(), 1e-5) << p.position[i].transpose();
      force = std::max(force, (state.force[i].internal() + state.force[i].stabilising()).norm());
    }
    EXPECT_LT(force, 1e-3) << "of " << setup.stabilisers.modulus;
    EXPECT_GT(turned(1, 0), 0.0);
  }
}

// What the plates give the soil is the momentum and the angular momentum that it gains. Two plates hold a block that
// moves in an arbitrary way. Only hourglass control acts across the line between two particles, and is left out.
TEST(TiltingPlate, GivesTheSoilTheAngularMomentumThatItGains) {
  for (const auto surface : {Plate::Surface::smooth, Plate::Surface::rough}) {
    Case scene = block(0.1, surface);
    scene.walls.clear();
    scene.plates[0].face.points = {{0.7, height, 0.0}, {0.1, height, 0.0}};  // with soil beside its ends
    Plate lower = scene.plates[0];
    lower.name = "lower";
    lower.face.points = {{0.0, 0.0, 0.0}, {width, 0.0, 0.0}};
    scene.plates.push_back(lower);
    auto [setup, particles] = set_up<2>(scene);
    setup.stabilisers.hourglass_viscosity = setup.stabilisers.hourglass_stiffness = 0.0;
    State<2> state = laid_out(setup, std::move(particles));
    Particles<2>& p = state.particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vec<2>& x = p.position[i];
      p.velocity[i] = Vec<2>(0.3 * std::sin(3.0 * x.y()) + 0.2 * x.x() * x.y(), -0.4 * x.x() * x.x() - 0.2 * x.y());
    }
    Drive<2> drive;
    drive.plates = {{Vec<2>::Zero(), 300.0, 150.0}, {Vec<2>::Zero(), 200.0, -250.0}};
    for (int k = 0; k < 60; ++k) substep(setup, setup.longest_substep, drive, state);
    rebuild(setup, state);  // corrections of the kernel at the positions of the forces
    evaluate_forces(setup, state);
    Vec<2> gained = Vec<2>::Zero();
    double turned = 0.0, given = 0.0, size = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vec<2> f = p.volume[i] * (state.force[i].internal() + state.force[i].stabilising());
      gained += f;
      turned += moment_of<2>(p.position[i], f);
    }
    Vec<2> pushed = Vec<2>::Zero();
    for (std::size_t k = 0; k < 2; ++k) {
      const PlateMotion<2>& plate = p.plates[k];
      pushed -= plate.reaction;
      given -= plate.moment + moment_of<2>(setup.plates[k].middle + plate.displacement, plate.reaction);
      size += std::abs(plate.moment) + plate.reaction.norm();
      EXPECT_GT(std::abs(plate.angle), 1e-3);
    }
    std::printf("gained %.9g, given %.9g, size %g\n", turned, given, size);
    EXPECT_LT((gained - pushed).norm(), 1e-6 * size);
    EXPECT_NEAR(turned, given, 1e-6 * size);
  }
}

/// Energy [J/m] of the soil and of the plate, without that of the stabilisers.
double energy(const Solid<2>& solid) {
  const auto& p = solid.state().particles;
  const PlateSetup<2>& plate = solid.setup().plates[0];
  double sum =
      0.5 * plate.mass * p.plates[0].velocity.squaredNorm() + 0.5 * plate.inertia * std::pow(p.plates[0].spin, 2);
  for (std::size_t i = 0; i < p.free(); ++i)
    sum += 0.5 * p.mass[i] * p.velocity[i].squaredNorm() +
           p.volume[i] * strain_energy(p.stress[i], moduli(solid.setup(), p, i));
  return sum;
}

// A heavy plate rocks on the block as on a spring that turns, with the period 2 pi sqrt(I_p theta / M), and
// gains no energy from it beyond the work of the moment.
TEST(TiltingPlate, RocksOnItsSoilWithoutGainingEnergy) {
  constexpr double moment = 300.0, share = 50.0;
  for (const auto surface : {Plate::Surface::smooth, Plate::Surface::rough}) {
    Case scene = block(0.1, surface);
    scene.plates[0].moment = Series{{{0.0, moment}}};
    scene.plates[0].start = 0.0;
    scene.plates[0].mass = share * density * width * height;
    Solid<2> solid(scene);
    solid.initialise({});
    const double inertia = *scene.plates[0].mass * width * width / 12.0;
    EXPECT_NEAR(solid.setup().plates[0].inertia, inertia, 0.02 * inertia);
    const double rest = bent_by(moment, 0.0, 0.1, surface);
    const double exact = 2.0 * std::numbers::pi * std::sqrt(solid.setup().plates[0].inertia * rest / moment);
    double before = -1.0, most = 0.0, largest = 0.0;
    std::vector<double> up;
    while (up.size() < 3 && solid.state().time < 5.0 * exact) {
      const double dt = 10.0 * solid.setup().longest_substep;
      solid.advance({0, solid.state().time, dt}, {});
      const double now = plate_of(solid).angle - rest;
      if (before <= 0.0 && now > 0.0) up.push_back(solid.state().time - dt * now / (now - before));
      before = now;
      const double stored = energy(solid), work = moment * plate_of(solid).angle;
      most = std::max(most, stored - work);
      largest = std::max(largest, stored);
    }
    ASSERT_EQ(up.size(), 3U);
    std::printf("period %.5f, exact %.5f; energy gained %.3g of %.3g\n", up[1] - up[0], exact, most, largest);
    EXPECT_NEAR(up[1] - up[0], exact, 0.01 * exact);
    EXPECT_NEAR(up[2] - up[1], up[1] - up[0], 0.002 * exact);
    EXPECT_LT(most, 0.003 * largest);
  }
}

/// Inbox of a field of pore pressure [Pa].
coupling::Inbox field_inbox(const Solid<2>& solid, const std::function<double(const Vec<2>&)>& pressure) {
  coupling::Inbox inbox = wet_inbox<2>(solid, pressure);
  inbox.fields.push_back({std::string(coupling::field::degree_of_saturation), 1,
                          std::vector<double>(solid.state().particles.size(), 1.0)});
  return inbox;
}

// In a window that is computed as an equilibrium the plate comes to the same angle as in time, and skeleton and pore
// pressure bear the moment together: that of a pressure s (x - x_m) on the plate is s I.
TEST(TiltingPlate, BearsMomentOfSoilAndWaterInEquilibrium) {
  constexpr double angle = 1e-3;
  for (const double slope : {0.0, 3000.0}) {  // Pa/m
    Case scene = block(0.05);
    if (slope > 0.0) scene.walls[0].soil = Wall::ForSoil::fixed;  // against the water's force along the block
    scene.soils[0].hydraulic_conductivity = 1e-4;
    scene.fluid.representation = FluidCase::Representation::field;
    const double total = angle * plane_modulus * second_moment / height;
    scene.plates[0].moment = Series{{{0.0, total}}};
    scene.plates[0].start = 0.0;
    Solid<2> solid(scene);
    solid.initialise(field_inbox(solid, [](const Vec<2>&) { return 0.0; }));
    const auto outcome = solid.advance(
        {0, 0.0, 1.0}, field_inbox(solid, [&](const Vec<2>& x) { return slope * (x.x() - 0.5 * width); }));
    ASSERT_TRUE(outcome.accepted);
    const auto& plate = plate_of(solid);
    const double water = -slope * second_moment;  // the plate's last point lies at x = 0
    std::printf("water %.5g of %.5g, sum %.6g of %.6g, angle %.5g, steps %g\n", plate.water_moment, water,
                plate.water_moment - plate.moment, total, plate.angle, solid.state().motion.steps);
    EXPECT_NEAR(plate.water_moment, water, 0.02 * std::abs(water));
    EXPECT_NEAR(plate.water_moment - plate.moment, total, 2e-3 * total);
    if (slope == 0.0) {
      EXPECT_NEAR(plate.angle, bent_by(total, 0.0, 0.05), 2e-3 * angle);
    }
    EXPECT_EQ(solid.counters().at("windows relaxed"), 1.0);
  }
}

/// A smooth rigid strip, 1 m wide, on an elastic layer.
Case strip(double spacing, double force) {
  ColumnSpec spec;
  spec.width = 3.0;
  spec.height = 1.5;
  spec.spacing = spacing;
  spec.gravity = 0.0;
  Case scene = column(spec);
  Plate plate;
  plate.name = "strip";
  plate.face.points = {{2.0, spec.height, 0.0}, {1.0, spec.height, 0.0}};
  plate.tilts = plate.lifts = true;
  plate.force = Series{{{0.0, force}}};
  scene.plates = {plate};
  return scene;
}

std::size_t touching(const PlateMotion<2>& plate) {
  return static_cast<std::size_t>(std::ranges::count(plate.apart, char{0}));
}

// The pressure under a smooth strip on a half plane is (F + 2 M x / a^2) / (pi sqrt(a^2 - x^2)) with half its width a:
// beyond an eccentricity e of a quarter of the width a part of it comes off, and it touches along 4 (a - e).
TEST(TiltingPlate, LiftsOffWhereItWouldPull) {
  constexpr double force = 1000.0, spacing = 0.05;
  for (const double eccentricity : {0.1, -0.2, 0.35}) {
    Case scene = strip(spacing, force);
    scene.plates[0].eccentricity = eccentricity;
    Solid<2> solid(scene);
    solid.initialise({});
    const auto& plate = plate_of(solid);
    const double length = std::min(1.0, 4.0 * (0.5 - std::abs(eccentricity)));
    const double found = spacing * static_cast<double>(touching(plate));
    std::printf("e %g: touches along %.3f of %.3f, angle %.4g, force %.5g, moment %.5g\n", eccentricity, found, length,
                plate.angle, plate.reaction.y(), -plate.moment);
    EXPECT_NEAR(found, length, 1.5 * spacing);
    EXPECT_NEAR(plate.reaction.y(), force, 2e-3 * force);
    EXPECT_NEAR(-plate.moment, eccentricity * force, 2e-3 * force);
    EXPECT_GT(plate.angle * eccentricity, 0.0);
    // The last point lies at the left: it is pressed in where the force acts beyond the middle towards it.
    if (length < 1.0) {
      EXPECT_EQ(plate.apart.front(), eccentricity > 0.0 ? 1 : 0);
      EXPECT_EQ(plate.apart.back(), eccentricity > 0.0 ? 0 : 1);
    }
  }
}

// Gaps that open and close leave nothing behind on elastic soil.
TEST(TiltingPlate, TouchesAgainWhereTheGapCloses) {
  constexpr double force = 1000.0, moment = 350.0;
  Case scene = strip(0.1, force);
  Series rocks;
  for (int k = 0; k <= 80; ++k) rocks.knots.emplace_back(0.025 * k, moment * std::sin(std::numbers::pi * 0.025 * k));
  scene.plates[0].moment = rocks;
  Solid<2> solid(scene);
  solid.initialise({});
  const auto& plate = plate_of(solid);
  const double settled = plate.displacement.y();
  std::size_t least = 10, changes = 0, before = touching(plate);
  double largest = 0.0;
  EXPECT_EQ(before, 10U);
  while (solid.state().time < 2.0 - 1e-9) {
    solid.advance({0, solid.state().time, 0.01}, {});
    const std::size_t now = touching(plate);
    least = std::min(least, now);
    changes += now != before ? 1 : 0;
    before = now;
    largest = std::max(largest, std::abs(plate.angle));
  }
  std::printf("touches with %zu of 10 parts at least, %zu changes; angle %.3g at most, %.3g left, settled %.5g, %.5g\n",
              least, changes, largest, plate.angle, settled, plate.displacement.y());
  EXPECT_LE(least, 7U);
  EXPECT_EQ(touching(plate), 10U);
  EXPECT_LT(std::abs(plate.angle), 0.02 * largest);
  EXPECT_NEAR(plate.displacement.y(), settled, 0.02 * std::abs(settled));
}

// A part of a plate that sticks to the soil pulls at it beyond the eccentricity at which a plate that lifts comes off.
TEST(TiltingPlate, ThatPullsInPartIsWarnedOf) {
  for (const auto& [eccentricity, lifts, warned] :
       {std::tuple{0.1, false, false}, {0.35, false, true}, {0.35, true, false}}) {
    Case scene = strip(0.1, 1000.0);
    scene.plates[0].eccentricity = eccentricity;
    scene.plates[0].lifts = lifts;
    Solid<2> solid(scene);
    solid.initialise({});
    solid.advance({0, 0.0, solid.setup().longest_substep}, {});
    double count = 0.0;
    for (const auto& warning : solid.warnings())
      if (warning.what.find("plate pulled") != std::string::npos) count += warning.count;
    EXPECT_EQ(count > 0.0, warned) << eccentricity << ", lifts " << lifts;
  }
}

// A state that is saved while a part of the plate is off the soil goes on as the run itself does.
TEST(TiltingPlate, GoesOnFromASavedStateToTheBit) {
  Case scene = strip(0.1, 1000.0);
  scene.plates[0].eccentricity = 0.35;
  scene.plates[0].start = 0.0;
  Solid<2> solid(scene), resumed(scene);
  solid.initialise({});
  run_dry(solid, 0.05, 0.01);
  EXPECT_LT(touching(plate_of(solid)), 10U);
  Archive saved;
  solid.archive(saved);
  Archive loaded(saved.bytes());
  resumed.archive(loaded);
  for (auto* of : {&solid, &resumed}) run_dry(*of, 0.1, 0.01);
  EXPECT_EQ(plate_of(solid).angle, plate_of(resumed).angle);
  EXPECT_EQ(plate_of(solid).moment, plate_of(resumed).moment);
  EXPECT_EQ(plate_of(solid).apart, plate_of(resumed).apart);
  EXPECT_EQ(solid.state().particles.position, resumed.state().particles.position);
}

// A tilted plate that turns throws particles back that have passed through it, with its own speed at their place.
TEST(TiltingPlate, KeepsSoilBeforeIt) {
  Case scene = block(0.1);
  auto [setup, particles] = set_up<2>(scene);
  PlateMotion<2>& plate = particles.plates[0];
  plate.angle = 0.2;
  plate.spin = 3.0;
  plate.velocity = Vec<2>(0.0, -0.1);
  const auto boundaries = with_plates_at<2>(particles.plates, setup.boundaries);
  const Vec<2> middle(0.5 * width, height), normal = rotation<2>(0.2) * Vec<2>(0.0, -1.0);
  const Vec<2> at = middle + rotation<2>(0.2) * Vec<2>(-0.3, 0.0),
               pushed = plate.velocity + 3.0 * spinning<2>() * (at - middle);
  Vec<2> x = at - 0.01 * normal, v = Vec<2>::Zero();
  sph::keep_inside<2>(boundaries.planes, 0.1, x, v);
  EXPECT_LT((x - (at + 0.01 * normal)).norm(), 1e-12);
  EXPECT_NEAR(normal.dot(v), normal.dot(pushed), 1e-12);
}

}  // namespace
}  // namespace poretwin::solid::test
