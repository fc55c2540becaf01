// Mistakes in cases: those that would run and give wrong numbers are refused, doubtful ones cause a warning, correct
// ones pass.
#include "tests/case/case_file.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/crossing.hpp"
#include "common/media/seepage_law.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <set>

namespace poretwin {
namespace {

using testing::HasSubstr;
using testing::Not;

class Mistakes : public CaseFile {};

/// A dam of rigid soil between two faces.
const std::string dam = R"([case]
end_time = 100
[[soil]]
name = "dam"
shape = "polygon"
points = [[0, 0], [1.2, 0], [0.8, 0.4], [0.4, 0.4]]
hydraulic_conductivity = 1e-4
[[wall]]
name = "base"
points = [[0, 0], [1.2, 0]]
[[water_face]]
name = "reservoir"
points = [[0.4, 0.4], [0, 0]]
head = 0.3
[[water_face]]
name = "toe"
points = [[1.2, 0], [0.8, 0.4]]
head = 0
[fluid]
particle_spacing = 0.02
[solid]
model = "rigid"
)";

/// A tank of free water, one metre wide, half full.
const std::string tank = R"([case]
end_time = 1
[fluid]
particle_spacing = 0.05
[[fluid.region]]
min = [0, 0]
max = [1, 0.5]
[solid]
model = "rigid"
[[wall]]
points = [[0, 1], [0, 0], [1, 0], [1, 1]]
)";

/// A slope of soil alone, 2 m high.
const std::string slope = R"([case]
end_time = 0.5
[[soil]]
shape = "polygon"
points = [[0, 0], [6, 0], [6, 1], [3, 1], [2, 2], [0, 2]]
porosity = 0.3
grain_density = 2700
youngs_modulus = 1e7
friction_angle = 20
cohesion = 5000
[[wall]]
points = [[0, 3], [0, 0]]
[[wall]]
points = [[0, 0], [6, 0]]
soil = "fixed"
[[wall]]
points = [[6, 0], [6, 3]]
[solid]
model = "drucker_prager"
particle_spacing = 0.1
)";

TEST_F(Mistakes, AnOldWordIsReadWithAWarning) {
  const auto with = [](const std::string& word) {
    return changed(slope, "porosity = 0.3", "porosity = 0.3\nseepage_law = \"" + word + "\"");
  };
  EXPECT_EQ(read(with("darcy")).soils[0].seepage_law->name, "kozeny_carman");
  EXPECT_THAT(warnings(with("darcy")),
              HasSubstr("case.toml:7: key 'soil[0].seepage_law': \"darcy\" is the old word for "
                        "\"kozeny_carman\"; the next version will not read it"));
  EXPECT_THAT(warnings(slope, {"soil.0.seepage_law=darcy"}), HasSubstr("\"darcy\" is the old word"));
  EXPECT_THAT(warnings(slope, {"solid.zero_energy_stiffness=0.2"}),
              HasSubstr("key 'solid.zero_energy_stiffness' is the old word for 'hourglass_stiffness'"));
  EXPECT_EQ(warnings(with("kozeny_carman")), "");
}

TEST_F(Mistakes, AllCasesOfTheProjectPass) {
  // linear.toml exists to show rockfill with a linear seepage law.
  const std::set<std::string> doubtful{"rockfill_dam_rigid/linear.toml",
                                       // Soil that is strained by its own weight.
                                       "gibson/case.toml", "gibson/kozeny.toml",
                                       // A slope whose toe is held by a wall along it; columns four particles wide.
                                       "embankment_failure_held/case.toml", "dynamic_column/case.toml",
                                       "dynamic_column/deboer.toml", "harmonic_column/case.toml"};
  std::size_t read = 0;
  for (const auto& folder : std::filesystem::directory_iterator(std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases"))
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      const auto name = file.path().parent_path().filename().string() + "/" + file.path().filename().string();
      if (file.path().extension() != ".toml" || file.path().filename() == "verify.toml") continue;
      const Case scene = read_case(file.path());
      EXPECT_TRUE(scene.warnings.empty() != doubtful.contains(name))
          << name << ": " << testing::PrintToString(scene.warnings);
      ++read;
    }
  EXPECT_GT(read, 40u);
}

TEST_F(Mistakes, AToleranceThatLetsErrorsAddUpIsDoubted) {
  const auto warnings_with = [](const std::string& tolerance) {
    const auto path = std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases/blow_out/case.toml";
    return read_case(path, {"coupling.tolerance=" + tolerance}).warnings;
  };
  EXPECT_THAT(warnings_with("0.003"), testing::IsEmpty());
  EXPECT_THAT(warnings_with("0.005"), testing::ElementsAre(HasSubstr("key 'coupling.tolerance': 0.005 of the weight")));
}

TEST_F(Mistakes, ADrainedFaceFromWhichTheSoilSettlesIsDoubted) {
  const auto path = std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases/settle_years/case.toml";
  const auto doubts = [&](const std::string& traction, const std::string& representation) {
    return read_case(path, {"load.0.traction=[0, " + traction + "]", "fluid.representation=" + representation})
        .warnings;
  };
  // A modulus of 5 MPa on 10 m, rows of 0.25 m: 0.16 and 0.08 spacings.
  EXPECT_THAT(doubts("-20000", "particles"),
              testing::Contains(AllOf(HasSubstr("load[0]"), HasSubstr("by some 0.04 m, 0.16 spacings"))));
  EXPECT_THAT(doubts("-10000", "particles"), Not(testing::Contains(HasSubstr("load[0]"))));
  EXPECT_THAT(doubts("-20000", "field"), Not(testing::Contains(HasSubstr("load[0]"))));
}

TEST_F(Mistakes, APolygonThatCrossesItselfIsNamed) {
  EXPECT_EQ(complaint(dam), "no complaint");
  EXPECT_THAT(complaint(changed(dam, "[0.8, 0.4], [0.4, 0.4]", "[0.4, 0.4], [0.8, 0.4]")),
              HasSubstr("case.toml:6: key 'soil[0].points': edges 2-3 and 4-1 cross at [0.6, 0.3] m"));
  EXPECT_THAT(
      complaint(dam + "[[fluid.region]]\nshape = \"polygon\"\npoints = [[0.5, 0], [0.7, 0], [0.5, 0.2], [0.7, 0.2]]\n"),
      HasSubstr("key 'fluid.region[0].points': edges 2-3 and 4-1 cross at [0.6, 0.1] m"));
  EXPECT_THAT(
      complaint(changed(tank, "[[0, 1], [0, 0], [1, 0], [1, 1]]", "[[0, 1], [0, 0], [1, 0], [1, 1], [-0.5, 0.8]]")),
      HasSubstr("key 'wall[0].points': edges 1-2 and 4-5 cross at [0, 0.866667] m"));
  EXPECT_THAT(
      complaint(tank + "[[gauge]]\nname = \"v\"\nphase = \"fluid\"\nkind = \"volume\"\nregion = {shape = \"polygon\", "
                       "points = [[0, 0], [1, 1], [1, 0], [0, 1]]}\n"),
      HasSubstr("key 'gauge[0].region.points': edges 1-2 and 3-4 cross at [0.5, 0.5] m"));
}

TEST_F(Mistakes, LinesThatOnlyTouchThemselvesDoNotCross) {
  const auto p = [](double x, double y) { return Point3(x, y, 0.0); };
  EXPECT_FALSE(self_crossing({p(0, 0), p(1, 0), p(1, 1), p(0, 1)}, true));
  // A polygon with a hole, reached by a bridge that the line follows twice.
  EXPECT_FALSE(self_crossing(
      {p(0, 0), p(3, 0), p(3, 3), p(1, 3), p(1, 2), p(1, 1), p(2, 1), p(2, 2), p(1, 2), p(1, 3), p(0, 3)}, true));
  // A point of the line lies on an edge, and the line turns back there.
  EXPECT_FALSE(self_crossing({p(0, 0), p(4, 0), p(4, 2), p(2, 0), p(0, 2)}, true));
  // The line crosses an edge at one of its points.
  const auto through = self_crossing({p(0, 0), p(4, 0), p(4, 2), p(2, 0), p(1, -1), p(0, -1)}, true);
  ASSERT_TRUE(through);
  EXPECT_EQ(through->at, p(2, 0));
  EXPECT_EQ(through->first, 0u);
  // Many corners take little time: a circle of 20000.
  std::vector<Point3> circle;
  for (int k = 0; k < 20000; ++k) circle.push_back(p(std::cos(k * 3.14159265e-4), std::sin(k * 3.14159265e-4)));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(self_crossing(circle, true));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST_F(Mistakes, AnUnknownQuantityIsRefusedWithTheKnownOnes) {
  const auto gauge = [&](const std::string& text, const std::string& phase, const std::string& quantity) {
    return complaint(text + "[[gauge]]\nname = \"p\"\nphase = \"" + phase + "\"\nkind = \"point\"\nquantity = \"" +
                     quantity + "\"\npoints = [[0.5, 0.1]]\n");
  };
  for (const char* known : {"pore_pressure", "pressure_head", "head", "degree_of_saturation", "velocity", "velocity_y"})
    EXPECT_EQ(gauge(tank, "fluid", known), "no complaint") << known;
  for (const char* known : {"displacement_x", "velocity_y", "effective_stress_yy", "total_stress_xy", "pore_pressure",
                            "pore_pressure_ratio", "mobilised_friction", "void_fraction", "accumulated_plastic_strain"})
    EXPECT_EQ(gauge(slope, "solid", known), "no complaint") << known;
  EXPECT_THAT(gauge(tank, "fluid", "presure"),
              HasSubstr("key 'gauge[0].quantity': expected one of \"pore_pressure\", \"pressure_head\", \"head\""));
  EXPECT_THAT(gauge(tank, "fluid", "presure"), HasSubstr("did you mean \"pore_pressure\"?"));
  EXPECT_THAT(gauge(tank, "fluid", "effective_stress_yy"), HasSubstr("key 'gauge[0].quantity'"));
  EXPECT_THAT(gauge(tank, "fluid", "velocity_z"), HasSubstr("did you mean \"velocity_"));
  EXPECT_THAT(gauge(slope, "solid", "effective_stres_yy"), HasSubstr("did you mean \"effective_stress_yy\"?"));
  EXPECT_THAT(gauge(slope, "solid", "displacement"), HasSubstr("did you mean \"displacement_x\"?"));
  const auto of = [&](const std::string& text, const std::string& kind, const std::string& quantity) {
    return complaint(text + "[[gauge]]\nname = \"g\"\nphase = \"fluid\"\nkind = \"" + kind + "\"\nquantity = \"" +
                     quantity + "\"\n");
  };
  EXPECT_EQ(of(dam, "passed_volume", "toe"), "no complaint");
  EXPECT_THAT(of(dam, "level", "reservoi"),
              HasSubstr("expected one of \"reservoir\", \"toe\", found \"reservoi\"; did you "
                        "mean \"reservoir\"?"));
  EXPECT_EQ(of(tank, "momentum", "momentum_x"), "no complaint");
  EXPECT_THAT(of(tank, "momentum", "x"), HasSubstr("expected one of \"momentum_x\", \"momentum_y\""));
}

TEST_F(Mistakes, TooMuchOfEverythingIsNamedBeforeItIsMade) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(
      complaint(tank, {"fluid.particle_spacing=1e-6"}),
      HasSubstr("key 'fluid.particle_spacing': 5e+11 water particles at a spacing of 1e-06 m: expected 1e+09 at most"));
  EXPECT_THAT(complaint(dam, {"fluid.particle_spacing=1e-6"}), HasSubstr("3.2e+11 water particles"))
      << "what would run in through the faces counts";
  EXPECT_THAT(complaint(slope, {"solid.particle_spacing=1e-5"}), HasSubstr("8.5e+10 soil particles"));
  EXPECT_THAT(complaint(tank, {"output.interval=1e-12"}),
              HasSubstr("key 'output.interval': 1e+12 frames of 200 particles"));
  EXPECT_THAT(complaint(tank + "[[gauge]]\nname = \"n\"\nphase = \"fluid\"\nkind = \"particles\"\n",
                        {"output.gauge_interval=1e-10"}),
              HasSubstr("key 'output.gauge_interval': 1e+10 gauge readings"));
  // Of millions of particles only a sample is checked.
  EXPECT_EQ(complaint(tank, {"fluid.particle_spacing=1e-4"}), "no complaint");
  EXPECT_EQ(complaint(slope, {"solid.particle_spacing=1e-3"}), "no complaint");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST_F(Mistakes, EstimatesAreThoseOfAreasAndVolumes) {
  const Amounts a = estimate(read(tank, {"output.interval=0.1"}));
  EXPECT_EQ(a.fluid, 200.0);
  EXPECT_EQ(a.frames, 11.0);
  EXPECT_NEAR(estimate(read(slope)).solid, 850.0, 1.0);
  EXPECT_NEAR(measure(read(slope).soils[0].shape, 2), 8.5, 1e-12);
}

TEST_F(Mistakes, AFaceThatEndsWhereAWallGoesStraightOnIsDoubted) {
  const std::string scene = R"(
[case]
end_time = 1
[[soil]]
min = [0, 0]
max = [0.8, 0.4]
hydraulic_conductivity = 1e-4
youngs_modulus = 1e7
[[wall]]
points = [[0, 0], [0.8, 0]]
[[wall]]
name = "lid"
points = [[0.8, 0.2], [0.8, 0.4], [0, 0.4]]
[[water_face]]
points = [[0, 0.4], [0, 0]]
head = 0.7
[[water_face]]
points = [[0.8, 0], [0.8, 0.2]]
head = 0.5
[fluid]
particle_spacing = 0.02
[[fluid.region]]
min = [0, 0]
max = [0.8, 0.4]
[solid]
model = "elastic"
)";
  EXPECT_THAT(warnings(scene), HasSubstr("key 'water_face[1]': wall[1] \"lid\" goes straight on where it ends"));
  EXPECT_THAT(warnings(scene), HasSubstr("it has 10: expected a smaller fluid.particle_spacing"));
  // In rigid soil the flow through a face follows from the matrix of the pressure solve.
  EXPECT_EQ(warnings(changed(scene, "\"elastic\"", "\"rigid\"")), "");
  // A face over a whole side between corners is exact.
  EXPECT_EQ(warnings(changed(changed(scene, "[0.8, 0], [0.8, 0.2]]", "[0.8, 0], [0.8, 0.4]]"),
                             "[[0.8, 0.2], [0.8, 0.4], [0, 0.4]]", "[[0.8, 0.4], [0, 0.4]]")),
            "");
}

TEST_F(Mistakes, OpeningsUnderWaterThatDrawAreRefused) {
  const auto with = [](const std::string& height, const std::string& kind) {
    return changed(tank, "[[0, 1], [0, 0], [1, 0], [1, 1]]", "[[0, 1], [0, 0], [1, 0]]") + "[[wall]]\npoints = [[1, " +
           height + "], [1, 1]]\n[[water_face]]\nname = \"slot\"\npoints = [[1, 0], [1, " + height + "]]\n" + kind +
           "\n";
  };
  for (const std::string kind : {"outlet = true", "pressure = 0", "head = 0.05", "discharge = -0.2"}) {
    const std::string key = kind.substr(0, kind.find(' '));
    EXPECT_THAT(complaint(with("0.1", kind)), HasSubstr("key 'water_face[0]." + key +
                                                        "': the opening from [1, 0] to [1, "
                                                        "0.1] m lies under water"))
        << kind;
    EXPECT_THAT(complaint(with("0.6", kind)), Not(HasSubstr("lies under water"))) << kind;
  }
  for (const std::string kind : {"discharge = 0.2", "head = 0.6"})
    EXPECT_EQ(complaint(with("0.1", kind)), "no complaint") << kind;
}

TEST_F(Mistakes, WaterDrawnBehindAFaceIsRefused) {
  const std::string pond = "[[fluid.region]]\nshape = \"polygon\"\npoints = [[-1, 0], [0, 0], [0.3, 0.3], [-1, 0.3]]\n";
  EXPECT_THAT(complaint(dam + pond), HasSubstr("key 'fluid.region[0]': water lies behind water_face[0] \"reservoir\""));
  EXPECT_THAT(complaint(dam + pond), HasSubstr("give its level by the face's 'head'"));
  // Also where the water does not touch the face: it would be removed all the same.
  EXPECT_THAT(complaint(dam + "[[fluid.region]]\nmin = [-1, 0]\nmax = [-0.5, 0.2]\n"),
              HasSubstr("water lies behind water_face[0]"));
  EXPECT_THAT(complaint(changed(dam, "head = 0\n", "outlet = true\n") +
                        "[[fluid.region]]\nshape = \"polygon\"\npoints = [[1.2, 0], [1.4, 0], [1.4, 0.2], [1, 0.2]]\n"),
              HasSubstr("water lies behind water_face[1] \"toe\""));
  EXPECT_EQ(complaint(dam + "[[fluid.region]]\nmin = [0.45, 0]\nmax = [0.75, 0.2]\n"), "no complaint");
}

TEST_F(Mistakes, NothingLiesBehindAPlane) {
  const auto plane = [](const std::string& name, const std::string& point, const std::string& normal) {
    return "[[wall]]\nname = \"" + name + "\"\npoint = " + point + "\nnormal = " + normal + "\n";
  };
  const std::string box =
      "[case]\nend_time = 1\ndimension = 3\n[fluid]\nparticle_spacing = 0.1\n[[fluid.region]]\nmin = [0, 0, 0]\nmax = "
      "[1, "
      "1, 0.5]\n[solid]\nmodel = \"rigid\"\n" +
      plane("left", "[0, 0, 0]", "[1, 0, 0]") + plane("right", "[3, 0, 0]", "[-1, 0, 0]") +
      plane("front", "[0, 0, 0]", "[0, 1, 0]") + plane("back", "[0, 1, 0]", "[0, -1, 0]") +
      plane("floor", "[0, 0, 0]", "[0, 0, 1]");
  EXPECT_EQ(complaint(box), "no complaint");
  EXPECT_EQ(complaint(box + plane("block", "[2, 0, 0]", "[-1, 0, 0]")), "no complaint");
  EXPECT_THAT(complaint(box + plane("block", "[2, 0, 0]", "[1, 0, 0]")),
              HasSubstr("key 'fluid.region[0]': water lies behind wall[5] \"block\""));
  const std::string block =
      "[case]\nend_time = 1\n[[soil]]\nmin = [0, 0]\nmax = [1, 0.5]\n[solid]\nparticle_spacing = 0.1\n[[wall]]\npoint "
      "= "
      "[0, 0]\nnormal = [0, 1]\n[[wall]]\npoint = [0, 0]\nnormal = [1, 0]\n";
  EXPECT_EQ(complaint(block), "no complaint");
  EXPECT_THAT(complaint(block + "[[wall]]\nname = \"right\"\npoint = [0.5, 0]\nnormal = [-1, 0]\n"),
              HasSubstr("key 'soil[0]': soil lies behind wall[2] \"right\""));
}

TEST_F(Mistakes, AGaugeBeforePlanesIsInside) {
  const std::string wide = changed(tank, "[[wall]]\npoints = [[0, 1], [0, 0], [1, 0], [1, 1]]\n",
                                   "[[wall]]\npoint = [0, 0]\nnormal = [1, 0]\n[[wall]]\npoint = [0, 0]\nnormal = [0, "
                                   "1]\n[[wall]]\npoint = [3, 0]\nnormal = [-1, 0]\n");
  const std::string gauge = "[[gauge]]\nname = \"h\"\nphase = \"fluid\"\nkind = \"front\"\npoints = ";
  EXPECT_EQ(complaint(wide + gauge + "[[2, 0.02], [2, 0.4]]\n"), "no complaint");
  EXPECT_THAT(complaint(wide + gauge + "[[4, 0.02], [4, 0.4]]\n"), HasSubstr("expected a place within the walls"));
}

// A line of sight separates water on both sides of a thin wall, but not beside soil that moves.
TEST_F(Mistakes, BesideSoilThatMovesWaterFeelsItselfThroughThinWalls) {
  const auto with = [&](double thickness, double right, double spacing = 0.04, const char* model = "elastic") {
    const double there = 1.0 + thickness;
    return complaint(fmt::format(
        R"([case]
end_time = 1
[[soil]]
min = [0, 0]
max = [0.4, 0.2]
youngs_modulus = 1e7
hydraulic_conductivity = 1e-4
[[wall]]
points = [[0, 2], [0, 0], [1, 0], [1, 1.5], [{0}, 1.5], [{0}, 0], [2.4, 0], [2.4, 2]]
[fluid]
particle_spacing = {1}
[[fluid.region]]
min = [0, 0]
max = [1, 1.2]
{2}[solid]
model = "{3}"
)",
        there, spacing,
        right > 0.0 ? fmt::format("[[fluid.region]]\nmin = [{}, 0]\nmax = [2.4, {}]\n", there, right) : "", model));
  };
  EXPECT_THAT(with(0.08, 0.4), HasSubstr("key 'wall[0]': is 0.08 m thick at [1, 0."));
  EXPECT_THAT(with(0.08, 0.4), HasSubstr("2 particle spacings, with water on both sides: particles would interact "
                                         "through it beside soil that moves; expected 0.2 m or more, 5 spacings"));
  EXPECT_THAT(with(0.16, 0.4), HasSubstr("4 particle spacings"));
  EXPECT_EQ(with(0.2, 0.4), "no complaint");
  EXPECT_THAT(with(0.04, 0.0), HasSubstr("with water on one side"));
  EXPECT_EQ(with(0.12, 0.0), "no complaint");
  EXPECT_EQ(with(0.08, 0.4, 0.016), "no complaint");
  for (const double thickness : {0.16, 0.08, 0.04, 0.02})
    EXPECT_EQ(with(thickness, 0.4, 0.04, "rigid"), "no complaint");
}

TEST_F(Mistakes, APileOfOneSpacingIsDoubted) {
  const auto with = [&](double thickness) {
    const double a = 1.0 - 0.5 * thickness, b = 1.0 + 0.5 * thickness;
    return warnings(fmt::format(R"([case]
end_time = 1
[[soil]]
shape = "polygon"
points = [[0, 0], [2, 0], [2, 0.6], [{1}, 0.6], [{1}, 0.3], [{0}, 0.3], [{0}, 0.6], [0, 0.6]]
hydraulic_conductivity = 1e-4
[[wall]]
points = [[0, 0.6], [0, 0], [2, 0], [2, 0.6]]
[[wall]]
points = [[{1}, 0.6], [{1}, 0.3], [{0}, 0.3], [{0}, 0.6]]
[[water_face]]
points = [[{0}, 0.6], [0, 0.6]]
head = 0.9
[[water_face]]
points = [[2, 0.6], [{1}, 0.6]]
head = 0.7
[fluid]
particle_spacing = 0.02
[[fluid.region]]
shape = "polygon"
points = [[0, 0], [2, 0], [2, 0.6], [{1}, 0.6], [{1}, 0.3], [{0}, 0.3], [{0}, 0.6], [0, 0.6]]
[solid]
model = "rigid"
)",
                                a, b));
  };
  EXPECT_THAT(with(0.02), HasSubstr("key 'wall[1]': is a particle spacing thick in soil: the flow past its end"));
  EXPECT_EQ(with(0.04), "");
}

TEST_F(Mistakes, ADrainWithoutPressureIsAnOutlet) {
  const std::string drained = R"([case]
end_time = 1
[[soil]]
shape = "polygon"
points = [[0, 0], [1.6, 0], [1.0, 0.4], [0.8, 0.4]]
hydraulic_conductivity = 1e-3
[[wall]]
points = [[0, 0], [1.2, 0]]
[[water_face]]
points = [[1.2, 0], [1.6, 0]]
pressure = 0
[[water_face]]
points = [[0.8, 0.4], [0, 0]]
head = [[0, 0], [30, 0.3]]
[[water_face]]
points = [[1.6, 0], [1.0, 0.4]]
head = 0
[fluid]
particle_spacing = 0.02
[solid]
model = "rigid"
)";
  EXPECT_THAT(complaint(drained),
              HasSubstr("key 'water_face[0].pressure': the pressure is zero along the face from [1.2, 0] "
                        "to [1.6, 0] m, before which the soil is dry"));
  EXPECT_THAT(complaint(changed(drained, "pressure = 0", "head = 0")),
              HasSubstr("key 'water_face[0].head': the pressure"));
  EXPECT_EQ(complaint(changed(drained, "pressure = 0", "outlet = true")), "no complaint");
  EXPECT_EQ(complaint(changed(drained, "pressure = 0", "pressure = 500")), "no complaint");
}

// A tank rotated with its gravity by 160 degrees: its water level is that of its own corners, not of the box around
// them.
TEST_F(Mistakes, ATurnedTankDoesNotLeak) {
  const std::string turned = R"([case]
end_time = 1
gravity = [3.3552, 9.2184]
[[wall]]
points = [[-0.4447, -1.2217], [0, 0], [-0.9397, 0.342], [-1.3844, -0.8797]]
[fluid]
particle_spacing = 0.05
[[fluid.region]]
shape = "polygon"
points = [[0, 0], [-0.9397, 0.342], [-1.2817, -0.5977], [-0.342, -0.9397]]
[solid]
model = "rigid"
)";
  EXPECT_EQ(complaint(turned), "no complaint");
  EXPECT_THAT(complaint(turned, {"wall.0.points=[[0, 0], [-0.9397, 0.342], [-1.3844, -0.8797]]"}),
              HasSubstr("water can run out"));
}

TEST_F(Mistakes, ALayerOfFewRowsIsRefusedWhereItIsAnother) {
  const std::string layers = R"([case]
end_time = 1
[[soil]]
name = "gravel"
min = [0, 0]
max = [0.2, 0.2]
hydraulic_conductivity = 1e-3
[[soil]]
name = "fabric"
min = [0, 0.2]
max = [0.2, 0.22]
hydraulic_conductivity = 1e-6
[[soil]]
min = [0, 0.22]
max = [0.2, 0.5]
[[wall]]
points = [[0, 0.5], [0, 0]]
[[wall]]
points = [[0.2, 0], [0.2, 0.5]]
[[water_face]]
points = [[0.2, 0.5], [0, 0.5]]
head = 0.7
[[water_face]]
points = [[0, 0], [0.2, 0]]
head = 0.2
[fluid]
particle_spacing = 0.02
[solid]
model = "rigid"
)";
  EXPECT_THAT(complaint(layers),
              HasSubstr("key 'soil[1]': is 0.02 m thin, 1 rows of particles, with a conductivity of 1e-06 "
                        "m/s beside soil[0] \"gravel\" of 0.001 m/s; expected 3 rows or more"));
  EXPECT_THAT(complaint(layers, {"fluid.particle_spacing=0.01"}), HasSubstr("0.02 m thin, 2 rows"));
  EXPECT_EQ(complaint(layers, {"fluid.particle_spacing=0.00666"}), "no complaint");
  EXPECT_THAT(warnings(layers, {"fluid.particle_spacing=0.00666"}), HasSubstr("key 'soil[1]': is 0.02 m thin, 3 rows"));
  // A lower contrast needs fewer rows; so does a layer that is faster than its neighbours.
  const std::vector<std::string> two_rows{"fluid.particle_spacing=0.01", "soil.0.hydraulic_conductivity=8e-6",
                                          "soil.2.hydraulic_conductivity=8e-6"};
  EXPECT_EQ(complaint(layers, two_rows), "no complaint");
  EXPECT_EQ(complaint(layers, {"fluid.particle_spacing=0.01", "soil.1.hydraulic_conductivity=1"}), "no complaint");
  // A wedge is thin at its tip only; a blanket beside a core is thin along its whole length.
  const auto with_core = [&](const std::string& points) {
    return R"([case]
end_time = 1
[[soil]]
name = "core"
shape = "polygon"
points = )" +
           points + R"(
hydraulic_conductivity = 1e-7
[[soil]]
name = "sand"
min = [0.4, 0]
max = [1, 0.4]
[[wall]]
points = [[0, 0.6], [0, -0.4], [1, -0.4], [1, 0.6]]
[[water_face]]
points = [[1, 0.4], [0, 0.4]]
head = 0.4
[fluid]
particle_spacing = 0.02
[solid]
model = "rigid"
)";
  };
  EXPECT_EQ(complaint(with_core("[[0, 0], [0, -0.4], [1, -0.4], [0.4, 0], [0.4, 0.4], [0, 0.4]]")), "no complaint");
  EXPECT_THAT(complaint(with_core(
                  "[[0, 0.4], [0, -0.4], [0.4, -0.4], [0.4, -0.04], [1, -0.04], [1, 0], [0.4, 0], [0.4, 0.4]]")),
              HasSubstr("soil[0]': is 0.04 m thin, 2 rows"));
  // Regions of one soil, as a slope in 3D is drawn, are one layer.
  EXPECT_EQ(complaint(layers, {"soil.0.hydraulic_conductivity=1e-4", "soil.1.hydraulic_conductivity=1e-4"}),
            "no complaint");
  EXPECT_EQ(warnings(layers, {"soil.0.hydraulic_conductivity=1e-4", "soil.1.hydraulic_conductivity=1e-4"}), "");
  // An inclined layer between the two.
  std::string slanted = changed(layers, "min = [0, 0.2]\nmax = [0.2, 0.22]",
                                "shape = \"polygon\"\npoints = [[0, 0.2], [0.2, 0.25], [0.2, 0.27], [0, 0.22]]");
  slanted = changed(slanted, "min = [0, 0]\nmax = [0.2, 0.2]",
                    "shape = \"polygon\"\npoints = [[0, 0], [0.2, 0], [0.2, 0.25], [0, 0.2]]");
  slanted = changed(slanted, "min = [0, 0.22]\nmax = [0.2, 0.5]",
                    "shape = \"polygon\"\npoints = [[0, 0.22], [0.2, 0.27], [0.2, 0.5], [0, 0.5]]");
  EXPECT_THAT(complaint(slanted), HasSubstr("key 'soil[1]': is 0.0195 m thin"));
}

TEST_F(Mistakes, SoilWithoutPoresIsNoWall) {
  const std::string block = tank + "[[soil]]\nmin = [0.8, 0]\nmax = [1, 0.2]\nporosity = ";
  EXPECT_EQ(complaint(changed(block, "max = [1, 0.5]", "max = [0.5, 0.5]") + "0.3\n"), "no complaint");
  EXPECT_THAT(complaint(changed(block, "max = [1, 0.5]", "max = [0.5, 0.5]") + "0.02\n"),
              HasSubstr("key 'soil[0].porosity': expected 0.1 or more beside free water, found 0.02"));
  EXPECT_EQ(complaint(changed(dam, "hydraulic_conductivity", "porosity = 0.05\nhydraulic_conductivity")),
            "no complaint")
      << "without free water it is only dense";
}

TEST_F(Mistakes, AHeadAboveTheSoilsTopIsRefusedForPlanes) {
  const std::string block = R"([case]
dimension = 3
end_time = 1
[[soil]]
min = [0, 0, 0]
max = [0.6, 0.2, 0.4]
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[wall]]
point = [0, 0, 0]
normal = [0, 1, 0]
[[wall]]
point = [0, 0.2, 0]
normal = [0, -1, 0]
[[water_face]]
point = [0, 0, 0]
normal = [1, 0, 0]
head = [[0, 0], [30, 0.3]]
[[water_face]]
point = [0.6, 0, 0]
normal = [-1, 0, 0]
head = 0
[fluid]
particle_spacing = 0.02
[solid]
model = "rigid"
)";
  EXPECT_EQ(complaint(block), "no complaint");
  const std::string high = changed(block, "[30, 0.3]", "[30, 0.5]");
  EXPECT_THAT(complaint(high),
              HasSubstr("key 'water_face[0].head': the water behind the face rises to 0.5 m, above the "
                        "soil's upper end at 0.4 m, and cannot run over there"));
  EXPECT_EQ(complaint(high + "[[wall]]\npoint = [0, 0, 0.4]\nnormal = [0, 0, -1]\n"), "no complaint")
      << "a lid holds it";
}

/// A column of soil under a load.
std::string loaded(const std::string& face) {
  return R"([case]
end_time = 1
[[soil]]
min = [0, 0]
max = [0.4, 0.4]
[[soil]]
name = "pad"
min = [0, 0.4]
max = [0.1, 0.48]
[[wall]]
points = [[0, 0.5], [0, 0], [0.4, 0], [0.4, 0.5]]
[solid]
particle_spacing = 0.02
[[load]]
traction = [0, -1000]
)" + face;
}

TEST_F(Mistakes, LoadsLieOnTheSurfaceTheyLoad) {
  EXPECT_EQ(complaint(loaded("points = [[0.1, 0.48], [0, 0.48]]\n")), "no complaint");
  EXPECT_EQ(complaint(loaded("points = [[0.4, 0.4], [0.1, 0.4]]\n")), "no complaint");
  EXPECT_EQ(complaint(loaded("points = [[0.1, 0.52], [0, 0.52]]\n")), "no complaint") << "two spacings off";
  EXPECT_THAT(
      complaint(loaded("points = [[0.1, 0.55], [0, 0.55]]\n")),
      HasSubstr("key 'load[0]': the soil's surface at [0.01, 0.47] m lies 0.07 m off the load's face, within its "
                "reach; expected surfaces within 0.04 m of the face"));
  EXPECT_THAT(complaint(loaded("point = [0, 0.48]\nnormal = [0, -1]\n")),
              HasSubstr("as a plane goes on without end, leave out what else it meets"))
      << "the block beside the pad is within its reach, too";
  EXPECT_THAT(complaint(loaded("points = [[0.1, 0.9], [0, 0.9]]\n")),
              HasSubstr("key 'load[0]': no soil lies within 0.096 m of the load's face"));
  EXPECT_THAT(complaint(loaded("points = [[0.1, 0.48], [0, 0.48]]\npressure = 5\n")),
              HasSubstr("key 'load[0]': expected either 'traction' or 'pressure', found both"));
  const std::string neither = changed(loaded("points = [[0.1, 0.48], [0, 0.48]]\n"), "traction = [0, -1000]\n", "");
  EXPECT_THAT(complaint(neither), HasSubstr("traction"));
  EXPECT_EQ(complaint(neither + "pressure = 1000\n"), "no complaint");
}

/// A block of soil in a box, its left half under a plate.
std::string under_plate(const std::string& line, const std::string& motion) {
  return R"([case]
end_time = 1
[[soil]]
min = [0, 0]
max = [0.4, 0.4]
[[wall]]
points = [[0, 0.5], [0, 0], [0.4, 0], [0.4, 0.5]]
[solid]
particle_spacing = 0.02
[[plate]]
name = "footing"
points = )" +
         line + "\n" + motion + "\n";
}

TEST_F(Mistakes, PlatesLieOnTheSoilBeforeThem) {
  const std::string sinks = "speed = 0.01";
  EXPECT_EQ(complaint(under_plate("[[0.2, 0.4], [0, 0.4]]", sinks)), "no complaint");
  EXPECT_EQ(complaint(under_plate("[[0.3, 0.4], [0.1, 0.4]]", sinks)), "no complaint");
  EXPECT_EQ(complaint(under_plate("[[0.4, 0.4], [0, 0.4]]", sinks)), "no complaint");
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.5], [0, 0.5]]", sinks)),
              HasSubstr("key 'plate[0]': the plate lies off the soil: 0 m of its line touch soil, expected at least"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.42], [0, 0.42]]", sinks)), HasSubstr("a gap is left between the plate"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.2], [0, 0.2]]", sinks)), HasSubstr("soil lies behind the plate"));
  EXPECT_THAT(complaint(under_plate("[[0, 0.4], [0.2, 0.4]]", sinks)), HasSubstr("soil lies behind the plate"))
      << "walked with the soil on the right";
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.4], [0.01, 0.4]]", sinks)), HasSubstr("lies 0.01 m off wall[0]"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.4], [-0.2, 0.4]]", sinks)), HasSubstr("crosses wall[0]"));
  EXPECT_THAT(complaint(under_plate("[[0, 0.4], [0, 0]]", sinks)), HasSubstr("lies on wall[0]"));
  const std::string wedge = under_plate("[[0.4, 0.2], [0, 0.4]]", sinks);
  EXPECT_THAT(complaint(changed(wedge, "min = [0, 0]\nmax = [0.4, 0.4]",
                                "shape = \"polygon\"\npoints = [[0, 0], [0.4, 0], [0.4, 0.2], [0, 0.4]]")),
              HasSubstr("the plate lies at an angle to the rows"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.4], [0.1, 0.4], [0, 0.4]]", sinks)),
              HasSubstr("expected its 2 ends, found 3 points"));
}

TEST_F(Mistakes, PlatesMoveInOneWay) {
  const std::string line = "[[0.2, 0.4], [0, 0.4]]";
  EXPECT_EQ(complaint(under_plate(line, "displacement = [[0, 0], [1, 0.01]]")), "no complaint");
  EXPECT_EQ(complaint(under_plate(line, "force = [[0, 0], [1, 100]]\nstart = 0\nmass = 10")), "no complaint");
  EXPECT_EQ(complaint(under_plate(line, "force = 100\nsurface = \"rough\"\nalong = [[0, 0], [1, 0.01]]")),
            "no complaint");
  EXPECT_THAT(complaint(under_plate(line, "")), HasSubstr("nothing says how the plate moves"));
  EXPECT_THAT(complaint(under_plate(line, "force = 100\nspeed = 1")), HasSubstr("found more"));
  EXPECT_THAT(complaint(under_plate(line, "displacement = 0.01")),
              HasSubstr("key 'plate[0].displacement': is the way since time zero"));
  EXPECT_THAT(complaint(under_plate(line, "displacement = [[0, 0], [2, 0.01], [1, 0.02]]")),
              HasSubstr("times that increase from row to row"));
  EXPECT_THAT(complaint(under_plate(line, "along = [[0, 0], [1, 0.01]]")), HasSubstr("expected surface = \"rough\""));
  EXPECT_THAT(complaint(under_plate(line, "speed = 1\nmass = 3")), HasSubstr("key 'plate[0].mass'"));
  EXPECT_THAT(complaint(under_plate(line, "speed = 1\nstart = 3")), HasSubstr("key 'plate[0].start'"));
}

TEST_F(Mistakes, PlatesTurnUnderAForceWithFreeEnds) {
  const std::string line = "[[0.3, 0.4], [0.1, 0.4]]", turns = "force = 100\ntilts = true\n";
  EXPECT_EQ(complaint(under_plate(line, turns)), "no complaint");
  EXPECT_EQ(complaint(under_plate(line, turns + "eccentricity = -0.09\nmoment = [[0, 0], [1, 5]]\nlifts = true")),
            "no complaint");
  for (const std::string key : {"eccentricity = 0.01", "moment = 3", "lifts = true"})
    EXPECT_THAT(
        complaint(under_plate(line, "force = 100\n" + key)),
        HasSubstr("key 'plate[0]." + key.substr(0, key.find(' ')) + "': without 'tilts' the plate does not turn"));
  EXPECT_THAT(
      complaint(under_plate(line, "displacement = [[0, 0], [1, 0.01]]\ntilts = true")),
      HasSubstr("key 'plate[0].tilts': a plate that moves in a prescribed way does not turn: expected 'force'"));
  EXPECT_THAT(complaint(under_plate(line, turns + "eccentricity = 0.1")),
              HasSubstr("key 'plate[0].eccentricity': the force acts beside the plate: expected less than half its "
                        "length, 0.1 m, found 0.1 m"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.4], [0, 0.4]]", turns)),
              HasSubstr("key 'plate[0].tilts': its end [0, 0.4] m lies 0 m off wall[0], which does not let it turn"));
  EXPECT_THAT(complaint(under_plate(line, turns) + "[[plate]]\npoints = [[0.1, 0.4], [0, 0.4]]\nspeed = 0.1\n"),
              HasSubstr("its end [0.1, 0.4] m lies 0 m off plate[1], which does not let it turn"));
  const std::string endless =
      changed(under_plate(line, turns), "points = " + line, "point = [0, 0.4]\nnormal = [0, -1]");
  EXPECT_THAT(complaint(endless), HasSubstr("key 'plate[0].tilts': a plate without ends has no middle to turn about"));
  EXPECT_THAT(complaint(under_plate(line, turns),
                        {"case.periodic=[\"x\"]", "case.domain_min=[0, 0]", "case.domain_max=[0.4, 1]"}),
              HasSubstr("expected no case.periodic"));
  const std::string water = "[fluid]\nparticle_spacing = 0.02\n[[fluid.region]]\nmin = [0, 0]\nmax = [0.4, 0.4]\n";
  const std::vector<std::string> field{"fluid.representation=\"field\""};
  EXPECT_EQ(complaint(under_plate(line, turns) + water, field), "no complaint");
  EXPECT_THAT(complaint(under_plate(line, turns + "lifts = true") + water, field),
              HasSubstr("key 'plate[0].lifts': the water in the gap under a plate that has come off is not computed"));
  EXPECT_THAT(complaint(under_plate(line, turns + "lifts = true") + "[[pore_pressure]]\npressure = 100\n"),
              HasSubstr("expected dry soil"));
  const std::string drain = "[[water_face]]\nname = \"drain\"\npoints = [[0.4, 0.4], [0, 0.4]]\npressure = 0\n";
  EXPECT_THAT(complaint(under_plate(line, turns) + water + drain, field),
              HasSubstr("water_face[0] \"drain\" lies on it and would not turn with it: expected a tight plate"));
}

TEST_F(Mistakes, APlateHasItsPlaceAndNameToItself) {
  const std::string left = under_plate("[[0.2, 0.4], [0, 0.4]]", "speed = 0.01");
  const auto second = [](const std::string& line, const std::string& name) {
    return "[[plate]]\nname = \"" + name + "\"\npoints = " + line + "\nspeed = 0.01\n";
  };
  EXPECT_EQ(complaint(left + second("[[0.4, 0.4], [0.2, 0.4]]", "right")), "no complaint");
  EXPECT_THAT(complaint(left + second("[[0.4, 0.4], [0.2, 0.4]]", "footing")),
              HasSubstr("key 'plate[1].name': expected a name of its own, found \"footing\" twice"));
  EXPECT_THAT(complaint(left + second("[[0.3, 0.4], [0.1, 0.4]]", "right")),
              HasSubstr("key 'plate[1]': lies on plate[0] at [0.15, 0.4] m: expected one plate at each place"));
  const auto load = [](const std::string& line) { return "[[load]]\npoints = " + line + "\npressure = 1000\n"; };
  EXPECT_EQ(complaint(left + load("[[0.4, 0.4], [0.2, 0.4]]")), "no complaint");
  EXPECT_THAT(complaint(left + load("[[0.4, 0.4], [0, 0.4]]")),
              HasSubstr("key 'plate[0]': lies on load[0] at [0.1, 0.4] m, which acts on the soil"));
}

TEST_F(Mistakes, WhatBeginsAfterTheEndIsDoubted) {
  const std::string line = "[[0.2, 0.4], [0, 0.4]]";
  EXPECT_EQ(warnings(under_plate(line, "force = 100\nstart = 0.5")), "");
  EXPECT_THAT(warnings(under_plate(line, "force = 100\nstart = 3")),
              HasSubstr("key 'plate[0].start': has no effect: it is 3 s, and the run ends at 1 s"));
  const std::string load = "[[load]]\npoints = [[0.4, 0.4], [0.2, 0.4]]\npressure = 1000\nstart = 1\n";
  EXPECT_THAT(warnings(under_plate(line, "force = 100") + load), HasSubstr("key 'load[0].start': has no effect"));
}

TEST_F(Mistakes, SofteningNeedsAStrengthThatFalls) {
  const std::string soil =
      changed(under_plate("[[0.2, 0.4], [0, 0.4]]", "speed = 0.01"), "max = [0.4, 0.4]",
              "max = [0.4, 0.4]\nmodel = \"mohr_coulomb\"\ncohesion = 1000\nsoftening_slip = 0.01");
  EXPECT_THAT(warnings(soil), HasSubstr("key 'soil[0].softening_slip': has no effect: no strength falls"));
  EXPECT_EQ(warnings(changed(soil, "softening_slip", "residual_cohesion = 500\nsoftening_slip")), "");
}

TEST_F(Mistakes, PlatesStandWhereTheyAreComputed) {
  const std::string footing = under_plate("[[0.2, 0.4], [0, 0.4]]", "speed = 0.01");
  EXPECT_THAT(complaint(footing + "[solid.quiet]\n"), HasSubstr("expected no [solid.quiet] beside it"));
  const std::string water = "[fluid]\nparticle_spacing = 0.02\n[[fluid.region]]\nmin = [0, 0]\nmax = [0.4, 0.4]\n";
  EXPECT_THAT(complaint(footing + water, {"solid.model=\"rigid\""}), HasSubstr("nothing gives way to a plate"));
  EXPECT_THAT(complaint(footing + water), HasSubstr("key 'plate[0]': water particles do not see a plate"));
  EXPECT_EQ(complaint(footing + water, {"fluid.representation=\"field\""}), "no complaint");
  const std::string gauge = "[[gauge]]\nname = \"q\"\nphase = \"solid\"\nkind = \"plate\"\n";
  EXPECT_EQ(complaint(footing + gauge + "quantity = \"footing\"\n"), "no complaint");
  EXPECT_THAT(complaint(footing + gauge + "quantity = \"foting\"\n"), HasSubstr("footing"));
}

TEST_F(Mistakes, PlatesIn3DAreRectanglesOnBoxes) {
  const auto block = [](const std::string& plate) {
    return R"([case]
dimension = 3
end_time = 1
[[soil]]
min = [0, 0, 0]
max = [0.4, 0.4, 0.4]
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[wall]]
point = [0, 0, 0]
normal = [1, 0, 0]
[solid]
particle_spacing = 0.02
[[plate]]
speed = 0.01
)" + plate;
  };
  const std::string top = "point = [0, 0, 0.4]\nnormal = [0, 0, -1]\n";
  const auto within = [&](const std::string& min, const std::string& max) {
    return block(top + "within = { min = " + min + ", max = " + max + " }\n");
  };
  EXPECT_EQ(complaint(block(top)), "no complaint");
  EXPECT_EQ(complaint(within("[-1, 0.1, 0]", "[0.2, 0.2, 1]")), "no complaint");
  EXPECT_THAT(complaint(within("[0.01, 0.1, 0]", "[0.2, 0.2, 1]")), HasSubstr("its rim at x = 0.01 m lies 0.01 m off"));
  EXPECT_THAT(complaint(within("[0, 0.1, 0]", "[0.2, 0.2, 0.3]")), HasSubstr("found none of z = 0.4 m in it"));
  EXPECT_THAT(complaint(within("[0, 0.1, 0]", "[0.2, 0.12, 1]")),
              HasSubstr("shorter side is 0.02 m: expected at least 0.04"));
  EXPECT_THAT(complaint(within("[0.2, 0.39, 0]", "[0.3, 0.6, 1]")),
              HasSubstr("touch soil, expected at least 0.0016 m2"));
  EXPECT_THAT(complaint(block("points = [[0.2, 0, 0.4], [0, 0, 0.4]]\n")), HasSubstr("expected 'point' and 'normal'"));
  EXPECT_THAT(complaint(block("point = [0, 0, 0.4]\nnormal = [0, 0.1, -1]\n")), HasSubstr("along an axis"));
  EXPECT_THAT(complaint(block("point = [0, 0, 0.42]\nnormal = [0, 0, -1]\n")), HasSubstr("a gap is left between"));
  EXPECT_THAT(complaint(block("point = [0, 0, 0.2]\nnormal = [0, 0, -1]\n")), HasSubstr("soil lies behind the plate"));
  EXPECT_THAT(complaint(block("point = [0, 0, 0]\nnormal = [0, 0, 1]\n")), HasSubstr("lies on wall[0]"));
  EXPECT_THAT(complaint(block(top + "surface = \"rough\"\nalong = [[0, 0], [1, 0.01]]\n")),
              HasSubstr("belongs to dimension = 2"));
  EXPECT_THAT(complaint(block(top + "tilts = true\n")),
              HasSubstr("key 'plate[0].tilts': belongs to dimension = 2, found dimension = 3"));
  EXPECT_THAT(complaint(block(top + "within = { shape = \"ball\", centre = [0, 0, 0.4], radius = 0.2 }\n")),
              HasSubstr("a plate in 3D is a rectangle"));
  EXPECT_THAT(complaint(block(top + "within = { min = [0, 0, 0], max = [1, 1, 1], turn = 30, axis = [0, 0, 1] }\n")),
              HasSubstr("without turn, scale, move and cuts"));
  EXPECT_THAT(complaint(changed(block(top), "min = [0, 0, 0]\nmax = [0.4, 0.4, 0.4]",
                                "shape = \"cylinder\"\nends = [[0.2, 0.2, 0], [0.2, 0.2, 0.4]]\nradius = 0.2")),
              HasSubstr("soil of another shape is packed"));
  EXPECT_THAT(complaint(changed(block(top), "normal = [1, 0, 0]", "normal = [1, 0, 0]\nsoil = \"rough\""),
                        {"case.domain_min=[0, 0, 0]", "case.domain_max=[1, 1, 1]"}),
              HasSubstr("wall[1] has rows of soil behind it, which no plate would meet"));
  const std::string field =
      "[fluid]\nrepresentation = \"field\"\nparticle_spacing = 0.02\ninitial_water_table = 0.4\n"
      "[[water_face]]\npoint = [0.4, 0, 0]\nnormal = [-1, 0, 0]\nhead = 0.4\n";
  EXPECT_THAT(complaint(block(top) + field), HasSubstr("plates in 3D stand beside dry soil only"));
  EXPECT_THAT(complaint(under_plate("[[0.2, 0.4], [0, 0.4]]", "speed = 0.01\nwithin = { min = [0, 0], max = [1, 1] }")),
              HasSubstr("belongs to dimension = 3"));
}

TEST_F(Mistakes, NoTightPlateMovesWithTheSoil) {
  const std::string strip = R"([case]
gravity = [0, 0]
end_time = 8
[[soil]]
min = [0, 0]
max = [0.25, 0.75]
[[wall]]
points = [[0, 0.75], [0, 0], [0.25, 0]]
[[wall]]
name = "tight end"
points = [[0.25, 0.75], [0, 0.75]]
soil = "none"
[[water_face]]
points = [[0.25, 0], [0.25, 0.75]]
pressure = 0
[[load]]
name = "end load"
points = [[0.25, 0.75], [0, 0.75]]
traction = [0, -1000]
[fluid]
particle_spacing = 0.0125
[[fluid.region]]
min = [0, 0]
max = [0.25, 0.75]
)";
  EXPECT_THAT(complaint(strip),
              HasSubstr("key 'wall[1]': a wall stands still, but load[0] \"end load\" moves the soil there"));
  EXPECT_EQ(complaint(strip, {"load.0.points=[[0.25,0],[0.25,0.75]]"}), "no complaint");
}

TEST_F(Mistakes, WithoutFrictionTensionNeedsALimit) {
  const std::string cut = changed(changed(slope, "[3, 1], [2, 2]", "[3, 0.5], [3, 2.5]"), "[0, 2]", "[0, 2.5]");
  EXPECT_EQ(complaint(cut), "no complaint");
  EXPECT_THAT(
      complaint(cut, {"soil.0.friction_angle=0"}),
      HasSubstr("key 'soil[0].tensile_strength': the soil stands 2 m high, more than the 1.03 m that its cohesion "
                "bears, and with friction_angle = 0"));
  EXPECT_EQ(complaint(cut, {"soil.0.friction_angle=0", "soil.0.tensile_strength=0"}), "no complaint");
  EXPECT_EQ(complaint(cut, {"soil.0.friction_angle=0", "soil.0.cohesion=12e3"}), "no complaint") << "it stands";
  EXPECT_EQ(complaint(cut, {"soil.0.friction_angle=0", "soil.0.cohesion=1"}), "no complaint") << "it is a liquid";
  EXPECT_EQ(complaint(cut, {"soil.0.friction_angle=0", "solid.model=elastic"}), "no complaint");
}

TEST_F(Mistakes, AFarSceneComesToTheOrigin) {
  const auto moved = [&](double by) {
    std::string text = slope;
    for (const auto& [from, to] : {std::pair{"[[0, 0], [6, 0], [6, 1], [3, 1], [2, 2], [0, 2]]",
                                             "[[{0}, 0], [{1}, 0], [{1}, 1], [{2}, 1], [{3}, 2], [{0}, 2]]"},
                                   {"[[0, 3], [0, 0]]", "[[{0}, 3], [{0}, 0]]"},
                                   {"[[0, 0], [6, 0]]", "[[{0}, 0], [{1}, 0]]"},
                                   {"[[6, 0], [6, 3]]", "[[{1}, 0], [{1}, 3]]"}})
      text = changed(text, from, fmt::format(fmt::runtime(to), by, by + 6, by + 3, by + 2));
    return text +
           fmt::format("[[gauge]]\nname = \"s\"\nphase = \"solid\"\nkind = \"height\"\npoints = [[{}, 0.5]]\n", by + 1);
  };
  const Case near = read(moved(0.0)), far = read(moved(533244.0)), farther = read(moved(1e7));
  const Case not_far = read(moved(9000.0)), left = read(moved(-9000.0)), beside = read(moved(5.0));
  EXPECT_EQ(near.general.origin, Point3::Zero());
  EXPECT_EQ(far.general.origin, Point3(533244, 0, 0));
  EXPECT_EQ(farther.general.origin, Point3(1e7, 0, 0));
  EXPECT_EQ(not_far.general.origin, Point3(9000, 0, 0));
  EXPECT_EQ(left.general.origin, Point3(-9000, 0, 0));
  EXPECT_EQ(beside.general.origin, Point3::Zero()) << "near";
  for (const Case* scene : {&far, &farther, &not_far, &left}) {
    EXPECT_EQ(scene->coupled_part(), near.coupled_part());
    EXPECT_EQ(scene->gauges[0].points[0], near.gauges[0].points[0]);
  }
  // Messages use the coordinates of the file.
  EXPECT_THAT(complaint(changed(moved(1e7), "[10000006, 0], [10000006, 1]", "[10000006, 1], [10000006, 0]")),
              HasSubstr("edges 1-2 and 3-4 cross at [10000004, 0.66666"));
  // Heads are measured from elevation zero, so that a scene cannot be moved vertically.
  EXPECT_THAT(complaint("[case]\nend_time = 1\n[[soil]]\nmin = [0, 600000]\nmax = [1, 600001]\n[[wall]]\npoints = [[0, "
                        "600000], [1, 600000]]\n[solid]\nparticle_spacing = 0.1\n"),
              HasSubstr("key 'soil[0]': lies at y = 600000 m, 6e+06 particle spacings from the origin"));
}

TEST_F(Mistakes, WhatIsHardlyMeantIsSaid) {
  EXPECT_EQ(warnings(slope), "");
  EXPECT_EQ(warnings(dam), "");
  EXPECT_EQ(warnings(tank), "");
  EXPECT_THAT(
      warnings(slope, {"soil.0.youngs_modulus=10e3"}),
      HasSubstr("key 'soil[0].youngs_modulus': the weight of 2 m of soil strains it by 275 % (rho g H / M), expected 5 "
                "% at most; youngs_modulus is in Pa, found 10000"));
  EXPECT_THAT(warnings(slope, {"soil.0.grain_density=2.7"}), HasSubstr("grain_density is in kg/m3"));
  EXPECT_THAT(warnings(tank, {"water.density=1"}), HasSubstr("key 'water.density'"));
  EXPECT_THAT(warnings(dam, {"soil.0.hydraulic_conductivity=10"}), HasSubstr("10 m/s is more than gravel has"));
  EXPECT_THAT(warnings(slope, {"case.gravity=[0,9.81]", "solid.initial_rest=false"}),
              HasSubstr("key 'case.gravity': points upwards"));
  EXPECT_THAT(warnings(dam, {"water_face.0.head=-0.2"}), HasSubstr("key 'water_face[0].head': never wets the face"));
  EXPECT_THAT(warnings(dam, {"water_face.0.head=0"}), HasSubstr("no water is there and none ever comes in"));
  EXPECT_THAT(warnings(dam, {"fluid.particle_spacing=0.1"}), HasSubstr("key 'soil[0]': is 0.4 m thin, 4 rows"));
  EXPECT_THAT(warnings(changed(tank, "[1, 0], [1, 1]", "[0.15, 0], [0.15, 1]"), {"fluid.region.0.max=[0.15,0.5]"}),
              HasSubstr("leaves 0.15 m for water beside wall[0] at [0, 0."));
}

TEST_F(Mistakes, NumbersInOtherMeasuresAreDoubted) {
  const auto doubt = [&](const std::vector<std::string>& set) { return warnings(slope, set); };
  EXPECT_EQ(doubt({}), "");
  EXPECT_THAT(doubt({"soil.0.friction_angle=0.44"}), HasSubstr("angles are in degrees"));
  EXPECT_THAT(doubt({"wall.0.soil=\"frictional\"", "wall.0.friction_angle=0.35"}), HasSubstr("wall[0].friction_angle"));
  EXPECT_THAT(doubt({"soil.0.earth_pressure_at_rest=50"}), HasSubstr("is a ratio"));
  EXPECT_EQ(doubt({"soil.0.earth_pressure_at_rest=3"}), "");
  const std::string grains = changed(slope, "cohesion = 5000\n", "");
  EXPECT_THAT(warnings(grains, {"solid.model=\"mu_i\"", "soil.0.static_friction=20", "soil.0.limiting_friction=32",
                                "soil.0.grain_diameter=1"}),
              AllOf(HasSubstr("static_friction"), HasSubstr("limiting_friction"), HasSubstr("grain_diameter is in m")));
  EXPECT_THAT(complaint(slope, {"solid.model=\"modified_cam_clay\"", "soil.0.earth_pressure_at_rest=0.6",
                                "soil.0.critical_state_slope=25"}),
              AllOf(HasSubstr("soil[0].critical_state_slope"), HasSubstr("expected less than 3")));
  EXPECT_THAT(doubt({"solid.quiet.sleep_below=0.1", "solid.quiet.wake_above=0.01"}),
              HasSubstr("solid.quiet.sleep_below"));
}

TEST_F(Mistakes, TablesAfterTheEndAreDoubted) {
  const std::string loaded =
      slope + "[[load]]\npoints = [[2, 2], [0, 2]]\npressure = 1e3\nfactor = [[0, 0], [0.2, 1]]\n";
  EXPECT_EQ(warnings(loaded), "");
  EXPECT_THAT(warnings(loaded, {"load.0.factor=[[5, 0], [6, 1]]"}),
              AllOf(HasSubstr("load[0].factor"), HasSubstr("its first value, 0, holds throughout")));
}

TEST_F(Mistakes, PorePressuresWithoutSoilAreDoubted) {
  const std::string wet =
      slope + "[[pore_pressure]]\nhead = 0.5\n[pore_pressure.region]\nmin = [{}, 0]\nmax = [9, 1]\n";
  EXPECT_EQ(warnings(fmt::format(fmt::runtime(wet), 0)), "");
  EXPECT_THAT(warnings(fmt::format(fmt::runtime(wet), 7)), HasSubstr("no soil lies in it"));
  EXPECT_THAT(warnings(slope + "[[pore_pressure]]\nhead = 0.5\n[[pore_pressure]]\nhead = 0.4\n"),
              AllOf(HasSubstr("pore_pressure[1]"), HasSubstr("has no effect")));
}

TEST_F(Mistakes, SeriesOfGaugesHaveNamesOfTheirOwn) {
  const auto gauges = [](const char* name) {
    return tank + fmt::format(
                      "[[gauge]]\nname = \"w\"\nphase = \"fluid\"\nkind = \"balance\"\n"
                      "[[gauge]]\nname = \"{}\"\nphase = \"fluid\"\nkind = \"volume\"\n",
                      name);
  };
  EXPECT_EQ(complaint(gauges("w_all")), "no complaint");
  for (const char* name : {"w_in", "w[0]"})
    EXPECT_THAT(complaint(gauges(name)), AllOf(HasSubstr("gauge[1].name"), HasSubstr("stands in gauges.csv"))) << name;
}

TEST_F(Mistakes, RegionsOfGaugesHoldSomething) {
  const std::string there = tank +
                            "[[gauge]]\nname = \"v\"\nphase = \"fluid\"\nkind = \"volume\"\n"
                            "[gauge.region]\nmin = [{}, 0]\nmax = [9, 9]\n";
  EXPECT_EQ(complaint(fmt::format(fmt::runtime(there), 0.9)), "no complaint");
  EXPECT_THAT(complaint(fmt::format(fmt::runtime(there), 1.1)),
              AllOf(HasSubstr("gauge[0].region"), HasSubstr("found one outside")));
}

/// Behind a wall the images of the water would be read.
TEST_F(Mistakes, LinesForForcesOfParticlesEndInTheDomain) {
  const std::string force =
      tank + "[[gauge]]\nname = \"f\"\nphase = \"fluid\"\nkind = \"pressure_force\"\npoints = [[0, 0], [{}, 0]]\n";
  EXPECT_EQ(complaint(fmt::format(fmt::runtime(force), 1)), "no complaint");
  EXPECT_THAT(complaint(fmt::format(fmt::runtime(force), 1.5)),
              AllOf(HasSubstr("gauge[0].points"), HasSubstr("found [1.5, 0] m outside")));
}

TEST_F(Mistakes, KeysWithoutEffectAreSaid) {
  EXPECT_THAT(warnings(dam, {"soil.0.model=elastic"}),
              HasSubstr("key 'soil[0].model': has no effect: with solid.model = \"rigid\" no soil moves"));
  EXPECT_THAT(warnings(changed(dam, "model = \"rigid\"", "model = \"rigid\"\ncourant = 0.5\njitter = 0.1")),
              HasSubstr("key 'solid': has no effect (courant, jitter): with solid.model = \"rigid\""));
  EXPECT_THAT(warnings(tank, {"fluid.sweeps=5"}), HasSubstr("key 'fluid.sweeps': has no effect"));
  EXPECT_THAT(warnings(tank, {"fluid.seed=5"}), HasSubstr("fluid.jitter is 0"));
  EXPECT_THAT(warnings(tank, {"coupling.scheme=parallel"}), HasSubstr("one phase runs alone"));
  EXPECT_THAT(warnings(slope, {"solid.initial_seepage=true"}),
              HasSubstr("key 'solid.initial_seepage': has no effect: no water drags at the soil"));
  EXPECT_THAT(warnings(slope, {"solid.initial_seepage=true", "solid.initial_rest=false"}),
              HasSubstr("key 'solid.initial_seepage': has no effect: solid.initial_rest = false"));
  EXPECT_THAT(warnings(slope, {"fluid.jitter=0.2"}), HasSubstr("there is no water"));
  EXPECT_THAT(warnings(tank, {"case.domain_max=[1,1]"}), HasSubstr("no axis is periodic"));
  EXPECT_THAT(
      warnings(tank +
               "[[gauge]]\nname = \"n\"\nphase = \"fluid\"\nkind = \"particles\"\nquantity = \"x\"\nthickness = 1\n"),
      testing::AllOf(HasSubstr("key 'gauge[0].quantity': has no effect"),
                     HasSubstr("key 'gauge[0].thickness': has no effect")));
  EXPECT_THAT(warnings(dam + "[[load]]\npoints = [[0.8, 0.4], [0.4, 0.4]]\ntraction = [0, -1]\n"),
              HasSubstr("key 'load[0]': has no effect"));
}

TEST_F(Mistakes, SuspendedGrainsAreLooserThanInContactAndNotAtRest) {
  const std::vector<std::string> suspended{"soil.0.contact_porosity=0.28", "solid.initial_rest=false"};
  EXPECT_EQ(complaint(slope, suspended), "no complaint");
  EXPECT_THAT(complaint(slope, {"soil.0.contact_porosity=0.3", "solid.initial_rest=false"}),
              HasSubstr("key 'soil[0].contact_porosity': expected less than the porosity of 0.3"));
  EXPECT_THAT(complaint(slope, {"soil.0.contact_porosity=0.28"}), HasSubstr("expected solid.initial_rest = false"));
  EXPECT_THAT(warnings(dam, {"soil.0.contact_porosity=0.28"}),
              HasSubstr("key 'soil[0].contact_porosity': has no effect"));
}

/// A bed under free water, which erodes it.
std::string eroding(const std::string& erosion) {
  return R"([case]
end_time = 1
[[soil]]
min = [0, 0]
max = [1, 0.3]
erosion = )" +
         erosion + R"(
[[wall]]
points = [[0, 1], [0, 0], [1, 0], [1, 1]]
[fluid]
particle_spacing = 0.02
[[fluid.region]]
min = [0, 0]
max = [1, 0.5]
[solid]
model = "elastic"
)";
}

TEST_F(Mistakes, ErosionThatIsNotComputed) {
  const std::string law = "{ friction_factor = 0.05, erodibility = 1e-5 }", bed = eroding(law);
  EXPECT_EQ(complaint(bed), "no complaint");
  EXPECT_THAT(complaint(eroding("{ erodibility = 1e-5 }")), HasSubstr("key 'soil[0].erosion.friction_factor'"));
  EXPECT_THAT(complaint(eroding("{ friction_factor = 0.05 }")),
              HasSubstr("case.toml:6: key 'soil[0].erosion.erodibility': the law \"excess_shear\" needs it"));
  EXPECT_THAT(complaint(eroding("{ friction_factor = 0.05, erodibility = -1 }")), HasSubstr("expected a number >= 0"));
  EXPECT_THAT(complaint(eroding("{ friction_factor = 0, erodibility = 1e-5 }")), HasSubstr("expected a number > 0"));
  EXPECT_THAT(complaint(eroding("{ friction_factor = 0.05, erodibility = 1e-5, critical_shear_stress = -1 }")),
              HasSubstr("expected a number >= 0"));
  EXPECT_THAT(complaint(eroding("{ model = \"bed_load\", friction_factor = 0.05 }")), HasSubstr("\"excess_shear\""));
  EXPECT_THAT(complaint(changed(bed, "\"elastic\"", "\"rigid\"")),
              HasSubstr("key 'soil[0].erosion': soil that loses its surface must be computed"));
  EXPECT_THAT(
      complaint(changed(bed,
                        "[fluid]\nparticle_spacing = 0.02\n[[fluid.region]]\nmin = [0, 0]\nmax = [1, 0.5]\n[solid]\n",
                        "[solid]\nparticle_spacing = 0.02\n")),
      HasSubstr(
          "only free water erodes: expected [[fluid.region]] and fluid.representation = \"particles\", found no"));
  EXPECT_THAT(complaint(bed + "[coupling]\nscheme = \"parallel\"\n"), HasSubstr("key 'coupling.scheme'"));
  EXPECT_THAT(complaint(changed(bed, "particle_spacing = 0.02", "particle_spacing = 0.02\nskeleton_response = false")),
              HasSubstr("key 'fluid.skeleton_response'"));
  EXPECT_THAT(complaint(bed + "[[load]]\npoints = [[1, 0.3], [0, 0.3]]\npressure = 10\n"), HasSubstr("key 'load[0]'"));
}

TEST_F(Mistakes, CommonSlipsOfThePenAreNamed) {
  EXPECT_THAT(complaint(changed(tank, "\"rigid\"", "\"rigid")),
              HasSubstr("case.toml:9: not valid TOML: a quote \" is missing in: model = \"rigid"));
  EXPECT_THAT(complaint(changed(tank, "\"rigid\"", "rigid")), HasSubstr("a text stands in quotes, \"rigid\""));
  EXPECT_THAT(complaint(changed(tank, "0.05", "0,05")), HasSubstr("a number has a decimal point"));
  EXPECT_THAT(complaint(changed(tank, "0.05", "0.05 m")), HasSubstr("expected a number alone"));
  EXPECT_THAT(complaint(changed(tank, "[1, 0.5]", "[1, 0.5")),
              HasSubstr("the array that begins in line 7 is not closed"));
  EXPECT_THAT(complaint(changed(tank, "end_time = 1", "end_time = 1\nend_time = 2")), HasSubstr("cannot redefine"));
  EXPECT_THAT(complaint(changed(tank, "[[wall]]", "[wall]")), HasSubstr("write [[wall]], in double brackets"));
  EXPECT_THAT(complaint(changed(dam, "shape = \"polygon\"\n", "")),
              HasSubstr("key 'soil[0].shape' is missing: expected shape = \"polygon\" with 'points'"));
  EXPECT_THAT(complaint(""), HasSubstr("the file is empty"));
  EXPECT_THAT(complaint("# nothing yet\n"), HasSubstr("the file is empty"));
}

}  // namespace
}  // namespace poretwin
