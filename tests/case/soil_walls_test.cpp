// Moving soil and its walls: what lies in front of them, on them, beside them, and what they cut off.
#include "tests/case/case_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace poretwin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SoilWalls : public CaseFile {};

/// A column of soil, 1 m wide and 2 m high, between rollers, under a load.
const std::string column = R"([case]
end_time = 1
[[soil]]
name = "clay"
min = [0, 0]
max = [1, 2]
youngs_modulus = 1e7
[[wall]]
name = "left"
points = [[0, 3], [0, 0]]
[[wall]]
name = "base"
points = [[0, 0], [1, 0]]
soil = "fixed"
[[wall]]
name = "right"
points = [[1, 0], [1, 3]]
[[load]]
points = [[1, 2], [0, 2]]
pressure = 1e4
[solid]
particle_spacing = 0.1
)";

/// The same in 3D, between planes.
const std::string block = R"([case]
dimension = 3
end_time = 1
[[soil]]
min = [0, 0, 0]
max = [1, 1, 1]
youngs_modulus = 1e7
[[wall]]
name = "base"
point = [0, 0, 0]
normal = [0, 0, 1]
[[load]]
point = [0, 0, 1]
normal = [0, 0, -1]
pressure = 1e4
[solid]
particle_spacing = 0.1
)";

TEST_F(SoilWalls, AreWalkedWithTheSoilOnTheLeft) {
  EXPECT_EQ(complaint(column), "no complaint");
  EXPECT_THAT(complaint(column, {"wall.0.points=[[0, 0], [0, 3]]"}),
              AllOf(HasSubstr("wall[0].points"), HasSubstr("turn the order")));
  EXPECT_EQ(complaint(column, {"wall.0.points=[[0, 0], [0, 3]]", "wall.0.soil=\"none\""}), "no complaint");
}

/// A row of particles that is not half a spacing from its wall leans on it with a wrong stress.
TEST_F(SoilWalls, TouchTheSoilOrStandApart) {
  for (const double gap : {0.03, 0.045, -0.03})
    EXPECT_THAT(complaint(column, {fmt::format("soil.0.min=[0, {}]", gap)}),
                AllOf(HasSubstr("soil[0]"), HasSubstr("wall[1] \"base\""), HasSubstr("a part of a particle spacing")))
        << gap;
  EXPECT_THAT(complaint(column, {"soil.0.max=[0.97, 2]"}), HasSubstr("leaves 0.03 m to wall[2] \"right\""));
  EXPECT_EQ(complaint(column, {"soil.0.max=[0.9, 2]"}), "no complaint");  // a slot of a spacing
  EXPECT_EQ(complaint(column, {"soil.0.max=[0.998, 2]"}), "no complaint");
  EXPECT_EQ(complaint(block), "no complaint");
  EXPECT_THAT(complaint(block, {"soil.0.min=[0, 0, 0.03]"}), HasSubstr("leaves 0.03 m to wall[0] \"base\""));
}

TEST_F(SoilWalls, CutOffNothingThatWouldFall) {
  for (const char* box : {"soil.0.max=[1.5, 2]", "soil.0.min=[0, -0.5]"})
    EXPECT_THAT(complaint(column, {box}), AllOf(HasSubstr("cut off a part"), HasSubstr("nothing holds"))) << box;
  // A sheet pile in the middle: soil rests on the base on both sides of it.
  EXPECT_EQ(complaint(column + "[[wall]]\npoints = [[0.5, 3], [0.5, 0.5]]\n"), "no complaint");
  EXPECT_EQ(complaint(column + "[[wall]]\npoints = [[0.5, 3], [0.5, 0]]\n"), "no complaint");
  EXPECT_EQ(complaint(column, {"soil.0.min=[0, -0.5]", "solid.initial_rest=false"}), "no complaint");
}

TEST_F(SoilWalls, BearLoadsThemselves) {
  for (const char* line : {"load.0.points=[[0, 0], [1, 0]]", "load.0.points=[[0, 2], [0, 0]]"})
    EXPECT_THAT(complaint(column, {line}), AllOf(HasSubstr("load[0]"), HasSubstr("holds the soil there"))) << line;
  EXPECT_THAT(complaint(block, {"load.0.point=[0, 0, 0]", "load.0.normal=[0, 0, 1]"}),
              AllOf(HasSubstr("load[0]"), HasSubstr("wall[0] \"base\"")));
}

TEST_F(SoilWalls, APressureActsOnTheSoilBeforeItsFace) {
  EXPECT_THAT(complaint(column, {"load.0.points=[[0, 2], [1, 2]]"}),
              AllOf(HasSubstr("load[0]"), HasSubstr("turn the order")));
  EXPECT_THAT(complaint(block, {"load.0.normal=[0, 0, 1]"}), AllOf(HasSubstr("load[0]"), HasSubstr("'normal' points")));
  // A traction has a direction of its own.
  EXPECT_EQ(complaint(changed(column, "pressure = 1e4", "traction = [0, -1e4]"), {"load.0.points=[[0, 2], [1, 2]]"}),
            "no complaint");
  EXPECT_THAT(complaint(column, {"load.0.start=-1"}), AllOf(HasSubstr("load[0].start"), HasSubstr("time begins at 0")));
}

TEST_F(SoilWalls, StandOnNoSideAtWhichTheCaseRepeatsItself) {
  const std::string repeated =
      changed(column, "end_time = 1", "end_time = 1\nperiodic = [\"x\"]\ndomain_min = [0, 0]\ndomain_max = [1, 2]");
  EXPECT_THAT(complaint(repeated), AllOf(HasSubstr("wall[0]"), HasSubstr("repeats itself along x")));
  EXPECT_EQ(complaint(repeated, {"wall.0.soil=\"none\"", "wall.2.soil=\"none\""}), "no complaint");
}

/// A sector of a cylinder of soil, 1 m in radius, between walls that end with that at 0 degrees. at: m, of their common
/// edge along x; spacing: m.
std::string sector(double degrees, const std::vector<double>& walls, const std::string& base, double spacing = 0.1) {
  const auto radians = [](double angle) { return angle * std::numbers::pi / 180.0; };
  std::string text = fmt::format(R"([case]
dimension = 3
end_time = 1
domain_min = [0, 0, -1]
domain_max = [2, 2, 2]
[[soil]]
shape = "cylinder"
ends = [[0, 0, 0], [0, 0, 1]]
radius = 1
youngs_modulus = 1e7
[[soil.within]]
shape = "polygon"
along = ["z"]
from = -1
to = 1
points = [[0, 0], [2, 0], [2, {}]]
[[wall]]
name = "base"
point = [0, 0, 0]
normal = [0, 0, 1]
soil = "{}"
[solid]
model = "drucker_prager"
particle_spacing = {}
)",
                                 2.0 * std::tan(radians(degrees)), base, spacing);
  for (const double angle : walls)
    text += fmt::format("[[wall]]\nname = \"at {}\"\npoint = [0, 0, 0]\nnormal = [{}, {}, 0]\n", angle,
                        std::sin(radians(angle)), -std::cos(radians(angle)));
  return text + "[[wall]]\nname = \"at 0\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n";
}

/// Images of planes fill the space behind an edge once, or the walls are refused.
TEST_F(SoilWalls, MeetAtAnglesThatImagesFill) {
  const auto unfilled = [](double angle) {
    return AllOf(HasSubstr("wall["), HasSubstr(fmt::format("at an angle of {} degrees", angle)),
                 HasSubstr("where soil lies"),
                 HasSubstr("Images of planes leave a gap behind such an edge, or overlap"));
  };
  EXPECT_EQ(complaint(sector(45, {45, 90}, "fixed")), "no complaint");
  EXPECT_EQ(complaint(sector(22.5, {22.5, 45, 90}, "fixed")), "no complaint");
  EXPECT_EQ(complaint(sector(22.5, {22.5, 45, 90}, "rough")), "no complaint");
  EXPECT_THAT(complaint(sector(45, {45}, "fixed")), unfilled(45));
  EXPECT_THAT(complaint(sector(60, {60}, "fixed")), unfilled(60));
  EXPECT_THAT(complaint(sector(45, {90, 45}, "fixed")), unfilled(45));
  EXPECT_THAT(complaint(sector(22.5, {22.5, 90}, "fixed")), unfilled(22.5));
  EXPECT_THAT(complaint(sector(30, {30, 60, 90}, "fixed")), unfilled(30));
}

/// A rough base has no particle near the edge of a narrow sector.
TEST_F(SoilWalls, OfNarrowSectorsAreNotRough) {
  const std::vector<double> walls{11.25, 22.5, 45, 90};
  EXPECT_EQ(complaint(sector(11.25, walls, "fixed")), "no complaint");
  EXPECT_THAT(
      complaint(sector(11.25, walls, "rough")),
      AllOf(HasSubstr("soil = \"rough\""), HasSubstr("expected a sector of 22.5 degrees or more, found 11.25")));
}

/// Where the body lies apart from the edge, moving soil could still come there.
TEST_F(SoilWalls, ThatMeetAtOtherAnglesFarAwayAreWarnedOf) {
  const std::string slope = "[[wall]]\nname = \"slope\"\npoint = [-0.5, 0, 0]\nnormal = [0.8, 0, 0.6]\n";
  EXPECT_EQ(complaint(block + slope), "no complaint");
  EXPECT_THAT(warnings(block + slope),
              AllOf(HasSubstr("wall[1]"), HasSubstr("meets wall[0] \"base\" at an angle of 126.9"),
                    HasSubstr("soil that comes there is computed wrongly")));
  EXPECT_THAT(complaint(changed(block + slope, "[-0.5, 0, 0]", "[-0.1, 0, 0]")),
              AllOf(HasSubstr("wall[1]"), HasSubstr("where soil lies")));
  EXPECT_EQ(complaint(changed(block + slope, "[0.8, 0, 0.6]", "[1, 0, 0]")), "no complaint");
}

}  // namespace
}  // namespace poretwin
