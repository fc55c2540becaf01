// Water in rigid soil, and water that passes faces, shared by several ranks.
#include "tests/tiles/loaded_column.hpp"
#include "tests/tiles/water.hpp"

#include <functional>

namespace poretwin::fluid::test {
namespace {

/// Scenes are run with tiles side by side and with tiles on top of each other, across this box.
void for_cuts(const Shape& shape, const std::function<void(std::shared_ptr<MpiTiling<2>>)>& run) {
  for (const int axis : {0, 1}) run(across<2>(axis, shape.min[axis], shape.max[axis]));
}

/// Seepage follows from the positions alone. Once a kernel rounds another way, velocities differ by some 1e-8, and do
/// not differ by more later; so do those on one rank under a gravity that differs by 1e-11.
constexpr std::size_t before_rounding = 3;

/// Soil that is full of water between two reservoirs, under a lid.
Case confined(const Shape& shape) {
  Case scene = still();
  scene.soils = {block(shape)};
  scene.fluid.regions = {shape};
  const double right = shape.max.x(), top = shape.max.y();
  scene.walls = {wall(line(0.0, 0.0, right, 0.0)), wall(line(right, top, 0.0, top))};
  scene.water_faces = {head_face(line(0.0, top, 0.0, 0.0), 0.6), head_face(line(right, 0.0, right, top), 0.3)};
  scene.gauges = {gauge("discharge", "discharge", {{0.5 * right, top, 0.0}, {0.5 * right, 0.0, 0.0}})};
  return scene;
}

void expect_same_flow(const State<2>& part, const State<2>& whole) {
  ASSERT_EQ(whole.section_flow.size(), 1u);
  EXPECT_NEAR(part.section_flow[0], whole.section_flow[0], scatter * std::abs(whole.section_flow[0]));
  EXPECT_NEAR(part.balance.in, whole.balance.in, scatter * whole.balance.in);
  EXPECT_NEAR(part.balance.out, whole.balance.out, scatter * whole.balance.out);
  EXPECT_NEAR(part.balance.initial, whole.balance.initial, 1e-12);
}

TEST(SharedSeepage, PassesSoilThatIsFull) {
  const Case scene = confined(box(0.0, 0.0, 0.3, 0.2));
  for_cuts(scene.soils[0].shape, [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.expect_as_whole(HUGE_VAL, before_rounding);
    const State<2>& whole = water.whole.state();
    EXPECT_TRUE(whole.full);
    EXPECT_GT(whole.counts.born, 10.0);
    EXPECT_GT(whole.counts.deleted, 10.0);
    expect_same_flow(water.part.state(), whole);
  });
}

/// Borders of soils with other conductivities and porosities lie along the flow and across it, on tiles and between
/// them.
TEST(SharedSeepage, PassesBordersOfSoils) {
  Case scene = confined(box(0.0, 0.0, 0.3, 0.2));
  scene.soils = {block(box(0.0, 0.0, 0.14, 0.1), 1.1e-3), block(box(0.0, 0.1, 0.14, 0.2)),
                 block(box(0.14, 0.0, 0.3, 0.2), 4e-4)};
  scene.soils[2].porosity = 0.3;
  for_cuts(box(0.0, 0.0, 0.3, 0.2), [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.expect_as_whole(HUGE_VAL, 1);
    EXPECT_GT(water.whole.state().counts.born, 10.0);
    expect_same_flow(water.part.state(), water.whole.state());
  });
}

TEST(SharedSeepage, EntersDryGround) {
  for_cuts(box(0.0, 0.2, 0.1, 0.4), [&](auto tiles) {
    Case scene = ponded_column(dx);
    scene.fluid.pressure_tolerance = 1e-14;
    scene.soils[0].suction_head = 0.05;
    scene.gauges.clear();
    Shared<2> water(scene, std::move(tiles));
    EXPECT_EQ(water.whole.state().particles.size(), 0u);
    water.run(20);
    EXPECT_LT(water.errors().largest(), 1e-9);
    water.run(20);
    EXPECT_LT(water.errors().largest(), scatter);
    EXPECT_GT(water.whole.state().counts.born, 10.0);
  });
}

/// A reservoir on the left whose basin sinks, and air on the right, where water leaves at a seepage face.
TEST(SharedSeepage, LeavesABasinAndASeepageFace) {
  Case scene = still();
  scene.soils = {block(box(0.0, 0.0, 0.3, 0.3), 1e-3)};
  scene.fluid.regions = {box(0.0, 0.0, 0.3, 0.2)};
  scene.walls = {wall(line(0.0, 0.0, 0.3, 0.0))};
  scene.water_faces = {head_face(line(0.0, 0.3, 0.0, 0.0), 0.25), head_face(line(0.3, 0.0, 0.3, 0.3), 0.05)};
  scene.water_faces[0].discharge = constant(1e-5);
  scene.water_faces[0].basin_area = Series{{{0.0, 0.2}, {1.0, 0.2}}};
  for_cuts(box(0.0, 0.0, 0.3, 0.2), [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.expect_as_whole(HUGE_VAL, before_rounding);
    const FaceState &part = water.part.state().faces[0], &whole = water.whole.state().faces[0];
    EXPECT_NE(whole.level, 0.25);
    EXPECT_NEAR(part.level, whole.level, 1e-9);
    EXPECT_GT(water.whole.state().counts.deleted, 5.0);
  });
}

/// Free water breaks against rockfill with quadratic drag, and leaves through an outlet behind it. Only the last ranks
/// have rockfill, and only the first free water, at first.
TEST(SharedSeepage, FreeWaterEntersRockfillAndLeaves) {
  Case scene = still();
  scene.soils = {block(box(0.2, 0.0, 0.3, 0.4), 0.3), block(box(0.3, 0.0, 0.4, 0.4), 1e-3)};
  scene.soils[0].seepage_law = &porous::seepage_law("ergun");
  scene.soils[0].own_numbers["grain_diameter"] = 0.035;
  scene.fluid.regions = {box(0.0, 0.0, 0.16, 0.3)};
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.0, 0.0, 0.4, 0.0))};
  scene.water_faces.emplace_back();
  scene.water_faces[0].face = line(0.4, 0.0, 0.4, 0.4);
  scene.water_faces[0].outlet = true;
  for_cuts(box(0.0, 0.0, 0.4, 0.3), [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.expect_as_whole(3e-3);
    water.run(30);
    EXPECT_LT(water.errors().largest(), scatter);
    EXPECT_GT(water.whole.state().counts.drag_rounds, 0.0);
  });
}

/// Water comes in through an inlet in the floor, and another draws it off.
TEST(SharedSeepage, InletsFillAndDrawOff) {
  Case scene = still();
  scene.fluid.regions = {box(0.0, 0.0, 0.4, 0.2)};
  scene.walls = {wall(line(0.0, 1.0, 0.0, 0.0)), wall(line(0.12, 0.0, 0.28, 0.0)), wall(line(0.4, 0.0, 0.4, 1.0))};
  for (const double left : {0.0, 0.28}) {
    scene.water_faces.emplace_back();
    scene.water_faces.back().face = line(left, 0.0, left + 0.12, 0.0);
  }
  scene.water_faces[0].head = constant(0.24);
  scene.water_faces[1].discharge = constant(-0.05);
  for_cuts(box(0.0, 0.0, 0.4, 0.2), [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.expect_as_whole(5e-3);
    water.run(20);
    EXPECT_LT(water.errors().largest(), scatter);
    EXPECT_GT(water.whole.state().counts.deleted, 5.0);
    EXPECT_GT(water.whole.state().counts.born, 5.0);
  });
}

/// A reservoir runs over its crest, and over the soil behind it back into tailwater.
TEST(SharedSeepage, AReservoirRunsOverItsCrest) {
  Case scene = still();
  scene.soils = {block(box(0.0, 0.0, 0.4, 0.1), 1e-6)};
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls = {wall(line(0.0, 0.0, 0.4, 0.0)), wall(line(0.4, 0.1, 0.0, 0.1)), wall(line(0.0, 0.2, 0.4, 0.2)),
                 wall(line(0.4, 0.2, 0.4, 0.1))};
  scene.water_faces = {head_face(line(0.0, 0.2, 0.0, 0.0), 0.32), head_face(line(0.4, 0.0, 0.4, 0.1), 0.05)};
  for_cuts(box(0.0, 0.1, 0.2, 0.3), [&](auto tiles) {
    Shared<2> water(scene, std::move(tiles));
    water.run(40);
    EXPECT_LT(water.errors().largest(), scatter);
    EXPECT_GT(water.whole.state().counts.born, 10.0);
  });
}

TEST(SharedSeepage, PassesSoilInThreeDimensions) {
  Case scene = still();
  scene.general.dimension = 3;
  scene.general.gravity = {0.0, 0.0, -9.81};
  scene.fluid.particle_spacing = 0.05;
  Shape shape;
  shape.max = {0.4, 0.2, 0.2};
  scene.soils = {block(shape)};
  scene.fluid.regions = {shape};
  const auto plane = [](const Point3& point, const Point3& normal) {
    Face face;
    face.point = point;
    face.normal = normal;
    return face;
  };
  for (const Point3& normal : {Point3(Point3::UnitY()), Point3(Point3::UnitZ())}) {
    scene.walls.push_back(wall(plane(Point3::Zero(), normal)));
    scene.walls.push_back(wall(plane(0.2 * normal, -normal)));
  }
  scene.water_faces = {head_face(plane(Point3::Zero(), Point3::UnitX()), 0.6),
                       head_face(plane({0.4, 0.0, 0.0}, -Point3::UnitX()), 0.3)};
  Shared<3> water(scene, across<3>(2, 0.0, 0.2));
  water.expect_as_whole(HUGE_VAL, before_rounding);
  EXPECT_GT(water.whole.state().counts.born, 10.0);
}

/// Pressure and skeleton are solved for together, to pressure::response_tolerance. Soil at rest that drains upwards
/// under a load, and soil that yields under free water.
TEST(SharedSeepage, ASkeletonResponds) {
  for (const bool yields : {false, true}) {
    const Case scene = loaded_column(yields);
    for (const int axis : {0, 1}) {
      Shared<2> water(scene, across<2>(axis, 0.0, axis == 0 ? 0.1 : 0.4),
                      [yields](const VecArray<2>& places) { return loaded_soil(places, yields); });
      water.run(10, 2e-4);
      const Errors error = water.errors();
      EXPECT_LT(error.position, 1e-5);
      EXPECT_LT(error.velocity, 1e-2);
      EXPECT_LT(error.pressure, 1e-3);
      const auto &part = water.part.state().exchanged, &whole = water.whole.state().exchanged;
      EXPECT_LT((part.received - whole.received).norm(), 1e-3 * whole.received.norm());
      EXPECT_NEAR(part.drag_work, whole.drag_work, 1e-2 * std::abs(whole.drag_work));
      EXPECT_GT(water.whole.state().counts.skeleton_iterations, 10.0);
    }
  }
}

}  // namespace
}  // namespace poretwin::fluid::test
