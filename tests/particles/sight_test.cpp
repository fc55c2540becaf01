// Which points see each other past walls thinner than the kernel.
#include "common/particles/sight.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/thin_walls.hpp"

#include <gtest/gtest.h>

#include <map>

namespace poretwin {
namespace {

using sph::Sight;

Wall wall(const std::vector<std::array<double, 2>>& points) {
  Wall result;
  for (const auto& [x, y] : points) result.face.points.push_back(Point3(x, y, 0.0));
  return result;
}
Shape box(double x0, double y0, double x1, double y1) {
  Shape shape;
  shape.min = Point3(x0, y0, 0.0);
  shape.max = Point3(x1, y1, 0.0);
  return shape;
}

/// A closed box of 20 x 10 spacings full of water, with a line from its lid down to a free tip, or to the floor, or a
/// slot of the given thickness in spacings.
struct Room {
  Case scene;
  VecArray<2> x;
  sph::Images<2> images;
  VecArray<2> all;
  Sight<2> sight;
  static constexpr double reach = 2.6, margin = 6.0;

  Room(double thickness, double tip, double jitter) {
    scene.fluid.particle_spacing = 1.0;
    const double a = 10.0 - 0.5 * thickness, b = 10.0 + 0.5 * thickness;
    if (thickness > 0.0) {
      scene.walls = {wall(
          {{a, 10.0}, {0.0, 10.0}, {0.0, 0.0}, {20.0, 0.0}, {20.0, 10.0}, {b, 10.0}, {b, tip}, {a, tip}, {a, 10.0}})};
      scene.fluid.regions = {box(0.0, 0.0, 20.0, tip), box(0.0, tip, a, 10.0), box(b, tip, 20.0, 10.0)};
    } else {
      scene.walls = {wall({{20.0, 10.0}, {0.0, 10.0}, {0.0, 0.0}, {20.0, 0.0}, {20.0, 10.0}}),
                     wall({{10.0, 10.0}, {10.0, tip}})};
      scene.fluid.regions = {box(0.0, 0.0, 10.0, 10.0), box(10.0, 0.0, 20.0, 10.0)};
    }
    for (const auto& region : scene.fluid.regions) {
      const auto lattice = fill<2>(region, 1.0, Point3(0.5, 0.5, 0.5), jitter, 3);
      x.insert(x.end(), lattice.position.begin(), lattice.position.end());
    }
    sight = Sight<2>(sides_of_walls(scene, Keeps::water, margin), sight_slack * margin);
    images = sph::images_in_all_orders<2>(x, sight.planes(), reach);
    all = x;
    all.insert(all.end(), images.position.begin(), images.position.end());
  }
  /// Calls f(parent, distance) for all that x sees within reach.
  template <class F>
  void for_each_seen(const Vec<2>& from, F&& f) const {
    Sight<2>::Near near;
    sight.find_near(from, reach, near);
    for (std::size_t j = 0; j < all.size(); ++j) {
      const double r = (all[j] - from).norm();
      if (r >= reach) continue;
      const bool seen = j < x.size()
                            ? sight.open(from, all[j], near)
                            : sight.sees(from, static_cast<Index>(j), x.size(), all, images.by, images.of, near);
      if (seen) f(j < x.size() ? static_cast<Index>(j) : images.parent[j - x.size()], r);
    }
  }
};

TEST(Sight, ASurroundingsAreFilledOnce) {
  // On a lattice that the walls mirror onto itself every particle has the lattice's 21 neighbour positions, by
  // distance.
  for (const double tip : {4.0, 0.0}) {
    const Room room(0.0, tip, 0.0);
    for (const auto& x : room.x) {
      int count = 0;
      double moment = 0.0;
      room.for_each_seen(x, [&](Index, double r) {
        ++count;
        moment += r * r;
      });
      EXPECT_EQ(count, 21) << x.transpose() << ", tip at " << tip;
      EXPECT_NEAR(moment, 4 * 1.0 + 4 * 2.0 + 4 * 4.0 + 8 * 5.0, 1e-6) << x.transpose();
    }
  }
}

TEST(Sight, OfTwoEachSeesTheOther) {
  for (const double thickness : {0.0, 1.0, 2.0, 4.0}) {
    const Room room(thickness, 4.0, 0.3);
    std::map<std::pair<Index, Index>, double> weight;
    for (std::size_t a = 0; a < room.x.size(); ++a)
      room.for_each_seen(room.x[a], [&](Index b, double r) { weight[{static_cast<Index>(a), b}] += room.reach - r; });
    for (const auto& [pair, w] : weight) {
      const auto back = weight.find({pair.second, pair.first});
      ASSERT_NE(back, weight.end()) << thickness;
      EXPECT_NEAR(w, back->second, 1e-6) << thickness;
    }
  }
}

TEST(Sight, NothingIsSeenThroughAWallButAllPastItsTip) {
  for (const double thickness : {0.0, 1.0}) {
    const Room room(thickness, 4.0, 0.0);
    bool past = false;
    for (const auto& x : room.x)
      room.for_each_seen(x, [&](Index b, double) {
        const Vec<2>& y = room.x[b];
        if ((x.x() < 10.0) == (y.x() < 10.0)) return;
        EXPECT_LT(std::min(x.y(), y.y()), 4.0);
        past = true;
      });
    EXPECT_TRUE(past);
  }
}

TEST(Sight, WhatMovesThroughALineIsThrownBackFromEitherSide) {
  const Room room(0.0, 4.0, 0.0);
  for (const double side : {-1.0, 1.0}) {
    Vec<2> x(10.0 - 0.1 * side, 6.0), v(side, 0.5);
    room.sight.keep_inside(Vec<2>(10.0 + -0.2 * side, 6.0), x, v);
    EXPECT_DOUBLE_EQ(x.x(), 10.0 - 0.1 * side) << "not through it";
    x.x() = 10.0 + 0.1 * side;
    room.sight.keep_inside(Vec<2>(10.0 - 0.2 * side, 6.0), x, v);
    EXPECT_NEAR(x.x(), 10.0 - 0.1 * side, 1e-12);
    EXPECT_NEAR(v.x(), 0.0, 1e-12);
    EXPECT_DOUBLE_EQ(v.y(), 0.5);
    x = Vec<2>(10.0 + 0.1 * side, 3.0);
    room.sight.keep_inside(Vec<2>(10.0 - 0.2 * side, 3.0), x, v);
    EXPECT_DOUBLE_EQ(x.x(), 10.0 + 0.1 * side) << "below the tip";
  }
}

}  // namespace
}  // namespace poretwin
