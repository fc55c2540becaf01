// Shapes of a case in 3D: read, placed, and refused with file, line, key and place.
#include "tests/case/case_file.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/solid.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace poretwin {
namespace {

using testing::HasSubstr;

class Bodies : public CaseFile {
 protected:
  void save(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
};

/// A tank of planes with water in it.
const std::string tank = R"([case]
dimension = 3
end_time = 1
[fluid]
particle_spacing = 0.05
[solid]
model = "rigid"
[[fluid.region]]
min = [0, 0, 0]
max = [1, 1, 0.5]
[[wall]]
point = [0, 0, 0]
normal = [1, 0, 0]
[[wall]]
point = [1, 0, 0]
normal = [-1, 0, 0]
[[wall]]
point = [0, 0, 0]
normal = [0, 1, 0]
[[wall]]
point = [0, 1, 0]
normal = [0, -1, 0]
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
)";

/// A tetrahedron of one metre, without some of its facets.
std::string tetrahedron(std::size_t facets) {
  const std::vector<std::string> all{"f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"};
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  for (std::size_t f = 0; f < facets; ++f) text += all[f] + "\n";
  return text;
}

TEST_F(Bodies, AreReadPlacedAndCut) {
  save("tip.obj", tetrahedron(4));
  const Case scene = read(tank + R"([[soil]]
shape = "mesh"
file = "tip.obj"
scale = 0.5
turn = 90
move = [1, 0, 0]
[[soil]]
shape = "cylinder"
ends = [[0.2, 0.7, 0], [0.2, 0.7, 0.4]]
radius = 0.2
within = [{ shape = "box", min = [0, 0, 0.1], max = [1, 1, 0.3] }]
without = [{ shape = "box", min = [0, 0, 0], max = [0.2, 1, 1] }]
)");
  EXPECT_NEAR(measure(scene.soils[0].shape, 3), 0.125 / 6.0, 1e-12);
  EXPECT_NEAR(scene.soils[0].shape.solid->bounds().first.x(), 0.5, 1e-12);
  EXPECT_NEAR(scene.soils[0].shape.solid->bounds().second.y(), 0.5, 1e-12);
  EXPECT_NEAR(measure(scene.soils[1].shape, 3), 0.5 * std::numbers::pi * 0.04 * 0.2, 2e-5);
}

TEST_F(Bodies, ChangeTheDigestWithTheirFile) {
  const std::string soil = "[[soil]]\nshape = \"mesh\"\nfile = \"tip.obj\"\n";
  save("tip.obj", tetrahedron(4));
  const std::string before = read(tank + soil).digest();
  save("tip.obj", changed(tetrahedron(4), "v 0 0 1", "v 0 0 0.9"));
  EXPECT_NE(read(tank + soil).digest(), before);
}

TEST_F(Bodies, AreRefusedWithTheirPlace) {
  const std::string mesh = "[[soil]]\nshape = \"mesh\"\nfile = \"tip.obj\"\n";
  EXPECT_THAT(complaint(tank + mesh), HasSubstr("key 'soil[0].file': 'tip.obj'"));
  save("tip.obj", tetrahedron(3));
  EXPECT_THAT(complaint(tank + mesh),
              testing::AllOf(HasSubstr("case.toml:28: key 'soil[0].file'"), HasSubstr("open there"),
                             HasSubstr(" m; expected a closed surface")));
  save("tip.obj", changed(tetrahedron(4), "f 1 3 2", "f 1 2 3"));
  EXPECT_THAT(complaint(tank + mesh), HasSubstr("turned against each other, at ["));
  save("tip.obj", changed(tetrahedron(4), "v 1 0 0", "v one 0 0"));
  EXPECT_THAT(complaint(tank + mesh), HasSubstr("'tip.obj': line 2: expected three coordinates"));
  save("tip.obj", tetrahedron(4));
  EXPECT_THAT(complaint(tank + mesh + "scale = 1000\n"), HasSubstr("in other units?"));
  EXPECT_THAT(complaint(tank + mesh + "scale = 0.01\n"), HasSubstr("no particle fits"));
  const std::string polygon = "[[soil]]\nshape = \"polygon\"\npoints = [[0, 0], [1, 0], [1, 0.3]]\n";
  EXPECT_THAT(complaint(tank + polygon), HasSubstr("extruded along or revolved around one axis"));
  EXPECT_THAT(complaint(tank + polygon + "along = [\"y\"]\nfrom = 1\nto = 0\n"), HasSubstr("soil[0].to"));
  EXPECT_THAT(complaint(tank + "[[soil]]\nshape = \"cylinder\"\nends = [[0, 0, 0], [0, 0, 0]]\nradius = 1\n"),
              HasSubstr("one point twice"));
  EXPECT_THAT(complaint(tank + "[[soil]]\nshape = \"cone\"\nends = [[0, 0, 0], [0, 0, 1]]\nradius = 1\n"),
              HasSubstr("'soil[0].end_radius' is missing"));
  EXPECT_THAT(
      complaint(
          tank +
          "[[soil]]\nmin = [0, 0, 0]\nmax = [0.2, 0.2, 0.2]\nwithin = [{ min = [0.5, 0.5, 0.5], max = [1, 1, 1] }]\n"),
      HasSubstr("nothing is left"));
}

TEST_F(Bodies, AsWallsAreRefusedWhereTheyAreNotRight) {
  const std::string obstacle =
      "[[wall]]\nname = \"pier\"\nshape = \"box\"\nmin = [0.4, 0.4, 0]\nmax = [0.6, 0.6, 1]\ndomain = \"outside\"\n";
  const std::string cut = changed(tank, "max = [1, 1, 0.5]",
                                  "max = [1, 1, 0.5]\nwithout = [{ min = [0.4, 0.4, -1], max = [0.6, 0.6, 1] }]");
  EXPECT_EQ(complaint(cut + obstacle), "no complaint");
  EXPECT_THAT(
      complaint(tank + obstacle),
      testing::AllOf(HasSubstr("'fluid.region[0]'"), HasSubstr("water lies in wall[5] \"pier\", for example at [0.4")));
  EXPECT_THAT(complaint(tank + changed(obstacle, "outside", "inside")), HasSubstr("water lies outside of wall[5]"));
  EXPECT_THAT(complaint(cut + changed(obstacle, "max = [0.6,", "max = [0.5,")), HasSubstr("0.1 m thick at [0.4"));
  EXPECT_THAT(complaint(changed(cut, "model = \"rigid\"", "model = \"elastic\"") + obstacle +
                        "[[soil]]\nmin = [0, 0, 0]\nmax = [0.2, 0.2, 0.2]\n"),
              testing::AllOf(HasSubstr("'wall[5].shape'"), HasSubstr("turns away from the soil by 90 degrees")));
  EXPECT_THAT(complaint(cut + obstacle + "[[water_face]]\npoint = [0.9, 0, 0]\nnormal = [-1, 0, 0]\nhead = 0.4\n"),
              HasSubstr("found a [[water_face]]"));
  EXPECT_THAT(complaint(cut + obstacle + "point = [0, 0, 0]\n"), HasSubstr("is not known"));
}

/// Soil, and a wall with a shape around it or in it.
std::string in_soil(const std::string& soil, const std::string& wall) {
  return "[case]\ndimension = 3\nend_time = 1\n[solid]\nmodel = \"elastic\"\nparticle_spacing = 0.05\n[[soil]]\n" +
         soil + "[[wall]]\n" + wall;
}

TEST_F(Bodies, AsWallsBesideMovingSoilAreRefusedWhereImagesAreNotRight) {
  const std::string turned = "turn = 20\naxis = [1, 0, 0]\n",
                    cylinder = "shape = \"cylinder\"\nends = [[0, 0, 0], [0, 0, 1]]\n",
                    lower = "within = [{ min = [-1, -1, -1], max = [1, 1, 0.5] }]\n";
  const std::string box = in_soil("min = [0, 0, 0]\nmax = [0.5, 0.5, 0.5]\n" + turned,
                                  "shape = \"box\"\nmin = [0, 0, 0]\nmax = [0.5, 0.5, 1]\n" + turned);
  const std::string well = in_soil(cylinder + "radius = 0.4\n" + lower, cylinder + "radius = 0.4\n");
  EXPECT_EQ(complaint(box), "no complaint");
  EXPECT_EQ(complaint(box + "soil = \"frictional\"\nfriction_angle = 20\n"), "no complaint");
  EXPECT_EQ(complaint(well), "no complaint");
  EXPECT_THAT(complaint(box + "soil = \"rough\"\n"), HasSubstr("\"rough\""));
  EXPECT_THAT(complaint(changed(box, "max = [0.5, 0.5, 1]", "max = [0.3, 0.5, 1]")),
              testing::AllOf(HasSubstr("'soil[0]'"), HasSubstr("soil lies outside of wall[0]")));
  EXPECT_THAT(complaint(changed(changed(well, "radius = 0.4", "radius = 0.2"), "radius = 0.4", "radius = 0.2")),
              HasSubstr("radius of curvature of 0.2 m"));
  const std::string tilted =
      in_soil("min = [0.1, 0.1, 0.1]\nmax = [0.4, 0.4, 0.4]\n",
              "shape = \"box\"\nmin = [-2, -2, 0.1]\nmax = [2, 2, 2]\nturn = -3\naxis = [0, 1, 0]\n");
  EXPECT_THAT(complaint(tilted), HasSubstr("at an angle"));
  const std::string prism =
      "shape = \"polygon\"\npoints = [[0, 0], [0.25, 1], [-0.25, 1]]\nalong = [\"x\"]\nfrom = 0\nto = 0.5\n";
  EXPECT_THAT(complaint(in_soil(prism, prism)), HasSubstr("meet at less than 60 degrees"));
  // A pile through the soil; its ends turn away from the soil where none comes, or in it.
  const std::string pile =
      in_soil(
          "min = [0, 0, 0]\nmax = [1, 1, 0.5]\nwithout = [{ shape = \"cylinder\", ends = [[0, 0, -1], "
          "[0, 0, 2]], radius = 0.4 }]\n",
          "shape = \"cylinder\"\nends = [[0, 0, -1], [0, 0, 2]]\nradius = 0.4\ndomain = \"outside\"\n") +
      "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  EXPECT_EQ(complaint(pile), "no complaint");
  EXPECT_THAT(complaint(changed(changed(pile, "2]], radius", "0.3]], radius"), "2]]\nradius", "0.3]]\nradius")),
              HasSubstr("turns away from the soil by 90 degrees"));
}

TEST_F(Bodies, ASceneWithAHoleInItsShapedWallLeaks) {
  // A cup with a hole in its bottom.
  const std::string cup = R"([case]
dimension = 3
end_time = 1
[fluid]
particle_spacing = 0.05
[solid]
model = "rigid"
[[fluid.region]]
shape = "cylinder"
ends = [[0, 0, 0.2], [0, 0, 0.6]]
radius = 0.5
[[wall]]
shape = "cylinder"
ends = [[0, 0, 0], [0, 0, 1]]
radius = 0.7
domain = "outside"
without = [{ shape = "cylinder", ends = [[0, 0, 0.2], [0, 0, 1.1]], radius = 0.5 }]
)";
  EXPECT_EQ(complaint(cup), "no complaint");
  EXPECT_THAT(
      complaint(changed(cup, "radius = 0.5 }]",
                        "radius = 0.5 }, { shape = \"cylinder\", ends = [[0, 0, -1], [0, 0, 1]], radius = 0.2 }]")),
      HasSubstr("water can run out at"));
}

TEST_F(Bodies, InThePlaneAreMovedToo) {
  const std::string plane = R"([case]
end_time = 1
[fluid]
particle_spacing = 0.05
[solid]
model = "rigid"
[[wall]]
points = [[0, 1], [0, 0], [1, 0], [1, 1]]
[[fluid.region]]
shape = "polygon"
points = [[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5]]
turn = 90
move = [0.5, 0]
)";
  const Case scene = read(plane);
  EXPECT_NEAR(scene.fluid.regions[0].points[1].x(), 0.5, 1e-12);
  EXPECT_NEAR(scene.fluid.regions[0].points[1].y(), 0.5, 1e-12);
  EXPECT_THAT(complaint(plane + "without = [{ min = [0, 0], max = [1, 1] }]\n"), HasSubstr("belongs to dimension = 3"));
  EXPECT_THAT(complaint(plane + "[[fluid.region]]\nshape = \"cylinder\"\nends = [[0, 0], [1, 1]]\nradius = 0.1\n"),
              HasSubstr("with dimension = 2"));
}

}  // namespace
}  // namespace poretwin
