#include "peer/still.hpp"

#include "common/geometry/shapes.hpp"
#include "common/media/seepage.hpp"

#include <algorithm>
#include <limits>

namespace poretwin::peer {
namespace {

using namespace coupling;

/// Elevation (along -gravity) of the surface of water at rest [m]: the highest prescribed head or, without one, the top
/// of the water.
double water_level(const Case& scene) {
  const Point3 up = -scene.general.gravity.normalized();
  double level = -std::numeric_limits<double>::infinity();
  for (const auto& face : scene.water_faces)
    if (face.head) level = std::max(level, face.head->at(0.0));
  if (level > -std::numeric_limits<double>::infinity()) return level;
  for (const auto& region : scene.fluid.regions) {
    const auto [low, high] = bounds(region);
    level = std::max({level, up.dot(low), up.dot(high)});
  }
  return level;
}

const Soil* soil_near(const Case& scene, const Point3& x) {
  if (const Soil* soil = soil_at(scene, x)) return soil;
  return scene.soils.empty() ? nullptr : &scene.soils.front();
}

template <int D>
PointSet points_in(const Case& scene, Role role) {
  const bool water = role == Role::fluid;
  const double spacing =
      water || scene.solid.particle_spacing <= 0.0 ? scene.fluid.particle_spacing : scene.solid.particle_spacing;
  std::vector<Shape> shapes = scene.fluid.regions;
  if (!water || shapes.empty()) {
    shapes.clear();
    for (const auto& soil : scene.soils) shapes.push_back(soil.shape);
  }
  constexpr double smoothing_per_spacing = 1.3;
  PointSet points;
  points.dimension = D;
  VecArray<D> x;
  for (const auto& shape : shapes) {
    const auto lattice = fill<D>(shape, spacing, Point3(0.5, 0.5, 0.5), 0.0, 1);
    x.insert(x.end(), lattice.position.begin(), lattice.position.end());
    points.volume.resize(x.size(), lattice.volume);
  }
  points.n_active = x.size();
  const double reach = 2.0 * smoothing_per_spacing * spacing;
  std::vector<sph::ImagePlane<D>> planes = periodic_planes<D>(scene.general, 0);
  for (const auto& wall : scene.walls)
    if (water ? wall.water != Wall::ForWater::none : wall.soil != Wall::ForSoil::none)
      for (const auto& plane : planes_of<D>(wall.face, 0, 2.0 * reach)) planes.push_back(plane);
  const auto images = sph::make_images<D>(x, planes, reach);
  for (std::size_t i = 0; i < points.n_active; ++i) points.owner.push_back(static_cast<double>(i));
  for (std::size_t k = 0; k < images.size(); ++k) {
    x.push_back(images.position[k]);
    points.volume.push_back(points.volume[images.parent[k]]);
    points.owner.push_back(static_cast<double>(images.parent[k]));
  }
  points.smoothing_length.assign(x.size(), smoothing_per_spacing * spacing);
  for (const auto& p : x) points.position.insert(points.position.end(), p.data(), p.data() + D);
  return points;
}

}  // namespace

double still_value(const Case& scene, const std::string& name, const Point3& x) {
  const double weight = scene.water.density * scene.general.gravity.norm();
  if (name == field::pore_pressure) {
    if (weight <= 0.0) return 0.0;
    const Point3 up = -scene.general.gravity.normalized();
    return weight * std::max(0.0, water_level(scene) - up.dot(x));
  }
  const Soil* soil = soil_near(scene, x);
  if (!soil) return 0.0;
  if (name == field::soil_fraction) return soil_at(scene, x) ? 1.0 : 0.0;
  const double solid = 1.0 - soil->porosity;
  if (name == field::solid_volume_fraction) return solid;
  if (name == field::grain_density) return soil->grain_density;
  if (name == field::hydraulic_conductivity) return porous::seepage_at(scene, *soil, soil->porosity).conductivity;
  if (name == field::forchheimer_coefficient) return porous::seepage_at(scene, *soil, soil->porosity).quadratic;
  if (name == field::constrained_modulus) {
    const double nu = soil->poissons_ratio;
    return soil->youngs_modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  }
  return 0.0;
}

PointSet still_points(const Case& scene, Role role) {
  return scene.general.dimension == 2 ? points_in<2>(scene, role) : points_in<3>(scene, role);
}

std::unique_ptr<Phase> make_still(const Case& scene, Role role) {
  const int dimension = scene.general.dimension;
  const auto formula = [scene, dimension](const std::string& name, int, const double* x, double) {
    return still_value(scene, name, Point3(x[0], x[1], dimension == 3 ? x[2] : 0.0));
  };
  Publication still = formula_publication(role, 0.0, still_points(scene, role), formula);
  if (role == Role::fluid && scene.is_field()) {
    std::erase_if(still.fields, [](const Field& f) { return f.name != field::pore_pressure; });
    still.fields.push_back({std::string(field::degree_of_saturation), 1, ScalarArray(still.points.size(), 1.0)});
  }
  MockKnobs knobs;
  knobs.digest = scene.digest();
  auto mock = std::make_unique<MockPhase>(
      role, dimension, [still](double) { return still; }, knobs);
  if (scene.is_field()) {
    Contract contract = mock->contract();
    (role == Role::fluid ? contract.gives : contract.takes) = standard_fields(Role::fluid, dimension, WaterAs::field);
    mock->set_contract(std::move(contract));
  }
  return mock;
}

}  // namespace poretwin::peer
