// Lattices in shapes; the soil at a place.
#include "common/geometry/shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace poretwin {
namespace {

Shape polygon(std::vector<Point3> points) {
  Shape shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = std::move(points);
  return shape;
}

std::size_t filled(const Shape& shape, double spacing, std::span<const Shape> later = {}) {
  return fill<2>(shape, spacing, Point3(0.5, 0.5, 0.5), 0.0, 1, later).position.size();
}

TEST(Fill, WhatLiesOnASlopeIsOutsideOnEitherSide) {
  // An embankment with slopes of 1:1 on which lattice points lie: rows of 118, 116 .. 40.
  const Shape dam = polygon({Point3(0, 0, 0), Point3(1.2, 0, 0), Point3(0.8, 0.4, 0), Point3(0.4, 0.4, 0)});
  const auto lattice = fill<2>(dam, 0.01, Point3(0.5, 0.5, 0.5), 0.0, 1);
  EXPECT_EQ(lattice.position.size(), 3160u);
  Vec<2> centre = Vec<2>::Zero();
  for (const auto& x : lattice.position) centre += x / static_cast<double>(lattice.position.size());
  EXPECT_NEAR(centre.x(), 0.6, 1e-12) << "as symmetric as the dam";
}

TEST(Fill, WhatLiesOnAnEdgeOfTwoIsTakenOnce) {
  const Shape square = polygon({Point3(0, 0, 0), Point3(1, 0, 0), Point3(1, 1, 0), Point3(0, 1, 0)});
  const std::array<Shape, 2> halves{polygon({Point3(0, 0, 0), Point3(1, 0, 0), Point3(1, 1, 0)}),
                                    polygon({Point3(0, 0, 0), Point3(1, 1, 0), Point3(0, 1, 0)})};
  const std::span<const Shape> both = halves;
  EXPECT_EQ(filled(square, 0.1), 100u);
  EXPECT_EQ(filled(halves[0], 0.1), 45u);
  EXPECT_EQ(filled(halves[0], 0.1, both.subspan(1)), 55u);
  EXPECT_EQ(filled(halves[1], 0.1, both.subspan(2)), 45u);
}

TEST(Fill, NothingIsLostWhereNoPointLiesOnAnEdge) {
  const Shape slope = polygon({Point3(0, 0, 0), Point3(2, 0, 0), Point3(0, 1, 0)});
  EXPECT_NEAR(static_cast<double>(filled(slope, 0.013)) * 0.013 * 0.013, 1.0, 0.01);
}

TEST(Fill, ATurnedRectangleHasRowsAlongItsSides) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  const auto turned = [&](double x, double y) { return Point3(3.0 + c * x - s * y, -1.0 + s * x + c * y, 0.0); };
  const Shape rectangle = polygon({turned(0, 0), turned(2, 0), turned(2, 1), turned(0, 1)});
  const auto lattice = fill<2>(rectangle, 0.1, Point3(0.5, 0.5, 0.5), 0.0, 1);
  ASSERT_EQ(lattice.position.size(), 200u);
  EXPECT_NEAR(lattice.volume, 0.01, 1e-12);
  const Vec<2> first = turned(0.05, 0.05).head<2>(), next = turned(0.15, 0.05).head<2>(),
               last = turned(1.95, 0.95).head<2>();
  EXPECT_LT((lattice.position[0] - first).norm(), 1e-12);
  EXPECT_LT((lattice.position[1] - next).norm(), 1e-12);
  EXPECT_LT((lattice.position[199] - last).norm(), 1e-12);
}

TEST(SoilAt, OfSoilsThatOverlapTheFirstCounts) {
  Case scene;
  scene.soils.resize(2);
  scene.soils[0].shape = polygon({Point3(0, 0, 0), Point3(2, 0, 0), Point3(0, 2, 0)});
  scene.soils[1].shape.kind = Shape::Kind::box;
  scene.soils[1].shape.max = Point3(2, 2, 0);
  scene.fluid.regions = {scene.soils[0].shape};
  EXPECT_EQ(soil_at(scene, Point3(0.5, 0.5, 0)), &scene.soils[0]);
  EXPECT_EQ(soil_at(scene, Point3(1.5, 1.5, 0)), &scene.soils[1]);
  EXPECT_EQ(soil_at(scene, Point3(2.5, 1.5, 0)), nullptr);
  EXPECT_TRUE(in_fluid_region(scene, Point3(0.5, 0.5, 0)));
  EXPECT_FALSE(in_fluid_region(scene, Point3(1.5, 1.5, 0)));
}

}  // namespace
}  // namespace poretwin
