// Cases whose water is a field: correct ones are read; unsupported or meaningless ones are refused with a reason.
#include "tests/case/case_file.hpp"

#include "common/case/amounts.hpp"
#include "common/media/retention_law.hpp"

namespace poretwin {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Field : public CaseFile {};

/// A dam with a reservoir, a seepage face, and rain on its crest.
const std::string dam = R"([case]
end_time = 1000
[[soil]]
name = "dam"
shape = "polygon"
points = [[0, 0], [1.2, 0], [0.8, 0.4], [0.4, 0.4]]
porosity = 0.4
hydraulic_conductivity = 1e-4
retention = { model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8 }
[[water_face]]
name = "reservoir"
points = [[0.4, 0.4], [0, 0]]
head = 0.3
[[water_face]]
name = "slope"
points = [[1.2, 0], [0.8, 0.4]]
outlet = true
[[rain]]
name = "rain"
points = [[0.8, 0.4], [0.4, 0.4]]
rate = [[0, 1e-6], [100, 0]]
[fluid]
representation = "field"
particle_spacing = 0.02
initial_water_table = 0
[solid]
model = "rigid"
[[gauge]]
name = "q"
phase = "fluid"
kind = "discharge"
quantity = "reservoir"
)";

TEST_F(Field, IsReadAndNothingIsSaidOfIt) {
  const Case scene = read(dam);
  EXPECT_TRUE(scene.is_field());
  EXPECT_TRUE(scene.has_water());
  ASSERT_TRUE(scene.soils[0].retention);
  EXPECT_EQ(scene.soils[0].retention->law->name, "van_genuchten");
  EXPECT_EQ(scene.soils[0].retention->numbers.at("n"), 2.8);
  ASSERT_EQ(scene.rains.size(), 1u);
  EXPECT_NEAR(scene.rains[0].rate->integral(0.0, 200.0), 5e-5, 1e-18);
  EXPECT_EQ(warnings(dam), "");
  EXPECT_NEAR(estimate(scene).fluid, 800.0, 1.0);
}

TEST_F(Field, RetentionCurvesThatMakeNoSenseAreNamed) {
  EXPECT_THAT(complaint(changed(dam, "residual_water_content = 0.05", "residual_water_content = 0.41")),
              AllOf(HasSubstr("case.toml:9"), HasSubstr("soil[0].retention.residual_water_content"),
                    HasSubstr("porosity of 0.4"), HasSubstr("found 0.41")));
  EXPECT_THAT(complaint(dam, {"soil.0.retention.n=0.9"}),
              AllOf(HasSubstr("soil[0].retention.n"), HasSubstr("above 1")));
  EXPECT_THAT(complaint(changed(dam, ", n = 2.8", "")),
              AllOf(HasSubstr("soil[0].retention.n"), HasSubstr("found none")));
  EXPECT_THAT(complaint(dam, {"soil.0.retention.pore_size_index=2"}),
              AllOf(HasSubstr("retention.pore_size_index"), HasSubstr("brooks_corey")));
  const auto table = changed(
      dam, R"(model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8)",
      R"(model = "table", saturation = [[-2, 0.2], [-1, 0.5], [0, 1]], permeability = [[-2, 0.01], [-1, 0.1], [0, 1]])");
  EXPECT_EQ(complaint(table), "no complaint");
  EXPECT_THAT(complaint(table, {"soil.0.retention.saturation=[[-2, 0.5], [-1, 0.4], [0, 1]]"}),
              AllOf(HasSubstr("retention.saturation"), HasSubstr("rise with the pressure head")));
  EXPECT_THAT(complaint(table, {"soil.0.retention.permeability=[[-2, 0.5], [-1, 0.6], [0, 0.9]]"}),
              AllOf(HasSubstr("retention.permeability"), HasSubstr("1 in the last row")));
  // The points are 0.02 m apart.
  EXPECT_THAT(complaint(table, {"soil.0.retention.permeability=[[-2, 0.01], [-0.201, 0.4], [-0.2, 0.8], [0, 1]]"}),
              AllOf(HasSubstr("retention.permeability"), HasSubstr("2 times within 0.001 m"),
                    HasSubstr("half a spacing apart, 0.01 m")));
  EXPECT_THAT(complaint(table, {"soil.0.retention.permeability=[[-2, 0.01], [-0.209, 0.1], [-0.206, 0.19], [-0.203, "
                                "0.36], [-0.2, 0.68], [0, 1]]"}),
              AllOf(HasSubstr("retention.permeability"), HasSubstr("6.8 times within 0.009 m"),
                    HasSubstr("such a rise over at least half a spacing")));
  for (const char* rows :
       {"[[-2, 0.01], [-0.201, 0.5], [-0.2, 0.8], [0, 1]]", "[[-2, 0.01], [-0.21, 0.1], [-0.2, 0.8], [0, 1]]"})
    EXPECT_EQ(complaint(table, {std::string("soil.0.retention.permeability=") + rows}), "no complaint") << rows;
  EXPECT_EQ(complaint(table, {"soil.0.retention.saturation=[[-2, 0.2], [-0.201, 0.5], [-0.2, 1]]"}), "no complaint");
  EXPECT_THAT(complaint(table, {"soil.0.retention.saturation=[[-2, 0.5], [-1, 0.50001], [0, 1]]"}),
              AllOf(HasSubstr("retention.saturation"), HasSubstr("no suction drains the soil")));
  EXPECT_THAT(complaint(table, {"soil.0.retention.saturation=[[-2, 0.5], [0, 1]]"}),
              AllOf(HasSubstr("retention.saturation"), HasSubstr("two rows or more below a pressure head of zero")));
  EXPECT_THAT(complaint(changed(table, ", permeability = [[-2, 0.01], [-1, 0.1], [0, 1]]", "")),
              AllOf(HasSubstr("retention.permeability"), HasSubstr("found none")));
}

TEST_F(Field, RainFallsOnOpenGroundOnly) {
  EXPECT_THAT(complaint(dam, {"rain.0.points=[[0.4, 0.4], [0, 0]]"}),
              AllOf(HasSubstr("rain[0]"), HasSubstr("reservoir"), HasSubstr("under its water, up to 0.3 m")));
  EXPECT_EQ(complaint(dam, {"rain.0.points=[[1.2, 0], [0.8, 0.4], [0.4, 0.4]]"}), "no complaint");
  EXPECT_THAT(complaint(dam, {"rain.0.points=[[0.4, 0.4], [0.8, 0.4]]"}), HasSubstr("with the soil on its left"));
  EXPECT_THAT(complaint(dam, {"rain.0.points=[[0.8, 0.6], [0.4, 0.6]]"}), HasSubstr("no soil lies under the rain"));
  EXPECT_THAT(complaint(changed(dam, "rate = [[0, 1e-6], [100, 0]]", "")), HasSubstr("rate"));
  EXPECT_THAT(complaint(dam + "[[wall]]\npoints = [[0.8, 0.4], [0.4, 0.4]]\n"),
              AllOf(HasSubstr("rain[0].points"), HasSubstr("wall[0]")));
  EXPECT_THAT(complaint(changed(dam, R"(model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8)",
                                R"(model = "sharp")")),
              AllOf(HasSubstr("rain[0]"), HasSubstr("retention curve")));
}

TEST_F(Field, FacesDoNotLieOnEachOther) {
  const auto second = [](const std::string& line) {
    return "[[water_face]]\nname = \"second\"\npoints = " + line + "\npressure = 0\n";
  };
  EXPECT_EQ(complaint(dam + second("[[0, 0], [1.2, 0]]")), "no complaint");
  EXPECT_THAT(complaint(dam + second("[[0.2, 0.2], [0, 0]]")),
              AllOf(HasSubstr("key 'water_face[2]'"), HasSubstr("lies on water_face[0] \"reservoir\" at [0.1, 0.1] m"),
                    HasSubstr("expected one water face at each place")));
}

TEST_F(Field, LinesForForcesLieInSoil) {
  const auto gauge = [](const std::string& kind, const std::string& line) {
    return "[[gauge]]\nname = \"g\"\nphase = \"fluid\"\nkind = \"" + kind + "\"\npoints = " + line + "\n";
  };
  EXPECT_EQ(warnings(dam + gauge("pressure_force", "[[0, 0], [1.2, 0]]")), "");
  EXPECT_THAT(warnings(dam + gauge("pressure_force", "[[1, 0], [1.4, 0]]")),
              HasSubstr("key 'gauge[1].points': about 0.2"));
  EXPECT_EQ(complaint(dam + gauge("heave", "[[0.5, 0.1], [0.6, 0.15]]")), "no complaint");
  EXPECT_THAT(complaint(dam + gauge("heave", "[[0.5, 0.1], [0.5, 0.3]]")),
              AllOf(HasSubstr("key 'gauge[1].points'"), HasSubstr("at least a particle spacing (0.02 m) wide")));
}

TEST_F(Field, WhatIsNotBuiltIsRefused) {
  const std::string moving = changed(dam, "model = \"rigid\"", "model = \"elastic\"\nparticle_spacing = 0.02");
  EXPECT_THAT(complaint(moving, {"solid.particle_spacing=0.01"}),
              AllOf(HasSubstr("fluid.particle_spacing"), HasSubstr("0.01 m"), HasSubstr("0.02 m")));
  EXPECT_THAT(complaint(moving, {"fluid.jitter=0.1"}), AllOf(HasSubstr("fluid.jitter"), HasSubstr("[solid]")));
  EXPECT_THAT(complaint(moving, {"coupling.scheme=\"parallel\""}), HasSubstr("coupling.scheme"));
  EXPECT_THAT(complaint(moving, {"solid.model=\"drucker_prager\"", "soil.0.cohesion=100"}), HasSubstr("rain[0]"));
  const std::string weightless = changed(
      changed(changed(moving, "end_time = 1000", "end_time = 1000\ngravity = [0, 0]"), "initial_water_table = 0", ""),
      "outlet = true", "pressure = 0");
  EXPECT_THAT(complaint(weightless), HasSubstr("case.gravity"));
  EXPECT_THAT(complaint(dam, {"soil.0.initial_saturation=0.1"}), HasSubstr("soil[0].initial_saturation"));
  EXPECT_THAT(complaint(dam, {"fluid.scheme=\"eisph\""}), AllOf(HasSubstr("fluid.scheme"), HasSubstr("particles")));
  EXPECT_THAT(complaint(dam, {"soil.0.suction_head=0.1"}), HasSubstr("soil[0].suction_head"));
  EXPECT_THAT(complaint(dam, {"soil.0.seepage_law=\"forchheimer\"", "soil.0.forchheimer_coefficient=3"}),
              HasSubstr("Darcy's law"));
  EXPECT_THAT(complaint(dam, {"water_face.0.head=0.5"}), AllOf(HasSubstr("water_face[0].head"), HasSubstr("run over")));
  EXPECT_THAT(complaint(changed(dam, "head = 0.3", "discharge = 1e-5")), HasSubstr("water_face[0].discharge"));
  EXPECT_THAT(complaint(dam, {"case.gravity=[0, 0]"}), HasSubstr("case.gravity"));
  EXPECT_THAT(complaint(dam + "[[fluid.region]]\nmin = [0, 0]\nmax = [0.2, 0.3]\n"), HasSubstr("free water"));
  EXPECT_THAT(complaint(dam, {"gauge.0.kind=\"energy\"", "gauge.0.quantity=\"\""}),
              AllOf(HasSubstr("gauge[0].kind"), HasSubstr("\"front\"")));
}

TEST_F(Field, ABasinFitsItsFace) {
  const std::string keys = "head = 0.1\ndischarge = 1e-5\nbasin_area = [[0, 1], [1, 2]]\nbasin_rain = 1e-6\n";
  const auto with = [&](const std::string& face, const std::string& more) {
    return changed(face, "head = 0.3", keys + more);
  };
  const std::string gauge = "\n[[gauge]]\nname = \"b\"\nphase = \"fluid\"\nkind = \"basin\"\nquantity = ";
  const Case scene = read(with(dam, "spill_level = 0.35") + gauge + "\"reservoir\"\n");
  EXPECT_EQ(scene.water_faces[0].spill_level, 0.35);
  EXPECT_EQ(scene.water_faces[0].basin_rain->at(0.0), 1e-6);
  // It must not run over the dam.
  EXPECT_THAT(complaint(with(dam, "")), AllOf(HasSubstr("water_face[0].spill_level"), HasSubstr("found none")));
  EXPECT_THAT(complaint(with(dam, "spill_level = 0.5")),
              AllOf(HasSubstr("water_face[0].spill_level"), HasSubstr("at most that"), HasSubstr("found 0.5 m")));
  EXPECT_THAT(complaint(with(dam, "spill_level = 0.05")),
              AllOf(HasSubstr("water_face[0].spill_level"), HasSubstr("not below the level at time zero, 0.1 m")));
  EXPECT_THAT(complaint(changed(with(dam, "spill_level = 0.35"), "[[0, 1]", "[[0.1, 1]")),
              AllOf(HasSubstr("water_face[0].basin_area"), HasSubstr("above the lowest place of the face")));
  EXPECT_THAT(complaint(changed(with(dam, "spill_level = 0.35"), "head = 0.1", "head = [[0, 0.1], [10, 0.2]]")),
              AllOf(HasSubstr("water_face[0].head"), HasSubstr("expected one number")));
  EXPECT_THAT(complaint(changed(dam, "head = 0.3", "head = 0.3\nspill_level = 0.35")),
              AllOf(HasSubstr("water_face[0].spill_level"), HasSubstr("belongs to a basin")));
  EXPECT_THAT(complaint(with(dam, "spill_level = 0.35") + gauge + "\"slope\"\n"),
              AllOf(HasSubstr("gauge[1].quantity"), HasSubstr("basin_area")));
  // Rain falls beside it.
  EXPECT_THAT(complaint(with(dam, "spill_level = 0.35") + "[[rain]]\npoints = [[0.4, 0.4], [0.2, 0.2]]\nrate = 1e-6\n"),
              AllOf(HasSubstr("rain[1]"), HasSubstr("'basin_rain'")));
  // Water particles have no such keys.
  EXPECT_THAT(complaint(with(dam, "spill_level = 0.35"), {"fluid.representation=\"particles\""}), HasSubstr("field"));
}

/// A layer between periodic sides, tilted gravity by an option.
const std::string periodic_layer = R"([case]
end_time = 1000
domain_min = [0, 0]
domain_max = [1, 1]
periodic = ["x"]
[[soil]]
shape = "polygon"
points = [[0, 0], [1, 0], [1, 0.5], [0.6, 0.7], [0, 0.5]]
porosity = 0.4
hydraulic_conductivity = 1e-4
[[water_face]]
points = [[1, 0.5], [0.6, 0.7], [0, 0.5]]
pressure = 0
[fluid]
representation = "field"
particle_spacing = 0.05
[[fluid.region]]
min = [0, 0]
max = [1, 0.5]
[solid]
model = "rigid"
)";

TEST_F(Field, PeriodicSidesFitTogether) {
  EXPECT_EQ(complaint(periodic_layer), "no complaint");
  EXPECT_EQ(complaint(periodic_layer, {"case.gravity=[1, -9.8]"}), "no complaint");
  EXPECT_THAT(complaint(changed(periodic_layer, "[1, 0.5], [0.6", "[1, 0.4], [0.6")),
              AllOf(HasSubstr("soil[0].shape"), HasSubstr("does not continue on the opposite side")));
  EXPECT_THAT(complaint(periodic_layer, {"case.domain_max=[1.2, 1]"}), HasSubstr("does not continue"));
  EXPECT_THAT(complaint(periodic_layer, {"case.domain_max=[0.8, 1]"}), HasSubstr("outside the periodic box"));
  EXPECT_THAT(complaint(periodic_layer, {"case.periodic=[\"x\", \"y\"]"}), HasSubstr("case.periodic"));
  EXPECT_THAT(complaint(periodic_layer, {"fluid.jitter=0.1"}), HasSubstr("fluid.jitter"));
  EXPECT_THAT(complaint(periodic_layer, {"fluid.offset=[0.4, 0.5]"}), HasSubstr("fluid.offset"));
  EXPECT_THAT(complaint(changed(periodic_layer, "hydraulic_conductivity",
                                "anisotropy = 4\nbedding_normal = [1, 1]\n"
                                "hydraulic_conductivity")),
              HasSubstr("soil[0].bedding_normal"));
  EXPECT_THAT(complaint(periodic_layer + "[[water_face]]\npoints = [[0, 0.5], [0, 0]]\npressure = 0\n"),
              AllOf(HasSubstr("water_face[1]"), HasSubstr("repeats itself along x")));
  EXPECT_THAT(
      complaint(periodic_layer + "[[water_face]]\npoints = [[0, 0], [1, 0]]\nhead = 0.2\n", {"case.gravity=[1, -9.8]"}),
      AllOf(HasSubstr("water_face[1].head"), HasSubstr("expected a pressure")));
  EXPECT_THAT(complaint(periodic_layer, {"case.gravity=[1, -9.8]", "fluid.initial_water_table=0.3"}),
              HasSubstr("fluid.initial_water_table"));
  EXPECT_THAT(
      complaint(changed(periodic_layer, "model = \"rigid\"", "model = \"drucker_prager\"\nparticle_spacing = 0.05")),
      HasSubstr("case.periodic"));
}

TEST_F(Field, TheStartMustBeKnown) {
  EXPECT_THAT(complaint(changed(dam, "initial_water_table = 0\n", "")),
              AllOf(HasSubstr("initial_water_table"), HasSubstr("found none")));
  EXPECT_THAT(complaint(dam, {"fluid.initial_pressure_head=-1"}), HasSubstr("found both"));
}

TEST_F(Field, KeysOfAFieldAreNotForParticles) {
  EXPECT_THAT(complaint(dam, {"fluid.representation=\"particles\""}),
              AllOf(HasSubstr("soil[0].retention"), HasSubstr("fluid.representation = \"field\"")));
  EXPECT_THAT(complaint(dam, {"fluid.representation=\"fields\""}), HasSubstr("fluid.representation"));
}

TEST_F(Field, BedsAreRefusedWhereTheyWouldBeWrong) {
  const std::string beds = changed(dam, "porosity = 0.4", "porosity = 0.4\nanisotropy = 10");
  EXPECT_EQ(complaint(beds), "no complaint");
  EXPECT_EQ(complaint(beds, {"soil.0.bedding_normal=[-0.5, 0.9]"}), "no complaint");
  EXPECT_THAT(complaint(beds, {"soil.0.anisotropy=0"}), AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("0.01")));
  EXPECT_THAT(complaint(dam, {"soil.0.bedding_normal=[0, 1]"}),
              AllOf(HasSubstr("soil[0].bedding_normal"), HasSubstr("'anisotropy'")));
  const std::string plain = changed(
      beds, R"(retention = { model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8 })", "");
  // Soils with different beds.
  const std::string core = beds + R"([[soil]]
shape = "box"
min = [0.55, 0]
max = [0.65, 0.4]
porosity = 0.4
retention = { model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8 }
)";
  const std::string two = changed(core, "points = [[0, 0], [1.2, 0], [0.8, 0.4], [0.4, 0.4]]",
                                  "points = [[0, 0], [0.55, 0], [0.55, 0.4], [0.4, 0.4]]");
  EXPECT_EQ(complaint(changed(changed(two, "points = [[1.2, 0], [0.8, 0.4]]", "points = [[0.65, 0], [0.65, 0.4]]"),
                              "points = [[0.8, 0.4], [0.4, 0.4]]", "points = [[0.65, 0.4], [0.4, 0.4]]")),
            "no complaint");
  EXPECT_THAT(complaint(two, {"soil.0.bedding_normal=[1, 2]"}),
              AllOf(HasSubstr("soil[0].bedding_normal"), HasSubstr("coordinate axis")));
  EXPECT_THAT(complaint(two, {"fluid.jitter=0.1"}), AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("jitter")));
}

TEST_F(Field, BedsWithParticlesAreRefusedWhereTheyWouldBeWrong) {
  const std::string beds = R"([case]
end_time = 1000
[[soil]]
shape = "box"
min = [0, 0]
max = [1, 0.5]
porosity = 0.4
hydraulic_conductivity = 1e-4
anisotropy = 10
bedding_normal = [0.5, 0.9]
[[wall]]
points = [[0, 0], [1, 0]]
[[water_face]]
points = [[0, 0.5], [0, 0]]
head = 0.4
[[water_face]]
points = [[1, 0], [1, 0.5]]
head = 0.1
[fluid]
representation = "particles"
particle_spacing = 0.02
[[fluid.region]]
shape = "box"
min = [0, 0]
max = [1, 0.3]
[solid]
model = "rigid"
)";
  EXPECT_EQ(complaint(beds), "no complaint");
  EXPECT_THAT(complaint(changed(beds, "anisotropy = 10\n", "")), HasSubstr("soil[0].bedding_normal"));
  EXPECT_THAT(complaint(changed(beds, "model = \"rigid\"", "model = \"drucker_prager\"\nparticle_spacing = 0.02")),
              AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("solid.model = \"rigid\"")));
  const std::string two = changed(beds, "max = [1, 0.5]", "max = [1, 0.2]") + R"([[soil]]
shape = "box"
min = [0, 0.2]
max = [1, 0.5]
porosity = 0.4
hydraulic_conductivity = 1e-5
)";
  EXPECT_THAT(complaint(two), AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("same beds")));
  EXPECT_EQ(complaint(two + "anisotropy = 10\nbedding_normal = [1, 1.8]\n"), "no complaint");
  EXPECT_THAT(complaint(beds, {"soil.0.seepage_law=\"ergun\""}), HasSubstr("soil[0].seepage_law"));
  EXPECT_THAT(complaint(beds, {"fluid.scheme=\"eisph\""}), HasSubstr("fluid.scheme"));
  EXPECT_THAT(complaint(beds, {"fluid.drag=false"}), HasSubstr("fluid.drag"));
  EXPECT_THAT(complaint(beds, {"fluid.drag_form=\"smoothed\""}), HasSubstr("fluid.drag_form"));
  EXPECT_THAT(complaint(beds, {"soil.0.hydraulic_conductivity=0.05"}),
              AllOf(HasSubstr("soil[0].hydraulic_conductivity"), HasSubstr("inertia")));
  EXPECT_THAT(complaint(changed(beds, "[[water_face]]\npoints = [[1, 0], [1, 0.5]]\nhead = 0.1\n", "")),
              AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("neither wall nor face")));
  EXPECT_EQ(complaint(changed(beds, "head = 0.1", "outlet = true")), "no complaint");
  EXPECT_THAT(complaint(changed(beds, "head = 0.1", "pressure = 1000")), HasSubstr("water_face[1].pressure"));
  EXPECT_THAT(complaint(beds, {"soil.0.suction_head=0.2"}), HasSubstr("neither wall nor face"));
  EXPECT_THAT(complaint(beds, {"fluid.region.0.max=[1, 0.6]"}),
              AllOf(HasSubstr("soil[0].anisotropy"), HasSubstr("free water")));
  EXPECT_THAT(complaint(changed(beds, "end_time = 1000",
                                "end_time = 1000\nperiodic = [\"x\"]\ndomain_min = [0, "
                                "0]\ndomain_max = [1, 1]")),
              HasSubstr("case.periodic"));
}

/// A dam in 3D with a reservoir, a drain under a part of its base, a well, and rain on a part of its crest.
const std::string dam_in_space = R"([case]
dimension = 3
end_time = 1000
[[soil]]
shape = "polygon"
points = [[0, 0], [12, 0], [8, 4], [4, 4]]
along = ["y"]
from = 0
to = 4
porosity = 0.4
retention = { model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8 }
[[water_face]]
name = "reservoir"
point = [0, 0, 0]
normal = [1, 0, -1]
head = 3
[[water_face]]
name = "drain"
outlet = true
within = { shape = "box", min = [8, 1, -0.1], max = [12, 3, 0.01] }
[[rain]]
name = "rain"
point = [0, 0, 4]
normal = [0, 0, -1]
within = { shape = "box", min = [4, 0, 3], max = [6, 4, 5] }
rate = 1e-6
[[well]]
name = "well"
points = [[6, 2, 0.5], [6, 2, 2.5]]
radius = 0.02
discharge = 1e-4
[fluid]
representation = "field"
particle_spacing = 0.4
initial_water_table = 0
[solid]
model = "rigid"
[[gauge]]
name = "level"
phase = "fluid"
kind = "level"
quantity = "well"
)";

TEST_F(Field, In3DIsReadAndNothingIsSaidOfIt) {
  EXPECT_EQ(complaint(dam_in_space), "no complaint");
  // The drain is 2.5 spacings wide from its middle to its ends in the base.
  EXPECT_THAT(warnings(dam_in_space), AllOf(HasSubstr("water_face[1]"), HasSubstr("ends on the surface of soil")));
  EXPECT_THAT(warnings(dam_in_space), Not(HasSubstr("water_face[0]")));
  EXPECT_EQ(warnings(dam_in_space, {"water_face.1.within.min=[8, 0, -0.1]", "water_face.1.within.max=[12, 4, 0.01]",
                                    "fluid.particle_spacing=0.18"}),
            "");
  const Case scene = read(dam_in_space);
  ASSERT_TRUE(scene.rains[0].face.within);
  ASSERT_EQ(scene.wells.size(), 1u);
  EXPECT_EQ(scene.wells[0].discharge->at(0.0), 1e-4);
}

TEST_F(Field, In3DMovesWithElasticSoilOnly) {
  const auto moving = [](const std::string& model) {
    return changed(dam_in_space, "model = \"rigid\"", "model = \"" + model + "\"\nparticle_spacing = 0.4") +
           "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nwater = \"none\"\n";
  };
  EXPECT_EQ(complaint(moving("elastic")), "no complaint");
  EXPECT_THAT(complaint(moving("drucker_prager")), AllOf(HasSubstr("solid.model"), HasSubstr("in 3D")));
  EXPECT_EQ(complaint(moving("elastic"), {"soil.0.poissons_ratio=0"}), "no complaint");
  // The soil's solver looks for the water behind a face on a plane.
  EXPECT_THAT(complaint(moving("elastic"), {"water_face.1.outlet=false", "water_face.1.head=1"}),
              AllOf(HasSubstr("water_face[1].within"), HasSubstr("'point' and 'normal'")));
}

/// A load on a part of a plane (3D): a rectangle on soil.
TEST_F(Field, PartsOfALoadedPlaneLieOnSoil) {
  const auto with = [](const std::string& keys) {
    return changed(dam_in_space, "model = \"rigid\"", "model = \"elastic\"\nparticle_spacing = 0.4") +
           "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nwater = \"none\"\n[[load]]\ntraction = [0, 0, -1000]\n" +
           keys;
  };
  const std::string crest = "point = [0, 0, 4]\nnormal = [0, 0, -1]\n";
  EXPECT_EQ(complaint(with(crest + "within = { shape = \"box\", min = [6.4, 0, 3], max = [7.6, 2, 5] }\n")),
            "no complaint");
  EXPECT_THAT(complaint(with(crest + "within = { shape = \"box\", min = [6.4, 0, 3], max = [8.8, 2, 5] }\n")),
              AllOf(HasSubstr("load[0].within"), HasSubstr("does not lie along the load's plane at [8.")));
  EXPECT_THAT(complaint(with(crest + "within = { shape = \"box\", min = [6.4, 0, 1], max = [7.6, 2, 2] }\n")),
              AllOf(HasSubstr("load[0].within"), HasSubstr("no part of the load's plane")));
  EXPECT_THAT(complaint(with(crest + "within = { shape = \"ball\", centre = [7, 2, 4], radius = 1 }\n")),
              AllOf(HasSubstr("load[0].within"), HasSubstr("a box along the axes")));
  EXPECT_THAT(complaint(with("point = [12, 0, 0]\nnormal = [-1, 0, -1]\nwithin = { shape = \"box\", min = [9, 1, 1], "
                             "max = [10, 2, 3] }\n")),
              AllOf(HasSubstr("load[0].within"), HasSubstr("along an axis")));
}

/// A load without a plane (3D): a pressure on the whole surface of the soil.
TEST_F(Field, PressureOnAllSidesLeavesNothingOut) {
  const auto with = [](const std::string& keys) {
    return changed(dam_in_space, "model = \"rigid\"", "model = \"elastic\"\nparticle_spacing = 0.4") +
           "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nwater = \"none\"\n[[load]]\n" + keys;
  };
  const std::string all = "within = { shape = \"box\", min = [-50, -50, -50], max = [50, 50, 50] }\n";
  EXPECT_EQ(complaint(with("pressure = 1000\n" + all)), "no complaint");
  EXPECT_THAT(complaint(with("traction = [0, 0, -1000]\n" + all)),
              AllOf(HasSubstr("load[0]"), HasSubstr("expected a 'pressure'")));
  EXPECT_THAT(complaint(with("pressure = 1000\nwithin = { shape = \"box\", min = [0, 0, 3], max = [50, 50, 50] }\n")),
              AllOf(HasSubstr("load[0].within"), HasSubstr("does not contain the soil at")));
}

TEST_F(Field, SectionsIn3DAreFlat) {
  const auto with = [](const std::string& points) {
    return dam_in_space + "[[gauge]]\nname = \"q\"\nphase = \"fluid\"\nkind = \"discharge\"\npoints = " + points + "\n";
  };
  EXPECT_EQ(complaint(with("[[6, 0, 0], [6, 4, 0], [6, 4, 4], [6, 0, 4]]")), "no complaint");
  EXPECT_THAT(complaint(with("[[6, 0, 0], [6, 4, 0]]")), AllOf(HasSubstr("gauge[1].points"), HasSubstr("found 2")));
  EXPECT_THAT(complaint(with("[[6, 0, 0], [6, 2, 0], [6, 4, 0]]")), HasSubstr("on a line"));
  EXPECT_THAT(complaint(with("[[6, 0, 0], [6, 4, 0], [6, 4, 4], [7, 0, 4]]")), HasSubstr("off a plane"));
}

TEST_F(Field, FacesIn3DMustLieOnSoil) {
  EXPECT_THAT(complaint(dam_in_space, {"water_face.0.normal=[1, 0, 1]"}),
              AllOf(HasSubstr("case.toml:12"), HasSubstr("water_face[0]"), HasSubstr("nowhere on the soil's surface")));
  EXPECT_THAT(complaint(dam_in_space, {"water_face.1.within.max=[12, 3, -0.01]"}),
              AllOf(HasSubstr("water_face[1]"), HasSubstr("expected a shape that contains")));
  EXPECT_THAT(complaint(dam_in_space, {"water_face.0.head=4.1"}),
              AllOf(HasSubstr("water_face[0].head"), HasSubstr("run over its upper end at 4")));
  EXPECT_EQ(complaint(dam_in_space, {"water_face.0.head=4", "rain.0.within.min=[5, 0, 3]"}), "no complaint");
  EXPECT_THAT(complaint(dam_in_space + "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"),
              AllOf(HasSubstr("water_face[1]"), HasSubstr("lies on wall[0]")));
  EXPECT_THAT(complaint(dam_in_space + "[[wall]]\npoint = [0, 2, 0]\nnormal = [0, 1, 0]\n"),
              AllOf(HasSubstr("wall[0]"), HasSubstr("lies behind it")));
  EXPECT_THAT(complaint(dam_in_space, {"rain.0.normal=[0, 0, 1]"}), HasSubstr("rain[0]"));
  EXPECT_THAT(complaint(dam_in_space + "[[rain]]\nrate = 1e-7\nwithin = { shape = \"ball\", centre = [6, 2, 4], "
                                       "radius = 1 }\n"),
              AllOf(HasSubstr("rain[1]"), HasSubstr("falls where rain[0] does")));
  EXPECT_THAT(complaint(dam_in_space + "[[rain]]\nrate = 1e-7\nwithin = { shape = \"ball\", centre = [2, 2, 2], "
                                       "radius = 1 }\n"),
              AllOf(HasSubstr("rain[1]"), HasSubstr("reservoir"), HasSubstr("under its water")));
  EXPECT_THAT(complaint(changed(dam, "outlet = true", "outlet = true\nwithin = { min = [0, 0], max = [1, 1] }")),
              AllOf(HasSubstr("water_face[1].within"), HasSubstr("dimension = 3")));
}

TEST_F(Field, WellsMustStandInSoil) {
  EXPECT_THAT(complaint(dam_in_space, {"well.0.points=[[6, 2, 0.5], [6, 2, 4.5]]"}),
              AllOf(HasSubstr("well[0].points"), HasSubstr("outside the soil at [6, 2, 4.")));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.points=[[6, 1, 0.5], [6, 1, 2.5]]"}),
              AllOf(HasSubstr("well[0].points"), HasSubstr("the soil ends at")));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.points=[[6, 2, 0.5], [6, 2, 1.5]]"}),
              AllOf(HasSubstr("well[0].points"), HasSubstr("3 particle spacings")));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.points=[[6, 2, 0.5]]"}), HasSubstr("2 ends of the screen"));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.radius=0.1"}),
              AllOf(HasSubstr("well[0].radius"), HasSubstr("0.06 m at most")));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.head=1"}), AllOf(HasSubstr("well[0]"), HasSubstr("found both")));
  EXPECT_THAT(complaint(dam_in_space, {"well.0.name=\"drain\""}),
              AllOf(HasSubstr("well[0].name"), HasSubstr("water_face[1]")));
  EXPECT_THAT(complaint(dam_in_space, {"gauge.0.quantity=\"wall\""}),
              AllOf(HasSubstr("gauge[0].quantity"), HasSubstr("\"well\"")));
  const std::string beds = changed(dam_in_space, "porosity = 0.4", "porosity = 0.4\nanisotropy = 10");
  EXPECT_EQ(complaint(beds), "no complaint");
  EXPECT_THAT(complaint(beds, {"soil.0.bedding_normal=[0, 0.1, 1]"}),
              AllOf(HasSubstr("well[0].points"), HasSubstr("across the beds")));
  EXPECT_EQ(complaint(dam + "[[well]]\npoints = [[0.6, 0.2]]\nradius = 0.002\nhead = 0.25\n"), "no complaint");
}

TEST_F(Field, WellsStandApart) {
  const auto beside = [](double x) {
    return dam + "[[well]]\nname = \"old\"\npoints = [[0.6, 0.2]]\nradius = 0.002\nhead = 0.25\n" +
           fmt::format("[[well]]\npoints = [[{}, 0.2]]\nradius = 0.002\ndischarge = 1e-6\n", x);
  };
  EXPECT_EQ(complaint(beside(0.64)), "no complaint");
  for (const double x : {0.6, 0.63})
    EXPECT_THAT(complaint(beside(x)),
                AllOf(HasSubstr("well[1].points"), HasSubstr("well[0] \"old\""), HasSubstr("2 particle spacings")));
  // A screen that crosses another one's way without touching it.
  const std::string second = "[[well]]\npoints = [[{}, 1.5, 1.2], [{}, 2.5, 1.2]]\nradius = 0.02\nhead = 1\n";
  EXPECT_THAT(complaint(dam_in_space + fmt::format(fmt::runtime(second), 6.5, 6.5)),
              AllOf(HasSubstr("well[1].points"), HasSubstr("stands 0.5 m from well[0]")));
}

/// A field meets faces and rain on its border only: beside it they would have no effect.
TEST_F(Field, FacesAndRainLieOnTheSoilsSurface) {
  const std::string off = "does not lie on the soil's surface";
  EXPECT_THAT(complaint(dam, {"water_face.1.points=[[1.202, 0], [0.802, 0.4]]"}),
              AllOf(HasSubstr("water_face[1].points"), HasSubstr(off)));
  EXPECT_THAT(complaint(dam, {"water_face.0.points=[[0.4, 0.4], [0.002, 0]]"}),
              AllOf(HasSubstr("water_face[0].points"), HasSubstr(off)));
  EXPECT_THAT(complaint(dam, {"rain.0.points=[[0.8, 0.398], [0.4, 0.398]]"}),
              AllOf(HasSubstr("rain[0].points"), HasSubstr(off)));
  // Longer than the soil, and bent around its corner.
  EXPECT_EQ(complaint(dam, {"water_face.1.points=[[1.4, -0.2], [0.7, 0.5]]"}), "no complaint");
  EXPECT_EQ(complaint(dam, {"water_face.1.points=[[1.2, 0], [0.8, 0.4], [0.7, 0.4]]",
                            "rain.0.points=[[0.7, 0.4], [0.4, 0.4]]"}),
            "no complaint");
}

TEST_F(Field, SoilsTouchOrAreApart) {
  const auto divided = [](const char* x) {
    const std::string left =
        changed(dam, "[[0, 0], [1.2, 0], [0.8, 0.4], [0.4, 0.4]]", "[[0, 0], [0.6, 0], [0.6, 0.4], [0.4, 0.4]]");
    return left + fmt::format(
                      "[[soil]]\nshape = \"polygon\"\npoints = [[{0}, 0], [1.2, 0], [0.8, 0.4], [{0}, 0.4]]\n"
                      "retention = {{ model = \"gardner\", alpha = 2 }}\n",
                      x);
  };
  for (const char* x : {"0.6", "0.600000001", "0.604"}) EXPECT_EQ(complaint(divided(x)), "no complaint") << x;
  EXPECT_THAT(complaint(divided("0.6001")), AllOf(HasSubstr("soil[1]"), HasSubstr("a gap of less than 0.001 m")));
}

TEST_F(Field, SoilsIn3DTouchOrAreApart) {
  std::string plain = dam_in_space.substr(0, dam_in_space.find("[[gauge]]"));  // without the well; points 0.4 m apart
  plain.erase(plain.find("[[well]]"), plain.find("[fluid]") - plain.find("[[well]]"));
  const std::string gap = "a gap of less than 0.02 m";
  // The dam in two parts, the left of which ends at x [m].
  const auto divided = [&](const char* x) {
    return changed(plain, "[[0, 0], [12, 0], [8, 4], [4, 4]]", "[[7, 0], [12, 0], [8, 4], [7, 4]]") +
           fmt::format(
               "[[soil]]\nshape = \"polygon\"\npoints = [[0, 0], [{0}, 0], [{0}, 4], [4, 4]]\n"
               "along = [\"y\"]\nfrom = 0\nto = 4\nretention = {{ model = \"gardner\", alpha = 2 }}\n",
               x);
  };
  for (const char* x : {"7", "6.9999999", "6.97"}) EXPECT_EQ(complaint(divided(x)), "no complaint") << x;
  EXPECT_THAT(complaint(divided("6.99")), AllOf(HasSubstr("soil[1]"), HasSubstr(gap)));
  // A cylinder of another soil fills a hole of 1 m radius, or nearly so.
  const auto pile = [&](const char* radius) {
    return changed(plain, "n = 2.8 }\n",
                   "n = 2.8 }\n[[soil.without]]\nshape = \"cylinder\"\nends = [[6, 2, -1], [6, 2, 5]]\nradius = 1\n") +
           fmt::format(
               "[[soil]]\nshape = \"cylinder\"\nends = [[6, 2, 0], [6, 2, 4]]\nradius = {}\n"
               "retention = {{ model = \"gardner\", alpha = 2 }}\n",
               radius);
  };
  for (const char* radius : {"1", "0.97"}) EXPECT_EQ(complaint(pile(radius)), "no complaint") << radius;
  EXPECT_THAT(complaint(pile("0.99")), HasSubstr(gap));
}

TEST_F(Field, WhatGaugesNameIsThereOnce) {
  EXPECT_THAT(complaint(dam, {"water_face.1.name=\"reservoir\""}),
              AllOf(HasSubstr("water_face[1].name"), HasSubstr("found \"reservoir\" twice")));
  EXPECT_THAT(complaint(dam + "[[rain]]\nname = \"rain\"\npoints = [[0.5, 0.4], [0.4, 0.4]]\nrate = 1e-6\n",
                        {"rain.0.points=[[0.8, 0.4], [0.5, 0.4]]"}),
              AllOf(HasSubstr("rain[1].name"), HasSubstr("found \"rain\" twice")));
}

/// Both ways of computing the water read such a face on its left side.
TEST_F(Field, FacesOfGaugesAreWalkedWithTheSoilOnTheLeft) {
  const auto with = [](const char* kind, const char* points) {
    return dam + fmt::format("[[gauge]]\nname = \"g\"\nphase = \"fluid\"\nkind = \"{}\"\npoints = {}\n", kind, points);
  };
  for (const char* kind : {"exit_gradient", "exit_height"}) {
    EXPECT_EQ(complaint(with(kind, "[[1.2, 0], [0.8, 0.4]]")), "no complaint") << kind;
    EXPECT_THAT(complaint(with(kind, "[[0.8, 0.4], [1.2, 0]]")),
                AllOf(HasSubstr("gauge[1].points"), HasSubstr("turn the order")))
        << kind;
  }
  EXPECT_THAT(complaint(with("exit_gradient", "[[1.1, 0.3], [1.2, 0.4]]")),
              AllOf(HasSubstr("gauge[1].points"), HasSubstr("no soil lies beside the line")));
}

/// The representation that "auto" stands for, and the reason for it.
TEST_F(Field, AutoIsAFieldWhereAFieldIsRight) {
  const auto chosen = [this](const std::string& text, const std::vector<std::string>& set = {}) {
    auto all = set;
    all.emplace_back("fluid.representation=\"auto\"");
    return read(text, all).representation_chosen;
  };
  EXPECT_THAT(chosen(dam), HasSubstr("field: the case has keys that only a field has"));
  EXPECT_THAT(chosen(dam_in_space), HasSubstr("field: "));
  // Without the keys of a field.
  const std::string plain = changed(
      changed(changed(dam,
                      R"(retention = { model = "van_genuchten", residual_water_content = 0.05, alpha = 3.5, n = 2.8 })",
                      ""),
              "[[rain]]\nname = \"rain\"\npoints = [[0.8, 0.4], [0.4, 0.4]]\nrate = [[0, 1e-6], [100, 0]]\n", ""),
      "initial_water_table = 0\n", "");
  const std::string by_line = changed(plain, "quantity = \"reservoir\"", "points = [[0.6, 0.4], [0.6, 0]]");
  EXPECT_THAT(chosen(by_line), HasSubstr("field: all water stays in soil"));
  EXPECT_THAT(chosen("[case]\nend_time = 1\n[[soil]]\nmin = [0, 0]\nmax = [1, 0.5]\nporosity = 0.4\n"
                     "[[wall]]\npoints = [[0, 1], [0, 0], [1, 0], [1, 1]]\n"
                     "[[fluid.region]]\nmin = [0, 0]\nmax = [1, 0.8]\n"
                     "[fluid]\nparticle_spacing = 0.05\n[solid]\nmodel = \"rigid\"\n"),
              AllOf(HasSubstr("particles: "), HasSubstr("free water")));
  EXPECT_THAT(chosen(by_line, {"water_face.0.head=0.45"}), AllOf(HasSubstr("particles: "), HasSubstr("run over")));
  const std::string yields = changed(by_line, "model = \"rigid\"", "model = \"drucker_prager\"");
  EXPECT_THAT(chosen(yields + "[[wall]]\npoints = [[0, 0], [1.2, 0]]\n"),
              AllOf(HasSubstr("particles: "), HasSubstr("yield")));
  EXPECT_EQ(read(by_line).representation_chosen, "");
}

}  // namespace
}  // namespace poretwin
