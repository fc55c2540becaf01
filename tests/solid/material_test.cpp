// Soils of different materials in one case, against exact answers in one dimension.
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace poretwin::solid {
namespace {

/// Elastic soil on soil without cohesion that yields under the weight: sigma_h there is what the cone bears of sigma_v,
/// (1/sqrt(3) - alpha) / (1/sqrt(3) + 2 alpha), and, as it yields at constant volume, its compression that of the mean
/// stress alone, p / K.
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
  EXPECT_LT(off, 1e-2 * gamma);  // with one ratio for both layers 0.11 gamma

  const Elasticity moduli = Elasticity::of(lower);
  const double by_upper = gamma * 0.125 / moduli.constrained();                          // its own weight
  const double by_lower = gamma * 0.375 * (1.0 + 2.0 * yielding) / (3.0 * moduli.bulk);  // both weights
  const auto readings = solid.gauges();
  EXPECT_NEAR(readings[0].value, -(by_lower + by_upper), 5e-3 * (by_lower + by_upper));
  EXPECT_NEAR(readings[1].value, -by_lower, 5e-3 * by_lower);
}

}  // namespace
}  // namespace poretwin::solid
