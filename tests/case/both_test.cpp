// Cases whose water is particles where it is free and a field in the soil: how they are divided, and what is refused.
#include "tests/case/case_file.hpp"

#include "common/case/parts.hpp"

namespace poretwin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Both : public CaseFile {};

/// A pit with upright sides beside a bank.
const std::string pit = R"([case]
end_time = 10
[[soil]]
min = [0, 0]
max = [0.8, 0.3]
porosity = 0.43
hydraulic_conductivity = 1e-3
retention = { model = "van_genuchten", residual_water_content = 0.045, alpha = 14.5, n = 2.68 }
[[soil]]
min = [0.2, 0.3]
max = [0.8, 0.5]
porosity = 0.43
hydraulic_conductivity = 1e-3
retention = { model = "van_genuchten", residual_water_content = 0.045, alpha = 14.5, n = 2.68 }
[[wall]]
points = [[0, 0.6], [0, 0], [0.8, 0], [0.8, 0.6]]
[fluid]
representation = "both"
particle_spacing = 0.02
initial_water_table = 0
[[fluid.region]]
min = [0, 0.3]
max = [0.2, 0.46]
[solid]
model = "rigid"
)";

TEST_F(Both, IsReadAndNothingIsSaidOfIt) {
  EXPECT_TRUE(read(pit).is_both());
  EXPECT_EQ(warnings(pit), "");
}

TEST_F(Both, IsDividedAtTheSoilsOpenSurface) {
  const Case scene = read(pit);
  const Case ground = ground_part(scene), free = free_part(scene);
  ASSERT_EQ(ground.water_faces.size(), 3u);
  double length = 0.0;
  for (const auto& face : ground.water_faces) {
    EXPECT_TRUE(face.free_water);
    length += (face.face.points[1] - face.face.points[0]).norm();
  }
  EXPECT_NEAR(length, 0.2 + 0.2 + 0.6, 1e-12);
  EXPECT_TRUE(ground.is_field());
  EXPECT_TRUE(ground.fluid.regions.empty());
  EXPECT_TRUE(free.soils.empty());
  EXPECT_FALSE(free.is_field());
  ASSERT_EQ(free.fluid.regions.size(), 1u);
  // The wall around the soil is left above it, on both sides, and the bed is one line with the water on its left.
  ASSERT_EQ(free.walls.size(), 3u);
  const auto expect_ends = [](const Face& face, const Point3& first, const Point3& last) {
    EXPECT_LT((face.points.front() - first).norm(), 1e-12);
    EXPECT_LT((face.points.back() - last).norm(), 1e-12);
  };
  expect_ends(free.walls[0].face, Point3(0.0, 0.6, 0.0), Point3(0.0, 0.3, 0.0));
  expect_ends(free.walls[1].face, Point3(0.8, 0.5, 0.0), Point3(0.8, 0.6, 0.0));
  expect_ends(free.walls[2].face, Point3(0.0, 0.3, 0.0), Point3(0.8, 0.5, 0.0));
  EXPECT_EQ(free.walls[2].face.points.size(), 4u);
}

TEST_F(Both, AutoIsBothWhereRetentionMeetsFreeWater) {
  EXPECT_THAT(read(pit, {"fluid.representation=\"auto\""}).representation_chosen, HasSubstr("both: "));
}

TEST_F(Both, WaterInSoilIsTheGrounds) {
  const Case scene = read(pit + "[[fluid.region]]\nmin = [0, 0]\nmax = [0.8, 0.1]\n");
  EXPECT_EQ(ground_part(scene).fluid.regions.size(), 1u);
  EXPECT_EQ(free_part(scene).fluid.regions.size(), 1u);
}

TEST_F(Both, WhatItDoesNotSupportIsRefusedByName) {
  const auto refused = [&](const std::string& text, const std::string& key, const std::string& why,
                           const std::vector<std::string>& set = {}) {
    EXPECT_THAT(complaint(text, set), AllOf(HasSubstr(key), HasSubstr(why))) << key;
  };
  refused(pit, "solid.model", "rigid",
          {"solid.model=\"elastic\"", "soil.0.youngs_modulus=1e6", "soil.1.youngs_modulus=1e6"});
  refused(pit, "case.gravity", "weight", {"case.gravity=[0, 0]"});
  refused(pit, "case.periodic", "periodic",
          {"case.periodic=[\"x\"]", "case.domain_min=[0, 0]", "case.domain_max=[0.8, 1]"});
  refused(pit, "fluid.drag", "no effect", {"fluid.drag=false"});
  refused(pit, "fluid.scheme", "not supported", {"fluid.scheme=\"eisph\""});
  refused(pit, "fluid.region[0]", "lies in soil at", {"fluid.region.0.min=[0, 0.2]"});
  refused(pit, "fluid", "no free water", {"fluid.region.0.min=[0.3, 0.1]", "fluid.region.0.max=[0.5, 0.2]"});
  refused(pit + "[[rain]]\npoints = [[0.8, 0.5], [0.2, 0.5]]\nrate = 1e-6\n", "rain[0]", "rain");
  refused(pit + "[[water_face]]\npoints = [[0.8, 0.6], [0.8, 0.7]]\ndischarge = 0.01\n", "water_face[0]", "free water");
  refused(pit + "[[wall]]\npoints = [[0.8, 0.5], [0.2, 0.5], [0.2, 0.3], [0, 0.3]]\n", "soil[0]", "open");
  refused(changed(pit, "[0, 0.6], [0, 0], [0.8, 0], [0.8, 0.6]]",
                  "[0, 0.6], [0, 0]]\n[[wall]]\npoints = [[0.8, 0], [0.8, 0.6]]"),
          "soil[0]", "looks down");
  const auto gauge = [&](const std::string& rest) {
    return pit + "[[gauge]]\nname = \"g\"\nphase = \"fluid\"\n" + rest;
  };
  refused(gauge("kind = \"runoff\"\n"), "gauge[0].kind", "cannot be read");
  refused(gauge("kind = \"point\"\nquantity = \"pore_pressure\"\npoints = [[0.1, 0.1], [0.1, 0.4]]\n"),
          "gauge[0].points", "two gauges");
  refused(gauge("kind = \"point\"\nquantity = \"velocity\"\npoints = [[0.1, 0.1]]\n"), "gauge[0].quantity",
          "no velocity");
  refused(gauge("kind = \"front\"\npoints = [[0.1, 0.32], [0.1, 0.4]]\n"), "gauge[0].points", "none of the points");
  EXPECT_EQ(complaint(gauge("kind = \"point\"\nquantity = \"pore_pressure\"\npoints = [[0.1, 0.4]]\n")),
            "no complaint");
}

// Each part is checked as a case of its own.
TEST_F(Both, AFaultOfOnePartIsFoundAsIfItStoodAlone) {
  EXPECT_THAT(complaint(changed(pit, "initial_water_table = 0\n", "")), HasSubstr("fluid.initial_water_table"));
  EXPECT_THAT(
      complaint(changed(pit, "points = [[0, 0.6], [0, 0], [0.8, 0], [0.8, 0.6]]", "points = [[0, 0], [0.8, 0]]")),
      HasSubstr("water can run out"));
}

}  // namespace
}  // namespace poretwin
