// A user's own law of seepage: Hazen (1892), for uniform sand, k = c d10^2 with c = 0.01 m/s per mm2.
#include "common/media/seepage.hpp"

#include "tests/case/case_file.hpp"

using namespace poretwin;

namespace {

const porous::SeepageLaw& hazen = porous::add_seepage_law(
    {"hazen",
     "k of uniform sand from its finest tenth (Hazen 1892)",
     [](const porous::Medium& medium) {
       const double d10 = medium.parameters[0], at_own_porosity = 1e4 * d10 * d10;
       return porous::carried_over({at_own_porosity, 0.0}, medium.own_porosity, medium.porosity);
     },
     {{"hazen_diameter", "m", "d10: a tenth of the grains is finer (`hazen`).", 0.0, true}},
     false});

const std::string column = R"([case]
title = "a column of sand under water"
end_time = 10
[[soil]]
shape = "box"
min = [0, 0]
max = [0.1, 0.4]
porosity = 0.4
seepage_law = "hazen"
[[wall]]
points = [[0, 0.4], [0, 0], [0.1, 0], [0.1, 0.4]]
soil = "fixed"
[[water_face]]
points = [[0.1, 0.4], [0, 0.4]]
head = 1
[fluid]
particle_spacing = 0.01
[[fluid.region]]
min = [0, 0]
max = [0.1, 0.4]
[solid]
model = "rigid"
)";

class DragLaw : public CaseFile {};

TEST_F(DragLaw, IsReadFromACase) {
  const Case scene = read(column, {"soil.0.hazen_diameter=2e-4"});
  EXPECT_EQ(scene.soils[0].seepage_law, &hazen);
  EXPECT_NEAR(porous::seepage_at(scene, scene.soils[0], scene.soils[0].porosity).conductivity, 4e-4, 1e-16);
}

TEST_F(DragLaw, MistakesAreNamed) {
  EXPECT_THAT(complaint(column), testing::HasSubstr("hazen_diameter"));
  EXPECT_THAT(complaint(column, {"soil.0.hazen_diameter=2e-4", "soil.0.hydraulic_conductivity=1e-3"}),
              testing::HasSubstr("finds the conductivity itself"));
}

}  // namespace
