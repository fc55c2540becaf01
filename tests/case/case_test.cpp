// The case file: values are read; mistakes are reported with file, line, key, what was expected and what was found.
#include "tests/case/case_file.hpp"

#include "common/case/document.hpp"
#include "common/case/keys.hpp"
#include "common/case/pace.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace poretwin {
namespace {

using testing::HasSubstr;

const std::string sound_case = R"([case]
title = "column"
end_time = 3.6
gravity = [0, 0]
[[soil]]
shape = "box"
min = [0, 0]
max = [0.1, 0.4]
porosity = 0.4
[[wall]]
name = "base"
points = [[0, 0], [0.1, 0]]
soil = "fixed"
[[water_face]]
points = [[0.1, 0.4], [0, 0.4]]
pressure = 0
[[load]]
points = [[0.1, 0.4], [0, 0.4]]
traction = [0, -1000]
start = 0
[fluid]
particle_spacing = 0.01
[[fluid.region]]
min = [0, 0]
max = [0.1, 0.4]
[[gauge]]
name = "settlement"
phase = "solid"
kind = "point"
quantity = "displacement_y"
points = [[0.05, 0.4]]
)";

TEST_F(CaseFile, ArrivesInTheStruct) {
  const Case scene = read(sound_case);
  EXPECT_EQ(scene.general.title, "column");
  EXPECT_EQ(scene.general.gravity, Point3::Zero());
  ASSERT_EQ(scene.soils.size(), 1u);
  EXPECT_DOUBLE_EQ(scene.soils[0].shape.max.y(), 0.4);
  EXPECT_EQ(scene.walls[0].soil, Wall::ForSoil::fixed);
  EXPECT_EQ(scene.walls[0].water, Wall::ForWater::free_slip);
  ASSERT_TRUE(scene.water_faces[0].pressure);
  EXPECT_FALSE(scene.water_faces[0].head);
  EXPECT_EQ(scene.loads[0].start, 0.0);
  EXPECT_DOUBLE_EQ(scene.solid.particle_spacing, 0.01);
  EXPECT_TRUE(scene.coupled());
  EXPECT_EQ(scene.text, sound_case);
}

/// The shortest characteristic time belongs to the fastest of all motions over one spacing.
TEST_F(CaseFile, HasAShortestTime) {
  Case scene = read(sound_case);
  const auto is = [&](double time, const char* of_what) {
    const auto [shortest, said] = shortest_time(scene);
    EXPECT_NEAR(shortest, time, 1e-6 * time);
    EXPECT_THAT(said, HasSubstr(of_what));
  };
  // E = 3 MPa, nu = 0.3, n = 0.4, grains of 2600 kg/m3: constrained modulus M = 4.0385 MPa.
  is(0.01 / std::sqrt(4.0384615e6 / 1560.0), "a wave of the soil");
  scene.solid.model = SolidCase::Model::rigid;
  is(std::sqrt(0.01 / 9.81), "a fall");
  scene.fluid.representation = FluidCase::Representation::field;
  const auto drained = scene.water_faces[0].pressure;
  scene.water_faces[0].pressure->knots = {{0.0, 9810.0}};  // 1 m of water
  is(0.01 / (scene.soils[0].hydraulic_conductivity / 0.4 * (1.0 + 1.0 / 0.01)), "a front's way");
  scene.fluid.representation = FluidCase::Representation::particles;
  scene.water_faces[0].pressure = drained;
  scene.water.kinematic_viscosity = 1e-2;
  is(0.01, "viscosity");
  scene.water_faces[0].pressure->knots = {{0.0, 2e6}};
  is(0.01 / std::sqrt(4e3), "a jet");
  scene.fluid.initial_velocity.x() = 100.0;
  is(1e-4, "initial speed");
  scene.coupling.interval = 1e-5;
  is(1e-5, "coupling.interval");
  scene.output.interval = 1e-6;
  is(1e-6, "output.interval");
  scene.general.end_time = 1e-7;
  is(1e-7, "the whole run");
  scene.fluid.scheme = FluidCase::Scheme::eisph;
  scene.soils[0].hydraulic_conductivity = 1e-8;
  is(1e-8 / 9.81, "the drag");
}

TEST_F(CaseFile, GravityPointsDownTheLastAxis) {
  const std::string fluid = "[fluid]\nparticle_spacing = 0.1\n[solid]\nmodel = \"rigid\"\n[[fluid.region]]\n";
  EXPECT_EQ(read("[case]\nend_time = 1\n" + fluid + "min = [0, 0]\nmax = [1, 1]\n").general.gravity,
            Point3(0, -9.81, 0));
  EXPECT_EQ(
      read("[case]\ndimension = 3\nend_time = 1\n" + fluid + "min = [0, 0, 0]\nmax = [1, 1, 1]\n").general.gravity,
      Point3(0, 0, -9.81));
}

TEST_F(CaseFile, SeriesInterpolatesAndHolds) {
  const Case scene = read(changed(sound_case, "pressure = 0", "head = [[0, 0.1], [10, 0.3]]"));
  EXPECT_DOUBLE_EQ(scene.water_faces[0].head->at(-1), 0.1);
  EXPECT_DOUBLE_EQ(scene.water_faces[0].head->at(5), 0.2);
  EXPECT_DOUBLE_EQ(scene.water_faces[0].head->at(20), 0.3);
}

TEST_F(CaseFile, NamesTheNearestKey) {
  EXPECT_THAT(
      complaint(changed(sound_case, "porosity", "porosty")),
      HasSubstr("case.toml:9: key 'soil[0].porosty' is not known; did you mean 'porosity'? Keys here: name, shape"));
  EXPECT_THAT(complaint(changed(sound_case, "[[load]]", "[[lod]]")),
              HasSubstr("key 'lod' is not known; did you mean 'load'?"));
}

TEST_F(CaseFile, NamesTypeAndRange) {
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "porosity = -0.4")),
              HasSubstr("case.toml:9: key 'soil[0].porosity': expected a number in (0, 1), found -0.4"));
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "porosity = \"high\"")),
              HasSubstr("found the text \"high\""));
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "poissons_ratio = 0.5")),
              HasSubstr("expected a number in [0, 0.5)"));
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "youngs_modulus = nan")),
              HasSubstr("expected a number > 0 in Pa, found nan"));
  EXPECT_THAT(complaint(changed(sound_case, "end_time = 3.6", "dimension = 4")),
              HasSubstr("a whole number in [2, 3], found 4"));
  EXPECT_THAT(complaint(changed(sound_case, "soil = \"fixed\"", "soil = \"fixd\"")),
              HasSubstr("did you mean \"fixed\"?"));
  EXPECT_THAT(complaint(changed(sound_case, "max = [0.1, 0.4]", "max = [0.1, 0.4, 1]")),
              HasSubstr("expected [x, y] in m, found [0.1, 0.4, 1]"));
  EXPECT_THAT(complaint(changed(sound_case, "end_time = 3.6\n", "")), HasSubstr("key 'case.end_time' is missing"));
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "porosity = ")),
              HasSubstr("case.toml:9: not valid TOML"));
}

TEST_F(CaseFile, NamesTheOverride) {
  EXPECT_DOUBLE_EQ(read(sound_case, {"soil.0.porosity=0.3"}).soils[0].porosity, 0.3);
  EXPECT_EQ(read(sound_case, {"solid.model=drucker_prager"}).solid.model, SolidCase::Model::drucker_prager);
  EXPECT_DOUBLE_EQ(*read(sound_case, {"coupling.interval=1e-3"}).coupling.interval, 1e-3);
  EXPECT_THAT(complaint(sound_case, {"soil[0].porosity=2"}),
              HasSubstr("--set soil[0].porosity=2: key 'soil[0].porosity': expected a number in (0, 1), found 2"));
  EXPECT_THAT(complaint(sound_case, {"soil.3.porosity=0.2"}),
              HasSubstr("the case has 1 [[soil]], counted from 0: expected soil.0, found soil.3"));
  EXPECT_THAT(complaint(sound_case, {"soil.porosity=0.2"}),
              HasSubstr("the case has 1 [[soil]]: expected soil.0 with its number, found 'porosity'"));
  EXPECT_THAT(complaint(sound_case, {"pore_pressure.0.head=1"}), HasSubstr("the case has no [[pore_pressure]]"));
  EXPECT_THAT(complaint(sound_case, {"fluid.jiter=0.2"}), HasSubstr("did you mean 'jitter'?"));
  EXPECT_THAT(complaint(sound_case, {"nonsense"}), HasSubstr("expected section.key=value"));
}

TEST(Choice, IsTheFirstWordWhereItIsNone) {
  constexpr std::array words{std::pair<std::string_view, int>{"one", 1}, std::pair<std::string_view, int>{"two", 2}};
  int value = 0;
  std::optional<int> free;
  read_keys(parse_document("", "nowhere"), [&](Keys& keys) {
    keys.choice<int>("some", value, words, {});
    keys.choice<int>("any", free, words, {});
  });
  EXPECT_EQ(value, 1);
  EXPECT_FALSE(free);
}

TEST_F(CaseFile, EachSoilMayHaveAMaterialOfItsOwn) {
  const auto second = sound_case + "[[soil]]\nmin = [0, 0.5]\nmax = [0.1, 0.6]\nmodel = \"drucker_prager\"\n";
  const Case both = read(second);
  EXPECT_EQ(both.model_of(both.soils[0]), MaterialName::elastic);
  EXPECT_EQ(both.model_of(both.soils[1]), MaterialName::drucker_prager);
  EXPECT_TRUE(both.can_yield());
  EXPECT_FALSE(read(sound_case).can_yield());
  EXPECT_FALSE(read(sound_case, {"solid.model=drucker_prager", "soil.0.model=elastic"}).can_yield());
  const Case paper = read(second, {"case.scheme=paper"});
  EXPECT_EQ(paper.model_of(paper.soils[1]), MaterialName::drucker_prager_rate);
  EXPECT_NE(both.digest(), read(second, {"soil.1.model=elastic"}).digest());
  EXPECT_THAT(
      complaint(second, {"soil.1.model=drucker_prage"}),
      HasSubstr("expected one of \"elastic\", \"drucker_prager\", \"drucker_prager_rate\", "
                "\"mohr_coulomb\", \"modified_cam_clay\", \"mu_i\", \"umat\", found the text \"drucker_prage\"; "
                "did you mean \"drucker_prager\"?"));
}

TEST_F(CaseFile, TakesThePapersDefaultsByName) {
  const Case own = read(sound_case, {"solid.model=drucker_prager"});
  EXPECT_EQ(own.fluid.scheme, FluidCase::Scheme::projection);
  const Case moving = read(sound_case, {"case.scheme=paper", "solid.model=drucker_prager", "solid.courant=0.3"});
  EXPECT_EQ(moving.fluid.scheme, FluidCase::Scheme::eisph_explicit_drag);
  EXPECT_FALSE(moving.fluid.skeleton_response);
  EXPECT_EQ(moving.fluid.drag_form, FluidCase::DragForm::pointwise);
  EXPECT_EQ(moving.solid.model, SolidCase::Model::drucker_prager_rate);
  EXPECT_EQ(moving.solid.hourglass_stiffness, 0.0);
  EXPECT_EQ(moving.solid.courant, 0.3);  // the case's own value has precedence
  const std::string water_alone = sound_case.substr(0, sound_case.find("[[gauge]]"));
  const Case rigid = read(water_alone, {"case.scheme=paper", "solid.model=rigid"});
  EXPECT_EQ(rigid.fluid.drag_form, FluidCase::DragForm::smoothed);
  EXPECT_NE(complaint(sound_case, {"case.scheme=papr"}).find("\"paper\""), std::string::npos);
}

TEST_F(CaseFile, ChecksSoilAndGeometry) {
  EXPECT_THAT(complaint(changed(sound_case, "porosity = 0.4", "friction_angle = 20\ndilation_angle = 30")),
              HasSubstr("key 'soil[0].dilation_angle': expected at most the friction angle of 20 degrees, found 30"));
  EXPECT_THAT(complaint(changed(sound_case, "max = [0.1, 0.4]", "max = [0.1, 0]")), HasSubstr("above that of 'min'"));
  EXPECT_THAT(complaint(changed(sound_case, "max = [0.1, 0.4]", "max = [0.1, 0.001]")), HasSubstr("no particle fits"));
  EXPECT_THAT(complaint(changed(sound_case, "[[wall]]", "[[soil]]\nmin = [0, 0.3]\nmax = [0.1, 0.5]\n[[wall]]")),
              HasSubstr("key 'soil[1]': overlaps soil[0]"));
  EXPECT_THAT(complaint(changed(sound_case, "shape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.4]",
                                "shape = \"polygon\"\npoints = [[0, 0], [1, 0]]")),
              HasSubstr("expected 3 corners or more, found 2"));
  EXPECT_THAT(complaint(changed(sound_case, "shape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.4]",
                                "shape = \"polygon\"\npoints = [[0, 0], [0.1, 0], [0.1, 0.001]]")),
              HasSubstr("no particle fits: the polygon measures 0.001 m along y"));
}

TEST_F(CaseFile, NamesBadSoilParameters) {
  const auto with = [&](const std::string& line) { return complaint(changed(sound_case, "porosity = 0.4", line)); };
  EXPECT_THAT(with("poissons_ratio = 0.5"), HasSubstr("key 'soil[0].poissons_ratio'"));
  EXPECT_THAT(with("cohesion = -1"), HasSubstr("key 'soil[0].cohesion'"));
  EXPECT_THAT(with("friction_angle = 90"), HasSubstr("key 'soil[0].friction_angle'"));
  EXPECT_THAT(with("earth_pressure_at_rest = 0"), HasSubstr("key 'soil[0].earth_pressure_at_rest'"));
}

TEST_F(CaseFile, SoilNeedsSupport) {
  const std::string heavy = changed(sound_case, "gravity = [0, 0]", "gravity = [0, -9.81]") +
                            "[[wall]]\npoints = [[0, 0.6], [0, 0]]\nsoil = \"none\"\n[[wall]]\npoints = [[0.1, 0], "
                            "[0.1, 0.6]]\nsoil = \"none\"\n";
  EXPECT_EQ(complaint(heavy), "no complaint");
  EXPECT_THAT(complaint(changed(heavy, "soil = \"fixed\"", "soil = \"none\"")),
              HasSubstr("key 'soil[0]': nothing holds the soil up"));
  EXPECT_THAT(complaint(changed(heavy, "points = [[0, 0], [0.1, 0]]", "points = [[0, -1], [0.1, -1]]")),
              HasSubstr("nothing holds the soil up"));
  const std::string stacked = "[[soil]]\nmin = [0, 0.4]\nmax = [0.1, 0.5]\n[[wall]]";
  EXPECT_EQ(complaint(changed(heavy, "[[wall]]", stacked)), "no complaint");
  const std::string hovering = "[[soil]]\nmin = [0, 0.5]\nmax = [0.1, 0.6]\n[[wall]]";
  EXPECT_THAT(complaint(changed(heavy, "[[wall]]", hovering)), HasSubstr("key 'soil[1]': nothing holds the soil up"));
  const std::string falling = changed(heavy, "[[wall]]", hovering) + "[solid]\ninitial_rest = false\n";
  EXPECT_THAT(complaint(falling), HasSubstr("key 'soil[1].hydraulic_conductivity'"));
  EXPECT_EQ(complaint(changed(falling, "[[soil]]\nmin = [0, 0.5]",
                              "[[soil]]\nhydraulic_conductivity = 1e-3\nmin = [0, 0.5]")),
            "no complaint");
  const std::string immersed =
      changed(changed(falling, "[[water_face]]\npoints = [[0.1, 0.4], [0, 0.4]]\npressure = 0\n", ""),
              "[[fluid.region]]\nmin = [0, 0]\nmax = [0.1, 0.4]", "[[fluid.region]]\nmin = [0, 0]\nmax = [0.1, 0.6]");
  const auto with = [&](const std::string& k) {
    return changed(immersed, "[[soil]]\nmin = [0, 0.5]",
                   "[[soil]]\nhydraulic_conductivity = " + k + "\nmin = [0, 0.5]");
  };
  EXPECT_EQ(complaint(with("1e-5")), "no complaint");
  EXPECT_THAT(complaint(with("1e-6")), HasSubstr("soil that falls, under water, has no stable exchange"));
}

TEST_F(CaseFile, ChecksPrescribedPressure) {
  EXPECT_THAT(complaint(sound_case + "[[pore_pressure]]\nhead = 1\n"), HasSubstr("the case has water of its own"));
  std::string dry = changed(sound_case, "[[fluid.region]]\nmin = [0, 0]\nmax = [0.1, 0.4]\n", "");
  dry = changed(dry, "[[water_face]]\npoints = [[0.1, 0.4], [0, 0.4]]\npressure = 0\n", "");
  EXPECT_FALSE(read(dry).coupled());
  EXPECT_TRUE(read(dry).deformable());
  EXPECT_THAT(complaint(dry + "[[pore_pressure]]\n"), HasSubstr("either 'head' or 'pressure', found neither"));
  EXPECT_THAT(complaint(dry + "[[pore_pressure]]\nhead = 1\n"), HasSubstr("a head needs gravity"));
  const std::string heavy = changed(dry, "gravity = [0, 0]", "gravity = [0, -9.81]");
  EXPECT_EQ(complaint(heavy + "[[pore_pressure]]\nhead = 1\n"), "no complaint");
  EXPECT_THAT(complaint(heavy + "[[pore_pressure]]\nhead = 1\nto_head = 2\n"),
              HasSubstr("expected a point other than 'from'"));
  EXPECT_THAT(complaint(heavy + "[[pore_pressure]]\npressure = 1\nto_head = 2\nto = [0, 1]\n"),
              HasSubstr("expected 'head' at 'from' with it"));
  EXPECT_THAT(complaint(changed(heavy, "phase = \"solid\"", "phase = \"fluid\"")),
              HasSubstr("without water there is no fluid phase"));
}

TEST_F(CaseFile, ChecksWalls) {
  const auto with_wall = [&](const std::string& points) {
    return complaint(
        changed(sound_case, "[[water_face]]", "[[wall]]\nname = \"second\"\npoints = " + points + "\n[[water_face]]"));
  };
  EXPECT_THAT(with_wall("[[0.05, 0], [0.2, 0]]"),
              HasSubstr("wall[1] \"second\" lies on wall[0] \"base\" from [0.05, 0] to [0.1, 0] m"));
  EXPECT_THAT(with_wall("[[0.05, -1], [0.05, 1]]"), HasSubstr("crosses wall[0] \"base\" at [0.05, 0] m"));
  EXPECT_EQ(with_wall("[[0.1, 0], [0.1, 0.4]]"), "no complaint");
  EXPECT_EQ(with_wall("[[0.1, 0], [0.3, 0]]"), "no complaint");
  EXPECT_THAT(with_wall("[[0.1, 0.4], [0, 0.4]]"), HasSubstr("key 'water_face[0]': lies on wall[1] \"second\""));
}

TEST_F(CaseFile, LoadsAndWavesVaryInTime) {
  const Case ramp = read(changed(sound_case, "start = 0", "factor = [[1, 0], [3, 1]]"));
  ASSERT_TRUE(ramp.loads[0].factor);
  EXPECT_DOUBLE_EQ(ramp.loads[0].factor->at(2.0), 0.5);
  EXPECT_THAT(complaint(changed(sound_case, "start = 0", "factor = [[1, 0], [3, 1]]") + "[solid.quiet]\n"),
              HasSubstr("key 'load[0].factor': soil that sleeps does not see a load that changes"));

  const std::string wave = "\nwave_amplitude = [[0, 0], [1, 200]]\nwave_length = 3\nwave_period = 1.5";
  const WaterFace face = read(changed(sound_case, "pressure = 0", "pressure = 1000" + wave)).water_faces[0];
  EXPECT_NEAR(face.wave(0.0, 3.0), 200.0, 1e-9);
  EXPECT_NEAR(face.wave(1.5, 3.0), -200.0, 1e-9);
  EXPECT_NEAR(face.wave(0.5, 0.75), -75.0, 1e-9) << "half of it still, a sixth of its length from the crest";
  EXPECT_THAT(complaint(changed(sound_case, "pressure = 0", "head = 1" + wave)),
              HasSubstr("key 'water_face[0].wave_amplitude': is added to the pressure of the face"));
  EXPECT_THAT(complaint(changed(sound_case, "pressure = 0", "pressure = 0\nwave_amplitude = 1\nwave_length = 1")),
              HasSubstr("key 'water_face[0].wave_period'"));
}

TEST_F(CaseFile, ChecksFacesGaugesAndPeriods) {
  EXPECT_THAT(complaint(changed(sound_case, "pressure = 0\n", "")),
              HasSubstr("expected one of 'head', 'pressure', 'discharge' and 'outlet', found none"));
  EXPECT_THAT(complaint(changed(sound_case, "pressure = 0\n", "pressure = 0\nhead = 1\n")), HasSubstr("found more"));
  EXPECT_THAT(complaint(changed(sound_case, "phase = \"solid\"", "phase = \"soil\"")),
              HasSubstr("did you mean \"solid\"?"));
  EXPECT_THAT(complaint(changed(sound_case, "kind = \"point\"", "kind = \"pint\"")), HasSubstr("key 'gauge[0].kind'"));
  EXPECT_THAT(complaint(changed(sound_case, "gravity = [0, 0]", "periodic = [\"x\"]")),
              HasSubstr("the periodic axis \"x\" needs case.domain_min"));
  EXPECT_THAT(complaint(changed(sound_case, "gravity = [0, 0]", "periodic = [\"z\"]")),
              HasSubstr("expected an array of \"x\", \"y\""));
}

const std::string tank_case = R"([case]
end_time = 1
[fluid]
particle_spacing = 0.05
[[fluid.region]]
min = [0, 0]
max = [1, 0.5]
[solid]
model = "rigid"
[[wall]]
name = "left"
points = [[0, 1], [0, 0]]
[[wall]]
name = "floor"
points = [[0, 0], [1, 0]]
[[wall]]
name = "right"
points = [[1, 0], [1, 1]]
)";

TEST_F(CaseFile, NamesTheHoleInAWall) {
  EXPECT_EQ(complaint(tank_case), "no complaint");
  const auto hole = complaint(changed(tank_case, "[[0, 0], [1, 0]]", "[[0, 0], [0.7, 0]]"));
  EXPECT_THAT(hole, HasSubstr("key 'wall': water can run out at [0."));
  EXPECT_THAT(hole,
              HasSubstr("between [0.7, 0], where wall[1] \"floor\" ends and [1, 0], where wall[2] \"right\" ends"));
  EXPECT_THAT(hole, HasSubstr("close the gap with a [[wall]]"));
  // Also a gap in the middle of a line, and a gap beside soil.
  EXPECT_THAT(complaint(changed(tank_case, "points = [[1, 0], [1, 1]]",
                                "points = [[1, 0], [1, 0.2]]\n[[wall]]\nname = \"top\"\npoints = [[1, 0.3], [1, 1]]")),
              HasSubstr("between [1, 0.2], where wall[2] \"right\" ends and [1, 0.3], where wall[3] \"top\" ends"));
  EXPECT_THAT(complaint(changed(tank_case, "[[0, 0], [1, 0]]", "[[0, 0], [0.7, 0]]") +
                        "[[soil]]\nmin = [0, 0]\nmax = [1, 0.5]\n"),
              HasSubstr("water can run out"));
  // A side without a wall.
  EXPECT_THAT(complaint(changed(tank_case, "points = [[1, 0], [1, 1]]", "points = [[1, 0], [1, 1]]\nwater = \"none\"")),
              HasSubstr("past [1, 0], where wall[1] \"floor\" ends"));
  // A wall that ends below the water's surface.
  EXPECT_THAT(complaint(changed(tank_case, "[[1, 0], [1, 1]]", "[[1, 0], [1, 0.4]]")),
              HasSubstr("past [1, 0.4], where wall[2] \"right\" ends"));
}

/// Planes have no ends, so that water cannot run out between them, however far away they are.
TEST_F(CaseFile, PlanesFarFromTheWaterHoldIt) {
  const auto plane = [](const std::string& point, const std::string& normal) {
    return "[[wall]]\npoint = " + point + "\nnormal = " + normal + "\n";
  };
  const std::string drop =
      "[case]\nend_time = 1\ndimension = 3\n[fluid]\nparticle_spacing = 0.1\n"
      "[[fluid.region]]\nmin = [1, 1, 1]\nmax = [1.4, 1.4, 1.4]\n[solid]\nmodel = \"rigid\"\n" +
      plane("[0, 0, 0]", "[1, 0, 0]") + plane("[9, 0, 0]", "[-1, 0, 0]") + plane("[0, 0, 0]", "[0, 1, 0]");
  const std::string floor = plane("[0, 0, 0]", "[0, 0, 1]"), front = plane("[0, 9, 0]", "[0, -1, 0]");
  EXPECT_EQ(complaint(drop + floor + front), "no complaint");
  EXPECT_THAT(complaint(drop + front), HasSubstr("water can run out"));
  EXPECT_THAT(complaint(drop + floor), HasSubstr("water can run out"));
}

TEST_F(CaseFile, NamesARegionWithoutParticles) {
  EXPECT_THAT(complaint(tank_case + "[[fluid.region]]\nmin = [0.2, 0.6]\nmax = [0.8, 0.61]\n"),
              HasSubstr("key 'fluid.region[1]': no particle fits: the box measures 0.01"));
}

TEST_F(CaseFile, LetsWaterThroughWhereItIsMeantTo) {
  const std::string face = "[[water_face]]\npoints = [[0.7, 0], [1, 0]]\ndischarge = 0.01\n";
  EXPECT_EQ(complaint(changed(tank_case, "[[0, 0], [1, 0]]", "[[0, 0], [0.7, 0]]") + face), "no complaint");
  EXPECT_EQ(complaint(changed(changed(tank_case, "end_time = 1",
                                      "end_time = 1\nperiodic = [\"x\"]\ndomain_min = [0, 0]\ndomain_max = [1, 1]"),
                              "points = [[1, 0], [1, 1]]", "points = [[1, 0], [1, 1]]\nwater = \"none\""),
                      {"wall.0.water=\"none\""}),
            "no complaint");
  EXPECT_EQ(complaint(changed(changed(tank_case, "[[0, 0], [1, 0]]", "[[0, 0], [0.7, 0]]"), "end_time = 1",
                              "end_time = 1\ngravity = [0, 0]")),
            "no complaint");
}

TEST_F(CaseFile, ChecksInletsOfRealWater) {
  // The left part of the floor is an opening.
  const std::string open = changed(tank_case, "[[0, 0], [1, 0]]", "[[0.4, 0], [1, 0]]");
  const auto inlet = [&](const std::string& tank, const std::string& keys) {
    return complaint(tank + "[[water_face]]\n" + keys + "\n");
  };
  const std::string dry = changed(open, "[[fluid.region]]\nmin = [0, 0]\nmax = [1, 0.5]\n", "");
  for (const auto& tank : {open, dry}) {
    EXPECT_EQ(inlet(tank, "points = [[0, 0], [0.4, 0]]\ndischarge = 0.01"), "no complaint");
    EXPECT_EQ(inlet(tank, "points = [[0, 0], [0.4, 0]]\nhead = [[0, 0.5], [9, 0.6]]"), "no complaint");
    EXPECT_THAT(inlet(tank, "points = [[0, 0], [0.3, 0]]\ndischarge = 0.01"), HasSubstr("water can run out at"));
  }
  EXPECT_THAT(inlet(tank_case, "points = [[0.2, 0], [0.4, 0]]\ndischarge = 0.01"),
              HasSubstr("lies on wall[1] \"floor\" from [0.2, 0] to [0.4, 0] m"));
  EXPECT_THAT(inlet(tank_case, "points = [[-0.5, 0.2], [-0.5, 0]]\ndischarge = 0.01"),
              HasSubstr("key 'water_face[0].points': an inlet is an opening in a wall, but neither of its ends, "
                        "[-0.5, 0.2] and [-0.5, 0] m, meets one: it is inside a wall"));
  EXPECT_THAT(inlet(tank_case, "points = [[0.5, 0.3], [0.5, 0]]\ndischarge = 0.01"),
              HasSubstr("a [[fluid.region]] lies behind the inlet, for example at [0.5, 0."));
  EXPECT_THAT(inlet(open, "points = [[0, 0], [0.2, -0.1], [0.4, 0]]\ndischarge = 0.01"),
              HasSubstr("an inlet is one straight opening; expected 2 points, found 3"));
  EXPECT_THAT(inlet(open, "points = [[0, 0], [0.4, 0]]\ndischarge = 0.01\n[[soil]]\nmin = [0, 0]\nmax = [0.3, 0.2]"),
              HasSubstr("key 'water_face[0].discharge': soil touches the face; expected 'basin_area' with it"));
}

TEST_F(CaseFile, GhostWaterThatWouldRunOverIsNamed) {
  const std::string dam = R"([case]
end_time = 1
[[soil]]
shape = "polygon"
points = [[0, 0], [1.2, 0], [0.8, 0.4], [0.4, 0.4]]
friction_angle = 30
[fluid]
particle_spacing = 0.05
[solid]
model = "rigid"
[[wall]]
points = [[0, 0], [1.2, 0]]
[[water_face]]
points = [[0.4, 0.4], [0, 0]]
head = 0.3
[[water_face]]
points = [[1.2, 0], [0.8, 0.4]]
head = 0
)";
  EXPECT_EQ(complaint(dam), "no complaint");
  // The water runs over the crest, down the other slope, and into the basin there.
  const std::string over = changed(dam, "head = 0.3", "head = [[0, 0], [10, 0.45]]");
  EXPECT_EQ(complaint(over), "no complaint");
  EXPECT_THAT(complaint(changed(over, "head = 0\n", "pressure = 0\n")), HasSubstr("water can run out at"));
  // So it does over soil that moves but cannot yield; still water cannot follow a crest that slides.
  EXPECT_EQ(complaint(changed(over, "model = \"rigid\"", "model = \"elastic\"")), "no complaint");
  const std::string yields = changed(over, "model = \"rigid\"", "model = \"drucker_prager\"");
  EXPECT_THAT(
      complaint(yields),
      HasSubstr("key 'water_face[0].head': the water behind the face rises to 0.45 m, above the face's upper end "
                "at 0.4 m, where no wall touches it, and cannot run over there: the soil can yield, and still "
                "water cannot follow a crest that slides"));
  // A wall upwards from the crest holds the water; a floor along the crest does not.
  const auto with_wall = [&](const std::string& points) { return complaint(yields + "[[wall]]\npoints = " + points); };
  EXPECT_EQ(with_wall("[[0.4, 0.6], [0.4, 0.4]]"), "no complaint");
  EXPECT_THAT(with_wall("[[0.4, 0.4], [0.8, 0.4]]"), HasSubstr("cannot run over there"));
}

TEST_F(CaseFile, NamesWallsAndFacesInTheWrongPlace) {
  EXPECT_THAT(complaint(changed(tank_case, "[[0, 0], [1, 0]]", "[[1, 0], [0, 0]]")),
              HasSubstr("key 'wall[1].points': water or soil lies to the right of the walk from [1, 0] to [0, 0]"));
  // A wall line through water is a thin wall, if rows of particles lie on either side of it.
  EXPECT_EQ(complaint(tank_case + "[[wall]]\npoints = [[0.5, 0.1], [0.5, 0.4]]\n"), "no complaint");
  EXPECT_THAT(complaint(tank_case + "[[wall]]\npoints = [[0.525, 0.1], [0.525, 0.4]]\n"),
              HasSubstr("wall[3], which runs through it; expected rows half a spacing from the line"));
  const std::string drain = "[[water_face]]\npressure = 0\npoints = ";
  EXPECT_THAT(complaint(tank_case + drain + "[[1.2, 0.1], [1.2, 0.4]]\n"),
              HasSubstr("key 'water_face[0].points': no [[soil]] and no [[fluid.region]] touches the face from "
                        "[1.2, 0.1] to [1.2, 0.4] m: it is inside a wall or off the domain"));
  EXPECT_THAT(complaint(changed(tank_case, "points = [[0, 1], [0, 0]]", "points = [[0, 1], [0, 0]]\nwater = \"none\"") +
                        drain + "[[0, 0], [0, 0.5]]\n"),
              HasSubstr("soil and water lie to the right of the walk"));
}

TEST_F(CaseFile, NamesThinWallsInSoilWhereNothingKeepsItsTwoSidesApart) {
  const std::string bin = R"([case]
end_time = 1
[solid]
model = "elastic"
particle_spacing = 0.05
[[soil]]
min = [0, 0]
max = [0.5, 0.6]
[[soil]]
min = [0.5, 0]
max = [1, 0.4]
[[wall]]
points = [[0, 1], [0, 0], [1, 0], [1, 1]]
soil = "roller"
[[wall]]
points = [[0.5, 1], [0.5, 0]]
soil = "roller"
)";
  EXPECT_EQ(complaint(bin), "no complaint");
  EXPECT_THAT(complaint(changed(bin, "[[0.5, 1], [0.5, 0]]", "[[0.475, 1], [0.475, 0]]")),
              HasSubstr("wall[1], which runs through it; expected rows half a spacing from the line: draw one soil"));
  const std::string water = "[fluid]\nparticle_spacing = 0.05\n[[fluid.region]]\n";
  EXPECT_THAT(complaint(bin + water + "min = [0, 0]\nmax = [0.5, 0.6]\n"),
              HasSubstr("key 'wall[1]': runs through a [[soil]], for example at [0.5, 0."));
  const std::string slot = changed(bin, "min = [0.5, 0]", "min = [0.6, 0]");
  const std::string around = "[[0.5, 0], [0.5, 1], [0.6, 1], [0.6, 0]]";
  EXPECT_EQ(complaint(changed(slot, "[[0.5, 1], [0.5, 0]]", around)), "no complaint");
  EXPECT_THAT(complaint(changed(slot, "[[0.5, 1], [0.5, 0]]", around) +
                        "[[plate]]\npoints = [[0.5, 0.6], [0, 0.6]]\nspeed = 1e-3\n"),
              HasSubstr("is 0.1 m thick at [0.5, 0.0"));
}

TEST_F(CaseFile, NamesAGaugeOutsideEverything) {
  const std::string gauge =
      "[[gauge]]\nname = \"p\"\nphase = \"fluid\"\nkind = \"point\"\nquantity = \"pore_pressure\"\npoints = ";
  EXPECT_EQ(complaint(tank_case + gauge + "[[0.5, 0.9]]\n"), "no complaint");
  EXPECT_THAT(complaint(tank_case + gauge + "[[0.5, 1.5]]\n"),
              HasSubstr("key 'gauge[0].points': expected a place within the walls, soil and water of the case, found "
                        "[0.5, 1.5] m"));
}

TEST_F(CaseFile, NamesASlipSurfaceWithoutItsLines) {
  const std::string gauge = "[[gauge]]\nname = \"slip\"\nphase = \"solid\"\nkind = \"slip_surface\"\npoints = ";
  EXPECT_EQ(complaint(sound_case + gauge + "[[0, 0], [0, 0.1], [0.1, 0], [0.1, 0.1]]\n"), "no complaint");
  EXPECT_THAT(complaint(sound_case + gauge + "[[0, 0], [0, 0.1]]\n"),
              HasSubstr("expected the 2 ends of each, found 2 points"));
}

TEST_F(CaseFile, NamesAGaugeThatACsvCouldNotHold) {
  const auto named = [](const std::string& name) { return changed(sound_case, "\"settlement\"", "\"" + name + "\""); };
  EXPECT_EQ(complaint(named("left side (h/2) [0]")), "no complaint");
  for (const std::string name : {"a,b", "a\\nb", "say \\\"a\\\"", "a\\u001b[31m"})
    EXPECT_THAT(complaint(named(name)), HasSubstr("key 'gauge[0].name': expected a name without commas")) << name;
  EXPECT_THAT(complaint(named("a\\nb")), HasSubstr("found 'a?b'"));
}

/// The parser recurses once per part of a key: a key with this many parts would overflow the stack.
TEST_F(CaseFile, NamesAKeyThatIsTooDeep) {
  std::string deep = "a";
  for (int k = 1; k < 100'000; ++k) deep += ".a";
  for (const std::string& text : {deep + " = 1\n", "[" + deep + "]\n", "x = { " + deep + " = 1 }\n"})
    EXPECT_THAT(complaint("\n" + text), HasSubstr("case.toml:2: expected a key of at most 64 parts, found more"));
  EXPECT_THAT(complaint(sound_case, {deep + "=1"}), HasSubstr("expected a key of at most 64 parts, found 100000"));
  EXPECT_THAT(complaint(sound_case, {"case.title={" + deep + "=1}"}), HasSubstr("a key of at most 64 parts"));
  // Dots elsewhere do not separate parts of a key.
  const std::string dots(200, '.'), title = "title = \"column\"";
  for (const std::string& text :
       {"\"\"\"" + dots + "\n" + dots + " \\\" it's\"\"\"", "'C:\\" + dots + "\\' # it's " + dots})
    EXPECT_EQ(complaint("# " + dots + " it's\n" + changed(sound_case, title, "title = " + text)), "no complaint");
}

TEST_F(CaseFile, MissingFileIsNamed) {
  try {
    read_case(folder_ / "absent.toml");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("absent.toml: cannot be opened: No such file or directory"));
  }
}

TEST_F(CaseFile, DigestHoldsWhatBothMustAgreeOn) {
  const auto digest = read(sound_case).digest();
  EXPECT_EQ(digest.size(), 16u);
  EXPECT_EQ(read("# a comment\n" +
                 changed(sound_case, "title = \"column\"\nend_time = 3.6", "end_time = 3.60\ntitle = \"column\""))
                .digest(),
            digest);
  EXPECT_EQ(read(sound_case, {"fluid.particle_spacing=0.02"}).digest(), digest);
  EXPECT_NE(read(sound_case, {"soil.0.porosity=0.41"}).digest(), digest);
  EXPECT_NE(read(sound_case, {"coupling.interval=1"}).digest(), digest);
}

TEST(CaseReference, StandsInDocs) {
  EXPECT_EQ(read_text(std::filesystem::path(PORETWIN_SOURCE_DIR) / "docs" / "case-file.md"), case_reference())
      << "write it anew with: poretwin case-keys > docs/case-file.md";
}

}  // namespace
}  // namespace poretwin
