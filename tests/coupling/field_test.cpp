// Pore water as a field, coupled with soil that moves.
#include "common/media/retention_law.hpp"
#include "pore_solver/pore_phase.hpp"
#include "solid_solver/solid.hpp"
#include "tests/coupling/column.hpp"

#include <cmath>

namespace poretwin::coupling {
namespace {

using test::last;
using test::line;

constexpr double width = 0.06, height = 0.4, spacing = 0.02, load = 1000.0, modulus = 4e6;

Gauge point(const std::string& phase, const std::string& quantity, double y) {
  return test::gauge_at(phase, quantity, 0.5 * width, y);
}

/// A column on a fixed base between rollers, of soil that strains in one direction only.
Case column() {
  Case scene = test::soil_column(width, height, spacing);
  scene.fluid.representation = FluidCase::Representation::field;
  scene.soils[0].youngs_modulus = modulus;
  scene.soils[0].poissons_ratio = 0.0;
  return scene;
}

/// Runs both phases to the end, in windows of at most `interval`.
void run(CoupledRun& coupled, const Case& scene, std::optional<double> interval = {}) {
  const auto water = pore::make_pore_water(scene);
  const auto soil = solid::make_solid(scene);
  coupled.paired = true;
  coupled.dimension = scene.general.dimension;
  coupled.scheme = Settled{scene.coupling.settled_below()};
  coupled.broker.case_digest = scene.digest();
  coupled.settings = {scene.general.end_time, interval, 0.0, 0.0};
  coupled.run(water.get(), soil.get());
  coupled.expect_success();
}

/// Terzaghi's degree of consolidation of a column that drains on one side.
double consolidation(double factor) {
  double left = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double m = M_PI * (i + 0.5);
    left += 2.0 / (m * m) * std::exp(-m * m * factor);
  }
  return 1.0 - left;
}

Case loaded_column(double end) {
  Case scene = column();
  scene.general.gravity.setZero();
  scene.general.end_time = end;
  scene.fluid.regions = {scene.soils[0].shape};
  WaterFace top;
  top.face = line(width, height, 0, height);
  top.pressure = Series{{{0.0, 0.0}}};
  scene.water_faces = {top};
  Load plate;
  plate.face = top.face;
  plate.traction = Point3(0.0, -load, 0.0);
  plate.start = 0.0;
  scene.loads = {plate};
  scene.gauges = {point("solid", "displacement_y", height), point("fluid", "pore_pressure", 0.0)};
  return scene;
}

TEST(FieldWithSoil, BearsASuddenLoadWholly) {
  const Case scene = loaded_column(1e-3);  // a hundredth of the time in which a row drains
  CoupledRun coupled;
  run(coupled, scene, 1e-4);
  EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), load, 0.003 * load);
  EXPECT_GT(coupled.report.passes, coupled.report.windows);  // the first window is repeated
}

/// The first pass settles as drained soil does, so that all pairs are found anew.
TEST(FieldWithSoil, BearsLoadsUnderWhichItSettlesByMuchOfASpacing) {
  for (const double strain : {0.01, 0.02, 0.04}) {
    Case scene = loaded_column(1e-3);
    scene.loads[0].traction.y() = -strain * modulus;
    CoupledRun coupled;
    run(coupled, scene, 1e-4);
    EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), strain * modulus, 0.003 * strain * modulus) << strain;
  }
}

/// column_until(time): the loaded column, until a time [s]; settlement: the gauge of its top's displacement upwards.
template <class Column>
void expect_consolidation(const Column& column_until, const std::string& settlement) {
  const double rate = 1e-4 * modulus / 9810.0;  // m2/s, coefficient of consolidation
  for (const double factor : {0.2, 1.0}) {
    const Case scene = column_until(factor * height * height / rate);
    CoupledRun coupled;
    run(coupled, scene);
    EXPECT_NEAR(-last(coupled.solid_record, settlement) * modulus / (load * height), consolidation(factor), 0.005);
    EXPECT_LT(coupled.report.windows, 150u);
  }
}

TEST(FieldWithSoil, ConsolidatesAsTerzaghiInWindowsOfItsOwn) { expect_consolidation(loaded_column, "displacement_y"); }

/// Water leaves the column across its beds.
TEST(FieldWithSoil, ConsolidatesWithTheConductivityAcrossTheBeds) {
  const double rate = 1e-5 * modulus / 9810.0;
  Case scene = loaded_column(0.2 * height * height / rate);
  scene.soils[0].anisotropy = 10.0;
  scene.soils[0].bedding_normal = Point3::UnitY();
  CoupledRun coupled;
  run(coupled, scene);
  EXPECT_NEAR(-last(coupled.solid_record, "displacement_y") * modulus / (load * height), consolidation(0.2), 0.005);
}

/// Between periodic sides a column strains and drains as between rollers.
TEST(FieldWithSoil, PeriodicSidesConsolidateAsRollersDo) {
  const auto column_until = [](double end) {
    Case scene = loaded_column(end);
    scene.walls = {scene.walls[1]};
    scene.general.periodic = {0};
    scene.general.domain_max = Point3(width, 1.0, 0.0);
    return scene;
  };
  expect_consolidation(column_until, "displacement_y");
}

/// Under uniform suction and open to the air, a weightless column shortens in proportion to suction over modulus.
TEST(FieldWithSoil, SuctionUnderAirCompressesTheSoil) {
  Case scene = column();
  scene.general.end_time = 1.0;
  scene.solid.initial_rest = true;
  Soil& soil = scene.soils[0];
  soil.grain_density = 1e-6;
  soil.porosity = 1e-3;  // so that grains and water have no weight
  soil.retention.emplace();
  for (const auto& law : porous::retention_laws())
    if (law.name == "gardner") soil.retention->law = &law;
  soil.retention->numbers = {{"alpha", 1e-3}, {"pore_connectivity", 0.5}, {"entry_head", 0.0}, {"n", 2.0}};
  scene.fluid.initial_pressure_head = Series{{{0.0, -1.0}, {height, -1.0 - height}}};  // at rest
  scene.gauges = {point("solid", "displacement_y", height)};
  CoupledRun coupled;
  run(coupled, scene);
  const double suction = 9810.0 * (1.0 + 0.5 * height);  // mean over the height
  EXPECT_NEAR(last(coupled.solid_record, "displacement_y"), -suction / modulus * height,
              0.01 * suction / modulus * height);
}

Face plane(const Point3& point, const Point3& normal) {
  Face face;
  face.point = point;
  face.normal = normal;
  return face;
}

/// column() in 3D, square, with heights along z.
Case column_in_space() {
  Case scene = column();
  scene.general.dimension = 3;
  scene.general.gravity = Point3(0.0, 0.0, -9.81);
  Soil& soil = scene.soils[0];
  soil.shape.max = Point3(width, width, height);
  soil.poissons_ratio = 0.1;
  soil.youngs_modulus = 1.1 * 0.8 / 0.9 * modulus;  // the constrained modulus is `modulus`
  scene.walls.clear();
  for (const auto& face : {plane(Point3::Zero(), Point3::UnitZ()), plane(Point3::Zero(), Point3::UnitX()),
                           plane(Point3(width, 0.0, 0.0), -Point3::UnitX()), plane(Point3::Zero(), Point3::UnitY()),
                           plane(Point3(0.0, width, 0.0), -Point3::UnitY())}) {
    Wall wall;
    wall.face = face;
    scene.walls.push_back(wall);
  }
  scene.walls[0].soil = Wall::ForSoil::fixed;
  return scene;
}
Face top_in_space() { return plane(Point3(0.0, 0.0, height), -Point3::UnitZ()); }

Gauge point_in_space(const std::string& phase, const std::string& quantity, double z) {
  Gauge gauge = point(phase, quantity, z);
  gauge.points = {Point3(0.5 * width, 0.5 * width, z)};
  return gauge;
}

Case loaded_column_in_space(double end) {
  Case scene = column_in_space();
  scene.general.gravity.setZero();
  scene.general.end_time = end;
  scene.fluid.regions = {scene.soils[0].shape};
  WaterFace top;
  top.face = top_in_space();
  top.pressure = Series{{{0.0, 0.0}}};
  scene.water_faces = {top};
  Load plate;
  plate.face = top.face;
  plate.traction = Point3(0.0, 0.0, -load);
  plate.start = 0.0;
  scene.loads = {plate};
  scene.gauges = {point_in_space("solid", "displacement_z", height), point_in_space("fluid", "pore_pressure", 0.0)};
  return scene;
}

TEST(FieldWithSoil, BearsASuddenLoadWhollyInSpace) {
  const Case scene = loaded_column_in_space(1e-3);
  CoupledRun coupled;
  run(coupled, scene, 1e-4);
  EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), load, 0.003 * load);
}

/// At a Poisson's ratio of zero the bulk modulus is a third of the constrained one.
Case column_without_lateral_strain(double end) {
  Case scene = loaded_column_in_space(end);
  scene.soils[0].poissons_ratio = 0.0;
  scene.soils[0].youngs_modulus = modulus;
  return scene;
}

TEST(FieldWithSoil, BearsASuddenLoadInSpaceAtAPoissonsRatioOfZero) {
  CoupledRun coupled;
  run(coupled, column_without_lateral_strain(1e-3), 1e-4);
  EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), load, 0.003 * load);
}

TEST(FieldWithSoil, ConsolidatesAsTerzaghiInSpaceAtAPoissonsRatioOfZero) {
  expect_consolidation(column_without_lateral_strain, "displacement_z");
}

TEST(FieldWithSoil, ConsolidatesAsTerzaghiInSpace) { expect_consolidation(loaded_column_in_space, "displacement_z"); }

/// A load on a quarter of the column's top: at first the water at the base bears its mean over the section, and the
/// force on the whole is the traction times the loaded area.
TEST(FieldWithSoil, ALoadOnAPartOfAPlaneHasTheForceOfItsArea) {
  Case scene = loaded_column_in_space(1e-3);
  const double wide = 0.08;
  scene.soils[0].shape.max = Point3(wide, wide, height);
  scene.soils[0].poissons_ratio = 0.0;  // the bulk modulus is a third of the constrained one
  scene.fluid.regions = {scene.soils[0].shape};
  scene.walls[2].face.point.x() = wide;
  scene.walls[4].face.point.y() = wide;
  Shape part;
  part.min = Point3(-1.0, -1.0, 0.9 * height);
  part.max = Point3(0.5 * wide, 0.5 * wide, 1.1 * height);
  scene.loads[0].face.within = part;
  CoupledRun coupled;
  run(coupled, scene, 1e-4);
  EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), 0.25 * load, 0.01 * 0.25 * load);
}

/// The weight of a pond over saturated soil is borne by the water: the skeleton is neither compressed nor lifted. The
/// pond's level is prescribed, or follows from what is poured into a basin.
TEST(FieldWithSoil, APondThatRisesDoesNotMoveSaturatedSoilInSpace) {
  const double rise = 1.0, area = 0.5;  // m, m2
  for (const bool basin : {false, true}) {
    Case scene = column_in_space();
    scene.solid.initial_rest = true;
    scene.general.end_time = 20.0;
    scene.fluid.initial_water_table = height;
    WaterFace top;
    top.face = top_in_space();
    top.head = Series{{{0.0, height}, {10.0, height + rise}}};
    if (basin) {
      top.head = Series{{{0.0, height}}};
      top.basin_area = Series{{{height, area}}};
      top.discharge = Series{{{0.0, 0.1 * rise * area}, {10.0, 0.1 * rise * area}, {10.001, 0.0}}};
    }
    scene.water_faces = {top};
    scene.gauges = {point_in_space("solid", "displacement_z", height), point_in_space("fluid", "pore_pressure", 0.0)};
    CoupledRun coupled;
    run(coupled, scene);
    EXPECT_NEAR(last(coupled.fluid_record, "pore_pressure"), 9810.0 * (height + rise), 0.002 * 9810.0 * rise) << basin;
    const double before = coupled.solid_record.series.front().readings.front().value;  // under its own weight
    EXPECT_NEAR(last(coupled.solid_record, "displacement_z"), before, 0.005 * 9810.0 * rise * height / modulus)
        << basin;
  }
}

}  // namespace
}  // namespace poretwin::coupling
