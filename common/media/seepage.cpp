#include "common/media/seepage.hpp"

#include "common/core/error.hpp"
#include "common/media/constant_conductivity.hpp"
#include "common/media/forchheimer.hpp"
#include "common/media/kozeny_carman.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace poretwin::porous {
namespace {

std::deque<SeepageLaw>& all_laws() {
  static std::deque<SeepageLaw> laws{kozeny_carman(), constant_conductivity(), forchheimer(), ergun()};
  return laws;
}

const SeepageLaw& law_of(const Soil& soil) { return soil.seepage_law ? *soil.seepage_law : all_laws().front(); }

}  // namespace

const std::deque<SeepageLaw>& seepage_laws() { return all_laws(); }

const SeepageLaw& seepage_law(std::string_view name) {
  std::string there;
  for (const auto& law : all_laws()) {
    if (law.name == name) return law;
    there += (there.empty() ? "" : ", ") + law.name;
  }
  throw CaseError(fmt::format("no law of seepage is called '{}'; there are {}", name, there));
}

const SeepageLaw& add_seepage_law(SeepageLaw law) {
  if (law.parameters.size() > most_parameters)
    throw CaseError(fmt::format("the law '{}' has {} parameters, at most {} are possible", law.name,
                                law.parameters.size(), most_parameters));
  for (const auto& other : all_laws()) {
    if (other.name == law.name) throw CaseError(fmt::format("a law of seepage is called '{}' already", law.name));
    for (const auto& theirs : other.parameters)
      for (const auto& own : law.parameters)
        if (theirs.key == own.key)
          throw CaseError(fmt::format("'{}' is a parameter of the law '{}' already", own.key, other.name));
  }
  return all_laws().emplace_back(std::move(law));
}

double parameter(const Soil& soil, const LawParameter& parameter) {
  return parameter.in(soil.own_numbers);
}

double Resistance::speed(double force) const {
  const double root = std::sqrt(linear * linear + 4.0 * quadratic * force);
  return linear + root > 0.0 ? 2.0 * force / (linear + root) : 0.0;
}

double critical_gradient(const Case& scene, const Soil& soil) {
  return (1.0 - soil.porosity) * (soil.grain_density / scene.water.density - 1.0);
}

double specific_weight(const Case& scene) {
  const double g = scene.general.gravity.norm();
  return scene.water.density * (g > 0.0 ? g : 9.81);
}

Seepage seepage_at(const Case& scene, const Soil& soil, double porosity) {
  return seepage_at(soil, porosity, specific_weight(scene) / scene.water.density, scene.water.kinematic_viscosity);
}

Seepage seepage_at(const Soil& soil, double porosity, double gravity, double viscosity) {
  const SeepageLaw& law = law_of(soil);
  std::array<double, most_parameters> values{};
  for (std::size_t i = 0; i < law.parameters.size(); ++i) values[i] = parameter(soil, law.parameters[i]);
  return law.at({porosity, soil.porosity, soil.hydraulic_conductivity, gravity, viscosity,
                 std::span(values).first(law.parameters.size())});
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
