// Images of a lattice in a box continue the lattice beyond walls and corners.
#include "common/particles/images.hpp"
#include "common/geometry/shapes.hpp"
#include "common/particles/kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace poretwin {
namespace {

TEST(Images, APlaneCatchesWhatFellThroughItHoweverDeep) {
  Face floor;
  floor.normal = Point3(0, 0, 1);
  const auto planes = planes_of<3>(floor, 0, 0.0);
  Vec<3> x(0.3, 0.4, -83.0), v(1.0, 0.0, -40.0);
  sph::keep_inside<3>(planes, 0.02, x, v);
  EXPECT_LT((x - Vec<3>(0.3, 0.4, 0.02)).norm(), 1e-12);
  EXPECT_EQ(v, Vec<3>(1.0, 0.0, 0.0));
}

TEST(Images, ARectangleMirrorsOnlyWhatLiesOppositeIt) {
  sph::ImagePlane<3> plane;
  plane.normal = Vec<3>::UnitZ();
  plane.tangent = Vec<3>::UnitX();
  plane.from = 1.0;
  plane.to = 2.0;
  plane.second_tangent = Vec<3>::UnitY();
  plane.second_from = 3.0;
  plane.second_to = 5.0;
  const VecArray<3> points{{1.5, 4.0, 0.1}, {0.9, 4.0, 0.1}, {2.1, 4.0, 0.1}, {1.5, 2.9, 0.1}, {1.5, 5.2, 0.1}};
  const auto images = sph::make_images<3>(points, std::span(&plane, 1), 0.2);
  ASSERT_EQ(images.size(), 1u);
  EXPECT_EQ(images.position[0], Vec<3>(1.5, 4.0, -0.1));
  EXPECT_NEAR(plane.beyond(points[0]), -0.5, 1e-12);
  EXPECT_NEAR(plane.beyond(points[4]), 0.2, 1e-12);
}

TEST(Images, ContinueTheLatticeThroughWallsAndCorners) {
  Shape box;
  box.max = Point3(1.0, 1.0, 0.0);
  const auto lattice = fill<2>(box, 0.1, Point3(0.5, 0.5, 0.5), 0.0, 1);
  ASSERT_EQ(lattice.position.size(), 100u);
  EXPECT_NEAR(lattice.volume, 0.01, 1e-15);
  Face open_box;  // left side down, base, right side up: the domain is on the left
  open_box.points = {Point3(0, 1, 0), Point3(0, 0, 0), Point3(1, 0, 0), Point3(1, 1, 0)};
  const auto planes = planes_of<2>(open_box, 3, 0.4);
  ASSERT_EQ(planes.size(), 3u);
  const auto images = sph::make_images<2>(lattice.position, planes, 0.2);
  // two rows below, two columns each side, two 2x2 corners
  EXPECT_EQ(images.size(), 20u + 2u * 20u + 2u * 4u);
  for (std::size_t k = 0; k < images.size(); ++k) {
    EXPECT_EQ(images.boundaries[k], 8u);
    EXPECT_NEAR(std::remainder(images.position[k].x() - 0.05, 0.1), 0.0, 1e-12);
    EXPECT_NEAR(std::remainder(images.position[k].y() - 0.05, 0.1), 0.0, 1e-12);
    const Vec<2> velocity(0.3, 0.7);
    const Vec<2> image_velocity = images.map[k] * velocity;
    EXPECT_NEAR(image_velocity.norm(), velocity.norm(), 1e-15);
  }
}

TEST(Images, FillOnceWhatLiesBehindACorner) {
  // Kernel sums over soil in a corner and its images, for corners of many angles, measured inside the domain.
  constexpr double dx = 0.05, h = 2.0 * dx, turn = std::numbers::pi / 180.0;
  for (const double angle : {90.0, 120.0, 150.0, 170.0, 180.0, 200.0, 240.0, 270.0}) {
    const auto ray = [&](double degrees) { return Point3(std::cos(degrees * turn), std::sin(degrees * turn), 0.0); };
    Face face;  // line with the domain on its left
    face.points = {ray(angle), Point3::Zero(), ray(0.0)};
    Shape fan;
    fan.kind = Shape::Kind::polygon;
    fan.points = {Point3::Zero()};
    for (int k = 0; k <= 10; ++k) fan.points.push_back(ray(0.1 * k * angle));
    const auto lattice = fill<2>(fan, dx, Point3(0.5, 0.5, 0.5), 0.0, 1);
    auto planes = planes_of<2>(face, 0, 0.0);
    meet_at_corners<2>(planes, 2.0 * h);
    const auto images = sph::make_images<2>(lattice.position, planes, 2.0 * h);
    const auto sum_at = [&](const Vec<2>& x) {
      double sum = 0.0;
      for (const auto* points : {&lattice.position, &images.position})
        for (const auto& y : *points) sum += lattice.volume * sph::WendlandC2<2>::value((y - x).norm(), h);
      return sum;
    };
    for (const double share : {0.25, 0.5, 0.75}) {
      const Vec<2> x = dx * ray(share * angle).head<2>();
      EXPECT_NEAR(sum_at(x), 1.0, 0.15) << angle << " degrees, at " << share;
    }
  }
}

TEST(Images, PeriodicSidesShift) {
  General general;
  general.domain_max = Point3(1.0, 1.0, 1.0);
  general.periodic = {0, 1, 2};
  const VecArray<3> points{Vec<3>(0.05, 0.05, 0.05)};
  const auto images = sph::make_images<3>(points, periodic_planes<3>(general, 0), 0.1);
  EXPECT_EQ(images.size(), 7u);
  for (std::size_t k = 0; k < images.size(); ++k) EXPECT_EQ(images.map[k], Mat<3>::Identity());
}

TEST(Images, APointOnAPeriodicSideHasOneImageAndNoTwin) {
  General general;
  general.domain_max = Point3(0.2, 0.2, 0.0);
  general.periodic = {0, 1};
  for (const double y : {0.0, 1e-20, 0.2}) {
    const VecArray<2> points{Vec<2>(0.1, y)};
    const auto images = sph::make_images<2>(points, periodic_planes<2>(general, 0), 0.03);
    ASSERT_EQ(images.size(), 1u) << y;
    EXPECT_NEAR((images.position[0] - points[0]).norm(), 0.2, 1e-15) << y;
  }
}

}  // namespace
}  // namespace poretwin
