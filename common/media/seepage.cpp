#include "common/media/seepage.hpp"

#include "common/media/constant_conductivity.hpp"
#include "common/media/forchheimer.hpp"
#include "common/media/kozeny_carman.hpp"

#include <cmath>

namespace poretwin::porous {

double Resistance::speed(double force) const {
  const double root = std::sqrt(linear * linear + 4.0 * quadratic * force);
  return linear + root > 0.0 ? 2.0 * force / (linear + root) : 0.0;
}

double specific_weight(const Case& scene) {
  const double g = scene.general.gravity.norm();
  return scene.water.density * (g > 0.0 ? g : 9.81);
}

Seepage seepage_at(const Case& scene, const Soil& soil, double porosity) {
  return seepage_at(soil, porosity, specific_weight(scene) / scene.water.density, scene.water.kinematic_viscosity);
}

Seepage seepage_at(const Soil& soil, double porosity, double gravity, double viscosity) {
  switch (soil.seepage_law) {
    case Soil::SeepageLaw::constant:
      return constant_conductivity(soil);
    case Soil::SeepageLaw::forchheimer:
      return forchheimer(soil, porosity);
    case Soil::SeepageLaw::ergun:
      return ergun(soil, gravity, viscosity, porosity);
    case Soil::SeepageLaw::kozeny_carman:
      break;
  }
  return kozeny_carman(soil, porosity);
}

Seepage carried_over(const Seepage& known, double known_porosity, double porosity) {
  return {known.conductivity * kozeny_carman_shape(porosity) / kozeny_carman_shape(known_porosity),
          known.quadratic * inertial_shape(porosity) / inertial_shape(known_porosity)};
}

Resistance resistance(double specific_weight, double n, const Seepage& seepage) {
  return {specific_weight * n * n / seepage.conductivity, specific_weight * n * n * n * seepage.quadratic};
}

double conductivity_contrast(const Case& scene) {
  double slowest = HUGE_VAL, fastest = 0.0;
  for (const auto& soil : scene.soils) {
    const double k = seepage_at(scene, soil, soil.porosity).conductivity;
    slowest = std::min(slowest, k);
    fastest = std::max(fastest, k);
  }
  return scene.soils.empty() ? 1.0 : fastest / slowest;
}

}  // namespace poretwin::porous
