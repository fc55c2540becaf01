// Soils of different materials in one case, compared with exact one-dimensional solutions.
#include "common/core/error.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

namespace poretwin::solid {
namespace {

/// Elastic soil on cohesionless soil that yields under the weight. There the cone limits sigma_h to sigma_v (1/sqrt(3)
/// - alpha) / (1/sqrt(3) + 2 alpha), and as it yields at constant volume, only the mean stress compresses it, p / K.
TEST(Materials, ElasticSoilOnSoilThatYieldsInOneDimension) {
  test::ColumnSpec spec;
  spec.base = Wall::ForSoil::roller;
  Case scene = test::column(spec);
  scene.solid.model = MaterialName::drucker_prager;
  Soil lower = scene.soils[0], upper = lower;
  lower.shape.max.y() = upper.shape.min.y() = 0.5;
  lower.youngs_modulus = upper.youngs_modulus = 3e7;
  lower.friction_angle = 15.0;
  upper.model = MaterialName::elastic;
  scene.soils = {lower, upper};
  scene.gauges = {test::point_gauge<2>("top", "displacement_y", {Point3(0.2, 1.0, 0.0)}),
                  test::point_gauge<2>("middle", "displacement_y", {Point3(0.2, 0.5, 0.0)})};
  Solid<2> solid(scene);
  solid.initialise({});

  const double gamma = 0.6 * 2600.0 * 9.81, tangent = std::tan(15.0 * std::numbers::pi / 180.0);
  const double alpha = tangent / std::sqrt(9.0 + 12.0 * tangent * tangent), root = std::numbers::inv_sqrt3;
  const double yielding = (root - alpha) / (root + 2.0 * alpha), elastic = 0.3 / 0.7;
  const auto& p = solid.state().particles;
  double off = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool below = p.material[i] == 0;
    const double vertical = -gamma * (1.0 - (p.position[i].y() - p.displacement[i].y()));
    off = std::max({off, std::abs(p.stress[i][1] - vertical),
                    std::abs(p.stress[i][0] - (below ? yielding : elastic) * p.stress[i][1])});
    EXPECT_EQ(p.plastic_strain[i] > 0.0, below) << "particle " << i;
  }
  EXPECT_LT(off, 1e-2 * gamma);  // 0.11 gamma with one stress ratio for both layers

  const Elasticity moduli = Elasticity::of(lower);
  const double by_upper = gamma * 0.125 / moduli.constrained();                          // its own weight
  const double by_lower = gamma * 0.375 * (1.0 + 2.0 * yielding) / (3.0 * moduli.bulk);  // both weights
  const auto readings = solid.gauges();
  EXPECT_NEAR(readings[0].value, -(by_lower + by_upper), 5e-3 * (by_lower + by_upper));
  EXPECT_NEAR(readings[1].value, -by_lower, 5e-3 * by_lower);
}

/// A layer of normally consolidated clay, 2 m thick, on which a fill is placed in 20 s; keys: added to its soil.
Case clay_under_a_fill(const std::string& keys) {
  const auto path = std::filesystem::temp_directory_path() / "poretwin_clay.toml";
  std::ofstream(path) << std::string(R"([case]
end_time = 30
[solid]
model = "modified_cam_clay"
particle_spacing = 0.1
[[soil]]
min = [0, 0]
max = [0.4, 2.0]
porosity = 0.5
grain_density = 2700
poissons_ratio = 0.3
compression_slope = 0.15
swelling_slope = 0.03
critical_state_slope = 1.0
earth_pressure_at_rest = 0.722
)" + keys + R"(
[[wall]]
points = [[0, 4], [0, 0], [0.4, 0], [0.4, 4]]
soil = "roller"
[[load]]
points = [[0.4, 2.0], [0, 2.0]]
traction = [0, -10e3]
start = 0
factor = [[0, 0], [20, 1]]
)");
  return read_case(path);
}

/// Clay on its normal compression line, under its own weight and then under a slowly placed fill: the specific volume
/// falls by lambda times the logarithm of the ratio of vertical stresses, since the ratio of horizontal stresses is
/// kept.
TEST(Materials, ClayUnderAFillSettlesByItsCompressionSlope) {
  Solid<2> solid(clay_under_a_fill(""));
  solid.initialise({});
  const auto& p = solid.state().particles;
  double at_rest = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) at_rest = std::max(at_rest, p.displacement[i].norm());
  EXPECT_LT(at_rest, 2e-3);  // it begins in equilibrium
  for (int k = 0; k < 480; ++k) solid.advance({static_cast<std::uint64_t>(k), solid.state().time, 0.05}, {});

  constexpr double gamma = 0.5 * 2700.0 * 9.81, fill = 10e3;
  constexpr int cells = 1000;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const double from = p.position[i].y() - p.displacement[i].y();
    if (from < 0.5 || from > 1.5) continue;  // the uppermost row is below the least pressure
    double due = 0.0;
    for (int k = 0; k < cells; ++k) {
      const double before = gamma * (2.0 - (k + 0.5) / cells * from);
      due += 0.15 / 2.0 * std::log((before + fill) / before) * from / cells;
    }
    EXPECT_NEAR(p.displacement[i].y(), -due, 0.02 * due) << from;
  }
}

/// The substep is chosen for the stiffness at a pressure: at a higher pressure the integration would be silently wrong.
TEST(Materials, SoilThatBearsMoreThanItsSubstepIsChosenForEndsTheRun) {
  Solid<2> sound(clay_under_a_fill("largest_pressure = 30e3")), weak(clay_under_a_fill("largest_pressure = 15e3"));
  EXPECT_LT(sound.setup().longest_substep, weak.setup().longest_substep);
  for (Solid<2>* solid : {&sound, &weak}) solid->initialise({});
  EXPECT_NO_THROW(sound.advance({0, 0.0, 0.05}, {}));
  try {
    weak.advance({0, 0.0, 0.05}, {});
    ADD_FAILURE() << "went on";
  } catch (const DivergedError& error) {
    EXPECT_NE(std::string(error.what()).find("set soil.largest_pressure"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace poretwin::solid
