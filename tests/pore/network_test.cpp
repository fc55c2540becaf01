// The Voronoi network: its cells fill the soil, and its links are exact where they should be.
#include "pore_solver/network.hpp"

#include "tests/pore/scenes.hpp"

#include <Eigen/Sparse>

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace poretwin::pore::test {
namespace {

Shape trapezium() {
  Shape shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = {{0.0, 0.0, 0.0}, {1.2, 0.0, 0.0}, {0.8, 0.4, 0.0}, {0.4, 0.4, 0.0}};
  return shape;
}

double sum(const ScalarArray& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Network, OfALatticeEachPointHasItsSquare) {
  const Network net = make_network(scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 1.0, 0.5), 0.1, 1.0));
  ASSERT_EQ(net.size(), 50u);
  for (const double v : net.volume) EXPECT_NEAR(v, 0.01, 1e-12);
  EXPECT_EQ(net.links.size(), 9u * 5u + 10u * 4u);
  for (const auto& link : net.links) EXPECT_NEAR(link.transmissibility, 1.0, 1e-9);
}

TEST(Network, CellsFillTheSoilToItsBorder) {
  Case scene = scene_of(sharp(0.4, 1e-4), trapezium(), 0.03, 1.0);
  scene.fluid.jitter = 0.2;
  scene.water_faces = {head_face(line(0.4, 0.4, 0.0, 0.0), 0.3), head_face(line(1.2, 0.0, 0.8, 0.4), 0.0)};
  const Network net = make_network(scene);
  EXPECT_NEAR(sum(net.volume), 0.32, 1e-9);
  double area = 0.0, level = 0.0;
  for (const auto& s : net.segments) {
    area += s.area;
    level += s.level_area;
    EXPECT_GT(s.transmissibility, 0.0);
  }
  EXPECT_NEAR(area, 2.0 * std::sqrt(0.32), 1e-9);
  EXPECT_NEAR(level, 0.8, 1e-9);
}

TEST(Network, SoilsThatTouchAreLinkedAndTheirBorderIsNone) {
  Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 0.5, 0.5), 0.1, 1.0);
  scene.soils.push_back(scene.soils[0]);
  scene.soils[1].shape = box(0.5, 0.0, 1.0, 1.0);  // higher: half its side touches
  scene.water_faces = {head_face(line(0.5, 1.0, 0.5, 0.5), 0.0)};
  const Network net = make_network(scene);
  std::size_t across = 0;
  for (const auto& link : net.links) across += net.soil[link.a] != net.soil[link.b];
  EXPECT_EQ(across, 5u);
  EXPECT_EQ(net.segments.size(), 5u);
  EXPECT_NEAR(sum(net.volume), 0.75, 1e-9);
}

TEST(Network, ASegmentEndsWhereItsFaceDoes) {
  Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 1.0, 0.5), 0.1, 1.0);
  scene.rains = {rain(line(0.53, 0.5, 0.0, 0.5), constant(1e-6))};
  double covered = 0.0;
  for (const auto& s : make_network(scene).segments) covered += s.level_area;
  EXPECT_NEAR(covered, 0.53, 1e-12);
}

TEST(Network, NothingIsLostWhereSoilsMeetOnASlope) {
  // Cells of either soil reach over the border between them, at the surface.
  for (const double dx : {0.2, 0.1, 0.07, 0.05}) {
    Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 1.0, 0.5), dx, 1.0);
    scene.soils.push_back(scene.soils[0]);
    for (Soil& soil : scene.soils) soil.shape.kind = Shape::Kind::polygon;
    scene.soils[0].shape.points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.0, 0.75, 0.0}, {0.0, 0.5, 0.0}};
    scene.soils[1].shape.points = {{1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 1.0, 0.0}, {1.0, 0.75, 0.0}};
    scene.rains = {rain(line(2.0, 1.0, 0.0, 0.5), constant(1e-6))};
    double covered = 0.0;
    for (const auto& s : make_network(scene).segments) covered += s.level_area;
    EXPECT_NEAR(covered, 2.0, 1e-9) << dx;
  }
}

TEST(Network, WallsCutLinks) {
  Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 1.0, 0.5), 0.1, 1.0);
  Wall pile;
  pile.face = line(0.5, 0.2, 0.5, 0.5);
  scene.walls = {pile};
  EXPECT_EQ(make_network(scene).links.size(), 9u * 5u + 10u * 4u - 3u);
}

/// Root mean square error of -lap(u) = f on a unit square, u = cos(pi x) cos(pi y), without flow through the sides.
double poisson_error(int rows, double jitter) {
  Case scene = scene_of(sharp(0.4, 1e-4), box(0.0, 0.0, 1.0, 1.0), 1.0 / rows, 1.0);
  scene.fluid.jitter = jitter;
  const Network net = make_network(scene);
  const auto n = static_cast<Eigen::Index>(net.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& link : net.links)
    for (const auto& [i, j] : {std::pair{link.a, link.b}, std::pair{link.b, link.a}}) {
      entries.emplace_back(i, i, link.transmissibility);
      entries.emplace_back(i, j, -link.transmissibility);
    }
  entries.emplace_back(0, 0, 1.0);  // fixes the constant
  Eigen::VectorXd b(n), exact(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Point3& x = net.position[static_cast<std::size_t>(i)];
    exact[i] = std::cos(M_PI * x.x()) * std::cos(M_PI * x.y());
    b[i] = 2.0 * M_PI * M_PI * exact[i] * net.volume[static_cast<std::size_t>(i)];
  }
  b.array() -= b.mean();
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(b);
  Eigen::VectorXd difference = u - exact;
  difference.array() -= difference.mean();
  return std::sqrt(difference.squaredNorm() / static_cast<double>(n));
}

TEST(Network, PoissonsEquationConvergesAtSecondOrderOnJitteredPoints) {
  for (const double jitter : {0.0, 0.1, 0.25}) {
    const double coarse = poisson_error(20, jitter), fine = poisson_error(40, jitter);
    EXPECT_LT(coarse, 4e-3) << jitter;
    EXPECT_GT(std::log2(coarse / fine), 1.7) << jitter << ": " << coarse << " " << fine;
  }
}

/// A translation changes only elevations; a shear of 0.3 changes links, and the cells still fill the whole area.
TEST(Network, GoesWithSoilThatMoves) {
  Case scene = scene_of(sharp(0.4, 1e-4), trapezium(), 0.03, 1.0);
  scene.water_faces = {head_face(line(1.2, 0.0, 0.8, 0.4), 0.1)};
  const Network drawn = make_network(scene);
  const auto moved = [&](double shear) {
    std::vector<Point3> now = drawn.position;
    for (auto& x : now) x += Point3(0.1 + shear * x.y(), 0.2, 0.0);
    return make_network(scene, drawn, now);
  };
  const auto area = [](const Network& net) { return std::accumulate(net.volume.begin(), net.volume.end(), 0.0); };
  const auto face = [](const Network& net) {
    double sum = 0.0;
    for (const auto& s : net.segments) sum += s.area;
    return sum;
  };
  const Network shifted = moved(0.0);
  ASSERT_EQ(shifted.links.size(), drawn.links.size());
  for (std::size_t i = 0; i < drawn.links.size(); ++i)
    EXPECT_NEAR(shifted.links[i].transmissibility, drawn.links[i].transmissibility, 1e-6);
  for (std::size_t a = 0; a < drawn.size(); ++a) {
    EXPECT_NEAR(shifted.volume[a], drawn.volume[a], 1e-9);
    EXPECT_NEAR(shifted.elevation[a], drawn.elevation[a] + 0.2, 1e-12);
  }
  EXPECT_NEAR(face(shifted), face(drawn), 1e-9);
  const Network sheared = moved(0.3);
  EXPECT_NEAR(area(sheared), area(drawn), 0.01 * area(drawn));
  // The foot of the slope moves by 0.3 of its height less than the crest.
  EXPECT_NEAR(face(sheared), std::hypot(0.4 - 0.3 * 0.4, 0.4), 0.02);
}

}  // namespace
}  // namespace poretwin::pore::test
