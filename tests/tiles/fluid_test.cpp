// Water that several ranks share moves as on one rank. Every rank also computes the whole water by itself, and compares
// its own particles, by their ids, with those of the whole.
#include "fluid_solver/fluid.hpp"
#include "common/core/error.hpp"
#include "tests/tiles/water.hpp"

#include <set>

namespace poretwin::fluid::test {
namespace {

/// Water of this shape in an open tank with a floor from 0 to `length` [m].
Case tank(double length, Shape water) {
  Case scene = still();
  scene.fluid.regions = {std::move(water)};
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, length, 0.0)),
                 wall(line(length, 0.0, length, 1.0))};
  return scene;
}

/// Adds a box full of water, with walls on all sides.
void add_full_box(double left, double right, double height, Case& scene) {
  scene.fluid.regions.push_back(box(left, 0.0, right, height));
  for (const auto& side : {line(left, height, left, 0.0), line(left, 0.0, right, 0.0), line(right, 0.0, right, height),
                           line(right, height, left, height)})
    scene.walls.push_back(wall(side));
}

/// The initial pressure is solved for to pressure::initial_tolerance.
constexpr double as_solved_first = 1e-7;

TEST(SharedWater, RestsInATankThatIsCut) {
  for (const int axis : {0, 1}) {  // across the floor, and below the surface
    Shared<2> water(tank(0.4, box(0.0, 0.0, 0.4, 0.3)), across<2>(axis, 0.0, axis == 0 ? 0.4 : 0.3));
    EXPECT_LT(water.errors().pressure, as_solved_first);
    water.expect_as_whole(HUGE_VAL);
  }
}

TEST(SharedWater, SloshesAcrossTheCut) {
  Case scene = tank(0.5, box(0.0, 0.0, 0.5, 0.2));
  scene.fluid.initial_wave = 0.2;
  scene.walls[1].water = Wall::ForWater::no_slip;
  scene.water.kinematic_viscosity = 1e-4;
  // A basin on the last rank whose particles have another volume: then all ranks form their matrices in another way.
  for (const auto& side : {line(0.9, 1.0, 0.9, 0.0), line(0.9, 0.0, 1.013, 0.0), line(1.013, 0.0, 1.013, 1.0)})
    scene.walls.push_back(wall(side));
  scene.fluid.regions.push_back(box(0.9, 0.0, 1.013, 0.1));
  Shared<2> water(scene, across<2>(0, 0.0, 0.5));
  EXPECT_NE(water.whole.state().particles.volume.front(), water.whole.state().particles.volume.back());
  water.expect_as_whole(5e-3);
}

TEST(SharedWater, PassesThroughPeriodicSides) {
  Case scene = still();
  scene.general.periodic = {0};
  scene.general.domain_max = {0.4, 1.0, 0.0};
  scene.general.gravity = {3.0, -9.0, 0.0};
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.16)};
  scene.walls = {wall(line(-1.0, 0.0, 2.0, 0.0))};
  scene.walls[0].water = Wall::ForWater::no_slip;
  scene.fluid.initial_velocity = {1.0, 0.0, 0.0};
  Shared<2> water(scene, across<2>(0, 0.0, 0.4));
  const double at_first = water.left();
  water.expect_as_whole(3e-3);
  if (all_ranks().size() > 1) {
    EXPECT_GT(water.left() - at_first, 10.0);
  }
}

/// Vortices, one period each way: nothing prescribes the pressure, and tiles meet their own images at the corners.
TEST(SharedWater, TurnsInAPeriodicBox) {
  Case scene = still();
  scene.general.periodic = {0, 1};
  scene.general.domain_max = {0.4, 0.4, 0.0};
  scene.general.gravity.setZero();
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.4)};
  scene.fluid.initial_vortices = 1.0;
  Shared<2> water(scene, across<2>(1, 0.0, 0.4));
  water.expect_as_whole(3e-3);
}

TEST(SharedWater, FallsAndSloshesInThreeDimensions) {
  Case scene = still();
  scene.general.dimension = 3;
  scene.fluid.particle_spacing = 0.05;
  Shape water;
  water.max = {0.3, 0.25, 0.25};
  scene.fluid.regions = {water};
  const auto side = [&](const Point3& point, const Point3& normal) {
    Wall w;
    w.face.point = point;
    w.face.normal = normal;
    scene.walls.push_back(w);
  };
  side(Point3::Zero(), Point3::UnitX());
  side(Point3::Zero(), Point3::UnitY());
  side(Point3::Zero(), Point3::UnitZ());
  side({0.0, 0.0, 0.25}, -Point3::UnitZ());
  scene.general.gravity = {0.0, -9.81, 0.0};
  Shared<3> held(scene, across<3>(0, 0.0, 0.3));
  held.expect_as_whole(5e-3);
  Shared<3> cut_anew(scene, std::make_shared<MpiTiling<3>>(all_ranks(), 0.1));
  cut_anew.expect_as_whole(5e-3);
}

/// A body of water that only walls surround has its own mean pressure. The first lies on all ranks, the second on the
/// last, and the third has a surface.
TEST(SharedWater, BodiesThatWallsSurroundAreFoundAcrossRanks) {
  Case scene = still();
  add_full_box(0.0, 0.4, 0.2, scene);
  add_full_box(0.7, 0.8, 0.2, scene);
  for (const auto& one : {line(1.1, 1.0, 1.1, 0.0), line(1.1, 0.0, 1.2, 0.0), line(1.2, 0.0, 1.2, 1.0)})
    scene.walls.push_back(wall(one));
  scene.fluid.regions.push_back(box(1.1, 0.0, 1.2, 0.2));
  scene.fluid.initial_wave = 0.2;
  Shared<2> water(scene, across<2>(0, 0.0, 0.4));
  std::set<int> numbers;
  for (const int n : water.part.state().particles.closed_body) numbers.insert(n);
  const auto all = all_ranks().gather_all(std::vector<int>(numbers.begin(), numbers.end()));
  EXPECT_EQ(std::set<int>(all.begin(), all.end()), (std::set<int>{0, 1, 2}));
  EXPECT_LT(water.errors().pressure, as_solved_first);
  water.expect_as_whole(5e-3);
}

/// A line with water on both sides runs across the cuts: particles see each other past its free tips.
TEST(SharedWater, SloshesOnBothSidesOfALine) {
  Case scene = tank(0.4, box(0.0, 0.0, 0.4, 0.2));
  scene.walls.push_back(wall(line(0.1, 0.09, 0.3, 0.09)));
  scene.fluid.initial_wave = 0.2;
  Shared<2> water(scene, across<2>(0, 0.0, 0.4));
  water.expect_as_whole(5e-3);
}

/// Around a block: the parts of the water on a rank between others touch through the water on these only.
TEST(SharedWater, ARingOfWaterIsOneBody) {
  Case scene = still();
  add_full_box(0.0, 0.48, 0.48, scene);
  scene.fluid.regions = {box(0.0, 0.0, 0.48, 0.16), box(0.0, 0.16, 0.16, 0.32), box(0.32, 0.16, 0.48, 0.32),
                         box(0.0, 0.32, 0.48, 0.48)};
  for (const auto& side : {line(0.16, 0.16, 0.16, 0.32), line(0.16, 0.32, 0.32, 0.32), line(0.32, 0.32, 0.32, 0.16),
                           line(0.32, 0.16, 0.16, 0.16)})
    scene.walls.push_back(wall(side));
  scene.fluid.initial_velocity = {0.2, 0.1, 0.0};
  Shared<2> water(scene, across<2>(1, 0.1, 0.38));
  for (const auto& p : {water.whole.state().particles, water.part.state().particles})
    for (std::size_t a = 0; a < p.size(); ++a) EXPECT_EQ(p.closed_body[a], 1);
  water.expect_as_whole(5e-3);
}

/// Rows of cavitating particles weigh 1e6 times as much as others (pressure::cavitating_weight), and solves end at
/// 1e-12 of the norm of the right-hand side, weights included: the other rows are solved to 1e-6.
constexpr double as_solved_beside_cavities = 1e-5;

/// With a mean pressure of zero the water in a full box cavitates under the lid.
TEST(SharedWater, CavitatesAcrossTheCut) {
  Case scene = still();
  add_full_box(0.0, 0.4, 0.2, scene);
  scene.water.cavitation_pressure = -500.0;
  scene.fluid.initial_wave = 0.2;
  Shared<2> water(scene, across<2>(0, 0.0, 0.4));
  water.run(10, 2e-3);
  EXPECT_LT(water.errors().largest(), as_solved_beside_cavities);
  EXPECT_GT(water.whole.state().counts.cavitating, 10.0);
}

/// In the core of a vortex water is under tension. Voids count in the density of their surroundings.
TEST(SharedWater, ADropThatTurnsCavitates) {
  Case scene = still();
  scene.general.domain_max = {0.4, 0.4, 0.0};  // of which the drop is one of four vortices
  scene.general.gravity.setZero();
  scene.fluid.regions = {box(0.0, 0.0, 0.2, 0.2)};
  scene.fluid.initial_vortices = 3.0;
  scene.water.cavitation_pressure = -500.0;
  Shared<2> water(scene, across<2>(0, 0.0, 0.2));
  water.run(30, 1e-3);
  EXPECT_LT(water.errors().largest(), as_solved_beside_cavities);
  EXPECT_GT(water.whole.state().counts.cavitating, 10.0);
}

/// Two drops strike each other on the cut. They have different viscosities, since these depend on a body's first depth,
/// and particles come so close that they collide, also with several others in one window.
TEST(SharedWater, DropsCollideOnTheCut) {
  Case scene = still();
  scene.fluid.regions = {box(0.0, 0.0, 0.12, 0.12), box(0.14, 0.01, 0.26, 0.23)};
  scene.fluid.initial_strain = -40.0;
  Shared<2> water(scene, across<2>(0, 0.0, 0.26));
  water.expect_as_whole(1e-3);
  const auto& speeds = water.whole.state().particles.wave_speed;
  EXPECT_GT(speeds.back(), 1.2 * speeds.front());
}

/// At first only the first ranks have water.
TEST(SharedWater, ADamBreaksIntoTheNextTile) {
  Case scene = tank(0.5, box(0.0, 0.0, 0.2, 0.3));
  Shared<2> water(scene, across<2>(0, 0.1, 0.3));
  scene.general.gravity *= 1.0 + 1e-14;
  Fluid<2> twin(scene);
  twin.initialise({});
  const double at_first = water.left();
  for (int third = 0; third < 3; ++third) {
    for (int k = 0; k < 20; ++k) {
      const double time = twin.state().time, longest = third == 0 ? 3e-3 : HUGE_VAL;
      const double dt = std::min(water.whole.proposal().first, longest);
      water.run(1, longest);
      twin.advance({water.step, time, dt}, {});
    }
    EXPECT_LT(water.errors().largest(), third == 0 ? 1e-9 : scatter);
    differences<2>(water.whole.state().particles, twin.state().particles, dx, [](std::size_t k) {
      return k;
    }).print("twin", twin.state().time);
  }
  if (all_ranks().size() > 1) {
    EXPECT_GT(water.left() - at_first, 10.0);
  }
}

/// Some particles strike several others in one window. Because of the water far away, the search for neighbours takes
/// larger cells, which changes their order.
TEST(SharedWater, TilesAreCutAnewWhereWaterGathers) {
  Case scene = tank(0.8, box(0.0, 0.0, 0.1, 0.3));
  for (const auto& side : {line(9.0, 1.0, 9.0, 0.0), line(9.0, 0.0, 9.1, 0.0), line(9.1, 0.0, 9.1, 1.0)})
    scene.walls.push_back(wall(side));
  scene.fluid.regions.push_back(box(9.0, 0.0, 9.1, 0.04));
  Shared<2> water(scene, std::make_shared<MpiTiling<2>>(all_ranks(), 0.05));
  water.run(40);
  EXPECT_LT(water.errors().largest(), scatter);
  if (all_ranks().size() > 1) {
    EXPECT_GT(water.tiling->cut(), 0u);
  }
}

/// Frames, gauges and checkpoints are those of the whole water; ranks, and one process, go on from a checkpoint.
TEST(SharedWater, IsReadAndStoredAsAWhole) {
  Case scene = tank(0.5, box(0.0, 0.0, 0.2, 0.3));
  scene.gauges = {gauge("energy", "energy"), gauge("front", "extent", {{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}})};
  const auto advance = [](Phase& phase, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t k = from; k < to; ++k) phase.advance({k, 2e-3 * static_cast<double>(k), 2e-3}, {});
  };
  const auto expect_same = [](Phase& shared, Phase& one) {
    const OutputFrame frame = shared.frame();
    const auto gauges = shared.gauges();
    const auto counters = shared.counters();
    if (all_ranks().rank() > 0) return;
    const OutputFrame expected = one.frame();
    const auto numbers_of = [](std::size_t n, std::size_t each, const ParticleWriter& write) {
      ScalarArray numbers(n * each);
      for (std::size_t i = 0; i < n; ++i) write(i, numbers.data() + i * each);
      return numbers;
    };
    const auto expect_close = [](const ScalarArray& found, const ScalarArray& right, const std::string& what) {
      double most = 0.0, differs = found.size() == right.size() ? 0.0 : HUGE_VAL;
      for (std::size_t i = 0; i < std::min(found.size(), right.size()); ++i) {
        most = std::max(most, std::abs(right[i]));
        differs = std::max(differs, std::abs(found[i] - right[i]));
      }
      EXPECT_LE(differs, scatter * most) << what;
    };
    EXPECT_EQ(frame.time, expected.time);
    expect_close(numbers_of(frame.count, 3, frame.position), numbers_of(expected.count, 3, expected.position), "place");
    ASSERT_EQ(frame.fields.size(), expected.fields.size());
    for (std::size_t f = 0; f < frame.fields.size(); ++f) {
      const auto each = static_cast<std::size_t>(frame.fields[f].components);
      expect_close(numbers_of(frame.count, each, frame.fields[f].write),
                   numbers_of(expected.count, each, expected.fields[f].write), frame.fields[f].name);
    }
    const auto right = one.gauges();
    ASSERT_EQ(gauges.size(), right.size());
    EXPECT_GE(gauges.size(), 2u);
    for (std::size_t g = 0; g < gauges.size(); ++g) EXPECT_NEAR(gauges[g].value, right[g].value, scatter) << g;
    EXPECT_EQ(counters.at("particles"), one.counters().at("particles"));
    EXPECT_EQ(counters.at("windows"), one.counters().at("windows"));
  };
  const auto tiles = [] { return std::make_shared<MpiTiling<2>>(all_ranks(), 0.1); };
  const auto shared = make_shared_fluid<2>(scene, tiles()), one = make_fluid(scene);
  for (Phase* phase : {shared.get(), one.get()}) {
    phase->initialise({});
    advance(*phase, 0, 10);
  }
  expect_same(*shared, *one);
  Archive stored;
  shared->archive(stored);
  const auto resumed = make_shared_fluid<2>(scene, tiles()), resumed_by_one = make_fluid(scene);
  Archive for_ranks(stored.bytes());
  resumed->archive(for_ranks);
  for (Phase* phase : {one.get(), resumed.get()}) advance(*phase, 10, 20);
  expect_same(*resumed, *one);
  if (all_ranks().rank() > 0) return;
  Archive for_one(stored.bytes());
  resumed_by_one->archive(for_one);
  for_one.expect_end();
  advance(*resumed_by_one, 10, 20);
  EXPECT_LT((resumed_by_one->gauges()[0].value - one->gauges()[0].value), scatter);
}

/// What several ranks cannot compute is refused by name.
TEST(SharedWater, RefusesWhatItCannotCompute) {
  const auto expect_refused = [](const Case& scene, const std::string& what) {
    try {
      Fluid<2> fluid(scene, std::make_shared<MpiTiling<2>>(all_ranks(), 0.2));
      ADD_FAILURE() << "not refused: " << what;
    } catch (const CaseError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  };
  const Case possible = tank(0.4, box(0.0, 0.0, 0.4, 0.2));
  Case scene = possible;
  scene.soils = {sand()};
  scene.soils[0].shape = box(0.5, 0.0, 0.6, 0.1);
  scene.soils[0].anisotropy = 10.0;
  expect_refused(scene, "soil.anisotropy");
  scene = possible;
  scene.fluid.scheme = FluidCase::Scheme::eisph;
  expect_refused(scene, "fluid.scheme");
  scene = possible;
  scene.walls[1].name = "floor";
  scene.walls[1].shape = box(0.0, -0.1, 0.4, 0.0);
  expect_refused(scene, "\"floor\" has a shape");
  scene = possible;
  scene.gauges = {gauge("balance", "unexplained_impulse")};
  expect_refused(scene, "[[gauge]] \"balance\"");
  Fluid<2> fluid(possible, std::make_shared<MpiTiling<2>>(all_ranks(), 0.2));
  Archive archive;
  EXPECT_THROW(fluid.archive(archive), Error);
}

}  // namespace
}  // namespace poretwin::fluid::test
