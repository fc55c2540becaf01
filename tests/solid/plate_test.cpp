// Rigid plates: the force on them against closed forms.
#include "solid_solver/discretisation/lists_hold.hpp"
#include "solid_solver/dynamics/plate_motion.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace poretwin::solid::test {
namespace {

constexpr double youngs_modulus = 3e6, ratio = 0.3;  // those of scenes.hpp
constexpr double constrained = youngs_modulus * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio));
constexpr double shear = youngs_modulus / (2.0 * (1.0 + ratio));
constexpr double density = 0.6 * 2600.0;

/// A column between smooth walls on a smooth base, without weight.
Case weightless_column(double spacing) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  spec.base = Wall::ForSoil::roller;
  spec.spacing = spacing;
  return column(spec);
}

Plate lid(double width, double height) {
  Plate plate;
  plate.name = "lid";
  plate.face.points = {{width, height, 0.0}, {0.0, height, 0.0}};
  return plate;
}

template <int D>
void run(Solid<D>& solid, double end) {
  run_dry(solid, end, 20.0 * solid.setup().longest_substep);
}

template <int D>
const PlateMotion<D>& plate_of(const Solid<D>& solid, std::size_t k = 0) {
  return solid.state().particles.plates[k];
}

TEST(Plate, CompressesAColumnAsAnOedometerDoes) {
  constexpr double width = 0.4, height = 1.0;
  for (const double spacing : {0.05, 0.1}) {
    Case scene = weightless_column(spacing);
    Plate plate = lid(width, height);
    constexpr double strain = 1e-3;
    plate.speed = Series{{{0.0, 0.0}, {1.0, strain * height}, {2.0, 0.0}}};  // without a jump of speed
    scene.plates = {plate};
    Solid<2> solid(scene);
    solid.initialise({});
    run(solid, 2.0);
    const double stress = -constrained * std::log1p(-strain);
    EXPECT_NEAR(plate_of(solid).displacement.y(), -strain * height, 1e-9);
    EXPECT_NEAR(plate_of(solid).reaction.y(), stress * width, 1e-3 * stress * width);
    EXPECT_NEAR(plate_of(solid).reaction.x(), 0.0, 1e-9 * stress * width);
    for (const Tensor& s : solid.state().particles.stress) EXPECT_NEAR(s[1], -stress, 2e-3 * stress);
  }
}

// The same in a column that is turned by 30 degrees, with its rows.
TEST(Plate, CompressesATurnedColumn) {
  constexpr double width = 0.4, height = 1.0, strain = 1e-3, angle = std::numbers::pi / 6.0;
  const auto turned = [&](double x, double y) {
    return Point3(std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y, 0.0);
  };
  Case scene = weightless_column(0.05);
  Shape& shape = scene.soils[0].shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = {turned(0, 0), turned(width, 0), turned(width, height), turned(0, height)};
  for (Wall& wall : scene.walls) {
    wall.face.point = turned(wall.face.point.x(), wall.face.point.y());
    wall.face.normal = turned(wall.face.normal.x(), wall.face.normal.y());
  }
  Plate plate;
  plate.face.points = {turned(width, height), turned(0, height)};
  plate.speed = Series{{{0.0, 0.0}, {1.0, strain * height}, {2.0, 0.0}}};
  scene.plates = {plate};
  Solid<2> solid(scene);
  solid.initialise({});
  run(solid, 2.0);
  const double force = -constrained * std::log1p(-strain) * width;
  const Vec<2> due = force * turned(0, 1).head<2>();
  EXPECT_LT((plate_of(solid).reaction - due).norm(), 1e-3 * force);
}

// The plate moves by two spacings: lists and images are built anew several times, and log(H / h) is the strain.
TEST(Plate, CompressesSoilByMuch) {
  constexpr double width = 0.4, height = 1.0, left = 0.9;
  Case scene = weightless_column(0.05);
  Plate plate = lid(width, height);
  plate.speed = Series{{{0.0, 0.0}, {1.0, (1.0 - left) * height}, {2.0, 0.0}}};
  scene.plates = {plate};
  Solid<2> solid(scene);
  solid.initialise({});
  run(solid, 2.0);
  EXPECT_GT(solid.state().rebuilds, 5.0);
  const double stress = -constrained * std::log(left);
  EXPECT_NEAR(plate_of(solid).reaction.y(), stress * width, 2e-3 * stress * width);
}

// The images of a plate that moves past soil at rest move twice as far: pairs come into reach a quarter of the lists'
// margin on.
TEST(Plate, ListsHoldUntilItsImagesComeIntoReach) {
  Case scene = weightless_column(0.05);
  scene.plates = {lid(0.4, 1.0)};
  scene.plates[0].displacement = Series{{{0.0, 0.0}}};
  const Solid<2> solid(scene);
  const auto holds = [&](double skins) {
    Particles<2> p = solid.state().particles;
    p.plates[0].displacement.y() -= skins * solid.setup().skin;
    return lists_hold(solid.setup(), p, solid.state().near);
  };
  EXPECT_TRUE(holds(0.0));
  EXPECT_TRUE(holds(0.24));
  EXPECT_FALSE(holds(0.26));
}

// Whatever the motion, what the plates give the soil is what it gains, stabilising forces and corners included.
TEST(Plate, AllPlatesTogetherBearTheForcesOfAllImages) {
  constexpr double width = 0.4, height = 0.6;
  ColumnSpec spec;
  spec.width = width;
  spec.height = height;
  spec.gravity = 0.0;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  Case scene = column(spec);
  const std::vector<Point3> corners{{0, 0, 0}, {width, 0, 0}, {width, height, 0}, {0, height, 0}};
  for (std::size_t k = 0; k < 4; ++k) {
    Plate plate;
    plate.name = std::string(1, static_cast<char>('a' + k));
    plate.face.points = {corners[k], corners[(k + 1) % 4]};
    plate.speed = Series{{{0.0, 0.02 * static_cast<double>(k + 1)}}};
    if (k == 2) plate.surface = Plate::Surface::rough;
    scene.plates.push_back(plate);
  }
  scene.solid.initial_velocity = {0.3, -0.2, 0.0};
  Solid<2> solid(scene);
  solid.initialise({});
  for (int k = 0; k < 5; ++k) {
    run(solid, solid.state().time + 0.005);
    const auto& p = solid.state().particles;
    Vec<2> all = Vec<2>::Zero(), borne = all, size = all;
    for (std::size_t i = 0; i < p.size(); ++i)
      all += p.volume[i] * (solid.state().force[i].internal() + solid.state().force[i].stabilising());
    for (const auto& plate : p.plates) {
      borne -= plate.reaction;
      size += plate.reaction.cwiseAbs();
    }
    EXPECT_GT(size.minCoeff(), 100.0);
    EXPECT_LT((all - borne).norm(), 1e-9 * size.norm()) << all.transpose() << ", borne " << borne.transpose();
  }
}

/// A column of soil, 1 m wide, under two smooth lids that meet at x = `seam` [m]. The other of them can be a wall.
Case two_lids(double seam, bool second_is_wall) {
  constexpr double width = 1.0, height = 0.6;
  ColumnSpec spec;
  spec.width = width;
  spec.height = height;
  spec.spacing = 0.1;
  spec.gravity = 0.0;
  spec.base = Wall::ForSoil::roller;
  Case scene = column(spec);
  Plate right = lid(width, height), left = lid(width, height);
  right.name = "right";
  left.name = "left";
  right.face.points = {{width, height, 0.0}, {seam, height, 0.0}};
  left.face.points = {{seam, height, 0.0}, {0.0, height, 0.0}};
  scene.plates = {right, left};
  if (!second_is_wall) return scene;
  scene.plates.pop_back();
  Wall wall;
  wall.face = left.face;
  wall.soil = Wall::ForSoil::roller;
  scene.walls.push_back(wall);
  return scene;
}

// Between two lids that move alike, nothing distinguishes the seam from the rest of the soil: each bears the
// oedometer's stress on its length, and none along it. The seam lies between two columns of particles, or on one.
TEST(Plate, ThatContinuesAnotherBearsNoShear) {
  constexpr double strain = 1e-3, height = 0.6;
  for (const double seam : {0.5, 0.45}) {
    Case scene = two_lids(seam, false);
    for (Plate& plate : scene.plates) plate.speed = Series{{{0.0, 0.0}, {1.0, strain * height}, {2.0, 0.0}}};
    Solid<2> solid(scene);
    solid.initialise({});
    run(solid, 2.0);
    const double stress = -constrained * std::log1p(-strain);
    const auto& plates = solid.state().particles.plates;
    EXPECT_NEAR(plates[0].reaction.y() + plates[1].reaction.y(), stress, 1e-3 * stress);
    EXPECT_NEAR(plates[0].reaction.y(), stress * (1.0 - seam), (seam == 0.5 ? 1e-3 : 0.06) * stress);
    for (const auto& plate : plates) EXPECT_NEAR(plate.reaction.x(), 0.0, 1e-5 * stress);
    for (const Tensor& s : solid.state().particles.stress) EXPECT_NEAR(s[1], -stress, 2e-3 * stress);
  }
}

// The same where a wall continues the plate (soil that is pressed from the side by another plate).
TEST(Plate, ThatContinuesAWallBearsNoShear) {
  constexpr double strain = 1e-3, width = 1.0, height = 0.6;
  Case scene = two_lids(0.5, true);
  std::erase_if(scene.walls, [](const Wall& wall) { return wall.face.normal.x() > 0.5; });
  scene.plates[0].displacement = Series{{{0.0, 0.0}}};
  Plate side;
  side.name = "side";
  side.face.points = {{0.0, height, 0.0}, {0.0, 0.0, 0.0}};
  side.speed = Series{{{0.0, 0.0}, {1.0, strain * width}, {2.0, 0.0}}};
  scene.plates.push_back(side);
  Solid<2> solid(scene);
  solid.initialise({});
  run(solid, 2.0);
  const double stress = -ratio / (1.0 - ratio) * constrained * std::log1p(-strain);
  EXPECT_NEAR(plate_of(solid).reaction.y(), 0.5 * stress, 1e-3 * stress);
  EXPECT_NEAR(plate_of(solid).reaction.x(), 0.0, 1e-5 * stress);
}

// Moved by different ways and one of them rough, the plates give the soil what it gains.
TEST(Plate, ThatContinuesAnotherBearsWithItAllThatTheSoilGains) {
  for (const bool rough : {false, true}) {
    Case scene = two_lids(0.5, false);
    scene.walls.clear();
    scene.solid.initial_velocity = {0.3, -0.2, 0.0};
    if (rough) scene.plates[1].surface = Plate::Surface::rough;
    for (std::size_t k = 0; k < 2; ++k) scene.plates[k].speed = Series{{{0.0, 0.02 * static_cast<double>(k + 1)}}};
    Solid<2> solid(scene);
    solid.initialise({});
    for (int k = 0; k < 5; ++k) {
      run(solid, solid.state().time + 0.005);
      const auto& p = solid.state().particles;
      Vec<2> all = Vec<2>::Zero(), size = all;
      for (std::size_t i = 0; i < p.size(); ++i)
        all += p.volume[i] * (solid.state().force[i].internal() + solid.state().force[i].stabilising());
      for (const auto& plate : p.plates) {
        all += plate.reaction;
        size += plate.reaction.cwiseAbs();
      }
      EXPECT_GT(size.minCoeff(), 1.0);
      EXPECT_LT(all.norm(), 1e-9 * size.norm()) << all.transpose();
    }
  }
}

TEST(Plate, UnderAForceComesToRestWhereTheSoilBearsIt) {
  constexpr double width = 0.4, height = 1.0, force = 1000.0;
  Case scene = weightless_column(0.05);
  Plate plate = lid(width, height);
  plate.force = Series{{{0.0, force}}};
  scene.plates = {plate};
  Solid<2> solid(scene);
  solid.initialise({});
  EXPECT_NEAR(plate_of(solid).reaction.y(), force, 2e-3 * force);
  const double strain = -std::expm1(-force / (width * constrained));
  EXPECT_NEAR(plate_of(solid).displacement.y(), -strain * height, 3e-3 * strain * height);
}

/// Period [s] of a plate of this mass [kg/m] on a column, from its passages through the mean.
double period(double mass, double spacing) {
  constexpr double width = 0.4, height = 1.0, force = 400.0;
  Case scene = weightless_column(spacing);
  Plate plate = lid(width, height);
  plate.force = Series{{{0.0, force}}};
  plate.start = 0.0;
  plate.mass = mass;
  scene.plates = {plate};
  Solid<2> solid(scene);
  solid.initialise({});
  const double rest = -force / (width * constrained) * height;
  double before = 0.0, passed = 0.0;
  std::vector<double> down;
  while (down.size() < 2) {
    const double dt = 2.0 * solid.setup().longest_substep;
    solid.advance({0, solid.state().time, dt}, {});
    const double now = plate_of(solid).displacement.y() - rest;
    if (before > 0.0 && now <= 0.0) down.push_back(solid.state().time - dt * now / (now - before));
    before = now;
    passed += dt;
    if (passed > 10.0) return 0.0;
  }
  return down[1] - down[0];
}

// A mass m on a bar of the mass m_s: omega H / c tan(omega H / c) = m_s / m.
TEST(Plate, WithAMassSwingsOnItsSoil) {
  constexpr double width = 0.4, height = 1.0;
  for (const double share : {4.0, 1.0, 0.05}) {  // mass of the plate over that of the soil; the last: one row
    double lower = 0.0, upper = 0.5 * std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
      const double x = 0.5 * (lower + upper);
      (x * std::tan(x) < 1.0 / share ? lower : upper) = x;
    }
    const double exact = 2.0 * std::numbers::pi * height / (lower * std::sqrt(constrained / density));
    const double found = period(share * density * width * height, 0.05);
    std::printf("period %.5f, exact %.5f\n", found, exact);
    EXPECT_NEAR(found, exact, 0.01 * exact);
  }
}

// Roughness: the layer between a rough plate and a fixed base is sheared evenly.
TEST(Plate, ShearsALayerThatItHolds) {
  constexpr double width = 0.4, height = 0.5, strain = 1e-3;
  ColumnSpec spec;
  spec.width = width;
  spec.height = height;
  spec.gravity = 0.0;
  spec.sides = false;
  Case scene = column(spec);
  scene.general.periodic = {0};
  scene.general.domain_max = {width, height, 0.0};
  Plate plate;
  plate.name = "shear box";
  plate.face = plane({0.0, height, 0.0}, -Point3::UnitY());
  plate.surface = Plate::Surface::rough;
  constexpr int steps = 40;
  Series slide;  // half a cosine, without jumps of the speed
  for (int k = 0; k <= steps; ++k)
    slide.knots.emplace_back(2.0 * k / steps, 0.5 * strain * height * (1.0 - std::cos(std::numbers::pi * k / steps)));
  plate.along = slide;
  scene.plates = {plate};
  Solid<2> solid(scene);
  solid.initialise({});
  run(solid, 2.0);
  const auto& motion = plate_of(solid);
  const double along = motion.displacement.x();
  EXPECT_NEAR(std::abs(along), strain * height, 1e-9);
  EXPECT_NEAR(-motion.reaction.x() * (along > 0.0 ? 1.0 : -1.0), shear * strain * width, 2e-3 * shear * strain * width);
  EXPECT_NEAR(motion.reaction.y(), 0.0, 2e-3 * shear * strain * width);
}

double warned_of_pull(const Solid<2>& solid) {
  for (const auto& warning : solid.warnings())
    if (warning.what.find("plate pulled") != std::string::npos) return warning.count;
  return -1.0;
}

// The soil sticks to the plate: pulled up, it is stretched.
TEST(Plate, ThatPullsIsWarnedOf) {
  constexpr double width = 0.4, height = 1.0, strain = 1e-4;
  for (const double sign : {1.0, -1.0}) {
    Case scene = weightless_column(0.1);
    Plate plate = lid(width, height);
    plate.speed = Series{{{0.0, 0.0}, {1.0, sign * strain}, {2.0, 0.0}}};
    scene.plates = {plate};
    Solid<2> solid(scene);
    solid.initialise({});
    run(solid, 2.0);
    EXPECT_NEAR(plate_of(solid).reaction.y(), sign * constrained * strain * width, 0.01 * constrained * strain * width);
    EXPECT_EQ(warned_of_pull(solid) > 0.0, sign < 0.0);
  }
}

/// A column in 3D between smooth walls, without weight.
Case block(double spacing, double width, double height, Wall::ForSoil base) {
  ColumnSpec spec;
  spec.dimension = 3;
  spec.width = width;
  spec.height = height;
  spec.spacing = spacing;
  spec.gravity = 0.0;
  spec.base = base;
  return column(spec);
}

/// A plate on a block's top: the rectangle from `min` to `max` [m].
Plate slab(const Point3& min, const Point3& max, double height) {
  Plate plate;
  plate.name = "slab";
  plate.face = plane(height * Point3::UnitZ(), -Point3::UnitZ());
  plate.face.within.emplace();
  plate.face.within->min = min;
  plate.face.within->max = max;
  return plate;
}

TEST(PlateIn3D, CompressesAColumnAsAnOedometerDoes) {
  constexpr double width = 0.4, height = 0.6, strain = 1e-3;
  for (const double beyond : {0.0, 0.3}) {  // a plate that ends on the walls, one that is drawn beyond them
    Case scene = block(0.1, width, height, Wall::ForSoil::roller);
    Plate plate = slab({-beyond, -beyond, 0.0}, {width + beyond, width + beyond, 1.0}, height);
    plate.speed = Series{{{0.0, 0.0}, {1.0, strain * height}, {2.0, 0.0}}};
    scene.plates = {plate};
    Solid<3> solid(scene);
    EXPECT_FALSE(solid.setup().plates[0].sinks_in);
    solid.initialise({});
    run(solid, 2.0);
    const double stress = -constrained * std::log1p(-strain), force = stress * width * width;
    EXPECT_NEAR(plate_of(solid).displacement.z(), -strain * height, 1e-9);
    EXPECT_NEAR(plate_of(solid).reaction.z(), force, 1e-3 * force);
    EXPECT_NEAR(plate_of(solid).reaction.head<2>().norm(), 0.0, 1e-6 * force);
    for (const Tensor& s : solid.state().particles.stress) EXPECT_NEAR(s[2], -stress, 2e-3 * stress);
  }
}

TEST(PlateIn3D, UnderAForceComesToRestWhereTheSoilBearsIt) {
  constexpr double width = 0.4, height = 0.6, force = 400.0;
  Case scene = block(0.1, width, height, Wall::ForSoil::roller);
  Plate plate = slab({0.0, 0.0, 0.0}, {width, width, 1.0}, height);
  plate.force = Series{{{0.0, force}}};
  scene.plates = {plate};
  Solid<3> solid(scene);
  solid.initialise({});
  EXPECT_NEAR(plate_of(solid).reaction.z(), force, 2e-3 * force);
  const double strain = -std::expm1(-force / (width * width * constrained));
  EXPECT_NEAR(plate_of(solid).displacement.z(), -strain * height, 3e-3 * strain * height);
}

// Smooth walls are planes of symmetry, also for a rough plate that ends on them.
TEST(PlateIn3D, AQuarterBearsAQuarter) {
  constexpr double spacing = 0.1, half = 0.5, side = 0.3, height = 0.4;
  std::vector<Vec<3>> force;
  for (const bool whole : {true, false}) {
    const double width = whole ? 2.0 * half : half, from = whole ? half - side : 0.0, to = whole ? half + side : side;
    Case scene = block(spacing, width, height, Wall::ForSoil::fixed);
    Plate plate = slab({from, from, 0.0}, {to, to, 1.0}, height);
    plate.surface = Plate::Surface::rough;
    plate.speed = Series{{{0.0, 0.0}, {0.05, 0.02}}};
    scene.plates = {plate};
    Solid<3> solid(scene);
    EXPECT_TRUE(solid.setup().plates[0].sinks_in);
    EXPECT_NEAR(solid.setup().plates[0].row, density * spacing * (to - from) * (to - from), 1e-9);
    solid.initialise({});
    run_dry(solid, 0.1, 0.002);
    force.push_back(plate_of(solid).reaction);
  }
  EXPECT_GT(force[0].z(), 100.0);
  EXPECT_NEAR(force[0].z(), 4.0 * force[1].z(), 1e-5 * force[0].z());  // kernels are kept as floats
}

// As in 2D, with six smooth plates that meet at the edges of a cube. Along an edge the forces of the images behind both
// of its plates cancel, as far as kernels, kept as floats, are the same for both of a pair.
TEST(PlateIn3D, AllPlatesTogetherBearTheForcesOfAllImages) {
  constexpr double width = 0.4, spacing = 0.1;
  Case scene = block(spacing, width, width, Wall::ForSoil::none);
  scene.walls.clear();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, 1.0}) {
      Plate plate = slab(Point3::Zero(), Point3::Constant(width), width);
      plate.face.point = side * width * Point3::Unit(axis);
      plate.face.normal = (1.0 - 2.0 * side) * Point3::Unit(axis);
      plate.speed = Series{{{0.0, 0.01 * (1.0 + axis + 3.0 * side)}}};
      scene.plates.push_back(plate);
    }
  scene.solid.initial_velocity = {0.3, -0.2, 0.1};
  Solid<3> solid(scene);
  solid.initialise({});
  for (int k = 0; k < 5; ++k) {
    run(solid, solid.state().time + 0.005);
    const auto& p = solid.state().particles;
    Vec<3> all = Vec<3>::Zero(), borne = all, size = all;
    for (std::size_t i = 0; i < p.size(); ++i)
      all += p.volume[i] * (solid.state().force[i].internal() + solid.state().force[i].stabilising());
    for (const auto& plate : p.plates) {
      borne -= plate.reaction;
      size += plate.reaction.cwiseAbs();
    }
    EXPECT_GT(size.minCoeff(), 10.0);
    EXPECT_LT((all - borne).norm(), 1e-6 * size.norm()) << all.transpose() << ", borne " << borne.transpose();
  }
}

/// Inbox of a field of pore pressure [Pa].
coupling::Inbox field_inbox(const Solid<2>& solid, const std::function<double(const Vec<2>&)>& pressure) {
  coupling::Inbox inbox = wet_inbox<2>(solid, pressure);
  inbox.fields.push_back({std::string(coupling::field::degree_of_saturation), 1,
                          std::vector<double>(solid.state().particles.size(), 1.0)});
  return inbox;
}

TEST(Plate, ThatPullsMoreThanAHundredthIsWarnedOf) {
  constexpr double strain = 1e-4;
  for (const double pull : {0.007, 0.015}) {  // over the pressure before
    Case scene = weightless_column(0.1);
    scene.fluid.representation = FluidCase::Representation::field;
    Plate plate = lid(0.4, 1.0);
    plate.displacement = Series{{{0.0, 0.0}, {1.0, strain}, {2.0, -pull * strain}}};
    scene.plates = {plate};
    Solid<2> solid(scene);
    const auto inbox = field_inbox(solid, [](const Vec<2>&) { return 0.0; });
    solid.initialise(inbox);
    for (std::uint64_t k = 0; k < 2; ++k)
      ASSERT_TRUE(solid.advance({k, 1.0 * static_cast<double>(k), 1.0}, inbox).accepted);
    EXPECT_EQ(warned_of_pull(solid) > 0.0, pull > 0.01);
  }
}

/// Soil twice as wide as the plate at its left end.
Case footing(double spacing, double speed) {
  ColumnSpec spec;
  spec.gravity = 0.0;
  spec.spacing = spacing;
  spec.width = 0.8;
  Case scene = column(spec);
  Plate plate = lid(0.4, spec.height);
  plate.surface = Plate::Surface::rough;
  plate.speed = Series{{{0.0, 0.0}, {0.2, speed}}};
  scene.plates = {plate};
  return scene;
}

TEST(Plate, ThatSinksFarBesideSoilEndsTheRun) {
  constexpr double spacing = 0.1, speed = 0.5;
  Solid<2> solid(footing(spacing, speed));
  ASSERT_TRUE(solid.setup().plates[0].sinks_in);
  solid.initialise({});
  const double due = 0.1 + 1.5 * spacing / speed;  // s, when the plate has sunk by 1.5 spacings
  run(solid, due - 0.02);
  EXPECT_THROW(run(solid, due + 0.02), DivergedError);
  // A plate whose ends lie on walls, or beyond the soil, does not stop.
  Case scene = footing(spacing, speed);
  scene.plates[0].face.points[0].x() = 1.0;
  EXPECT_FALSE(Solid<2>(scene).setup().plates[0].sinks_in);
}

// A state that is saved while the plate moves goes on as the run itself does.
TEST(Plate, GoesOnFromASavedStateToTheBit) {
  const Case scene = footing(0.05, 0.1);
  Solid<2> solid(scene), resumed(scene);
  solid.initialise({});
  run(solid, 0.2);
  Archive saved;
  solid.archive(saved);
  Archive loaded(saved.bytes());
  resumed.archive(loaded);
  for (auto* of : {&solid, &resumed}) run(*of, 0.4);
  EXPECT_GT(solid.state().rebuilds, 2.0);
  EXPECT_EQ(plate_of(solid).displacement, plate_of(resumed).displacement);
  EXPECT_EQ(plate_of(solid).reaction, plate_of(resumed).reaction);
  EXPECT_EQ(solid.state().particles.position, resumed.state().particles.position);
}

// Windows computed as equilibria: the plate bears the stress of the skeleton, continued to it, and the pore pressure.
TEST(Plate, BearsSoilAndWaterInEquilibrium) {
  constexpr double width = 0.4, height = 1.0, strain = 1e-3, datum = 3000.0, slope = 2000.0;  // Pa, Pa/m
  const auto pressure = [](const Vec<2>& x) { return datum - slope * x.y(); };
  for (const bool pushed : {true, false}) {
    Case scene = weightless_column(0.05);
    scene.soils[0].hydraulic_conductivity = 1e-4;
    scene.fluid.representation = FluidCase::Representation::field;
    Plate plate = lid(width, height);
    // The total stress is uniform. That of the skeleton is less by the pressure, and its mean that of the strain.
    const double total = (constrained * strain + datum - 0.5 * slope * height) * width;
    if (pushed) {
      plate.force = Series{{{0.0, total}}};
      plate.start = 0.0;
    } else {
      plate.displacement = Series{{{0.0, 0.0}, {1.0, strain * height}}};
    }
    scene.plates = {plate};
    Solid<2> solid(scene);
    solid.initialise(field_inbox(solid, [](const Vec<2>&) { return 0.0; }));
    const auto outcome = solid.advance({0, 0.0, 1.0}, field_inbox(solid, pressure));
    ASSERT_TRUE(outcome.accepted);
    const auto& motion = plate_of(solid);
    const double water = (datum - slope * height) * width;
    EXPECT_NEAR(motion.water, water, 1e-3 * water);
    EXPECT_NEAR(motion.water + motion.reaction.y(), total, 1e-3 * total);
    EXPECT_NEAR(-motion.displacement.y(), strain * height, 1e-3 * strain * height);
    EXPECT_EQ(solid.counters().at("windows relaxed"), 1.0);
  }
}

}  // namespace
}  // namespace poretwin::solid::test
