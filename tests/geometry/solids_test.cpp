// Bodies in 3D: what is inside, how far the border is, what a file says, and particles laid in them.
#include "common/core/error.hpp"
#include "common/geometry/mesh_file.hpp"
#include "common/geometry/packing.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/solid.hpp"
#include "common/geometry/surfaces.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <random>

namespace poretwin {
namespace {

constexpr double pi = std::numbers::pi;

Shape with_solid(Shape shape, double spacing) {
  const auto none = [](const std::string&) { return std::string(); };
  std::vector<Solid::Part> parts;
  parts.push_back({TriangleMesh(surface_of(shape, spacing, none)), false});
  for (const auto& other : shape.within) parts.push_back({TriangleMesh(surface_of(other, spacing, none)), false});
  for (const auto& other : shape.without) parts.push_back({TriangleMesh(surface_of(other, spacing, none)), true});
  for (const auto& part : parts) EXPECT_FALSE(fault_of(part.mesh)) << fault_of(part.mesh)->what;
  shape.solid = std::make_shared<const Solid>(std::move(parts), spacing);
  return shape;
}

Shape box(double size) {
  Shape shape;
  shape.max = Point3::Constant(size);
  return shape;
}

Shape turned_box() {
  Shape shape = box(1.0);
  shape.placement = Placement{1.0, 40.0, Point3(1, 2, 0.5), Point3(0.3, 0, -2)};
  return shape;
}

Shape ball(double radius) {
  Shape shape;
  shape.kind = Shape::Kind::ball;
  shape.radius = radius;
  return shape;
}

Shape cylinder(double radius, double length, Point3 way) {
  Shape shape;
  shape.kind = Shape::Kind::cylinder;
  shape.ends = {Point3::Zero(), length * way.normalized()};
  shape.radius = radius;
  return shape;
}

Shape polygon(std::vector<Point3> points) {
  Shape shape;
  shape.kind = Shape::Kind::polygon;
  shape.points = std::move(points);
  return shape;
}

TEST(Solids, HaveTheVolumesOfTheirFormulas) {
  constexpr double dx = 0.05;
  EXPECT_NEAR(with_solid(turned_box(), dx).solid->volume(), 1.0, 1e-12);
  EXPECT_NEAR(with_solid(ball(0.5), dx).solid->volume(), pi / 6.0, 1e-12);
  EXPECT_NEAR(with_solid(cylinder(0.5, 2.0, {1, 1, 1}), dx).solid->volume(), 0.5 * pi, 1e-12);
  Shape cone = cylinder(0.6, 1.0, {0, 0, 1});
  cone.kind = Shape::Kind::cone;
  EXPECT_NEAR(with_solid(cone, dx).solid->volume(), pi / 3.0 * 0.36, 1e-12);
  cone.end_radius = 0.3;
  EXPECT_NEAR(with_solid(cone, dx).solid->volume(), pi / 3.0 * (0.36 + 0.18 + 0.09), 1e-12);
  // A section with a notch, clockwise.
  Shape dam = polygon({{4, 0, 0}, {3, 1, 0}, {2, 0.5, 0}, {1, 1, 0}, {0, 0, 0}});
  dam.along = {1};
  dam.to = 3.0;
  EXPECT_NEAR(with_solid(dam, dx).solid->volume(), 3.0 * 2.5, 1e-12);
  Shape ring = polygon({{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}});
  ring.around = {2};
  EXPECT_NEAR(with_solid(ring, dx).solid->volume(), 3.0 * pi, 1e-12);
}

/// The nearest facet decides whether a place is inside; the result is what the winding number says, at notches and ridges, too.
TEST(Solids, AreEnteredThroughTheirNearestFacet) {
  Shape notched;
  notched.kind = Shape::Kind::polygon;
  notched.points = {{0, 0, 0}, {1, 0, 0}, {0.6, 0.5, 0}, {1, 1, 0}, {0, 1, 0}, {0.1, 0.5, 0}};
  notched.along = {1};
  notched.to = 1.0;
  for (const Shape& shape : {notched, turned_box(), ball(0.6), cylinder(0.5, 1.0, Point3(1, 1, 1))}) {
    const TriangleMesh mesh(surface_of(shape, 0.2, [](const std::string&) { return std::string(); }));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> anywhere(-2.5, 1.5);
    for (int k = 0; k < 20000; ++k) {
      const Point3 x(anywhere(random), anywhere(random), anywhere(random));
      const double turns = mesh.winding_number(x);
      if (std::abs(turns - 0.5) < 0.1) continue;  // on the surface
      EXPECT_EQ(mesh.contains(x), turns > 0.5) << x.transpose();
    }
  }
}

TEST(Solids, KnowHowFarTheirBorderIs) {
  const auto solid = with_solid(turned_box(), 0.05).solid;
  const Placement p = *turned_box().placement;
  EXPECT_NEAR(solid->depth(placed(p, {0.5, 0.5, 0.2}, 3), 9.0), 0.2, 1e-12);
  EXPECT_NEAR(solid->depth(placed(p, {0.5, 0.5, -0.2}, 3), 9.0), -0.2, 1e-12);
  EXPECT_NEAR(solid->depth(placed(p, {-0.3, -0.4, 0.5}, 3), 9.0), -0.5, 1e-12);
  EXPECT_EQ(solid->depth(placed(p, {0.5, 0.5, 0.2}, 3), 0.1), 0.1);
  const auto round = with_solid(ball(0.5), 0.05).solid;
  EXPECT_NEAR(round->depth({0.1, 0.2, -0.1}, 9.0), 0.5 - std::sqrt(0.06), 2e-4);
  EXPECT_NEAR(round->depth({1.1, 0.2, -0.1}, 9.0), 0.5 - std::sqrt(1.26), 2e-4);
}

TEST(Solids, AreCutByOthers) {
  Shape shape = box(1.0);
  shape.without = {ball(0.5)};
  Shape half = box(1.0);
  half.max.z() = 0.5;
  shape.within = {half};
  shape = with_solid(shape, 0.02);
  EXPECT_NEAR(shape.solid->volume(), 0.5 - pi / 48.0, 2e-4);
  EXPECT_FALSE(contains(shape, {0.1, 0.1, 0.1}, 3));
  EXPECT_TRUE(contains(shape, {0.4, 0.4, 0.4}, 3));
  EXPECT_FALSE(contains(shape, {0.4, 0.4, 0.6}, 3));
}

TEST(Solids, AreTheSameAsMeshFromAFile) {
  const Shape drawn = with_solid(turned_box(), 0.1);
  std::string text = "solid box\n";
  const auto& [points, facets] = drawn.solid->parts()[0].mesh.triangles();
  for (const auto& f : facets) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const Index i : f)
      text += fmt::format("vertex {:.17g} {:.17g} {:.17g}\n", points[i].x(), points[i].y(), points[i].z());
    text += "endloop\nendfacet\n";
  }
  text += "endsolid\n";
  std::vector<Solid::Part> parts;
  parts.push_back({TriangleMesh(parse_mesh(text, ".stl")), false});
  const Solid read(std::move(parts), 0.1);
  auto one = deepest_in(*drawn.solid, 0.1, {0.5, 0.5, 0.5}), other = deepest_in(read, 0.1, {0.5, 0.5, 0.5});
  pack(*drawn.solid, 0.1, one);
  pack(read, 0.1, other);
  ASSERT_EQ(one.position.size(), other.position.size());
  double apart = 0.0;
  for (std::size_t a = 0; a < one.position.size(); ++a)
    apart = std::max(apart, (one.position[a] - other.position[a]).norm());
  EXPECT_LT(apart, 1e-9);
}

/// A cube of one metre as eight points and six squares.
const std::vector<Point3> cube_points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const std::vector<std::array<int, 4>> cube_sides{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                                 {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

std::string obj(std::size_t sides) {
  std::string text = "# a cube\no cube\n";
  for (const auto& x : cube_points) text += fmt::format("v {} {} {}\n", x.x(), x.y(), x.z());
  for (std::size_t i = 0; i < sides; ++i)
    text += fmt::format("f {}//1 {}//1 {}//1 {}//1\n", cube_sides[i][0] + 1, cube_sides[i][1] + 1, cube_sides[i][2] - 8,
                        cube_sides[i][3] + 1);
  return text;
}

std::string ascii_ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
      "red\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& x : cube_points) text += fmt::format("{} {} {} 255\n", x.x(), x.y(), x.z());
  for (const auto& side : cube_sides) text += fmt::format("4 {} {} {} {}\n", side[0], side[1], side[2], side[3]);
  return text;
}

template <class T>
void append(std::string& bytes, T value, bool swapped = false) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if (swapped) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string binary_ply(bool big_endian) {
  std::string text = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
      "property double z\nelement face 6\nproperty list uchar uint vertex_index\nend_header\n",
      big_endian ? "big" : "little");
  for (const auto& x : cube_points)
    for (int d = 0; d < 3; ++d) append(text, x[d], big_endian);
  for (const auto& side : cube_sides) {
    append(text, std::uint8_t{4});
    for (const int i : side) append(text, static_cast<std::uint32_t>(i), big_endian);
  }
  return text;
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes.replace(0, 5, "solid");
  bytes[10] = '\0';
  append(bytes, std::uint32_t{12});
  for (const auto& side : cube_sides)
    for (const auto& facet : {std::array{0, 1, 2}, {0, 2, 3}}) {
      for (int k = 0; k < 3; ++k) append(bytes, 0.0F);
      for (const int c : facet)
        for (int d = 0; d < 3; ++d)
          append(bytes,
                 static_cast<float>(cube_points[static_cast<std::size_t>(side[static_cast<std::size_t>(c)])][d]));
      append(bytes, std::uint16_t{0});
    }
  return bytes;
}

TEST(MeshFile, IsReadInAllItsFormats) {
  for (const auto& [text, ending] : {std::pair<std::string, const char*>{obj(6), ".obj"},
                                     {ascii_ply(), ".ply"},
                                     {binary_ply(false), ".ply"},
                                     {binary_ply(true), ".ply"},
                                     {binary_stl(), ".stl"}}) {
    const TriangleMesh mesh(parse_mesh(text, ending));
    EXPECT_EQ(mesh.triangles().points.size(), 8) << ending;
    EXPECT_EQ(mesh.size(), 12) << ending;
    EXPECT_NEAR(mesh.volume(), 1.0, 1e-12) << ending;
    EXPECT_FALSE(fault_of(mesh)) << ending;
  }
}

std::string refusal(const std::string& text, const char* ending) {
  try {
    parse_mesh(text, ending);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "none";
}

TEST(MeshFile, IsRefusedWithTheLine) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal("solid a\nfacet normal 0 0 1\nouter loop\nvertex 1 2 x\n", ".stl"),
              HasSubstr("line 4: expected three coordinates, found 'vertex 1 2 x'"));
  EXPECT_THAT(refusal("solid a\nhello\n", ".stl"), HasSubstr("line 2"));
  EXPECT_THAT(refusal("v 0 0 0\nf 1 2 3\n", ".obj"), HasSubstr("line 2: expected numbers of points up to 1"));
  EXPECT_THAT(refusal(binary_stl().substr(0, 300), ".stl"), HasSubstr("announces 12 facets"));
  EXPECT_THAT(refusal(binary_ply(false).substr(0, 300), ".ply"), HasSubstr("ends amid"));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\nelement vertex 99999999999\n", ".ply"), HasSubstr("line 3"));
  EXPECT_THAT(refusal("", ".obj"), HasSubstr("found none"));
  EXPECT_THAT(refusal("", ".dxf"), HasSubstr(".stl, .obj or .ply"));
}

TEST(MeshFile, FaultsAreNamedWithTheirPlace) {
  using testing::HasSubstr;
  const auto fault = [](Triangles mesh) { return fault_of(TriangleMesh(std::move(mesh))); };
  const auto open = fault(parse_mesh(obj(5), ".obj"));
  ASSERT_TRUE(open);
  EXPECT_THAT(open->what, HasSubstr("open"));
  EXPECT_NEAR(open->at.x(), 0.0, 1e-12);  // the sixth side's
  Triangles turned = parse_mesh(obj(6), ".obj");
  std::swap(turned.facets[3][0], turned.facets[3][1]);
  ASSERT_TRUE(fault(turned));
  EXPECT_THAT(fault(turned)->what, HasSubstr("turned against each other"));
  Triangles two = parse_mesh(obj(6), ".obj"), other = two;
  for (auto& x : other.points) two.points.push_back(x + Point3(0.5, 0.4, 0.3));
  for (const auto& f : other.facets) two.facets.push_back({f[0] + 8, f[1] + 8, f[2] + 8});
  ASSERT_TRUE(fault(two));
  EXPECT_THAT(fault(two)->what, HasSubstr("cross each other"));
}

TEST(Terrain, IsTheBodyBelowItsHeights) {
  const std::string esri =
      "ncols 3\nnrows 2\nxllcorner 9.5\nyllcorner 19.5\ncellsize 1\nNODATA_value -9999\n4 5 6\n1 2 3\n";
  const std::string xyz = "10 20 1\n11 20 2\n12 20 3\n10 21 4\n11 21 5\n12 21 6\n";
  for (const auto& [text, ending] : {std::pair{esri, ".asc"}, {xyz, ".xyz"}}) {
    const TriangleMesh body(parse_terrain(text, ending, -1.0));
    EXPECT_FALSE(fault_of(body)) << ending;
    EXPECT_NEAR(body.volume(), 2.0 * (3.5 + 1.0), 1e-9) << ending;
    EXPECT_TRUE(body.contains({11.0, 20.5, 3.4})) << ending;
    EXPECT_FALSE(body.contains({11.0, 20.5, 3.6})) << ending;
  }
  const auto refused = [&](std::string text, const char* ending, double bottom) {
    try {
      parse_terrain(text, ending, bottom);
    } catch (const CaseError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused(esri, ".asc", 2.5), HasSubstr("at 1 m at [10, 20] m"));
  EXPECT_THAT(refused(esri.substr(0, esri.size() - 4), ".asc", 0.0), HasSubstr("2 rows of 3 heights"));
  std::string hole = esri;
  EXPECT_THAT(refused(hole.replace(hole.find("4 5 6"), 5, "4 -9999 6"), ".asc", 0.0),
              HasSubstr("no height at [11, 21] m"));
  EXPECT_THAT(refused(xyz.substr(0, 40), ".xyz", 0.0), HasSubstr("whole grid"));
}

TEST(Surfaces, HaveAtMostOneImageForEachWayRoundACorner) {
  // A turned box: its faces, edges and corners have one, three and seven images.
  const Shape shape = with_solid(turned_box(), 0.1);
  Surfaces walls;
  walls.add(shape.solid, true, 3);
  const auto at = [&](double x, double y, double z) { return VecArray<3>{placed(*shape.placement, {x, y, z}, 3)}; };
  EXPECT_EQ(walls.images(at(0.5, 0.5, 0.5), 0.26).size(), 0);
  EXPECT_EQ(walls.images(at(0.5, 0.5, 0.1), 0.26).size(), 1);
  EXPECT_EQ(walls.images(at(0.5, 0.1, 0.1), 0.26).size(), 3);
  EXPECT_EQ(walls.images(at(0.9, 0.1, 0.2), 0.26).size(), 7);
  const auto image = walls.images(at(0.5, 0.5, 0.1), 0.26);
  EXPECT_LT((image.position[0] - placed(*shape.placement, {0.5, 0.5, -0.1}, 3)).norm(), 1e-12);
  EXPECT_EQ(image.boundaries[0], 1u << 3);
  // Before an edge that turns away there is none.
  Surfaces obstacle;
  obstacle.add(shape.solid, false, 0);
  EXPECT_EQ(obstacle.images(at(0.5, 0.5, -0.1), 0.26).size(), 1);
  EXPECT_EQ(obstacle.images(at(0.5, -0.1, -0.1), 0.26).size(), 0);
}

TEST(Surfaces, LetNothingThrough) {
  const Shape shape = with_solid(ball(1.0), 0.1);
  Surfaces walls;
  walls.add(shape.solid, true, 0);
  walls.add(Vec<3>(0, 0, -0.5), Vec<3>(0, 0, 1), 1);
  std::uint32_t random = 1;
  const auto next = [&] {
    return static_cast<double>((random = random * 1664525u + 1013904223u) >> 8) / (1u << 24) - 0.5;
  };
  for (const double way : {0.1, 3.0, 1000.0})
    for (int k = 0; k < 2000; ++k) {
      Vec<3> from;
      do from = Vec<3>(next(), next(), next()) * 2.0;
      while (!walls.holds(from));
      Vec<3> to = from + way * Vec<3>(next(), next(), next()), v = (to - from).normalized();
      walls.keep_inside(from, 0.1, to, v);
      ASSERT_TRUE(walls.holds(to)) << to.transpose();
    }
}

/// The outermost particles' distance from the border, in spacings: least and mean of those within 0.9.
std::pair<double, double> outermost(const Lattice<3>& lattice, const Solid& solid, double dx) {
  double least = 1e300, sum = 0.0, n = 0.0;
  for (const auto& x : lattice.position) {
    const double depth = solid.depth(x, 9.0) / dx;
    least = std::min(least, depth);
    if (depth < 0.9) {
      sum += depth;
      n += 1.0;
    }
  }
  return {least, sum / n};
}

TEST(Packing, FillsBodiesEvenlyUpToHalfASpacing) {
  constexpr double dx = 0.1;
  Shape cut = ball(0.6);
  Shape lower = box(2.0);
  lower.min = Point3(-1, -1, -1);
  lower.max = Point3(1, 1, 0.1);
  cut.within = {lower};
  const std::map<std::string, Shape> shapes{{"mesh of a turned box", turned_box()},
                                            {"cylinder", cylinder(0.5, 1.0, {0, 0, 1})},
                                            {"slanted cylinder", cylinder(0.5, 1.0, {1, 2, 3})},
                                            {"ball", ball(0.6)},
                                            {"cut ball", cut}};
  for (const auto& [name, drawn] : shapes) {
    const Shape shape = with_solid(drawn, dx);
    auto lattice = deepest_in(*shape.solid, dx, {0.5, 0.5, 0.5});
    pack(*shape.solid, dx, lattice);
    const double volume = lattice.volume * static_cast<double>(lattice.position.size());
    EXPECT_NEAR(volume, shape.solid->volume(), 1e-9) << name;
    EXPECT_NEAR(lattice.volume, dx * dx * dx, 1e-3 * dx * dx * dx) << name;
    const auto [least, mean] = outermost(lattice, *shape.solid, dx);
    EXPECT_GT(least, 0.35) << name;
    EXPECT_NEAR(mean, 0.5, 0.08) << name;
  }
}

TEST(Packing, LeavesALatticeThatFitsAsItIs) {
  const Shape shape = with_solid(box(1.0), 0.1);
  auto lattice = deepest_in(*shape.solid, 0.1, {0.5, 0.5, 0.5});
  const auto before = lattice.position;
  ASSERT_EQ(before.size(), 1000);
  pack(*shape.solid, 0.1, lattice);
  double moved = 0.0;
  for (std::size_t a = 0; a < before.size(); ++a) moved = std::max(moved, (lattice.position[a] - before[a]).norm());
  EXPECT_LT(moved, 1e-9);
}

TEST(Packing, TurnsTheRowsOfATurnedBoxWithIt) {
  const Shape shape = with_solid(turned_box(), 0.1);
  const auto lattice = lay<3>(shape, 0.1, {0.5, 0.5, 0.5}, 0.0, 1);
  ASSERT_EQ(lattice.position.size(), 1000);
  EXPECT_NEAR(lattice.volume, 1e-3, 1e-15);
  EXPECT_LT((lattice.position[0] - placed(*shape.placement, {0.05, 0.05, 0.05}, 3)).norm(), 1e-12);
  for (const auto& x : lattice.position) EXPECT_GT(shape.solid->depth(x, 1.0), 0.05 - 1e-9);
}

}  // namespace
}  // namespace poretwin
